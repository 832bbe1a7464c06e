"""Road ends at which cars come to junctions, and where they stop there."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from osm2xodr.curves import lengths, pose, wrapped
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world.world import Approach, Crossing, Movement, World
from osm2xodr.model import VEHICLE_LANES, LaneType


def find_approaches(world: World, crossings: Sequence[Crossing]) -> tuple[Approach, ...]:
    """Find all road ends at which cars come to a junction, in the order of junctions and roads.

    Traffic stops before the crossings at the junction.
    """
    at_ends: dict[tuple[int, bool], list[Crossing]] = defaultdict(list)
    for crossing in crossings:
        for at_end, there in ((False, crossing.at_start), (True, crossing.at_end)):
            if there:
                at_ends[crossing.road, at_end].append(crossing)
    nodes = _control_nodes(world)
    street_end = {}
    for end, road in enumerate(world.places.end_road.tolist()):
        if road >= 0:
            street_end[road, bool(end % 2)] = end
    out: list[Approach] = []
    for (junction, road, at_end), movements in sorted(_movements(world).items()):
        if (road, at_end) not in street_end:
            continue
        lanes = sorted({item.entry_lane for item in movements}, reverse=at_end)
        stop = _stop(world, road, at_end, at_ends.get((road, at_end), ()), nodes.get((road, at_end), ()))
        out.append(Approach(road, at_end, junction, street_end[road, at_end], tuple(lanes), tuple(movements), stop))
    return tuple(out)


def _movements(world: World) -> dict[tuple[int, int, bool], list[Movement]]:
    """Return the ways of cars through junctions, by junction, road and whether they come from its end."""
    road_map = world.road_map
    plan = road_map.plan_view
    every = np.arange(len(plan.start) - 1)
    start, end = (pose(plan, every, s)[2] for s in (np.zeros(len(every)), lengths(plan)))
    # Change of heading along each road, rad
    turns = wrapped(end - start).tolist()
    out: dict[tuple[int, int, bool], list[Movement]] = defaultdict(list)
    for junction in road_map.junctions:
        for connection in junction.connections:
            through = world.lanes.road(connection.connecting_road)
            before, after = through.predecessor, through.successor
            if before is None or after is None:
                continue
            for lane_in, lane_through in connection.lane_links:
                lane = next(item for item in through.lane_sections[0].lanes if item.id == lane_through)
                if lane.type not in VEHICLE_LANES or lane.successor is None:
                    continue
                turn = turns[world.lanes.index(through.id)]
                movement = Movement(through.id, lane_in, after.id, bool(after.at_start), lane.successor, turn)
                out[junction.id, before.id, not before.at_start].append(movement)
    return out


def _control_nodes(world: World) -> Mapping[tuple[int, bool], list[float]]:
    """Return s of the nodes with signs or lights near a road's start or end, by road and whether it is its end, m."""
    places = world.places
    out: dict[tuple[int, bool], list[float]] = defaultdict(list)
    for node, road, s in zip(places.node.tolist(), places.road.tolist(), places.s.tolist(), strict=True):
        control = world.network.node_facts.controls.get(node)
        if road < 0 or control is None or control.tagged is None:
            continue
        for at_end, distance in ((False, s), (True, world.lanes.length(road) - s)):
            if 0.0 < s < world.lanes.length(road) and distance <= defaults.STOP_NODE_REACH:
                out[road, at_end].append(s)
    return out


def _stop(world: World, road: int, at_end: bool, crossings: Sequence[Crossing], nodes: Sequence[float]) -> float:
    """Return s where traffic stops: at the farthest sign, but before crossings and outside the junction, m."""
    length = world.lanes.length(road)
    # s, and how far before it traffic stops
    before = [(s, 0.0) for s in nodes]
    before += [(item.s, 0.5 * item.width + defaults.STOP_LINE_BEFORE_CROSSING) for item in crossings]
    # Distances from the junction
    away = [(length - s if at_end else s) + more for s, more in before]
    farthest = min(max([defaults.STOP_LINE_SETBACK, *away]), 0.5 * length)
    return length - farthest if at_end else farthest


def car_lanes(world: World, road: int, s: float, along: bool) -> tuple[int, ...]:
    """Return the ids of the lanes for cars that run along s (or against it), from the centre outwards."""
    runs = world.lanes.runs_along
    cars = [lane for lane in world.lanes.at(road, s) if lane.type in VEHICLE_LANES]
    own = (lane.id for lane in cars if lane.type is LaneType.BIDIRECTIONAL or runs(lane.id) == along)
    return tuple(sorted(own, key=abs))
