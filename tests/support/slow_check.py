"""Counts gaps, kinks and broken references of OpenDRIVE files link by link, in plain Python, to hold `check` against.

Written from the standard and not from the product; knows lines, arcs and paramPoly3, raises on other shapes.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from clothoids import clothoid

Element = ElementTree.Element
Row = tuple[float, float, float, float, float]

# Lanes that cars drive on.
CAR_LANES = frozenset({"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "bus", "taxi", "HOV"})
GAP, KINK_DEG, GRADE, LENGTH = 0.01, 1.0, 0.005, 0.001


def number(element: Element, name: str) -> float:
    return float(element.attrib[name])


def rows(elements: list[Element], start: str = "s") -> list[Row]:
    return [(number(e, start), number(e, "a"), number(e, "b"), number(e, "c"), number(e, "d")) for e in elements]


def value(records: list[Row], s: float) -> tuple[float, float]:
    """Return value and slope of piecewise cubics."""
    found = (0.0, 0.0, 0.0, 0.0, 0.0)
    for k, record in enumerate(records):
        if k == 0 or record[0] <= s + 1e-9:
            found = record
    ds = s - found[0]
    _, a, b, c, d = found
    return a + b * ds + c * ds**2 + d * ds**3, b + 2 * c * ds + 3 * d * ds**2


def turn(angle: float) -> float:
    return abs(math.degrees(math.remainder(angle, 2 * math.pi)))


def pose(geometry: Element, ds: float) -> tuple[float, float, float]:
    """Return x, y and heading at ds of a record; of paramPoly3 only at its ends."""
    shape = next(child for child in geometry if child.tag in ("line", "arc", "spiral", "paramPoly3"))
    length = number(geometry, "length")
    if shape.tag == "paramPoly3":
        p = ds / length if shape.get("pRange", "normalized") == "normalized" else ds
        u, v, du, dv = parametric(shape, p)
        bend = math.atan2(dv, du)
    elif shape.tag == "spiral":
        first, last = number(shape, "curvStart"), number(shape, "curvEnd")
        place, turned = clothoid(first, (last - first) / length, ds)
        u, v, bend = float(place.real), float(place.imag), float(turned)
    else:
        k = number(shape, "curvature") if shape.tag == "arc" else 0.0
        bend = k * ds
        u, v = (math.sin(bend) / k, (1 - math.cos(bend)) / k) if abs(bend) > 1e-12 else (ds, 0.0)
    hdg = number(geometry, "hdg")
    cos, sin = math.cos(hdg), math.sin(hdg)
    return number(geometry, "x") + cos * u - sin * v, number(geometry, "y") + sin * u + cos * v, hdg + bend


def parametric(shape: Element, p: float) -> tuple[float, float, float, float]:
    """Return u, v and their derivatives."""
    out = []
    for letter in ("U", "V"):
        a, b, c, d = (number(shape, f"{name}{letter}") for name in "abcd")
        out.append((a + b * p + c * p**2 + d * p**3, b + 2 * c * p + 3 * d * p**2))
    return out[0][0], out[1][0], out[0][1], out[1][1]


def true_length(geometry: Element) -> float:
    """Return the length along a record, for paramPoly3 by 400 chords."""
    shape = geometry.find("paramPoly3")
    length = number(geometry, "length")
    if shape is None:
        return length
    end = 1.0 if shape.get("pRange", "normalized") == "normalized" else length
    points = [parametric(shape, end * k / 400)[:2] for k in range(2001)]
    return sum(math.dist(points[k], points[k + 1]) for k in range(400))


@dataclass
class Lane:
    type: str
    width: list[Row]
    links: dict[str, list[int]]


@dataclass
class Section:
    s: float
    lanes: dict[int, Lane]

    def edges(self, lane: int, s: float) -> tuple[float, float]:
        """Return t of a lane's inner and outer edge, the lane offset left out."""
        sign = 1 if lane > 0 else -1
        inner = outer = 0.0
        for k in range(sign, lane + sign, sign):
            inner = outer
            outer += sign * value(self.lanes[k].width, s - self.s)[0] if k in self.lanes else 0.0
        return inner, outer


class Road:
    """A road, as far as ends of lanes need it."""

    def __init__(self, element: Element) -> None:
        self.id = element.attrib["id"]
        self.length = number(element, "length")
        self.junction = element.get("junction", "-1")
        self.left_hand = element.get("rule") == "LHT"
        self.geometries = element.findall("planView/geometry")
        self.elevation = rows(element.findall("elevationProfile/elevation"))
        self.bank = rows(element.findall("lateralProfile/superelevation"))
        self.offset = rows(element.findall("lanes/laneOffset"))
        self.sections = [self._section(e) for e in element.findall("lanes/laneSection")]
        self.link = {
            tag: None if e is None else (e.attrib["elementType"], e.attrib["elementId"], e.get("contactPoint"))
            for tag, e in ((tag, element.find(f"link/{tag}")) for tag in ("predecessor", "successor"))
        }

    @staticmethod
    def _section(element: Element) -> Section:
        lanes = {}
        for lane in element.iter("lane"):
            links = {
                tag: [int(e.attrib["id"]) for e in lane.findall(f"link/{tag}")]
                for tag in ("predecessor", "successor")
            }
            lanes[int(lane.attrib["id"])] = Lane(lane.attrib["type"], rows(lane.findall("width"), "sOffset"), links)
        return Section(number(element, "s"), lanes)

    def section(self, at_end: bool) -> Section:
        return self.sections[-1 if at_end else 0]

    def middle(self, at_end: bool) -> tuple[float, float, float]:
        geometry = self.geometries[-1 if at_end else 0]
        return pose(geometry, number(geometry, "length") if at_end else 0.0)

    def lane_end(self, lane: int, at_end: bool) -> tuple[list[tuple[float, float, float]], float, float]:
        """Return both edges of a lane at an end, and heading and grade of its traffic."""
        s = self.length if at_end else 0.0
        x, y, hdg = self.middle(at_end)
        z, grade = value(self.elevation, s)
        bank = value(self.bank, s)[0]
        offset = value(self.offset, s)[0]
        points = []
        for t in self.section(at_end).edges(lane, s):
            across = (t + offset) * math.cos(bank)
            points.append((x - math.sin(hdg) * across, y + math.cos(hdg) * across, z + (t + offset) * math.sin(bank)))
        forward = (lane < 0) != self.left_hand
        return points, hdg + (0.0 if forward else math.pi), grade if forward else -grade


End = tuple[Road, bool, int]


def slow_counts(path: Path) -> Counter[str]:
    """Return how often each rule is broken; ``broken-references`` stands for several rules at once."""
    root = ElementTree.parse(path).getroot()
    roads = {road.id: road for road in map(Road, root.findall("road"))}
    out: Counter[str] = Counter()
    for road in roads.values():
        count_inside(road, out)
    junctions = {e.attrib["id"] for e in root.findall("junction")}
    steps = list(road_steps(roads, junctions, out))
    for junction in root.findall("junction"):
        steps += connection_steps(junction, roads, out)
    for one, other in steps:
        count_step(one, other, out)
    return +out


def count_inside(road: Road, out: Counter[str]) -> None:
    """Count what is wrong within a road."""
    for geometry in road.geometries:
        out["record-length"] += abs(true_length(geometry) - number(geometry, "length")) > LENGTH
    for one, other in zip(road.geometries, road.geometries[1:], strict=False):
        x, y, hdg = pose(one, number(one, "length"))
        at_x, at_y, at_hdg = pose(other, 0.0)
        out["record-gap"] += math.hypot(at_x - x, at_y - y) > GAP
        out["record-kink"] += turn(at_hdg - hdg) > KINK_DEG
    for before, after in zip(road.elevation, road.elevation[1:], strict=False):
        z, grade = value([before], after[0])
        out["height-step"] += abs(after[1] - z) > GAP
        out["grade-step"] += abs(after[2] - grade) > GRADE


def road_steps(roads: dict[str, Road], junctions: set[str], out: Counter[str]) -> Iterator[tuple[End, End]]:
    """Yield the steps that roads name themselves."""
    for road in roads.values():
        for tag, link in road.link.items():
            if link is None:
                continue
            kind, name, contact = link
            if name not in (roads if kind == "road" else junctions):
                out["broken-references"] += 1
            elif kind == "road":
                other, at_end = roads[name], contact == "end"
                back = other.link["successor" if at_end else "predecessor"]
                if road.junction == "-1" and (back is None or back[:2] != ("road", road.id)):
                    out["broken-references"] += 1
                here = tag == "successor"
                for lane, data in road.section(here).lanes.items():
                    for to in data.links[tag]:
                        if to in other.section(at_end).lanes:
                            yield (road, here, lane), (other, at_end, to)
                        else:
                            out["broken-references"] += 1


def connection_steps(junction: Element, roads: dict[str, Road], out: Counter[str]) -> Iterator[tuple[End, End]]:
    """Yield the steps into a junction."""
    for connection in junction.findall("connection"):
        incoming, connecting = (roads.get(connection.get(f"{word}Road", "")) for word in ("incoming", "connecting"))
        if incoming is None or connecting is None:
            out["broken-references"] += 1
            continue
        at_end = connection.get("contactPoint") == "end"
        ends = [
            tag == "successor"
            for tag, link in incoming.link.items()
            if link is not None and link[:2] == ("junction", junction.attrib["id"])
        ]
        out["broken-references"] += not ends or connection.find("laneLink") is None
        place = connecting.middle(at_end)[:2]
        ends.sort(key=lambda end: math.dist(incoming.middle(end)[:2], place))
        for link in connection.findall("laneLink") if ends else []:
            lane, to = int(link.attrib["from"]), int(link.attrib["to"])
            if lane in incoming.section(ends[0]).lanes and to in connecting.section(at_end).lanes:
                yield (incoming, ends[0], lane), (connecting, at_end, to)
            else:
                out["broken-references"] += 1


def count_step(one: End, other: End, out: Counter[str]) -> None:
    """Count what is wrong where a lane goes over into another."""
    road, at_end, lane = one
    if road.section(at_end).lanes[lane].type not in CAR_LANES:
        return
    here, hdg, grade = road.lane_end(lane, at_end)
    there, other_hdg, other_grade = other[0].lane_end(other[2], other[1])
    middles = [[(a + b) / 2 for a, b in zip(*points, strict=True)][:2] for points in (here, there)]
    out["lane-gap"] += math.dist(*middles) > GAP
    out["lane-edge-gap"] += max(math.dist(a[:2], b[:2]) for a, b in zip(here, there, strict=True)) > GAP
    out["lane-height-step"] += max(abs(a[2] - b[2]) for a, b in zip(here, there, strict=True)) > GAP
    out["link-kink"] += turn(hdg - other_hdg) > KINK_DEG
    out["link-grade-step"] += abs(grade - other_grade) > GRADE
