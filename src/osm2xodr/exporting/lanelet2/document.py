"""Nodes, ways and relations as OSM XML: where nodes are by latitude and longitude, and in Autoware's coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, islice
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from osm2xodr.errors import InputError
from osm2xodr.exporting.lanelet2.words import Tags
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive, frame_of
from osm2xodr.projection import make_frame, to_geographic, to_utm
from osm2xodr.system import ByteSink

# Lines of text that are written at a time.
_BLOCK: Final = 10_000

LOCAL: Final = "local"
MGRS: Final = "mgrs"
PROJECTORS: Final = (LOCAL, MGRS)

# Squares of MGRS, m, and the letters of its bands, columns and rows: NGA.STND.0037, Universal Grids and Grid
# Reference Systems, 2014, chapter 3.
_SQUARE: Final = 100_000.0
_BANDS: Final = "CDEFGHJKLMNPQRSTUVWX"
_COLUMNS: Final = ("STUVWXYZ", "ABCDEFGH", "JKLMNPQR")
_ROWS: Final = "ABCDEFGHJKLMNPQRSTUV"
_BAND_HEIGHT_DEG: Final = 8.0
_ZONE_WIDTH_DEG: Final = 6.0
_SOUTHERNMOST_DEG: Final = -80.0
_NORTHERNMOST_DEG: Final = 84.0
# Digits of each half of a grid reference: to 1 m.
_DIGITS: Final = 5


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


@dataclass(frozen=True)
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
    letters = _COLUMNS[zone % 3][column - 1] + _ROWS[(row + (0 if zone % 2 else 5)) % len(_ROWS)]
    return east - column * _SQUARE, north - row * _SQUARE, f"{zone}{band}{letters}"


def _zone(lat: float, lon: float) -> int:
    """Return the zone of UTM of a place, degrees; Norway and Svalbard have wider ones."""
    zone = int((lon + 180.0) % 360.0 // _ZONE_WIDTH_DEG) + 1
    if 56.0 <= lat < 64.0 and 3.0 <= lon < 12.0:
        return 32
    if lat >= 72.0 and 0.0 <= lon < 42.0:
        return 31 if lon < 9.0 else 33 if lon < 21.0 else 35 if lon < 33.0 else 37
    return zone
