"""Cuts lane sections in two.

SUMO's netconvert gives a light to the end of the lane section that it stands in: a light amid a road would
make the next junction one with lights. A section that ends behind it keeps it where it is.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from osm2xodr.curves import curvature_at, lengths
from osm2xodr.furniture import defaults
from osm2xodr.model import Cubic, Lane, LaneSection, PlanView, Road, RoadMap

# What is narrower is written as 0, m.
_NO_WIDTH = 1e-6


def cut_sections(road_map: RoadMap, breaks: Sequence[tuple[int, float]]) -> RoadMap:
    """Return a road map with a new lane section from each of some places on, the same as the one before it.

    Parameters
    ----------
    road_map
        The roads.
    breaks
        (id of the road, s, m). Where a section begins or a road ends within `SECTION_BREAK_APART`, or the road bends
        tightly, none is added: readers that step from section to section along the reference line leave outer lanes
        there.
    """
    if not breaks:
        return road_map
    at: dict[int, list[float]] = defaultdict(list)
    for road, s in breaks:
        at[road].append(s)
    length = lengths(road_map.plan_view).tolist()
    roads = [
        _cut(road, _straight(road_map.plan_view, k, sorted(at[road.id])), far) if road.id in at else road
        for k, (road, far) in enumerate(zip(road_map.roads, length, strict=True))
    ]
    return replace(road_map, roads=tuple(roads))


def _straight(plan: PlanView, curve: int, places: Sequence[float]) -> list[float]:
    """Return the places off tight bends."""
    probes = np.array([[s - defaults.SECTION_BREAK_STEP, s, s + defaults.SECTION_BREAK_STEP] for s in places])
    curves = np.full(probes.size, curve, np.int64)
    bend = np.abs(curvature_at(plan, curves, probes.ravel())).reshape(-1, 3).max(axis=1)
    return [s for s, k in zip(places, bend.tolist(), strict=True) if k * defaults.SECTION_BREAK_RADIUS < 1.0]


def _cut(road: Road, places: Sequence[float], length: float) -> Road:
    sections = list(road.lane_sections)
    for s in places:
        starts = [section.s for section in sections]
        # A light at the end of a short road may ask for a section that would begin beyond it.
        at_end = s > length - defaults.SECTION_BREAK_APART
        if at_end or min(abs(s - other) for other in starts) < defaults.SECTION_BREAK_APART:
            continue
        k = bisect_right(starts, s) - 1
        sections[k : k + 1] = _halves(sections[k], s)
    return replace(road, lane_sections=tuple(sections))


def _halves(section: LaneSection, s: float) -> tuple[LaneSection, LaneSection]:
    along = s - section.s
    before, after = [], []
    for lane in section.lanes:
        first, last = tuple(item for item in lane.widths if item.s < along), _from(lane.widths, along)
        # A lane without width where sections touch is linked to none beyond (ASAM OpenDRIVE 1.7, 11.6).
        link = lane.id if last and last[0].a > _NO_WIDTH else None
        before.append(replace(lane, widths=first, successor=link))
        after.append(replace(lane, widths=last, predecessor=link))
    # What lies beside the carriageway in one half only is no lane of the other.
    gone = _nowhere(before, "predecessor"), _nowhere(after, "successor")
    before = [replace(lane, successor=None) if lane.id in gone[1] else lane for lane in before]
    after = [replace(lane, predecessor=None) if lane.id in gone[0] else lane for lane in after]
    kept_before = tuple(lane for lane in before if lane.id not in gone[0])
    kept_after = tuple(lane for lane in after if lane.id not in gone[1])
    return LaneSection(section.s, kept_before), LaneSection(s, kept_after)


def _nowhere(lanes: Sequence[Lane], beyond: str) -> frozenset[int]:
    """Return the ids of the outermost lanes without any width that go on as nothing at one end."""
    out: set[int] = set()
    for side in (lanes, lanes[::-1]):
        for lane in side:
            wide = any(item.a or item.b or item.c or item.d for item in lane.widths)
            if lane.id == 0 or wide or getattr(lane, beyond) is not None:
                break
            out.add(lane.id)
    return frozenset(out)


def _from(cubics: Sequence[Cubic], s: float) -> tuple[Cubic, ...]:
    """Return what is left of piecewise cubics from s on, counted from there."""
    if not cubics:
        return ()
    k = max(bisect_right([item.s for item in cubics], s) - 1, 0)
    return (cubics[k].begun_later(s - cubics[k].s, 0.0), *(replace(item, s=item.s - s) for item in cubics[k + 1 :]))
