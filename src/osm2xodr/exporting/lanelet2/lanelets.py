"""Lanelets of strips, between bounds that neighbours share.

They follow each other exactly if they share their end nodes: ends of strips are joined where lanes are linked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from osm2xodr.curves import unique_inverse, wrapped
from osm2xodr.exporting.lanelet2.document import (
    CLOSEST,
    LANELETS,
    MOTORWAY,
    TURN_LEAST,
    TURNING,
    Primitives,
    Tags,
    lanelet_tags,
)
from osm2xodr.exporting.lanelet2.strips import Cut, Strip, StripLane
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import End
from osm2xodr.system import record

# An end of a border: strip, border, and at which `End` of the strip.
Slot = tuple[int, int, int]


@dataclass
class Placed:
    """Which lanelet each lane of each strip became."""

    cut: Cut
    by_strip: list[dict[int, int]] = field(default_factory=list)  # Number of the lanelet by lane id
    by_road: dict[int, list[int]] = field(default_factory=dict)  # Strips of each road, along s

    def at(self, road: int, s: float, *, along: bool) -> int | None:
        """Return the strip at s of a road, at a cut the one that traffic along (or against) s comes from."""
        found = None
        for k in self.by_road.get(road, ()):
            low, high = self.cut.strips[k].s
            if low <= s <= high and (found is None or not along):
                found = k
        return found

    def nearest(self, road: int, s: float, *, along: bool) -> int | None:
        """Return the strip at s of a road, or the nearest one."""
        k = self.at(road, s, along=along)
        strips = self.by_road.get(road)
        if k is not None or not strips:
            return k
        return min(strips, key=lambda k: max(self.cut.strips[k].s[0] - s, s - self.cut.strips[k].s[1]))


def add_lanelets(cut: Cut, ends: Ends, primitives: Primitives) -> Placed:
    """Add the lanelets of all strips with their bounds; the first nodes are those of `ends`."""
    primitives.add_points(ends.place)
    placed = Placed(cut)
    turns = _turns(cut)
    for k, strip in enumerate(cut.strips):
        bounds = {
            border: primitives.add_line(_nodes(cut, ends, primitives, k, border), mark.tags())
            for border, mark in strip.words.marks
        }
        numbers = {}
        for lane in strip.words.lanes:
            left, right = bounds[lane.left], bounds[lane.left + 1]
            if lane.direction < 0:
                left, right = right, left
            tags = _tags(cut, strip, lane, turns[strip.road])
            numbers[lane.id] = primitives.add_lanelet(left, right, tags)
        placed.by_strip.append(numbers)
        placed.by_road.setdefault(strip.road, []).append(k)
    return placed


def _nodes(cut: Cut, ends: Ends, primitives: Primitives, strip: int, border: int) -> list[int]:
    """Return the nodes of a bound: those of its ends, and new ones between."""
    first, last = ends.node[strip, border, 0], ends.node[strip, border, 1]
    points = cut.line(cut.strips[strip], border)
    kept, before = [], ends.place[first]
    for point in points[1:-1]:
        if np.hypot(*(point - before)[:2]) >= CLOSEST and np.hypot(*(point - ends.place[last])[:2]) >= CLOSEST:
            kept.append(point)
            before = point
    inner: FloatArray = np.array(kept).reshape(-1, 3)
    return [first, *primitives.add_points(inner), last]


def _tags(cut: Cut, strip: Strip, lane: StripLane, turn: float) -> Tags:
    """Return the tags of a lanelet: what Lanelet2 wants to know, and where in OpenDRIVE it comes from."""
    file = cut.file
    subtype, participants = LANELETS[lane.kind]
    if strip.words.road_type == MOTORWAY and subtype in TURNING:
        participants = tuple(who for who in participants if who != "bicycle")
    both = lane.direction == 0 or "pedestrian" in participants
    speed = math.nan if "pedestrian" in participants else lane.speed
    tags = lanelet_tags(subtype, participants, location=strip.words.location, both_ways=both, speed=speed)
    if file.roads.junction[strip.road] != -1 and subtype in TURNING:
        angle = turn if lane.direction >= 0 else -turn
        tags["turn_direction"] = "straight" if abs(angle) <= TURN_LEAST else "left" if angle > 0 else "right"
    low, high = strip.s
    place = {"xodr:road": file.roads.id[strip.road], "xodr:lane": str(lane.id), "xodr:s": f"{low:.3f} {high:.3f}"}
    return {**tags, **place}


def _turns(cut: Cut) -> FloatArray:
    """Return how far each road turns to the left along s, (roads,), rad."""
    stations = cut.stations
    step = wrapped(np.diff(stations.hdg))
    step[stations.road[1:] != stations.road[:-1]] = 0.0
    out = np.zeros(len(stations.start) - 1)
    np.add.at(out, stations.road[1:], np.nan_to_num(step))
    return out


@record
class Ends:
    """The ends of all borders of strips, as nodes that linked lanes share."""

    node: dict[Slot, int]  # Which node each end is
    place: FloatArray  # (nodes, 3) x, y, z in the middle of the ends that meet, m
    gap: FloatArray  # (nodes,) How far the ends that meet lie apart, horizontally, m


def join_ends(cut: Cut) -> Ends:
    """Join the ends of borders where their lanes are linked, or where one strip was cut from the next."""
    slots: dict[Slot, int] = {}
    points = []
    for k, strip in enumerate(cut.strips):
        for border, _ in strip.words.marks:
            line = cut.line(strip, border)
            for end, row in ((End.START, 0), (End.END, -1)):
                slots[k, border, int(end)] = len(slots)
                points.append(line[row])
    parent = list(range(len(slots)))
    for one, other in [*_links(cut), *_seams(cut)]:
        a, b = _root(parent, slots[one]), _root(parent, slots[other])
        parent[max(a, b)] = min(a, b)
    roots = np.array([_root(parent, k) for k in range(len(parent))], np.int64)
    group = unique_inverse(roots)[1]
    place = np.array(points).reshape(-1, 3)
    return _placed(slots, group.astype(np.int64), place)


def _placed(slots: dict[Slot, int], group: IntArray, points: FloatArray) -> Ends:
    """Return the nodes of groups of ends, (ends,), at `points`, (ends, 3)."""
    count = int(group.max(initial=-1)) + 1
    place = np.zeros((count, 3))
    np.add.at(place, group, points)
    place /= np.bincount(group, minlength=count)[:, None]
    gap = np.zeros(count)
    np.maximum.at(gap, group, 2 * np.hypot(*(points - place[group])[:, :2].T))
    return Ends({slot: int(group[k]) for slot, k in slots.items()}, place, gap)


def lane_ends(cut: Cut) -> dict[tuple[int, int], tuple[Slot, Slot]]:
    """Return the ends of the left and right borders, along s, of lanes (rows) where their strips end."""
    out = {}
    for k, strip in enumerate(cut.strips):
        for end, (section, _, _) in ((End.START, strip.pieces[0]), (End.END, strip.pieces[-1])):
            bounds = strip.s[0] <= _begin(cut, section) if end == End.START else strip.s[1] >= _end(cut, section)
            if not bounds:
                continue
            rows = _rows(cut, section)
            for lane in strip.words.lanes:
                out[rows[lane.id], int(end)] = (k, lane.left, int(end)), (k, lane.left + 1, int(end))
    return out


def _links(cut: Cut) -> list[tuple[Slot, Slot]]:
    """Return the ends of borders that links between lanes join."""
    ends = lane_ends(cut)
    pairs = []
    for a, end_a, b, end_b in zip(*(column.tolist() for column in cut.contacts), strict=True):
        one, other = ends.get((a, end_a)), ends.get((b, end_b))
        if one is None or other is None:
            continue
        # Where two ends or two starts meet, left is right.
        other = other if end_a != end_b else other[::-1]
        pairs += list(zip(one, other, strict=True))
    return pairs


def _seams(cut: Cut) -> list[tuple[Slot, Slot]]:
    """Return the ends of borders where one strip goes on as the next one within a section."""
    pairs = []
    for k, (one, other) in enumerate(zip(cut.strips, cut.strips[1:], strict=False)):
        (section, _, last), (following, first, _) = one.pieces[-1], other.pieces[0]
        if section == following and last == first:
            common = {border for border, _ in one.words.marks} & {border for border, _ in other.words.marks}
            pairs += [((k, border, int(End.END)), (k + 1, border, int(End.START))) for border in sorted(common)]
    return pairs


def _root(parent: list[int], k: int) -> int:
    while parent[k] != k:
        parent[k] = parent[parent[k]]
        k = parent[k]
    return k


def _rows(cut: Cut, section: int) -> dict[int, int]:
    """Return the rows of the lanes of a section by id; of those with the same id the first."""
    lanes = cut.file.lanes
    rows: dict[int, int] = {}
    for row in range(int(lanes.start[section]), int(lanes.start[section + 1])):
        rows.setdefault(int(lanes.id[row]), row)
    return rows


def _begin(cut: Cut, section: int) -> float:
    return _stations(cut, section)[0]


def _end(cut: Cut, section: int) -> float:
    return _stations(cut, section)[1]


def _stations(cut: Cut, section: int) -> tuple[float, float]:
    """Return s of the first and last station of a section."""
    border = int(cut.border_start[section])
    rows = cut.ribbons.station[cut.ribbons.start[border] : cut.ribbons.start[border + 1]]
    return float(cut.stations.s[rows[0]]), float(cut.stations.s[rows[-1]])
