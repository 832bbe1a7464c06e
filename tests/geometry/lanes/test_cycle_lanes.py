"""Lanes for bicycles and buses do not change where cars go."""

from __future__ import annotations

import pytest
from junction_cases import CASES
from road_measures import assert_sound
from street_cases import Case, Link, built_links, mirrored_links, written_links

from osm2xodr.model import LaneType, RoadMap, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
SIDE_BY_SIDE = ("x", "t", "offset_t", "roundabout", "y_merge", "y_split", "only_straight_on", "star")


def built(case: Case, rule: Rule) -> RoadMap:
    return (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)


def with_tags(case: Case, tags: dict[int, str]) -> Case:
    ways = {way: (nodes, f"{text} {tags.get(way, '')}".strip()) for way, (nodes, text) in case.ways.items()}
    return Case(case.nodes, ways, case.restrictions, case.node_tags)


def links_by_type(roads: RoadMap) -> tuple[set[Link], set[Link]]:
    """Return the links of cars' lanes, and those of bicycle lanes."""
    by_id = {road.id: road for road in roads.roads}
    biking = set()
    for junction in roads.junctions:
        for connection in junction.connections:
            road = by_id[connection.incoming_road]
            at_end = by_id[connection.connecting_road].predecessor
            assert at_end is not None
            section = road.lane_sections[0 if at_end.at_start else -1]
            types = {lane.id: lane.type for lane in section.lanes}
            ways = road.osm_way_ids[0 if at_end.at_start else -1]
            biking |= {(ways, lane) for lane, _ in connection.lane_links if types[lane] is LaneType.BIKING}
    every = set(built_links(roads))
    return {link for link in every if link[:2] not in biking}, {link for link in every if link[:2] in biking}


@EITHER
@pytest.mark.parametrize("name", [name for name in SIDE_BY_SIDE if name in CASES])
def test_cars_go_where_they_went_before(name: str, rule: Rule) -> None:
    expected = CASES[name]
    tagged = with_tags(expected.case, dict.fromkeys(expected.case.ways, "cycleway=lane"))
    roads = built(tagged, rule)
    cars, _ = links_by_type(roads)
    assert cars == (expected.links if rule is Rule.RIGHT_HAND else mirrored_links(expected.links))
    assert len(roads.junctions) == expected.junctions
    assert_sound(roads)


@EITHER
def test_bicycle_lanes_go_straight_on_and_round_the_corner_along_the_kerb(rule: Rule) -> None:
    roads = built(with_tags(CASES["x"].case, dict.fromkeys(range(1, 5), "cycleway=lane")), rule)
    _, bicycles = links_by_type(roads)
    wanted = written_links("1:-2>2:-2,3:2 2:2>1:2,4:-2 3:-2>4:-2,2:-2 4:2>3:2,1:2")
    assert bicycles == (wanted if rule is Rule.RIGHT_HAND else mirrored_links(wanted))


@EITHER
@pytest.mark.parametrize("tag", ["cycleway=opposite_lane", "busway=opposite_lane"])
def test_a_lane_against_a_one_way_street_lets_no_car_in(tag: str, rule: Rule) -> None:
    """Way 2 leads away to the east; nothing may come from it, and no car may enter way 1 from the crossing."""
    tags = {1: "oneway=yes lanes=2", 2: f"oneway=yes lanes=2 {tag}"}
    roads = built(with_tags(CASES["x"].case, tags), rule)
    plain = built(with_tags(CASES["x"].case, {**tags, 2: f"oneway=yes lanes={1 if 'bus' in tag else 2}"}), rule)
    assert built_links(roads) == built_links(plain)
    (east,) = (road for road in roads.roads if road.osm_way_ids == (2,))
    side = 1 if rule is Rule.RIGHT_HAND else -1
    kind = LaneType.BUS if "bus" in tag else LaneType.BIKING
    assert [lane.type for lane in east.lane_sections[0].lanes if lane.id == side] == [kind]


@EITHER
def test_a_direction_closed_to_cars_is_not_entered(rule: Rule) -> None:
    case = with_tags(CASES["t"].case, {3: "lanes=1 motor_vehicle:backward=no"})
    wanted = written_links("1:-1>2:-1 2:1>1:1 3:-1>1:1,2:-1")
    assert set(built_links(built(case, rule))) == (wanted if rule is Rule.RIGHT_HAND else mirrored_links(wanted))
