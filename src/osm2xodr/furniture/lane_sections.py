"""Lane sections that furniture needs: cut behind lights apart from junctions, and where nobody may park."""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Final

import numpy as np

from osm2xodr.curves import curvature_at, lengths, part_of_cubics
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import Crossing, World, car_lanes
from osm2xodr.model import Cubic, Lane, LaneSection, LaneType, PlanView, Road, RoadMap

# Lanes that are narrower where sections touch end there, m: rounding.
_NARROWEST_LANE: Final = 1e-6
# Widths are written in steps of this, m.
_STEP: Final = 1e-7
# Least distance of a cut from other cuts and the road's end, m; a choice.
_APART: Final = 0.5
# No section is cut within this distance of a bend of less than this radius, m: CARLA steps 2.5 m along the reference
# line, which is up to 3.3 m on a lane 6 m outside of it.
_BEND_REACH: Final = 2.5
_BEND_RADIUS: Final = 20.0


@dataclass(frozen=True, slots=True, order=True)
class NoParking:
    """A stretch of a road at one side of which nobody may park."""

    road: int  # Id
    side: int  # Left 1, right -1
    begin: float  # s, m
    end: float


def no_parking(world: World, crossings: Sequence[Crossing]) -> tuple[NoParking, ...]:
    """Return where nobody may park as people cross there: on crossings, and before them, seen from who comes.

    What is left of the road beside it, if too short for a car, belongs to it.
    """
    found: list[NoParking] = []
    for crossing in crossings:
        road, s = crossing.on_course
        ahead, back = (bool(car_lanes(world, road, s, along=along)) for along in (True, False))
        half = 0.5 * crossing.width + abs(crossing.skew) * 0.5 * (crossing.left - crossing.right)
        for side in (1, -1):
            comes_along = ahead if ahead != back else world.lanes.runs_along(side)
            before = half + defaults.NO_PARKING_BEFORE_CROSSING
            begin, end = (s - before, s + half) if comes_along else (s - half, s + before)
            found.append(NoParking(road, side, begin, end))
    return tuple(_joined(world, sorted(found)))


def _joined(world: World, found: Iterable[NoParking]) -> list[NoParking]:
    """Join stretches between which no car fits, and lead them on to ends of roads before which none does."""
    out: list[NoParking] = []
    for item in found:
        length = world.lanes.length(item.road)
        begin = item.begin if item.begin >= defaults.ROOM_TO_PARK else 0.0
        end = item.end if item.end <= length - defaults.ROOM_TO_PARK else length
        if begin >= length or end <= 0.0:
            continue
        last = out[-1] if out else None
        if last and (last.road, last.side) == (item.road, item.side) and begin < last.end + defaults.ROOM_TO_PARK:
            out[-1] = replace(last, end=max(last.end, end))
        else:
            out.append(replace(item, begin=begin, end=end))
    return out


def without_parking(road_map: RoadMap, stretches: Iterable[NoParking]) -> RoadMap:
    """Return a road map in which nobody parks on some stretches: lanes to park on are `restricted` there."""
    at: dict[int, list[NoParking]] = defaultdict(list)
    for item in stretches:
        at[item.road].append(item)
    breaks = (
        (road.id, s)
        for road in road_map.roads
        for item in at.get(road.id, ())
        for s in (item.begin, item.end)
        if any(_parking(lane, item.side) for lane in _section_at(road, s).lanes)
    )
    road_map = cut_sections(road_map, list(breaks))
    length = lengths(road_map.plan_view).tolist()
    roads = [
        _restricted(road, at[road.id], far) if road.id in at else road
        for road, far in zip(road_map.roads, length, strict=True)
    ]
    return replace(road_map, roads=tuple(roads))


def _section_at(road: Road, s: float) -> LaneSection:
    return road.lane_sections[max(bisect_right([section.s for section in road.lane_sections], s) - 1, 0)]


def _parking(lane: Lane, side: int) -> bool:
    return lane.type is LaneType.PARKING and lane.id * side > 0


def _restricted(road: Road, stretches: Sequence[NoParking], length: float) -> Road:
    """Return a road whose sections within stretches have no lanes to park on."""
    sections = list(road.lane_sections)
    ends = [*(section.s for section in sections[1:]), length]
    for k, (section, end) in enumerate(zip(sections, ends, strict=True)):
        for item in stretches:
            if item.begin - _APART < section.s and end < item.end + _APART:
                section = _without(section, item.side)
        sections[k] = section
    return replace(road, lane_sections=tuple(sections))


def _without(section: LaneSection, side: int) -> LaneSection:
    """Return a section with no lanes to park on at a side."""
    lanes = (replace(lane, type=LaneType.RESTRICTED) if _parking(lane, side) else lane for lane in section.lanes)
    return replace(section, lanes=tuple(lanes))


def cut_sections(road_map: RoadMap, breaks: Sequence[tuple[int, float]]) -> RoadMap:
    """Cut lane sections in two at some places (id of the road, s, m).

    Where another section begins or the road ends within `_APART`, or where the road bends tightly, none is cut:
    readers that step from section to section along the reference line leave outer lanes there.
    """
    if not breaks:
        return road_map
    at: dict[int, list[float]] = defaultdict(list)
    for road, s in breaks:
        at[road].append(s)
    length = lengths(road_map.plan_view).tolist()
    roads = [
        _cut(road, _off_bends(road_map.plan_view, k, sorted(at[road.id])), far) if road.id in at else road
        for k, (road, far) in enumerate(zip(road_map.roads, length, strict=True))
    ]
    return replace(road_map, roads=tuple(roads))


def _off_bends(plan: PlanView, curve: int, places: Sequence[float]) -> list[float]:
    """Return the places apart from tight bends."""
    probes = np.array([[s - _BEND_REACH, s, s + _BEND_REACH] for s in places])
    curves = np.full(probes.size, curve, np.int64)
    bend = np.abs(curvature_at(plan, curves, probes.ravel())).reshape(-1, 3).max(axis=1)
    return [s for s, k in zip(places, bend.tolist(), strict=True) if k * _BEND_RADIUS < 1.0]


def _cut(road: Road, places: Sequence[float], length: float) -> Road:
    sections = list(road.lane_sections)
    for s in places:
        starts = [section.s for section in sections]
        # A light near the start or the end of a road may want a section that begins beyond it.
        if _APART <= s <= length - _APART and min(abs(s - other) for other in starts) >= _APART:
            k = bisect_right(starts, s) - 1
            sections[k : k + 1] = _halves(sections[k], s)
    return replace(road, lane_sections=tuple(sections))


def _halves(section: LaneSection, s: float) -> tuple[LaneSection, LaneSection]:
    along = s - section.s
    before, after = [], []
    for lane in section.lanes:
        first, last = part_of_cubics(lane.widths, 0.0, along), part_of_cubics(lane.widths, along, np.inf)
        last = (*map(_rounded_up, last[:1]), *last[1:])
        # A lane of width 0 where sections touch has no link (ASAM OpenDRIVE 1.7, 11.6).
        link = lane.id if last and last[0].a > _NARROWEST_LANE else None
        before.append(replace(lane, widths=first, successor=link))
        after.append(replace(lane, widths=last, predecessor=link))
    # Strips beside the carriageway of one half only are not lanes of the other half.
    gone = _vanished(before, "predecessor"), _vanished(after, "successor")
    before = [replace(lane, successor=None) if lane.id in gone[1] else lane for lane in before]
    after = [replace(lane, predecessor=None) if lane.id in gone[0] else lane for lane in after]
    kept_before = tuple(lane for lane in before if lane.id not in gone[0])
    kept_after = tuple(lane for lane in after if lane.id not in gone[1])
    return LaneSection(section.s, kept_before), LaneSection(s, kept_after)


def _vanished(lanes: Sequence[Lane], beyond: str) -> frozenset[int]:
    """Return the ids of the outermost lanes of width 0 throughout that have no link of the given name."""
    out: set[int] = set()
    for side in (lanes, lanes[::-1]):
        for lane in side:
            wide = any(item.a or item.b or item.c or item.d for item in lane.widths)
            if lane.id == 0 or wide or getattr(lane, beyond) is not None:
                break
            out.add(lane.id)
    return frozenset(out)


def _rounded_up(cubic: Cubic) -> Cubic:
    """Return a cubic that begins no lower when it is written: what becomes narrower would end below 0."""
    return cubic if cubic.is_flat else replace(cubic, a=ceil(cubic.a / _STEP) * _STEP)
