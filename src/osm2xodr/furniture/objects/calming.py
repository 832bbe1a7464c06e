"""Traffic calming: humps, tables, cushions and islands on the carriageway."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.furniture.objects.crosswalks import NARROWEST_ISLAND, island, island_edges
from osm2xodr.furniture.world import NodePlace, World
from osm2xodr.model import VEHICLE_LANES, RoadObject

# Length along the road and height by OSM's value, m. Humps and tables: Highways (Road Hump) Regulations 1999 (at most
# 0.1 m high) and FHWA Traffic Calming ePrimer (humps of 12 ft, tables of 22 ft); all others: choices.
_SIZES: Final = {
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


def calming_objects(world: World) -> list[RoadObject]:
    """Make the objects of ``traffic_calming`` on nodes of streets, in the order of nodes."""
    calming = world.network.node_facts.calming
    places = world.nodes.on_streets(calming)
    out: list[RoadObject] = []
    left_out: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for node in sorted(places):
        found = _objects(world, node, calming[node], places[node])
        if isinstance(found, str):
            left_out[calming[node], found].append(f"node/{node}")
        else:
            out += found
    for (kind, why), names in sorted(left_out.items()):
        finding = f"with traffic_calming={kind} left out: {why}"
        world.diagnostics.count(Kind.DROPPED, "traffic-calming", names, "node", finding)
    return out


def _objects(world: World, node: int, kind: str, here: Iterable[NodePlace]) -> list[RoadObject] | str:
    """Make the objects of one node, or return why there are none."""
    if kind != "island" and kind not in _SIZES:
        return "it changes the carriageway, which follows the lanes"
    length = _ISLAND_LENGTH if kind == "island" else _SIZES[kind][0]
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
    length, height = _SIZES[kind]
    patch = world.object_at(road, ("patch", kind, kind.replace("_", " ")), s, 0.5 * (left + right), osm_id)
    return replace(patch, length=length, width=left - right, height=height)
