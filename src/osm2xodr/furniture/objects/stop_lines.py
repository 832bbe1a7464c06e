"""Lines across lanes at which traffic stops or yields."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.furniture.world import LaneAt, Stop, World, lane_ranges
from osm2xodr.model import RoadObject

# Extent along the road, m: RMS-1, Zeichen 294 (0.50 m) and 341; MUTCD 2009, 3B.16: 12 to 24 in.
_EXTENT: Final = 0.5
# Lines on the same lanes that are nearer to each other are one, m; a choice.
_APART: Final = 2.0
# Subtype and name of lines by the kind of stop, the strictest first.
_LINES: Final = {
    "traffic_signals": ("stopLine", "stop line"),
    "stop": ("stopLine", "stop line"),
    "give_way": ("giveWayLine", "give-way line"),
}
_RANK: Final = {kind: rank for rank, kind in enumerate(_LINES)}
# Lanes whose edges are nearer lie side by side, and narrower lanes get no line, m: rounding.
_TOUCH: Final = 0.01


def stop_lines(world: World, stops: Sequence[Stop]) -> list[RoadObject]:
    """Make the lines of stops, one across each group of lanes side by side; the strictest of stops at one place."""
    out: list[RoadObject] = []
    for stop in _distinct(stops):
        length = world.lanes.length(stop.road)
        extent = min(_EXTENT, length)
        # The line lies on the side from which traffic comes.
        begin = stop.s - extent if stop.orientation == "+" else stop.s
        begin = min(max(begin, 0.0), length - extent)
        middle = begin + 0.5 * extent
        lanes = [lane for lane in world.lanes.at(stop.road, middle) if lane.id in stop.lanes]
        out += [_line(world, stop, middle, extent, group) for group in _side_by_side(lanes)]
    return out


def _distinct(stops: Sequence[Stop]) -> list[Stop]:
    kept: dict[tuple[int, str], list[Stop]] = defaultdict(list)
    for stop in sorted(stops, key=lambda item: (item.road, item.orientation, _RANK[item.kind], item.s)):
        others = kept[stop.road, stop.orientation]
        if not any(abs(other.s - stop.s) < _APART and set(other.lanes) & set(stop.lanes) for other in others):
            others.append(stop)
    return [stop for group in kept.values() for stop in group]


def _side_by_side(lanes: Sequence[LaneAt]) -> list[list[LaneAt]]:
    """Return lanes, from left to right, in groups without a gap."""
    groups: list[list[LaneAt]] = []
    for lane in lanes:
        if lane.left - lane.right >= _TOUCH:
            if not groups or groups[-1][-1].right - lane.left >= _TOUCH:
                groups.append([])
            groups[-1].append(lane)
    return groups


def _line(world: World, stop: Stop, s: float, extent: float, lanes: Sequence[LaneAt]) -> RoadObject:
    left, right = lanes[0].left, lanes[-1].right
    line = world.object_at(stop.road, ("roadMark", *_LINES[stop.kind]), s, 0.5 * (left + right), stop.osm_id)
    validity = lane_ranges(lane.id for lane in lanes)
    return replace(line, length=extent, width=left - right, orientation=stop.orientation, validity=validity)
