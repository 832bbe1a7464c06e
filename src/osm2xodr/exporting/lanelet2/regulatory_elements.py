"""Lights, signs, stop lines, crosswalks and the right of way as lines, lanelets and regulatory elements.

Crosswalks are lanelets for walkers.
"""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Final

import numpy as np

from osm2xodr.defaults import SIGN_REACH
from osm2xodr.exporting.geojson import outline_points
from osm2xodr.exporting.lanelet2.document import (
    BODY_WIDTH,
    LANELETS,
    LIGHT_HEIGHT,
    SIGN_HEIGHT,
    TURNING,
    Primitives,
    lanelet_tags,
    sign_type,
)
from osm2xodr.exporting.lanelet2.lanelets import Placed
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import ABSENT, End, Furniture, OpenDrive, pose, surface_points
from osm2xodr.system import record

# Lights that hold for walkers or cyclists alone, of OpenDRIVE's own catalogue (ASAM OpenDRIVE 1.8, signal types).
_NOT_FOR_CARS: Final = frozenset({"1000002", "1000007", "1000013"})
_STOP_LINES: Final = {"stopline": "solid", "givewayline": "dashed", "yieldline": "dashed"}
# The type of stop lines that stand in a file as signals (Germany's code for the mark).
_STOP_LINE_SIGNAL: Final = "294"
# The bounds by subtype: those that nothing marks are virtual.
_BOUNDS: Final = {"zebra": "zebra_marking", "virtual": "virtual"}


@record
class _Line:
    """A stop line: its place, whose traffic it holds for, and the number of its way."""

    s: float
    forward: bool | None  # Whether for traffic along s or against it; None where the file does not say
    lanes: frozenset[int]  # Empty for all
    way: int


class FurnitureMaker:
    """Adds what furniture becomes."""

    def __init__(self, placed: Placed, primitives: Primitives) -> None:
        self._placed, self._primitives = placed, primitives
        self._file: OpenDrive = placed.cut.file
        self._lines: dict[int, list[_Line]] = defaultdict(list)
        self.left_out: dict[str, int] = defaultdict(int)

    def add(self) -> None:
        """Add everything."""
        signals: dict[str, Furniture] = {}
        for item in self._file.furniture:
            if item.kind == "object" and item.attributes.get("type") == "crosswalk":
                self._count("crosswalks", add_crosswalk(self._placed, self._primitives, item))
            elif item.kind == "object":
                self._stop_line(item)
            elif item.kind == "signal":
                signals.setdefault(item.attributes.get("id", ""), item)
        references: dict[str, list[Furniture]] = defaultdict(list)
        for item in self._file.furniture:
            if item.kind == "signalReference":
                references[item.attributes.get("id", "")].append(item)
        for item in self._file.furniture:
            if item.kind == "signal":
                name = item.attributes.get("id", "")
                more = references[name] if signals[name] is item else []
                self._signal(item, [item, *more])

    def lines_before(self, road: int, s: float, *, forward: bool, lane: int) -> list[int]:
        """Return the way of the nearest stop line on a road for a lane's traffic, as a list of at most one."""
        fit = [
            line
            for line in self._lines.get(road, ())
            if line.forward in (None, forward) and (not line.lanes or lane in line.lanes)
        ]
        near = [line for line in fit if abs(line.s - s) <= SIGN_REACH]
        return [min(near, key=lambda line: abs(line.s - s)).way] if near else []

    def _count(self, what: str, added: bool) -> None:
        if not added:
            self.left_out[what] += 1

    def _stop_line(self, item: Furniture) -> None:
        """Add an object if it is a stop line."""
        words = (item.attributes.get("subtype", ""), item.attributes.get("name", ""))
        kinds = [_STOP_LINES[word] for text in words if (word := text.lower().replace(" ", "")) in _STOP_LINES]
        if kinds and math.isfinite(item.s + item.t):
            half = item.width / 2 if item.width > 0 else 0.0
            ends = (item.t + half, item.t - half) if half else self._across(item)
            if ends is not None:
                way = self._across_line(item.road, item.s, ends, kinds[0])
                self._lines[item.road].append(_Line(item.s, _forward(item), frozenset(_lanes(item)), way))

    def _across(self, item: Furniture) -> tuple[float, float] | None:
        """Return the t of the outer ends of the lanes that furniture holds for; None where it holds for none."""
        strip, numbers = self._affected(item)
        if strip is None or not numbers:
            return None
        cut = self._placed.cut
        line = cut.strips[strip]
        borders = [lane.left + k for lane in line.words.lanes if lane.id in numbers for k in (0, 1)]
        section = line.pieces[0][0]
        t = []
        for border in (min(borders), max(borders)):
            rows = slice(*cut.ribbons.start[cut.border_start[section] + border + np.array([0, 1])])
            s = cut.stations.s[cut.ribbons.station[rows]]
            t.append(float(np.interp(item.s, s, cut.ribbons.t[rows])))
        return t[0], t[1]

    def _across_line(self, road: int, s: float, ends: tuple[float, float], subtype: str) -> int:
        """Add a stop line across a road and return its number."""
        points = surface_points(self._file, np.array([road, road]), np.array([s, s]), np.array(ends))
        nodes = self._primitives.add_points(np.column_stack(points))
        return self._primitives.add_line(nodes, {"type": "stop_line", "subtype": subtype})

    def _affected(self, item: Furniture) -> tuple[int | None, dict[int, int]]:
        """Return the strip that furniture stands at, and the lanelets for cars that it holds for, by lane."""
        forward = _forward(item)
        strip = self._placed.nearest(item.road, item.s, along=forward is not False)
        if strip is None:
            return None, {}
        numbers = self._placed.by_strip[strip]
        wanted = _lanes(item)
        return strip, {
            lane.id: numbers[lane.id]
            for lane in self._placed.cut.strips[strip].words.lanes
            if LANELETS[lane.kind][0] in TURNING
            and (not wanted or lane.id in wanted)
            and (forward is None or lane.direction in (0, 1 if forward else -1))
        }

    def _signal(self, item: Furniture, places: list[Furniture]) -> None:
        """Add a light or sign with its regulatory element; `places` are it and the references to it."""
        kind, light = item.attributes.get("type", ""), item.attributes.get("dynamic") == "yes"
        what = "signs" if not light else "lights for walkers and cyclists" if kind in _NOT_FOR_CARS else "lights"
        affected = [(place, *self._affected(place)) for place in places]
        lanelets = sorted({number for _, _, found in affected for number in found.values()})
        usable = math.isfinite(item.s + item.t) and kind not in ("", "-1", "none", _STOP_LINE_SIGNAL)
        if not lanelets or not usable or kind in _NOT_FOR_CARS:
            self.left_out[what] += 1
            return
        place, _, found = next(entry for entry in affected if entry[2])
        lines = self._lines_for(place, found, light=light)
        tags = {"type": "traffic_light", "subtype": "red_yellow_green"}
        if not light:
            words = (item.attributes.get(name, "") for name in ("country", "type", "subtype"))
            tags = {"type": "traffic_sign", "subtype": sign_type(*words)}
        body = self._body(item, tags, LIGHT_HEIGHT if light else SIGN_HEIGHT)
        members = [("refers", "way", body), *(("ref_line", "way", line) for line in lines)]
        self._primitives.add_rule(members, {"type": "regulatory_element", "subtype": tags["type"]}, lanelets)

    def _lines_for(self, item: Furniture, lanelets: dict[int, int], *, light: bool) -> list[int]:
        """Return the stop line that goes with a light or sign; lights without one get one where they stand."""
        strip, _ = self._affected(item)
        assert strip is not None
        for lane in self._placed.cut.strips[strip].words.lanes:
            if lane.id in lanelets:
                found = self.lines_before(item.road, item.s, forward=lane.direction >= 0, lane=lane.id)
                if found:
                    return found
        ends = self._across(item) if light else None
        if ends is None:
            return []
        way = self._across_line(item.road, item.s, ends, "solid")
        self._lines[item.road].append(_Line(item.s, _forward(item), frozenset(lanelets), way))
        return [way]

    def _body(self, item: Furniture, tags: dict[str, str], height: float) -> int:
        """Add the lower edge of a light or sign, from left to right as drivers see it, and return its number."""
        road, s = np.array([item.road]), np.array([item.s])
        z = 0.0 if math.isnan(item.z_offset) else item.z_offset
        middle = np.concatenate(surface_points(self._file, road, s, np.array([item.t]), z))
        facing = float(pose(self._file, road, s)[2][0]) + (0.0 if math.isnan(item.hdg) else item.hdg)
        facing += math.pi if _forward(item) is False else 0.0
        half = 0.5 * (item.width if item.width > 0 else BODY_WIDTH)
        right = half * np.array([math.sin(facing), -math.cos(facing), 0.0])
        points: FloatArray = np.array([middle - right, middle + right])
        size = item.height if item.height > 0 else height
        return self._primitives.add_line(self._primitives.add_points(points), {**tags, "height": f"{size:g}"})


def _forward(item: Furniture) -> bool | None:
    """Return whether furniture holds for traffic along s, or against it; None for both."""
    return {"+": True, "-": False}.get(item.attributes.get("orientation", ""))


def _lanes(item: Furniture) -> set[int]:
    """Return the lanes that furniture holds for; none where it holds for all."""
    return {lane for a, b in item.validity for lane in range(max(min(a, b), -99), min(max(a, b), 99) + 1)}


def add_crosswalk(placed: Placed, primitives: Primitives, item: Furniture) -> bool:
    """Add a crosswalk as a lanelet across its road; False where its outline has no two sides along the way across."""
    file = placed.cut.file
    ring = _ring(placed, item)
    if ring is None:
        return False
    heading = float(pose(file, np.array([item.road]), np.array([item.s]))[2][0])
    sides = _sides(ring, np.array([-math.sin(heading), math.cos(heading)]))
    if sides is None:
        return False
    type_ = _BOUNDS.get(item.attributes.get("subtype", ""), "pedestrian_marking")
    left, right = (
        primitives.add_line(primitives.add_points(side), {"type": type_, "lane_change": "no"}) for side in sides
    )
    strip = placed.nearest(item.road, item.s, along=True)
    location = "" if strip is None else placed.cut.strips[strip].words.location
    tags = lanelet_tags("crosswalk", ("pedestrian",), location=location, both_ways=True, speed=math.nan)
    place = {"xodr:road": file.roads.id[item.road], "xodr:object": item.attributes.get("id", "")}
    primitives.add_lanelet(left, right, {**tags, **place})
    return True


def _ring(placed: Placed, item: Furniture) -> FloatArray | None:
    """Return the corners of an object's outline, or of the rectangle of its size, (n, 3), m; None without."""
    file = placed.cut.file
    if item.outlines:
        corners, local = np.array(item.outlines[0]), item.local_outlines[0]
    elif item.length > 0 and item.width > 0:
        u, v = item.length / 2, item.width / 2
        corners, local = np.array([(-u, -v, 0, 0), (u, -v, 0, 0), (u, v, 0, 0), (-u, v, 0, 0)]), True
    else:
        return None
    ring = np.column_stack(outline_points(file, item, corners, local))
    if len(ring) > 1 and np.allclose(ring[0], ring[-1]):
        ring = ring[:-1]
    return ring if len(ring) >= 4 and bool(np.isfinite(ring).all()) else None


def _sides(ring: FloatArray, across: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return the left and right side of a ring (n, 3) for who walks in the direction `across`.

    Of its edges the two that are squarest to the way across, one at either end, are where walkers come and go.
    """
    middles = 0.5 * (ring + np.roll(ring, -1, axis=0))[:, :2]
    edges = (np.roll(ring, -1, axis=0) - ring)[:, :2]
    far = (middles - ring[:, :2].mean(0)) @ across
    size = np.hypot(*edges.T)
    # The part of an edge that leads neither to nor fro.
    square = np.sqrt(np.maximum(size**2 - (edges @ across) ** 2, 0.0))
    first, last = (int(np.argmax(np.where(sign * far > 0, square, -1.0))) for sign in (-1, 1))
    if min(square[first], square[last]) <= 0.0 or far[first] >= 0 or far[last] <= 0:
        return None
    n = len(ring)
    one = ring[[(first + 1 + k) % n for k in range((last - first - 1) % n + 1)]]
    other = ring[[(last + 1 + k) % n for k in range((first - last - 1) % n + 1)]][::-1]
    if len(one) < 2 or len(other) < 2:
        return None
    # Counter-clockwise rings have the right side first.
    left_first = float(np.cross(across, one[:, :2].mean(0) - other[:, :2].mean(0))) > 0
    return (one, other) if left_first else (other, one)


def add_priorities(placed: Placed, primitives: Primitives, furniture: FurnitureMaker) -> None:
    """Add an element for each connecting road that must yield: it, those that it yields to, and its stop line."""
    file = placed.cut.file
    index = {name: k for k, name in reversed(list(enumerate(file.roads.id)))}
    yields: dict[int, set[int]] = defaultdict(set)
    for _, first, second in file.junctions.priorities:
        if first in index and second in index and first != second:
            yields[index[second]].add(index[first])
    for low in sorted(yields):
        waits = _lanelets(placed, low)
        goes = sorted({number for high in yields[low] for number in _lanelets(placed, high)} - set(waits))
        if not waits or not goes:
            continue
        line = _line(placed, furniture, low)
        members = [
            *(("right_of_way", "lanelet", number) for number in goes),
            *(("yield", "lanelet", number) for number in waits),
            *(("ref_line", "way", way) for way in line),
        ]
        tags = {"type": "regulatory_element", "subtype": "right_of_way"}
        primitives.add_rule(members, tags, sorted([*goes, *waits]))


def _lanelets(placed: Placed, road: int) -> list[int]:
    """Return the lanelets for motor traffic of a road."""
    return sorted(
        placed.by_strip[strip][lane.id]
        for strip in placed.by_road.get(road, ())
        for lane in placed.cut.strips[strip].words.lanes
        if LANELETS[lane.kind][0] in TURNING
    )


def _line(placed: Placed, furniture: FurnitureMaker, road: int) -> list[int]:
    """Return the stop line where traffic comes from that enters a connecting road, as a list of at most one."""
    file = placed.cut.file
    table = file.connections
    for k in range(len(table.connecting)):
        if table.connecting[k] != road or table.incoming[k] == ABSENT:
            continue
        incoming = int(table.incoming[k])
        at_end = int(file.roads.link[incoming, End.END]) == int(table.junction[k])
        s = float(file.roads.length[incoming]) if at_end else 0.0
        for row in range(int(table.link_start[k]), int(table.link_start[k + 1])):
            found = furniture.lines_before(incoming, s, forward=at_end, lane=int(table.link_from[row]))
            if found:
                return found
    return []
