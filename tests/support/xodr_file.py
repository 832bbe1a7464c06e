"""A small strict reader of OpenDRIVE for tests, written from the standard and not from the product.

It knows lines and arcs, cubic profiles and lanes with widths, and raises `ValueError` on everything else, so that a
figure is never measured on half of a file. Lengths in m, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from clothoids import clothoid
from lxml import etree

FloatArray = npt.NDArray[np.float64]

CAR_LANES = frozenset({"driving", "bidirectional"})
# How far a station may lie beyond an end and still be meant to be on the road: rounding of s.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Cubics:
    """Records (s, a, b, c, d) of one piecewise cubic; empty means 0 everywhere."""

    records: FloatArray

    def _at(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        row = np.searchsorted(self.records[:, 0], s + ROUNDING, side="right") - 1
        if np.any(row < 0):
            raise ValueError("a station lies before the first record")
        return self.records[row], s - self.records[row, 0]

    def value(self, s: FloatArray) -> FloatArray:
        if not len(self.records):
            return np.zeros_like(s)
        r, d = self._at(s)
        return np.asarray(r[:, 1] + d * (r[:, 2] + d * (r[:, 3] + d * r[:, 4])))

    def slope(self, s: FloatArray) -> FloatArray:
        if not len(self.records):
            return np.zeros_like(s)
        r, d = self._at(s)
        return np.asarray(r[:, 2] + d * (2 * r[:, 3] + 3 * d * r[:, 4]))


@dataclass(frozen=True)
class Geometry:
    """One line (curvature 0), arc or spiral of a reference line."""

    s: float
    x: float
    y: float
    hdg: float
    length: float
    curvature: float
    rate: float = 0.0  # Of a spiral: change of curvature per m

    @property
    def turn(self) -> float:
        """The angle from its start to its end, rad."""
        return self.length * (self.curvature + self.rate * self.length / 2)

    def pose(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y and heading at stations of the road (chord of an arc: 2 sin(k ds / 2) / k)."""
        ds = s - self.s
        if self.rate:
            place, turn = clothoid(self.curvature, self.rate, ds)
            place = place * np.exp(1j * self.hdg)
            return self.x + place.real, self.y + place.imag, self.hdg + turn
        half = 0.5 * self.curvature * ds
        chord = ds * np.sinc(half / math.pi)
        return (
            self.x + chord * np.cos(self.hdg + half),
            self.y + chord * np.sin(self.hdg + half),
            self.hdg + 2 * half,
        )


@dataclass(frozen=True)
class Lane:
    """A lane but for the centre lane."""

    id: int
    type: str
    width: Cubics
    predecessors: tuple[int, ...]
    successors: tuple[int, ...]


@dataclass(frozen=True)
class Section:
    """The lanes from s to `end`, without the centre lane."""

    s: float
    end: float
    lanes: dict[int, Lane]

    def edges(self, lane_id: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t of a lane's inner and outer edge at stations of the road, the lane offset left out."""
        sign = 1 if lane_id > 0 else -1
        outer = np.zeros_like(s)
        inner = outer
        for k in range(sign, lane_id + sign, sign):
            inner, outer = outer, outer + sign * self.lanes[k].width.value(s - self.s)
        return inner, outer


@dataclass(frozen=True)
class Link:
    """What lies beyond a road's end."""

    element_type: str
    element_id: str
    contact_point: str | None


@dataclass(frozen=True)
class Road:
    """A road of the file."""

    id: str
    length: float
    junction: str
    left_hand: bool
    geometries: tuple[Geometry, ...]
    elevation: Cubics
    superelevation: Cubics
    lane_offset: Cubics
    sections: tuple[Section, ...]
    predecessor: Link | None
    successor: Link | None

    @property
    def connecting(self) -> bool:
        return self.junction != "-1"

    def forward(self, lane_id: int) -> bool:
        """Whether traffic on the lane runs along s."""
        return (lane_id < 0) != self.left_hand

    def pose(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y and heading of the reference line."""
        starts = np.array([g.s for g in self.geometries])
        which = np.clip(np.searchsorted(starts, s + ROUNDING, side="right") - 1, 0, None)
        x, y, hdg = np.empty_like(s), np.empty_like(s), np.empty_like(s)
        for k in np.unique(which):
            at = which == k
            x[at], y[at], hdg[at] = self.geometries[k].pose(s[at])
        return x, y, hdg

    def points(self, s: FloatArray, t: FloatArray) -> FloatArray:
        """Return x, y, z (n, 3) of points beside the reference line."""
        x, y, hdg = self.pose(s)
        z = self.elevation.value(s) + t * np.tan(self.superelevation.value(s))
        return np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg), z])

    def lane_middle(self, section: int, lane_id: int, s: FloatArray) -> FloatArray:
        """Return x, y, z (n, 3) of a lane's middle at stations of the road."""
        inner, outer = self.sections[section].edges(lane_id, s)
        return self.points(s, (inner + outer) / 2 + self.lane_offset.value(s))

    def section(self, at_start: bool) -> Section:
        return self.sections[0 if at_start else -1]

    def lane_end(self, lane_id: int, at_start: bool) -> tuple[FloatArray, float, float]:
        """Return a lane's edges (2, 3) at an end of the road, and heading and grade of traffic on it there."""
        s = np.array([0.0 if at_start else self.length])
        inner, outer = self.section(at_start).edges(lane_id, s)
        offset = self.lane_offset.value(s)
        edges = np.vstack([self.points(s, inner + offset), self.points(s, outer + offset)])
        hdg, grade = float(self.pose(s)[2][0]), float(self.elevation.slope(s)[0])
        return (edges, hdg, grade) if self.forward(lane_id) else (edges, hdg + math.pi, -grade)


@dataclass(frozen=True)
class Connection:
    """One way through a junction."""

    id: str
    incoming: str
    connecting: str
    contact_point: str
    lane_links: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Junction:
    """A junction of the file."""

    id: str
    connections: tuple[Connection, ...]


@dataclass(frozen=True)
class XodrFile:
    """All roads and junctions; `ids` are those of roads and junctions as they stand, repetitions included."""

    version: str
    georeference: str
    roads: dict[str, Road]
    junctions: dict[str, Junction]
    ids: tuple[str, ...]


def read_xodr(path: Path) -> XodrFile:
    """Read a file; raise `ValueError` on what this reader does not know or the standard does not allow."""
    root = etree.parse(str(path), etree.XMLParser(huge_tree=True)).getroot()
    header = _only(root, "header")
    if header.find("offset") is not None:
        raise ValueError("the header has an offset")
    roads = [_road(e) for e in root.findall("road")]
    junctions = [_junction(e) for e in root.findall("junction")]
    return XodrFile(
        f"{_text(header, 'revMajor')}.{_text(header, 'revMinor')}",
        (header.findtext("geoReference") or "").strip(),
        {r.id: r for r in roads},
        {j.id: j for j in junctions},
        tuple([r.id for r in roads] + [j.id for j in junctions]),
    )


def _only(parent: etree._Element, tag: str) -> etree._Element:
    found = parent.findall(tag)
    if len(found) != 1:
        raise ValueError(f"<{parent.tag} id={parent.get('id')}> has {len(found)} <{tag}>")
    return found[0]


def _text(element: etree._Element, name: str) -> str:
    return str(element.attrib[name])


def _number(element: etree._Element, name: str) -> float:
    value = float(element.attrib[name])
    if not math.isfinite(value):
        raise ValueError(f"<{element.tag!s}> has {name}={value}")
    return value


def _cubics(elements: list[etree._Element], s: str = "s") -> Cubics:
    records = [[_number(e, name) for name in (s, "a", "b", "c", "d")] for e in elements]
    table = np.array(records, np.float64).reshape(-1, 5)
    if len(table) and (table[0, 0] != 0.0 or np.any(np.diff(table[:, 0]) <= 0)):
        raise ValueError(f"records of <{elements[0].tag}> do not start at 0 or do not ascend: {table[:, 0].tolist()}")
    return Cubics(table)


def _geometry(element: etree._Element) -> Geometry:
    shapes = [child for child in element if child.tag != "userData"]
    if len(shapes) != 1 or shapes[0].tag not in ("line", "arc", "spiral"):
        raise ValueError(f"a <geometry> holds {[child.tag for child in shapes]}")
    curvature = _number(shapes[0], "curvature") if shapes[0].tag == "arc" else 0.0
    s, x, y, hdg, length = (_number(element, name) for name in ("s", "x", "y", "hdg", "length"))
    if shapes[0].tag != "spiral":
        return Geometry(s, x, y, hdg, length, curvature)
    first, last = (_number(shapes[0], name) for name in ("curvStart", "curvEnd"))
    return Geometry(s, x, y, hdg, length, first, (last - first) / length)


def _link(element: etree._Element, tag: str) -> Link | None:
    link = element.find(f"link/{tag}")
    if link is None:
        return None
    kind, contact = _text(link, "elementType"), link.get("contactPoint")
    if (kind, contact) not in (("junction", None), ("road", "start"), ("road", "end")):
        raise ValueError(f"road {element.get('id')}: {tag} is a {kind} with contact point {contact}")
    return Link(kind, _text(link, "elementId"), contact)


def _lane(element: etree._Element) -> Lane:
    if element.find("border") is not None or not element.findall("width"):
        raise ValueError("a lane has a border or no width")

    def linked(tag: str) -> tuple[int, ...]:
        return tuple(int(e.attrib["id"]) for e in element.findall(f"link/{tag}"))

    widths = _cubics(element.findall("width"), "sOffset")
    return Lane(int(element.attrib["id"]), _text(element, "type"), widths, linked("predecessor"), linked("successor"))


def _section(element: etree._Element, end: float) -> Section:
    left, centre, right = ([int(e.attrib["id"]) for e in element.findall(f"{side}/lane")] for side in _SIDES)
    if centre != [0] or min(left, default=1) < 1 or max(right, default=-1) > -1:
        raise ValueError(f"lanes stand on the wrong side: {left} {centre} {right}")
    order = left + right
    if order != sorted(order, reverse=True) or len(set(order)) != len(order):
        raise ValueError(f"lane ids {order} do not descend from left to right")
    if set(order) | {0} != set(range(min([*order, 0]), max([*order, 0]) + 1)):
        raise ValueError(f"lane ids {order} have a hole")
    lanes = [_lane(e) for side in ("left", "right") for e in element.findall(f"{side}/lane")]
    return Section(_number(element, "s"), end, {lane.id: lane for lane in lanes})


_SIDES = ("left", "center", "right")


def _road(element: etree._Element) -> Road:
    length = _number(element, "length")
    sections = _only(element, "lanes").findall("laneSection")
    starts = [_number(e, "s") for e in sections]
    if not starts or starts[0] != 0.0 or starts != sorted(set(starts)) or starts[-1] >= length:
        raise ValueError(f"road {element.get('id')} of length {length} has lane sections at {starts}")
    return Road(
        _text(element, "id"),
        length,
        _text(element, "junction"),
        element.get("rule", "RHT") == "LHT",
        tuple(_geometry(e) for e in _only(element, "planView")),
        _cubics(element.findall("elevationProfile/elevation")),
        _cubics(element.findall("lateralProfile/superelevation")),
        _cubics(element.findall("lanes/laneOffset")),
        tuple(_section(e, end) for e, end in zip(sections, [*starts[1:], length], strict=True)),
        _link(element, "predecessor"),
        _link(element, "successor"),
    )


def _junction(element: etree._Element) -> Junction:
    connections = []
    for c in element.findall("connection"):
        links = tuple((int(e.attrib["from"]), int(e.attrib["to"])) for e in c.findall("laneLink"))
        own_id, incoming, connecting = (_text(c, name) for name in ("id", "incomingRoad", "connectingRoad"))
        connections.append(Connection(own_id, incoming, connecting, _text(c, "contactPoint"), links))
    return Junction(_text(element, "id"), tuple(connections))
