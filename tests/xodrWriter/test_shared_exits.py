"""Lanes for buses and for cars that lead to one lane."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sample_road_maps import centre, crossing, lane, plan_view, profile

from osm2xodr.conventions import TARGETS
from osm2xodr.model import Connection, LaneSection, LaneType, Road, RoadLink, RoadMap
from osm2xodr.xodrWriter.formatting import Words
from osm2xodr.xodrWriter.options import DIALECTS
from osm2xodr.xodrWriter.shared_exits import with_exits_for_all

SUMO = Words(DIALECTS["1.7"], TARGETS["sumo"].lane_types)


def two_lanes_to_one(bus_exit: int = -1) -> RoadMap:
    """`crossing` with a way from the bus lane of road 1, road 6, to a lane of road 2 as well."""
    found = crossing()
    ways = (
        LaneSection(0.0, (centre(None), lane(-1, -2, -3, None))),
        LaneSection(4.0, (centre(None), lane(-3, -1, bus_exit))),
    )
    added = Road(6, "", 5, RoadLink(False, 1, False), RoadLink(False, 2, True), (), ways, ())
    (junction,) = found.junctions
    connections = (*junction.connections, Connection(2, 1, 6, ((-2, -1),)))
    line: list[tuple[float, ...]] = [(0.0, 0.0, 0.0, 0.0, 10.0, 0.0)]
    return replace(
        found,
        roads=(*found.roads, added),
        junctions=(replace(junction, connections=connections),),
        plan_view=plan_view([line] * 5),
        elevation=profile([[]] * 5),
        superelevation=profile([[]] * 5),
        lane_offset=profile([[]] * 5),
    )


def lane_types(road_map: RoadMap) -> list[list[LaneType]]:
    """Types of the lanes of all connecting roads but their centre, section after section."""
    return [
        [item.type for section in road.lane_sections for item in section.lanes if item.id]
        for road in road_map.roads
        if road.junction is not None
    ]


def test_a_way_for_buses_gives_way_to_one_for_cars() -> None:
    found = with_exits_for_all(two_lanes_to_one(), SUMO)
    driving, shoulder = LaneType.DRIVING, LaneType.SHOULDER
    assert lane_types(found) == [[driving], [driving], [shoulder, shoulder]]
    assert found.junctions == two_lanes_to_one().junctions


def test_a_way_for_buses_to_a_lane_of_its_own_stays() -> None:
    road_map = two_lanes_to_one(bus_exit=-2)
    assert with_exits_for_all(road_map, SUMO) is road_map


def test_ways_for_all_stay() -> None:
    """As where the lane beside is one for cars, and for readers that know lanes for buses."""
    road_map = two_lanes_to_one()
    assert with_exits_for_all(road_map, Words(DIALECTS["1.7"])) is road_map
    assert with_exits_for_all(road_map, Words(DIALECTS["1.4"], TARGETS["sumo"].lane_types)) is road_map
    first, *others = road_map.roads
    *before, last = first.lane_sections
    cars = replace(
        last, lanes=tuple(replace(item, type=LaneType.DRIVING) if item.id else item for item in last.lanes)
    )
    all_cars = replace(road_map, roads=(replace(first, lane_sections=(*before, cars)), *others))
    assert with_exits_for_all(all_cars, SUMO) is all_cars


@pytest.mark.parametrize("kind", [LaneType.BUS, LaneType.TAXI])
def test_without_a_lane_for_cars_buses_keep_their_way(kind: LaneType) -> None:
    road_map = two_lanes_to_one()
    first, *others = road_map.roads
    *before, last = first.lane_sections
    apart = replace(last, lanes=tuple(replace(item, type=kind) if item.id else item for item in last.lanes))
    road_map = replace(road_map, roads=(replace(first, lane_sections=(*before, apart)), *others))
    assert with_exits_for_all(road_map, SUMO) is road_map
