"""Where lanes come and go along a road: which goes on as which, on either side of the road."""

from __future__ import annotations

import pytest
from road_measures import RoadMeasures, assert_sound
from street_cases import Case

from osm2xodr.model import LaneType, Rule

_NODES = {"w": (-150.0, 0.0), "o": (0.0, 0.0), "e": (150.0, 0.0)}


def _street(before: str, after: str, *named: tuple[int, str, int, str, int, int]) -> Case:
    return Case(_NODES, {1: ("w o", before), 2: ("o e", after)}, connectivity=named)


_CENTRE = "highway=primary lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1 turn:lanes:both_ways=left"
_POCKET = "highway=primary lanes=3 lanes:forward=2 lanes:backward=1 turn:lanes:forward=left|through"
_ONEWAY = "highway=primary oneway=yes lanes="
_FOUR = "highway=primary lanes=4"
_ONE_MORE = "highway=primary lanes=5 lanes:forward=3 lanes:backward=2"

# What the lanes before the middle go on as behind it.
CHANGES = {
    "lane_drop": (_street(_ONEWAY + "3", _ONEWAY + "2"), {-1: -1, -2: -2}),
    "lane_drop_at_the_far_side": (
        _street(_ONEWAY + "3 turn:lanes=merge_to_right|through|through", _ONEWAY + "2"),
        {-2: -1, -3: -2},
    ),
    "lane_gain": (_street(_ONEWAY + "2", _ONEWAY + "3"), {-1: -1, -2: -2}),
    "lane_gain_with_placement": (
        _street(_ONEWAY + "2 placement=right_of:1", _ONEWAY + "3 placement=right_of:2"),
        {-1: -2, -2: -3},
    ),
    "lane_gain_with_placement_at_the_near_side": (
        _street(_ONEWAY + "2 placement=right_of:1", _ONEWAY + "3 placement=right_of:1"),
        {-1: -1, -2: -2},
    ),
    "centre_lane_opens": (_street("highway=primary lanes=2", _CENTRE), {1: 1, -1: -2}),
    "centre_lane_becomes_a_pocket": (_street(_CENTRE, _POCKET), {1: 1, -1: -1, -2: -2}),
    "connectivity_opens_a_lane_at_the_far_side": (
        _street(_FOUR, _ONE_MORE, (1, "o", 2, "1:2|2:3", 2, 3)),
        {2: 2, 1: 1, -1: -2, -2: -3},
    ),
    "connectivity_opens_a_lane_in_the_middle": (
        _street(_FOUR, _ONE_MORE, (1, "o", 2, "1:1,(2)|2:3", 2, 3)),
        {2: 2, 1: 1, -1: -1, -2: -3},
    ),
    "connectivity_against_the_street": (
        _street(_ONE_MORE, "highway=primary lanes=5 lanes:forward=3 lanes:backward=1", (2, "o", 1, "1:2", 1, 2)),
        {2: 1, -1: -1, -2: -2, -3: -3},
    ),
}


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
@pytest.mark.parametrize("name", CHANGES)
def test_lanes_that_go_on(name: str, rule: Rule) -> None:
    case, expected = CHANGES[name]
    right = rule is Rule.RIGHT_HAND
    roads = (case if right else case.mirrored()).build(rule)
    assert_sound(roads)
    (road,) = roads.roads
    assert set(road.osm_way_ids) == {1, 2}
    before, after = road.lane_sections
    going_on = {lane.id: lane.successor for lane in before.lanes if lane.successor is not None}
    coming = {lane.predecessor: lane.id for lane in after.lanes if lane.predecessor is not None}
    wanted = expected if right else {-lane: -to for lane, to in expected.items()}
    assert going_on == wanted
    assert coming == wanted


@pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
def test_a_centre_lane_keeps_its_width_as_it_becomes_a_pocket(rule: Rule) -> None:
    case = CHANGES["centre_lane_becomes_a_pocket"][0]
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    (road,) = roads.roads
    measures = RoadMeasures(roads)
    inner = -1 if rule is Rule.RIGHT_HAND else 1
    kinds = [next(lane.type for lane in section.lanes if lane.id == inner) for section in road.lane_sections]
    assert kinds == [LaneType.BIDIRECTIONAL, LaneType.DRIVING]
    border = road.lane_sections[1].s
    for s in (border - 20.0, border, border + 20.0):
        edges = measures.edges(road, int(s >= border), s)
        assert max(max(pair) for pair in edges.values()) - min(min(pair) for pair in edges.values()) > 9.0
        assert abs(edges[inner][0] - edges[inner][1]) > 2.9
