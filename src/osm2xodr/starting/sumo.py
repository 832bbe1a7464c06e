"""SUMO: the network that its netconvert makes of the file, traffic on it, and a configuration that runs both.

Traffic makes trips between the places where roads of each class have theirs.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from osm2xodr.conventions import programmes_file
from osm2xodr.curves import sorted_unique
from osm2xodr.errors import InputError, OutputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing import HIGHWAYS, class_of, open_osm_file, read_ways
from osm2xodr.starting.request import FOLDER, Made, Request
from osm2xodr.system import DATA_OF_OTHERS, record

_NETWORK: Final = "map.net.xml"
_ROUTES: Final = "map.rou.xml"
_VIEW: Final = "map.view.xml"
_CONFIGURATION: Final = "map.sumocfg"
_MISSING: Final = (
    "SUMO's netconvert, which makes the network, is not found; install SUMO (pip install eclipse-sumo does), or set"
    " SUMO_HOME to where it is"
)
# The comment with the time of day at the beginning of files by SUMO's programs; the same input gives the same bytes.
_TIME_STAMP: Final = re.compile(rb"\A(<\?xml[^>]*\?>)?\s*<!-- generated on .*?-->\s*", re.DOTALL)

# The view of the map as a photograph shows it, with names of streets. A step of 1 s takes 50 ms of the watcher's.
_VIEW_TEXT: Final = """\
<viewsettings>
    <scheme name="real world">
        <edges streetName_show="1" streetName_size="60.00" streetName_constantSize="1"/>
    </scheme>
    <delay value="50"/>
</viewsettings>
"""
# How often drivers look for a quicker way, s. Where they do not, SUMO takes 117 of 3,000 cars out of jams in a large
# interchange, in place of 15.
_REROUTED_S: Final = 60
_CONFIGURATION_TEXT: Final = f"""\
<sumoConfiguration>
    <input>
        <net-file value="{_NETWORK}"/>
        <route-files value="{_ROUTES}"/>
    </input>
    <routing>
        <device.rerouting.probability value="1"/>
        <device.rerouting.period value="{_REROUTED_S}"/>
    </routing>
    <report>
        <no-step-log value="true"/>
        <duration-log.statistics value="true"/>
    </report>
    <gui_only>
        <gui-settings-file value="{_VIEW}"/>
        <start value="true"/>
    </gui_only>
</sumoConfiguration>
"""

_CARS = "passenger"

# Vehicles per day, both ways, by class of road. Choices, of the order of the low ends that FHWA's Highway Functional
# Classification Concepts, Criteria and Procedures (2013, section 3) has for towns; its tables were not at hand.
_VEHICLES_PER_DAY: Final[Mapping[str, float]] = MappingProxyType(
    {"motorway": 35_000.0, "trunk": 13_000.0, "primary": 7_000.0, "secondary": 3_000.0, "tertiary": 1_100.0}
)
_LOCAL_VEHICLES_PER_DAY: Final = 80.0
# Share of a day's traffic in one hour, as nearly all of it flows within 16 of the 24.
_ONE_HOUR: Final = 1.0 / 16.0
# Cars set out within a quarter of an hour, the time for which traffic engineers count.
_DEMAND_S: Final = 900.0
# So many at least, so that something moves in the smallest of areas, and at most: of 3,000 in the interchange of
# Portland 15 are taken out of jams, of 1,500 four.
_LEAST_TRIPS: Final = 60
_MOST_TRIPS: Final = 1_500
# Shorter trips than these are walked, m; in smaller areas shorter ones than this share of the longest.
_SHORTEST_M: Final = 300.0
_SHORTEST_SHARE: Final = 0.3
# Edges on which no car has room to set out, m.
_LEAST_EDGE: Final = 10.0
# Steps of the sequence with the least discrepancy in two dimensions, powers of the root of x^3 = x + 1 (M. Roberts,
# The unreasonable effectiveness of quasirandom sequences, 2018): places as even as can be without any chance.
_PLASTIC: Final = 1.324717957244746
# Origins whose ways are searched for at a time.
_BLOCK: Final = 64


def make(request: Request) -> Made:
    """Write the network, the traffic and the configuration."""
    request.on_stage("making SUMO's network")
    _make_network(request)
    network = read_network(request.folder / _NETWORK)
    request.on_stage("making traffic")
    trips = make_trips(network, request)
    lines = [
        f'    <trip id="{k}" type="car" depart="{trip.depart_s:.1f}" from="{trip.origin}" to="{trip.destination}"'
        ' departLane="best" departSpeed="max"/>\n'
        for k, trip in enumerate(trips)
    ]
    routes = f'<routes>\n    <vType id="car" vClass="passenger"/>\n{"".join(lines)}</routes>\n'
    (request.folder / _ROUTES).write_text(routes, encoding="utf-8")
    (request.folder / _VIEW).write_text(_VIEW_TEXT, encoding="utf-8")
    (request.folder / _CONFIGURATION).write_text(_CONFIGURATION_TEXT, encoding="utf-8")
    files = {
        _CONFIGURATION: "the simulation",
        _NETWORK: "SUMO's network, with the names of streets",
        _ROUTES: f"{len(trips):,} cars",
        _VIEW: "settings of the view",
    }
    programmes = programmes_file(request.xodr)
    if programmes.is_file():
        files[programmes.name] = "programmes of traffic lights, which the network has already"
    traffic = f"{len(trips):,} cars set out within 15 minutes, more where the class of road has more traffic"
    return Made(
        "Install [SUMO](https://eclipse.dev/sumo), 1.28 or later.",
        f"sumo-gui -c {FOLDER}/{_CONFIGURATION}",
        files,
        (traffic if trips else "there is no road that cars could drive on: no traffic",),
        {"Without a window": "`sumo` in place of `sumo-gui` runs it without a window, to the end."},
    )


def _make_network(request: Request) -> None:
    """Run the command that `Conversion.load_command` names, with names of streets."""
    program, home = _netconvert()
    # In the folder, so that no path of this machine gets into the network.
    words = shlex.split(request.conversion.load_command(request.xodr.name))
    command = [str(program), *words[1:], "--output.street-names", "--no-warnings", "--xml-validation", "never"]
    environment = {name: value for name, value in os.environ.items() if name not in DATA_OF_OTHERS}
    if home is not None:
        environment |= {"SUMO_HOME": str(home), "PROJ_DATA": str(home / "data" / "proj")}
    try:
        done = subprocess.run(
            command,
            cwd=request.folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
    except OSError as error:
        raise InputError(f"{program} cannot be run: {(error.strerror or str(error)).lower()}; {_MISSING}") from error
    network = request.folder / _NETWORK
    if done.returncode or not network.is_file():
        errors = [line for line in done.stderr.splitlines() if line.startswith("Error:")] or ["no reason given"]
        raise OutputError(f"SUMO's netconvert makes no network: {errors[0]}; try SUMO 1.28")
    network.write_bytes(_TIME_STAMP.sub(rb"\1\n", network.read_bytes(), count=1))


def _netconvert() -> tuple[Path, Path | None]:
    """Return the program, and the folder of SUMO that it belongs to if it is not installed for all."""
    homes = [Path(home)] if (home := os.environ.get("SUMO_HOME")) else []
    if (found := next(filter(None, (_in(home) for home in homes)), None)) is not None:
        return found, homes[0]
    if (path := shutil.which("netconvert")) is not None:
        return Path(path), None
    # The package of Python, whose programs need not be on the path.
    spec = importlib.util.find_spec("sumo")
    if spec is not None and spec.origin is not None and (found := _in(Path(spec.origin).parent)) is not None:
        return found, Path(spec.origin).parent
    raise InputError(_MISSING)


def _in(home: Path) -> Path | None:
    """Return the program in a folder of SUMO."""
    found = shutil.which("netconvert", path=str(home / "bin"))
    return None if found is None else Path(found)


@dataclass(frozen=True, eq=False)
class SumoNetwork:
    """Edges for cars outside of junctions."""

    id: tuple[str, ...]
    length: FloatArray  # (edges,) m
    speed: FloatArray  # (edges,) m/s, of its fastest lane
    # (links,) Indices of edges: from the end of one onto the other
    start: IntArray
    end: IntArray

    @cached_property
    def road(self) -> tuple[str, ...]:
        """The id of the road in OpenDRIVE that each edge was made of; netconvert adds the direction and a number."""
        return tuple(name.lstrip("-").partition("#")[0] for name in self.id)

    @cached_property
    def entrances(self) -> BoolArray:
        """Which edges no other one leads to but that of the opposite direction: traffic comes in there."""
        return ~self._met(self.end, self.start)

    @cached_property
    def exits(self) -> BoolArray:
        """Which edges lead to no other one but that of the opposite direction: traffic leaves there."""
        return ~self._met(self.start, self.end)

    def _met(self, edges: IntArray, others: IntArray) -> BoolArray:
        found = np.zeros(len(self.id), np.bool_)
        road = np.array(self.road)
        found[edges[road[edges] != road[others]]] = True
        # Pieces of one road that follow each other in one direction.
        direction = np.array([name.startswith("-") for name in self.id])
        found[edges[(road[edges] == road[others]) & (direction[edges] == direction[others])]] = True
        return found


def read_network(path: Path) -> SumoNetwork:
    """Read the network that netconvert wrote."""
    ids: dict[str, int] = {}
    lengths: list[float] = []
    speeds: list[float] = []
    links: set[tuple[int, int]] = set()
    for element in _elements(path):
        if element.tag == "edge" and not element.get("function"):
            lanes = [lane for lane in element.iter("lane") if _for_cars(lane)]
            if lanes:
                ids[element.get("id", "")] = len(ids)
                lengths.append(float(lanes[0].get("length", "0")))
                speeds.append(max(float(lane.get("speed", "0")) for lane in lanes))
        elif element.tag == "connection":
            pair = ids.get(element.get("from", "")), ids.get(element.get("to", ""))
            if pair[0] is not None and pair[1] is not None:
                links.add((pair[0], pair[1]))
    pairs = np.array(sorted(links), np.int64).reshape(-1, 2)
    return SumoNetwork(tuple(ids), np.array(lengths), np.array(speeds), pairs[:, 0], pairs[:, 1])


def _elements(path: Path) -> Iterator[ET.Element]:
    """Yield the elements of a network one by one; what was read is forgotten."""
    depth = 0
    for event, element in ET.iterparse(path, ("start", "end")):
        depth += 1 if event == "start" else -1
        if event == "end" and depth == 1:
            yield element
            element.clear()


def _for_cars(lane: ET.Element) -> bool:
    allowed = lane.get("allow")
    if allowed is not None:
        return _CARS in allowed.split() or allowed == "all"
    return not {_CARS, "all"} & set(lane.get("disallow", "").split())


@record
class Trip:
    """A car that goes from one edge to another."""

    depart_s: float
    origin: str
    destination: str


def make_trips(network: SumoNetwork, request: Request) -> list[Trip]:
    """Return the cars of a quarter of an hour, in the order in which they set out."""
    hourly = _hourly(network, request)
    leaving = np.where(network.entrances, hourly.through, hourly.local)
    arriving = np.where(network.exits, hourly.through, hourly.local)
    if not len(network.id) or not leaving.any() or not arriving.any():
        return []
    count = int(np.clip(leaving.sum() * _DEMAND_S / 3600.0, _LEAST_TRIPS, _MOST_TRIPS))
    k = np.arange(1, count + 1)
    origins = _drawn(leaving, (k / _PLASTIC) % 1.0)
    pairs = zip(origins.tolist(), _destinations(network, origins, arriving), strict=True)
    return [Trip(_DEMAND_S / count * n, network.id[a], network.id[b]) for n, (a, b) in enumerate(pairs)]


@record(eq=False)
class _Hourly:
    """Vehicles per hour and direction of each edge."""

    through: FloatArray  # Where it leads into the area or out of it
    local: FloatArray  # Elsewhere


def _hourly(network: SumoNetwork, request: Request) -> _Hourly:
    source = open_osm_file(request.area)
    ways, _ = read_ways(source, HIGHWAYS, {"highway"})
    classes = {way.id: class_of(way.tags).removesuffix("_link") for way in ways}
    daily = {
        str(road.id): max(
            (_VEHICLES_PER_DAY.get(classes.get(way, ""), _LOCAL_VEHICLES_PER_DAY) for way in road.osm_way_ids),
            default=_LOCAL_VEHICLES_PER_DAY,
        )
        for road in request.conversion.road_map.roads
    }
    share = 0.5 * _ONE_HOUR
    through = share * np.array([daily.get(road, _LOCAL_VEHICLES_PER_DAY) for road in network.road])
    through[network.length < _LEAST_EDGE] = 0.0
    local = np.where(through > share * _LOCAL_VEHICLES_PER_DAY, 0.0, through)
    return _Hourly(through, local)


def _drawn(weight: FloatArray, share: FloatArray) -> IntArray:
    """Return the items at shares, 0 to 1, of the sum of all weights."""
    total = np.cumsum(weight)
    found: IntArray = np.minimum(np.searchsorted(total, share * total[-1], side="right"), len(weight) - 1)
    return found


def _destinations(network: SumoNetwork, origins: IntArray, weight: FloatArray) -> list[int]:
    """Return where cars from each edge go: to its end, where no other place can be reached."""
    count = len(network.id)
    metres = csr_matrix((network.length[network.end], (network.start, network.end)), shape=(count, count))
    out: list[int] = origins.tolist()
    places = sorted_unique(origins)
    for at in range(0, len(places), _BLOCK):
        block = places[at : at + _BLOCK]
        for place, far in zip(block.tolist(), dijkstra(metres, indices=block), strict=True):
            there = np.isfinite(far) & (weight > 0.0)
            there[place] = False
            if not there.any():
                continue
            shortest = min(_SHORTEST_M, _SHORTEST_SHARE * float(far[there].max()))
            wanted = np.where(there & (far >= shortest), weight, 0.0)
            for k in np.flatnonzero(origins == place).tolist():
                out[k] = int(_drawn(wanted, np.array([((k + 1) / _PLASTIC**2) % 1.0]))[0])
    return out
