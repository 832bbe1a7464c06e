"""Lanelets of strips, between bounds that neighbours share."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.exporting.lanelet2.defaults import CLOSEST, TURN_LEAST
from osm2xodr.exporting.lanelet2.ends import Ends
from osm2xodr.exporting.lanelet2.primitives import Primitives
from osm2xodr.exporting.lanelet2.strips import Cut, Strip, StripLane
from osm2xodr.exporting.lanelet2.words import LANELETS, MOTORWAY, TURNING, Tags, lanelet_tags
from osm2xodr.model import FloatArray


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
