"""Lane ids of the strips that sidewalks round corners join: lane sections are known only after the corners."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial

from osm2xodr.geometry.connections import BESIDE_CARS, ConnectingRoads, InnerLane
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import LaneLayout
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strip_columns import columns_of, present
from osm2xodr.geometry.roadside.strips import Margins
from osm2xodr.model import LaneType, MarginSpec


def strips_at_end(parts: RoadParts, margins: Margins, end: int, side: int) -> list[tuple[int, MarginSpec]]:
    """Return the strips at one side (left 1, right -1) of a road end, from the carriageway outwards, with lane ids.

    The ids hold if the last lane section is as long as the last stretch.
    """
    simple = len(margins) < 2 and not (margins and margins[0].wedges)
    # Most roads have no strips, or such as are columns of their own, from end to end.
    here = margins[0].strips(side) if margins and simple else ()
    if simple and not here:
        return []
    stretch = parts.at_end(end)
    first = len(stretch.section.left if side > 0 else stretch.section.right) + 1
    if simple:
        return [(side * number, strip) for number, strip in enumerate(here, first)]
    columns = columns_of(margins, side)
    # Columns of the section count as lanes even where they have no width.
    strips = (columns[k].strip_at(end, side) for k in present(columns, margins, stretch.start, stretch.end))
    return [(side * number, strip) for number, strip in enumerate(strips, first) if strip is not None]


def with_lanes_of_sections(
    roads: ConnectingRoads, parts: RoadParts, margins: Sequence[Margins], layouts: Sequence[LaneLayout]
) -> ConnectingRoads:
    """Return connecting roads whose sidewalks join the lanes that the road ends have in their lane sections."""
    entry_lane, exit_lane, inner = roads.entry_lane.copy(), roads.exit_lane.copy(), list(roads.inner)
    ids = cache(partial(_lane_ids, parts, margins, layouts))
    entry: Callable[[int], int]
    exit_: Callable[[int], int]
    for row, kind in enumerate(roads.lane_type):
        if kind is LaneType.BIKING:
            # Lanes of the carriageway keep their ids.
            entry, exit_ = (partial(_strip_id, ids(int(end[row]))) for end in (roads.entry, roads.exit))
        elif kind in BESIDE_CARS:
            entry, exit_ = (ids(int(end[row])).__getitem__ for end in (roads.entry, roads.exit))
        else:
            continue
        entry_lane[row], exit_lane[row] = entry(int(entry_lane[row])), exit_(int(exit_lane[row]))
        inner[row] = tuple(_renumbered(lane, entry, exit_) for lane in inner[row])
    return replace(roads, entry_lane=entry_lane, exit_lane=exit_lane, inner=tuple(inner))


def _strip_id(ids: Mapping[int, int], lane: int) -> int:
    return ids.get(lane, lane)


def _renumbered(lane: InnerLane, entry: Callable[[int], int], exit_: Callable[[int], int]) -> InnerLane:
    if lane.entry_lane is None or lane.exit_lane is None:
        return lane
    return replace(lane, entry_lane=entry(lane.entry_lane), exit_lane=exit_(lane.exit_lane))


def _lane_ids(
    parts: RoadParts, margins: Sequence[Margins], layouts: Sequence[LaneLayout], end: int
) -> dict[int, int]:
    """Return the lane ids, in the last lane section of a road, of the strips that `strips_at_end` gives numbers."""
    out: dict[int, int] = {}
    road, last = end // 2, end % 2 == 1
    section, here = layouts[road].sections[-1 if last else 0], parts.at_end(end).section
    s = float(parts.length[road]) - section.s if last else 0.0
    for side, carriageway in ((1, len(here.left)), (-1, len(here.right))):
        numbers = [number for number, _ in strips_at_end(parts, margins[road], end, side)]
        strips = sorted(
            (lane for lane in section.lanes if lane.id * side > carriageway), key=lambda lane: abs(lane.id)
        )
        records = [(lane.id, lane.widths[-1 if last else 0]) for lane in strips]
        ids = [lane for lane, width in records if width.at(s - width.s) > defaults.SAME_PLACE]
        out |= zip(numbers, ids, strict=False)
    return out
