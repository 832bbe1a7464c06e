"""What raises and paints the carriageway: crosswalks and islands of crossings, other islands, and traffic calming."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import hypot
from typing import Final

import numpy as np

from osm2xodr.curves import cosine, pose, project, sine
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.furniture.world import Crossing, LaneAt, NodePlace, World, outline
from osm2xodr.model import VEHICLE_LANES, LaneType, RoadMap, RoadObject

# Length along the road and height by OSM's value, m. Humps and tables: Highways (Road Hump) Regulations 1999 (at most
# 0.1 m high) and FHWA Traffic Calming ePrimer (humps of 12 ft, tables of 22 ft); all others: choices.
_CALMING_SIZES: Final = {
    "bump": (0.6, 0.08),
    "mini_bumps": (0.3, 0.04),
    "hump": (3.7, 0.08),
    "double_hump": (7.4, 0.08),
    "table": (6.7, 0.08),
    "cushion": (3.0, 0.07),
    "rumble_strip": (3.0, 0.01),
    "dip": (2.0, 0.0),
    "double_dip": (4.0, 0.0),
}
# Width of cushions, and length of islands without a crossing, m; choices.
_CUSHION_WIDTH: Final = 1.8
_ISLAND_LENGTH: Final = 6.0

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

# Decimals of the corners and the size of an island, m.
_DECIMALS: Final = 3


def calming_objects(world: World) -> list[RoadObject]:
    """Make the objects of ``traffic_calming`` on nodes of streets, in the order of nodes."""
    calming = world.network.node_facts.calming
    places = world.nodes.on_streets(calming)
    out: list[RoadObject] = []
    left_out: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for node in sorted(places):
        found = _calming_objects(world, node, calming[node], places[node])
        if isinstance(found, str):
            left_out[calming[node], found].append(f"node/{node}")
        else:
            out += found
    for (kind, why), names in sorted(left_out.items()):
        finding = f"with traffic_calming={kind} left out: {why}"
        world.diagnostics.count(Kind.DROPPED, "traffic-calming", names, "node", finding)
    return out


def _calming_objects(world: World, node: int, kind: str, here: Iterable[NodePlace]) -> list[RoadObject] | str:
    """Make the objects of one node, or return why there are none."""
    if kind != "island" and kind not in _CALMING_SIZES:
        return "it changes the carriageway, which follows the lanes"
    length = _ISLAND_LENGTH if kind == "island" else _CALMING_SIZES[kind][0]
    outside = (place for place in here if place.road >= 0 and 0.0 <= place.s <= world.lanes.length(place.road))
    place = next(outside, None)
    if place is None:
        return "it lies in a junction"
    whole = world.lanes.length(place.road)
    if whole < length:
        return "the road there is shorter"
    s = min(max(place.s, 0.5 * length), whole - 0.5 * length)
    osm_id = f"node/{node}"
    if kind != "island":
        return [_patch(world, kind, place.road, s, *edges, osm_id) for edges in _across(world, kind, place.road, s)]
    edges = island_edges(world, place.road, s)
    if edges is None:
        return "all lanes run the same way and do not show where it lies"
    if edges[0] - edges[1] < NARROWEST_ISLAND:
        return "the lanes cannot spare the room"
    return [island(world, place.road, s, 0.5 * length, edges, osm_id)]


def _across(world: World, kind: str, road: int, s: float) -> list[tuple[float, float]]:
    """Return t of left and right edges across a road, m: one cushion per lane, all else across the carriageway."""
    if kind != "cushion":
        left, right = world.lanes.carriageway(road, s)
        return [(left, right)] if left > right else []
    half = 0.5 * _CUSHION_WIDTH
    return [
        (lane.middle + half, lane.middle - half)
        for lane in world.lanes.at(road, s)
        if lane.type in VEHICLE_LANES and lane.left - lane.right >= _CUSHION_WIDTH
    ]


def _patch(world: World, kind: str, road: int, s: float, left: float, right: float, osm_id: str) -> RoadObject:
    length, height = _CALMING_SIZES[kind]
    patch = world.object_at(road, ("patch", kind, kind.replace("_", " ")), s, 0.5 * (left + right), osm_id)
    return replace(patch, length=length, width=left - right, height=height)


def crossing_objects(world: World, crossings: Sequence[Crossing]) -> list[RoadObject]:
    """Make the objects of crossings: crosswalks, and islands in them."""
    return [item for crossing in crossings for item in _crossing_objects(world, crossing)]


def _crossing_objects(world: World, crossing: Crossing) -> list[RoadObject]:
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


def island_objects(road_map: RoadMap, diagnostics: Diagnostics) -> list[RoadObject]:
    """Return the islands of a road map, at least one, as objects on roads beside them."""
    furniture, islands = road_map.furniture, road_map.islands
    used = (item.id for kind in (furniture.signals, furniture.objects, furniture.structures) for item in kind)
    number = max(used, default=0)
    road = np.array([item.road for item in islands], np.int64)
    x, y = np.array([item.corners.mean(axis=0) for item in islands]).T
    s, t, _ = project(road_map.plan_view, road, x, y)
    at_x, at_y, hdg = pose(road_map.plan_view, road, s)
    x, y = at_x - t * sine(hdg), at_y + t * cosine(hdg)
    nodes = {item.id: item.osm_node_ids[0] for item in road_map.junctions}
    made: list[RoadObject] = []
    for k, item in enumerate(islands):
        dx, dy = (item.corners - (x[k], y[k])).T
        u, v = dx * cosine(hdg[k]) + dy * sine(hdg[k]), dy * cosine(hdg[k]) - dx * sine(hdg[k])
        corners = zip(u.round(_DECIMALS).tolist(), v.round(_DECIMALS).tolist(), strict=True)
        made.append(
            RoadObject(
                number + 1 + k,
                road_map.roads[item.road].id,
                *("trafficIsland", "", "island"),
                float(s[k]),
                float(t[k]),
                length=round(float(np.ptp(u)), _DECIMALS),
                width=round(float(np.ptp(v)), _DECIMALS),
                height=ISLAND_HEIGHT,
                outline=tuple((a, b, 0.0, ISLAND_HEIGHT) for a, b in corners),
                osm_id=item.osm_id,
            )
        )
        if item.osm_id:
            continue
        text = "a place that its carriageways go round is raised as an island"
        diagnostics.guessed("junction-island", f"node/{nodes[item.junction]}", text)
    return made
