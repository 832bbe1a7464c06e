"""Road ends at which cars come to junctions and stop there, and roads that cross railways."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import Final

import numpy as np

from osm2xodr.conventions import meant_ends
from osm2xodr.curves import heading_change
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world.world import Approach, Crossing, Movement, World
from osm2xodr.model import VEHICLE_LANES, LaneType, RailCrossing
from osm2xodr.system import record

# How far before the middle of the first track signs stand, m: MUTCD 2009, 8B.03, wants crossbucks 12 ft from the
# nearest rail, and the rail is half of the gauge from the middle.
_BEFORE_TRACK: Final = 4.4


def find_approaches(world: World, crossings: Sequence[Crossing]) -> tuple[Approach, ...]:
    """Find all road ends at which cars come to a junction, in the order of junctions and roads.

    Traffic stops before the crossings at the junction, see `before_crossings`.
    """
    on_course = crossings_on_course(crossings)
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
        stop = _stop(world, road, at_end, on_course.get(road, ()), nodes.get((road, at_end), ()))
        out.append(Approach(road, at_end, junction, street_end[road, at_end], tuple(lanes), tuple(movements), stop))
    return tuple(out)


def _movements(world: World) -> dict[tuple[int, int, bool], list[Movement]]:
    """Return the ways of cars through junctions, by junction, road and whether they come from its end."""
    road_map = world.road_map
    plan = road_map.plan_view
    turns = heading_change(plan, np.arange(len(plan.start) - 1)).tolist()
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
    """Return s of the nodes with signs or lights near a road's start or end, by road and whether it is its end, m.

    They count for the traffic that they are meant for: one behind a junction is not for the next one.
    """
    places = world.places
    out: dict[tuple[int, bool], list[float]] = defaultdict(list)
    columns = (column.tolist() for column in (places.node, places.street, places.road, places.s))
    for node, street_id, road, s in zip(*columns, strict=True):
        control = world.network.node_facts.controls.get(node)
        if road < 0 or control is None or control.tagged is None:
            continue
        length, street = world.lanes.length(road), world.network.streets[street_id]
        for end in meant_ends(street, street.place_of(node), control.facing) if 0.0 < s < length else ():
            if (length - s if end else s) <= defaults.STOP_NODE_REACH:
                out[road, bool(end)].append(s)
    return out


def _stop(world: World, road: int, at_end: bool, crossings: Sequence[Crossing], nodes: Sequence[float]) -> float:
    """Return s where traffic stops: at the farthest sign, but before crossings and outside the junction, m."""
    length = world.lanes.length(road)
    away = [length - s if at_end else s for s in nodes]
    farthest = min(max([defaults.STOP_LINE_SETBACK, *away]), 0.5 * length)
    farthest = before_crossings(farthest, length, crossings, at_end=at_end)
    return length - farthest if at_end else farthest


def crossings_on_course(crossings: Iterable[Crossing]) -> Mapping[int, list[Crossing]]:
    """Return crossings by the road outside junctions on whose course they lie."""
    out: dict[int, list[Crossing]] = defaultdict(list)
    for crossing in crossings:
        out[crossing.on_course[0]].append(crossing)
    return out


def before_crossings(stop: float, length: float, crossings: Sequence[Crossing], *, at_end: bool) -> float:
    """Return where traffic that would stop at a place stops for crossings, as a distance from the road's end, m.

    It stops before a crossing if no car fits between this and the line, and at a junction before all of its crossings
    with lights; a line right at a junction comes nearer to it where that makes room for a car. Traffic runs to the
    road's end, else (not `at_end`) to its start; `crossings` are those on the road's course, `length` is its length.
    """
    room = defaults.ROOM_FOR_CAR + defaults.STOP_LINE_EXTENT
    # Where each ends and begins as traffic leaves and meets it, as distances from the road's end
    found = []
    for item in crossings:
        away = length - item.on_course[1] if at_end else item.on_course[1]
        together = item.signals and (item.at_end if at_end else item.at_start)
        found.append((away - 0.5 * item.width, away + 0.5 * item.width, together))
    for near, far, together in sorted(found):
        if far + defaults.STOP_LINE_BEFORE_CROSSING <= stop or (near >= stop + room and not together):
            continue
        if room <= near < room + defaults.STOP_LINE_SETBACK >= room + stop and not together:
            stop = near - room
            continue
        # On a short road the line lies at its beginning, but not on the crossing.
        least, most = far + defaults.STOP_LINE_SQUEEZED, length - defaults.STOP_LINE_EXTENT
        if least <= length:
            stop = max(stop, min(far + defaults.STOP_LINE_BEFORE_CROSSING, most), least)
    return stop


def with_room_for_line(world: World, road: int, s: float, width: float) -> tuple[float, float]:
    """Return s and width, m, of a crossing mapped at s of a short road, so that traffic can stop before it.

    s may lie beyond the road's ends; both stay as they are where the crossing would have to be moved too far.
    """
    length = world.lanes.length(road)
    at, half, line = min(max(s, 0.0), length), 0.5 * width, defaults.STOP_LINE_SQUEEZED + defaults.STOP_LINE_EXTENT
    behind = defaults.ROOM_FOR_CAR + defaults.STOP_LINE_EXTENT + half
    if min(s, length - s) >= half + line or length >= behind + half + line:
        # There is room for lines on both sides, or for a car behind every crossing that leaves none for a line.
        return s, width
    first = half + line if length - s < behind and car_lanes(world, road, at, along=True) else -inf
    last = length - half - line if s < behind and car_lanes(world, road, at, along=False) else inf
    moved = min(max(s, first), last)
    if first > last or moved == s:
        return s, width
    if not 0.0 <= moved <= length:
        # The crossing becomes narrower rather than that it loses its road.
        moved = min(max(moved, 0.0), length)
        width = max(min(width, 2.0 * (length - line)), min(width, defaults.CROSSING_WIDTH_MIN))
    return (moved, width) if abs(moved - s) <= defaults.CROSSING_REACH_FOR_LINE else (s, 2.0 * half)


def car_lanes(world: World, road: int, s: float, along: bool) -> tuple[int, ...]:
    """Return the ids of the lanes for cars that run along s (or against it), from the centre outwards."""
    runs = world.lanes.runs_along
    cars = [lane for lane in world.lanes.lanes(road, s) if lane.type in VEHICLE_LANES]
    own = (lane.id for lane in cars if lane.type is LaneType.BIDIRECTIONAL or runs(lane.id) == along)
    return tuple(sorted(own, key=abs))


def junction_behind(world: World, approach: Approach) -> int | None:
    """Return the id of the junction from which an approach comes; None where it comes from none."""
    road = world.lanes.road(approach.road)
    link = road.predecessor if approach.at_end else road.successor
    return link.id if link is not None and link.to_junction else None


def lane_at_other_end(world: World, road: int, lane: int, *, along: bool) -> int | None:
    """Return the id at a road's end (`along`, else its start) of a lane at its other end; None if it ends before."""
    sections = world.lanes.road(road).lane_sections
    found: int | None = lane
    for section in sections[:-1] if along else sections[:0:-1]:
        one = next((item for item in section.lanes if item.id == found), None)
        found = None if one is None else one.successor if along else one.predecessor
    return found


@record
class RailStop:
    """What stands before the tracks for one direction of a road."""

    road: int  # Id of the road
    s: float  # m
    along: bool  # Whether for traffic along s, else for that against it
    crossing: RailCrossing  # What OSM says of it
    osm_id: str  # The node


def find_rail_stops(world: World) -> list[RailStop]:
    """Return where traffic meets railways, by road; tracks near each other are one crossing.

    Crossings in a junction are for the road that leads to them.
    """
    known = world.network.node_facts.rail_crossings
    by_road: dict[int, list[tuple[float, int]]] = defaultdict(list)
    for node, places in sorted(world.nodes.on_streets(known).items()):
        on_road = [place for place in places if place.road >= 0]
        for place in on_road:
            by_road[place.road].append((place.s, node))
        if not on_road:
            words = "railway=level_crossing is not carried: it lies in a junction, on a way that no road leads over"
            world.diagnostics.dropped("street-node", f"node/{node}", words)
    return [stop for road, tracks in sorted(by_road.items()) for stop in _stops(world, road, sorted(tracks))]


def _stops(world: World, road: int, tracks: list[tuple[float, int]]) -> list[RailStop]:
    length = world.lanes.length(road)
    groups: list[list[tuple[float, int]]] = []
    for track in tracks:
        if not groups or track[0] - groups[-1][-1][0] > defaults.ONE_INSTALLATION:
            groups.append([])
        groups[-1].append(track)
    out: list[RailStop] = []
    for group in groups:
        for (at, node), along in ((group[0], True), (group[-1], False)):
            s = at - _BEFORE_TRACK if along else at + _BEFORE_TRACK
            # Beyond the road's end, in a junction, it is met by those who leave the road there.
            met = s >= 0.0 if along else s <= length
            inside = min(max(s, 0.0), length)
            if met and car_lanes(world, road, inside, along):
                crossing = world.network.node_facts.rail_crossings[node]
                out.append(RailStop(road, inside, along, crossing, f"node/{node}"))
    return out
