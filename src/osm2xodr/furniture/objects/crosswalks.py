"""The objects of crossings: crosswalks from kerb to kerb, and their islands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot
from typing import Final

from osm2xodr.furniture.world import Crossing, LaneAt, World, outline
from osm2xodr.model import VEHICLE_LANES, LaneType, RoadObject

# Width that lanes keep beside an island, m: that of buses and lorries without their mirrors; a choice.
_WIDTH_BESIDE_ISLAND: Final = 2.5
# Narrower islands are left out, m; a choice.
NARROWEST_ISLAND: Final = 1.0
# How far islands reach beyond their crossing, and their height, m; choices.
_ISLAND_BEYOND: Final = 1.0
ISLAND_HEIGHT: Final = 0.12
# Lanes of which an island may take the whole width.
_SPARE: Final = frozenset({LaneType.MEDIAN, LaneType.NONE, LaneType.BORDER})
# Subtypes by OSM's words for what is painted, where they differ.
_SUBTYPES: Final = {"unmarked": "virtual", "yes": "marked"}


def crossing_objects(world: World, crossings: Sequence[Crossing]) -> list[RoadObject]:
    """Make the objects of crossings: crosswalks, and islands in them."""
    return [item for crossing in crossings for item in _objects(world, crossing)]


def _objects(world: World, crossing: Crossing) -> list[RoadObject]:
    if not crossing.island:
        return [_crosswalk(world, crossing, None, None)]
    if crossing.junction >= 0:
        words = "the island of the crossing is left out: it lies in a junction"
        world.diagnostics.note("crossing-island", crossing.osm_id, words)
        return [_crosswalk(world, crossing, None, None)]
    edges = island_edges(world, crossing.road, crossing.s)
    if edges is None:
        words = "the island of the crossing is left out: all lanes run the same way and do not show where it lies"
        world.diagnostics.note("crossing-island", crossing.osm_id, words)
        return [_crosswalk(world, crossing, None, None)]
    left, right = edges
    out = [_crosswalk(world, crossing, None, left)]
    if left - right < NARROWEST_ISLAND:
        words = f"the crossing is split, but its island is left out: the lanes can spare only {left - right:.1f} m"
        world.diagnostics.note("crossing-island", crossing.osm_id, words)
    else:
        half = 0.5 * crossing.width + _ISLAND_BEYOND
        out.append(island(world, crossing.road, crossing.s, half, edges, crossing.osm_id))
    return [*out, _crosswalk(world, crossing, right, None)]


def _crosswalk(world: World, crossing: Crossing, left: float | None, right: float | None) -> RoadObject:
    """Make one crosswalk, up to t = left and right or the carriageway's edges, m."""
    road, s, width = crossing.road, crossing.s, crossing.width
    outer = crossing.left if left is None else left, crossing.right if right is None else right
    t = 0.5 * (outer[0] + outer[1])
    kind = crossing.marking.partition(":")[0].partition(";")[0]
    name = f"{'marked' if kind == 'yes' else kind} crossing"
    words = ("crosswalk", _SUBTYPES.get(crossing.marking, kind), name)
    found = world.object_at(road, words, s, t, crossing.osm_id)
    if crossing.junction >= 0:
        corners = _slanting(crossing)
    else:
        ends = s - 0.5 * width, s + 0.5 * width
        (begin, end), length = ends, world.lanes.length(road)
        # Before a junction it may lie partly in it, and is as wide there as where the road ends.
        at_begin, at_end = (
            (edges[0] if left is None else left, edges[1] if right is None else right)
            for edges in (world.lanes.carriageway(road, min(max(at, 0.0), length)) for at in ends)
        )
        around = ((begin, at_begin[1]), (end, at_end[1]), (end, at_end[0]), (begin, at_begin[0]))
        corners = outline(world, road, s, t, around)
    return replace(found, length=width, width=outer[0] - outer[1], outline=corners)


def _slanting(crossing: Crossing) -> tuple[tuple[float, float, float, float], ...]:
    """Return the corners of a crosswalk that leads straight over connecting roads, in its own frame, as `outline`."""
    reach, half = 0.5 * (crossing.left - crossing.right), 0.5 * crossing.width * hypot(1.0, crossing.skew)
    return tuple(
        (crossing.skew * v + along, v, 0.0, 0.0)
        for v, along in ((-reach, -half), (-reach, half), (reach, half), (reach, -half))
    )


def island_edges(world: World, road: int, s: float) -> tuple[float, float] | None:
    """Return t of the left and right edge of the widest island for which the lanes have room, m.

    It lies between the two directions of traffic; None where there is only one.
    """
    lanes = sorted(world.lanes.at(road, s), key=lambda lane: abs(lane.id))
    left, right = [lane for lane in lanes if lane.id > 0], [lane for lane in lanes if lane.id < 0]
    if not all(any(lane.type in VEHICLE_LANES for lane in side) for side in (left, right)):
        return None
    return left[0].right + _spare(left), right[0].left - _spare(right)


def _spare(lanes: Sequence[LaneAt]) -> float:
    """Return the width next to the centre that lanes, from there outwards, can spare, m."""
    spare = 0.0
    for lane in lanes:
        width = lane.left - lane.right
        if lane.type not in _SPARE:
            return spare + max(width - _WIDTH_BESIDE_ISLAND, 0.0) if lane.type in VEHICLE_LANES else spare
        spare += width
    return spare


def island(world: World, road: int, s: float, half: float, edges: tuple[float, float], osm_id: str) -> RoadObject:
    """Make an island from s - half to s + half, cut at the road's ends, between t of its edges, m."""
    begin, end = max(s - half, 0.0), min(s + half, world.lanes.length(road))
    left, right = edges
    s, t = 0.5 * (begin + end), 0.5 * (left + right)
    corners = ((begin, right), (end, right), (end, left), (begin, left))
    around = outline(world, road, s, t, corners, ISLAND_HEIGHT)
    found = world.object_at(road, ("trafficIsland", "", "island"), s, t, osm_id)
    return replace(found, length=end - begin, width=left - right, height=ISLAND_HEIGHT, outline=around)
