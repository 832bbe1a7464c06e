"""Nodes, ways and relations of Lanelet2 as OSM XML, OpenDRIVE's words as its tags, and numbers of this export.

The tags are those of Lanelet2's documents LaneletPrimitives, LinestringTagging and RegulatoryElementTagging. Nodes
have latitude and longitude, and the coordinates that Autoware reads beside them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, islice
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive, frame_of
from osm2xodr.projection import make_frame, to_geographic, to_utm
from osm2xodr.system import ByteSink, record

# Lines of text that are written at a time.
_BLOCK: Final = 10_000

LOCAL: Final = "local"
MGRS: Final = "mgrs"
PROJECTORS: Final = (LOCAL, MGRS)

# Squares of MGRS, m, and the letters of its bands, columns and rows: NGA.STND.0037, Universal Grids and Grid
# Reference Systems, 2014, chapter 3.
_SQUARE: Final = 100_000.0
_BANDS: Final = "CDEFGHJKLMNPQRSTUVWX"
_GRID_COLUMNS: Final = ("STUVWXYZ", "ABCDEFGH", "JKLMNPQR")
_ROWS: Final = "ABCDEFGHJKLMNPQRSTUV"
_BAND_HEIGHT_DEG: Final = 8.0
_ZONE_WIDTH_DEG: Final = 6.0
_SOUTHERNMOST_DEG: Final = -80.0
_NORTHERNMOST_DEG: Final = 84.0
# Digits of each half of a grid reference: to 1 m.
_DIGITS: Final = 5

Tags = dict[str, str]

ROAD: Final = "road"
BUS_LANE: Final = "bus_lane"
# Kinds of lanelets that motor traffic turns on.
TURNING: Final = frozenset({ROAD, BUS_LANE})
_CAR_TEXT: Final = (
    "driving entry exit onRamp offRamp connectingRamp slipLane bidirectional mwyEntry mwyExit HOV shared"
)
_WALKS: Final = "walkway"
# Lanes with these types become lanelets: their subtype, and who may use them.
LANELETS: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    **{kind: (ROAD, ("vehicle", "bicycle")) for kind in _CAR_TEXT.split()},
    "bus": (BUS_LANE, ("vehicle:bus",)),
    "taxi": (BUS_LANE, ("vehicle:taxi",)),
    "biking": ("bicycle_lane", ("bicycle",)),
    "sidewalk": (_WALKS, ("pedestrian",)),
    "walking": (_WALKS, ("pedestrian",)),
}
MOTORWAY: Final = "motorway"
# Types of roads outside towns; other types are inside, and where a road has none its place is unknown.
_NONURBAN: Final = frozenset({"rural", MOTORWAY})
_UNKNOWN_PLACE: Final = frozenset({"", "unknown"})

# Road marks: type and subtype of the bound, and whether one may change lanes to the left and to the right of it,
# along s, where the mark does not say. Marks that are not listed are solid.
_THIN_LINE: Final = "line_thin"
_MARKS: Final = {
    "broken": (_THIN_LINE, "dashed", True, True),
    "broken broken": (_THIN_LINE, "dashed", True, True),
    "botts dots": (_THIN_LINE, "dashed", True, True),
    "solid": (_THIN_LINE, "solid", False, False),
    "solid solid": (_THIN_LINE, "solid_solid", False, False),
    # Who is on the side of the broken line may cross it.
    "solid broken": (_THIN_LINE, "solid_dashed", True, False),
    "broken solid": (_THIN_LINE, "dashed_solid", False, True),
    "curb": ("curbstone", "high", False, False),
    "grass": ("road_border", "", False, False),
    "edge": ("road_border", "", False, False),
}
_UNMARKED: Final = frozenset({"", "none"})
_TURNED_ROUND: Final = {"solid broken": "broken solid", "broken solid": "solid broken"}
# ``laneChange``, whose ids ascend from right to left: to the left, to the right.
_CHANGES: Final = {"both": (True, True), "none": (False, False), "increase": (True, False), "decrease": (False, True)}

# Ways through junctions that turn by more than this turn left or right, rad (30 degrees): a choice, between the turns
# that OSM's wiki calls slight (35 degrees and more) and the bends of ways that lead straight on.
TURN_LEAST: Final = 0.5236
# Lanes that are nowhere wider than this are no lanelets, m: it is less than any road mark.
NARROWEST: Final = 0.01
# Lanelets that are longer, m, or turn by more, rad, or by some of both, are divided: CommonRoad's designer tells the
# sides of lanelets apart in a frame along them, which it cannot make around hairpins. Choices.
LONGEST: Final = 200.0
MOST_TURN: Final = 3.1416
# Points of a bound that are closer together than this are one, m: readers divide by their distance.
CLOSEST: Final = 0.01
# Ends of linked lanes that are farther apart than this are reported, m: the checker's lane gaps are small below it.
GAP_REPORTED: Final = 0.10
# Kerbs lower than this are ``low``, m: rolled ones have 0.05 (`osm2xodr.defaults.KERB_HEIGHT`), usual ones 0.12.
KERB_LOW: Final = 0.06
# Height of a light's or a sign's body where the file has none, m: a usual signal head with three lenses of 0.2 m
# (EN 12368) is 0.9 m high.
LIGHT_HEIGHT: Final = 0.9
SIGN_HEIGHT: Final = 0.6
# Width of the same, m.
BODY_WIDTH: Final = 0.3


@dataclass
class Line:
    """A way: numbers of nodes, and its tags."""

    nodes: list[int]
    tags: Tags


@dataclass
class Lanelet:
    """A lanelet: numbers of the lines that bound it in the direction of traffic, and its tags."""

    left: int
    right: int
    tags: Tags
    rules: list[int] = field(default_factory=list)  # Numbers of its regulatory elements


@dataclass
class Rule:
    """A regulatory element: role, kind (``way`` or ``lanelet``) and number of its members, and its tags."""

    members: list[tuple[str, str, int]]
    tags: Tags


class Primitives:
    """All nodes, ways, lanelets and regulatory elements; each has a number among its kind."""

    def __init__(self) -> None:
        self._points: list[FloatArray] = []
        self._count = 0
        self.lines: list[Line] = []
        self.lanelets: list[Lanelet] = []
        self.rules: list[Rule] = []

    def add_points(self, points: FloatArray) -> list[int]:
        """Add nodes at x, y, z, (n, 3), m, and return their numbers."""
        first = self._count
        self._points.append(points)
        self._count += len(points)
        return list(range(first, self._count))

    def add_line(self, nodes: list[int], tags: Tags) -> int:
        """Add a way and return its number."""
        self.lines.append(Line(nodes, tags))
        return len(self.lines) - 1

    def add_lanelet(self, left: int, right: int, tags: Tags) -> int:
        """Add a lanelet and return its number."""
        self.lanelets.append(Lanelet(left, right, tags))
        return len(self.lanelets) - 1

    def add_rule(self, members: list[tuple[str, str, int]], tags: Tags, lanelets: list[int]) -> None:
        """Add a regulatory element that holds for some lanelets."""
        for lanelet in lanelets:
            self.lanelets[lanelet].rules.append(len(self.rules))
        self.rules.append(Rule(members, tags))

    def points(self) -> FloatArray:
        """Return x, y, z of all nodes, (n, 3), m."""
        return np.concatenate(self._points) if self._points else np.zeros((0, 3))


def write_document(primitives: Primitives, places: Places, credit: str, version: str, stream: ByteSink) -> None:
    """Write OSM XML; ids count from 1 over nodes, ways and relations, for Lanelet2 has one space of ids for all."""
    source = f" attribution={quoteattr(credit)}" if credit else ""
    head = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<osm version="0.6" generator="osm2xodr {version}"{source}>',
        ' <MetaInfo format_version="1" map_version="1"/>',
    ]
    lines = chain(head, _nodes(places), _ways(primitives, len(places.lat)), _relations(primitives, len(places.lat)))
    while block := list(islice(lines, _BLOCK)):
        stream.write(("\n".join(block) + "\n").encode())
    stream.write(b"</osm>\n")


def _nodes(places: Places) -> Iterator[str]:
    """Yield nodes, to 0.1 mm."""
    columns = (places.lat, places.lon, places.height, places.local_x, places.local_y)
    # A negative zero has another text.
    rows = zip(*((column + 0.0).tolist() for column in columns), strict=True)
    codes = grid_references(places) if places.square else None
    for k, (lat, lon, height, x, y) in enumerate(rows):
        code = f'<tag k="mgrs_code" v="{codes[k]}"/>' if codes else ""
        yield (
            f' <node id="{k + 1}" version="1" lat="{lat:.9f}" lon="{lon:.9f}"><tag k="ele" v="{height:.4f}"/>'
            f'<tag k="local_x" v="{x:.4f}"/><tag k="local_y" v="{y:.4f}"/>{code}</node>'
        )


def _ways(primitives: Primitives, nodes: int) -> Iterator[str]:
    """Yield ways after a number of nodes."""
    for k, line in enumerate(primitives.lines):
        members = "".join(f'<nd ref="{node + 1}"/>' for node in line.nodes)
        yield f' <way id="{nodes + k + 1}" version="1">{members}{_tags(line.tags)}</way>'


def _relations(primitives: Primitives, nodes: int) -> Iterator[str]:
    """Yield lanelets and regulatory elements after the ways."""
    first = nodes + len(primitives.lines) + 1
    rules = first + len(primitives.lanelets)
    for k, lanelet in enumerate(primitives.lanelets):
        members = [("way", nodes + lanelet.left + 1, "left"), ("way", nodes + lanelet.right + 1, "right")]
        members += [("relation", rules + rule, "regulatory_element") for rule in lanelet.rules]
        yield _relation(first + k, members, lanelet.tags)
    for k, rule in enumerate(primitives.rules):
        found = [
            ("way", nodes + number + 1, role) if kind == "way" else ("relation", first + number, role)
            for role, kind, number in rule.members
        ]
        yield _relation(rules + k, found, rule.tags)


def _relation(number: int, members: list[tuple[str, int, str]], tags: Tags) -> str:
    text = "".join(f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members)
    return f' <relation id="{number}" version="1">{text}{_tags(tags)}</relation>'


def _tags(tags: Tags) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())


@record
class Places:
    """Nodes on Earth and in the coordinates of Autoware."""

    # (n,) Degrees, WGS 84
    lat: FloatArray
    lon: FloatArray
    height: FloatArray  # (n,) m, in whatever datum the file was made with
    # (n,) `LOCAL`: those of the file; `MGRS`: east and north in the square, m
    local_x: FloatArray
    local_y: FloatArray
    square: str  # Of MGRS; empty without


def place(file: OpenDrive, points: FloatArray, projector: str) -> tuple[Places, str]:
    """Return where points (n, 3) of a file are, and a sentence if that is not known; then they lie around 0° N, 0° E.

    All count from the square of MGRS that their middle lies in. `InputError` if MGRS has no place for them.
    """
    x, y, z = points.T
    frame, reason = frame_of(file.header)
    if frame is None:
        if projector == MGRS:
            raise InputError(f"{file.path}: {reason}, and MGRS counts from there; leave the projector out, or local")
        lon, lat = to_geographic(make_frame(0.0, 0.0), x, y)
        return Places(lat, lon, z, x, y, ""), f"{reason}; latitude and longitude count from 0, 0"
    lon, lat = frame.to_geographic(x, y)
    height = frame.height(z)
    if not np.isfinite(lon + lat).all():
        raise InputError(f"{file.path}: some lanes lie outside the projection of the file; osm2xodr check lists them")
    if projector != MGRS or not len(x):
        return Places(lat, lon, height, x, y, ""), ""
    east, north, square = _grid(lat, lon)
    return Places(lat, lon, height, east, north, square), ""


def projector_info(projector: str, square: str) -> str:
    """Return Autoware's map_projector_info.yaml.

    Heights of elevation models are mostly above the geoid, which Autoware knows as EGM2008.
    """
    if projector == LOCAL:
        return "projector_type: Local\n"
    return f"projector_type: MGRS\nvertical_datum: EGM2008\nmgrs_grid: {square}\n"


def grid_references(places: Places) -> list[str]:
    """Return the grid reference of each node, to 1 m."""
    most = 10**_DIGITS - 1
    halves = [np.clip(column, 0, most).astype(np.int64) for column in (places.local_x, places.local_y)]
    return [f"{places.square}{x:0{_DIGITS}d}{y:0{_DIGITS}d}" for x, y in zip(*halves, strict=True)]


def _grid(lat: FloatArray, lon: FloatArray) -> tuple[FloatArray, FloatArray, str]:
    """Return east and north (m) from the corner of the square that the middle of places lies in, and its name."""
    lat_0, lon_0 = float(lat.min() + lat.max()) / 2, float(lon.min() + lon.max()) / 2
    if not _SOUTHERNMOST_DEG <= lat_0 < _NORTHERNMOST_DEG:
        raise InputError(f"MGRS in zones of UTM ends at 80° S and 84° N, and the map lies at {lat_0:.2f}; use local")
    zone = _zone(lat_0, lon_0)
    band = _BANDS[min(int((lat_0 - _SOUTHERNMOST_DEG) // _BAND_HEIGHT_DEG), len(_BANDS) - 1)]
    east, north = to_utm(lon, lat, zone, south=lat_0 < 0)
    column = math.floor((east.min() + east.max()) / 2 / _SQUARE)
    row = math.floor((north.min() + north.max()) / 2 / _SQUARE)
    # Rows of even zones begin five letters later.
    letters = _GRID_COLUMNS[zone % 3][column - 1] + _ROWS[(row + (0 if zone % 2 else 5)) % len(_ROWS)]
    return east - column * _SQUARE, north - row * _SQUARE, f"{zone}{band}{letters}"


def _zone(lat: float, lon: float) -> int:
    """Return the zone of UTM of a place, degrees; Norway and Svalbard have wider ones."""
    zone = int((lon + 180.0) % 360.0 // _ZONE_WIDTH_DEG) + 1
    if 56.0 <= lat < 64.0 and 3.0 <= lon < 12.0:
        return 32
    if lat >= 72.0 and 0.0 <= lon < 42.0:
        return 31 if lon < 9.0 else 33 if lon < 21.0 else 35 if lon < 33.0 else 37
    return zone


@record
class Mark:
    """A road mark as a bound: what it looks like, and where one may change lanes across it, along s."""

    type: str
    subtype: str
    to_left: bool
    to_right: bool

    def tags(self) -> Tags:
        """Return the tags of the bound."""
        tags = {"type": self.type, **({"subtype": self.subtype} if self.subtype else {})}
        if self.to_left == self.to_right:
            return {**tags, "lane_change": _yes(self.to_left)}
        return {**tags, "lane_change:left": _yes(self.to_left), "lane_change:right": _yes(self.to_right)}


def mark_of(kind: str, change: str, *, outwards_left: bool, low: bool, bare: str) -> Mark:
    """Return a road mark as a bound.

    `outwards_left` says that the mark belongs to a lane left of the centre, whose double lines count from the inside
    to the outside; `low` that a kerb is one that wheels can cross; `bare` is the type of a bound without a mark.
    """
    if kind in _UNMARKED:
        stated = _CHANGES.get(change, (bare == "virtual",) * 2)
        return Mark(bare, "", *stated)
    if outwards_left:
        kind = _TURNED_ROUND.get(kind, kind)
    type_, subtype, left, right = _MARKS.get(kind, _MARKS["solid"])
    if low and type_ == "curbstone":
        subtype = "low"
    return Mark(type_, subtype, *_CHANGES.get(change, (left, right)))


def location_of(road_type: str) -> str:
    """Return where a road of a type is: ``urban``, ``nonurban``, or nothing where that is unknown."""
    if road_type in _UNKNOWN_PLACE:
        return ""
    return "nonurban" if road_type in _NONURBAN else "urban"


def lanelet_tags(
    subtype: str, participants: tuple[str, ...], *, location: str, both_ways: bool, speed: float
) -> Tags:
    """Return the tags of a lanelet; `speed` is its limit, m/s, NaN where unknown and infinite where there is none.

    Limits are in km/h without a unit, Lanelet2's default, for Autoware reads no unit.
    """
    tags = {"type": "lanelet", "subtype": subtype}
    if location:
        tags["location"] = location
    tags["one_way"] = _yes(not both_ways)
    if math.isfinite(speed):
        tags["speed_limit"] = f"{round(3.6 * speed, 2):g}"
    return {**tags, **{f"participant:{who}": "yes" for who in participants}}


def sign_type(country: str, kind: str, subtype: str) -> str:
    """Return a traffic sign as Lanelet2 names it: country and code, such as de274-50."""
    name = f"{'' if country == 'OpenDRIVE' else country.lower()}{kind}"
    return name if subtype in ("", "-1", "none") else f"{name}-{subtype}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
