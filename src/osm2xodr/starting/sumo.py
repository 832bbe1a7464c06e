"""SUMO: the network that its netconvert makes of the file, traffic on it, and a configuration that runs both."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Final

from osm2xodr.conventions import programmes_file
from osm2xodr.errors import InputError, OutputError
from osm2xodr.starting.demand import make_trips
from osm2xodr.starting.request import FOLDER, Made, Request
from osm2xodr.starting.sumo_network import read_network
from osm2xodr.system import DATA_OF_OTHERS

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
