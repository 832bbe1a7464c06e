"""Ways through junctions that a reader would keep in place of those for cars.

Where several lanes of a road lead to one lane, SUMO's netconvert keeps the way whose road comes first by its id as a
text (measured with 1.28). If that one begins on a lane for buses, no car gets there any more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from osm2xodr.model import CAR_LANES, Connection, LaneType, Road, RoadLink, RoadMap
from osm2xodr.xodrWriter.formatting import Words

# What such a way is written as: nothing is driven on, but the surface stays.
_CLOSED = LaneType.SHOULDER


class _Way(NamedTuple):
    """A way through a junction from one lane to another."""

    entry: RoadLink
    exit: tuple[RoadLink, int | None]  # The road that it leads to, and the id of its lane
    for_all: bool  # Whether it begins on a lane for all
    lane: tuple[int, int]  # Ids of the connecting road and of its lane


def with_exits_for_all(road_map: RoadMap, words: Words) -> RoadMap:
    """Close ways from lanes for some to lanes that lanes for all lead to from the same road.

    They become shoulders. Lanes for some are those that `words` writes as lanes for all with an ``<access>``.
    """
    some = frozenset(kind for kind in LaneType if words.lane_users(kind.value))
    roads = {road.id: road for road in road_map.roads}
    closed: set[tuple[int, int]] = set()
    for junction in road_map.junctions if some else ():
        ways = [way for item in junction.connections for way in _ways(item, roads, some)]
        if all(way.for_all for way in ways):
            continue
        free = {(way.entry, way.exit) for way in ways if way.for_all}
        closed |= {way.lane for way in ways if not way.for_all and (way.entry, way.exit) in free}
    if not closed:
        return road_map
    changed = {road for road, _ in closed}
    made = [_with_closed(road, closed) if road.id in changed else road for road in road_map.roads]
    return replace(road_map, roads=tuple(made))


def _ways(connection: Connection, roads: Mapping[int, Road], some: frozenset[LaneType]) -> list[_Way]:
    """Return the ways of a connection that begin on lanes for vehicles."""
    road = roads[connection.connecting_road]
    entry, leaves = road.predecessor, road.successor
    if entry is None or leaves is None:
        return []
    before = roads[entry.id].lane_sections[0 if entry.at_start else -1]
    types = {lane.id: lane.type for lane in before.lanes}
    open_ = some | CAR_LANES
    return [
        _Way(entry, (leaves, _exit_lane(road, lane)), types[begin] not in some, (road.id, lane))
        for begin, lane in connection.lane_links
        if types.get(begin) in open_
    ]


def _exit_lane(road: Road, lane: int) -> int | None:
    """Return the lane that a lane of a connecting road leads to at its end."""
    found: int | None = lane
    for section in road.lane_sections:
        found = next((item.successor for item in section.lanes if item.id == found), None)
    return found


def _with_closed(road: Road, closed: set[tuple[int, int]]) -> Road:
    """Return a connecting road with some of its lanes, by (id of the road, id of the lane), closed."""
    sections = []
    ids = {lane for other, lane in closed if other == road.id}
    for section in road.lane_sections:
        lanes = [replace(lane, type=_CLOSED) if lane.id in ids else lane for lane in section.lanes]
        ids = {lane.successor for lane in section.lanes if lane.id in ids and lane.successor is not None}
        sections.append(replace(section, lanes=tuple(lanes)))
    return replace(road, lane_sections=tuple(sections))
