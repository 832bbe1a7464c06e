"""Limits of single lanes, lists of limits, and bus lanes against the main direction."""

from __future__ import annotations

import pytest
from street_cases import Case

from osm2xodr.model import Direction, LaneType, Rule
from osm2xodr.osmParsing.tags.cross_sections import CrossSection, cross_section
from osm2xodr.osmParsing.tags.values import lowest_speed

_KMH = 1 / 3.6
_LINE = {"a": (0.0, 0.0), "b": (300.0, 0.0)}


def lanes_of(section: CrossSection) -> list[tuple[LaneType, Direction]]:
    return [(lane.type, lane.direction) for lane in section.lanes_ltr]


@pytest.mark.parametrize(
    ("text", "kmh", "one"),
    [("50;70", 50.0, False), ("30 mph; 20 mph", 32.187, False), ("80", 80.0, True), ("signals;60", 60.0, False)],
)
def test_the_lowest_of_several_limits_is_taken(text: str, kmh: float, one: bool) -> None:
    speed, exact = lowest_speed(text)
    assert speed is not None
    assert speed == pytest.approx(kmh * _KMH, rel=1e-4)
    assert exact is one


@pytest.mark.parametrize(("rule", "expected"), [(Rule.RIGHT_HAND, [130, 130, 80]), (Rule.LEFT_HAND, [130, 130, 80])])
def test_lanes_have_limits_of_their_own(rule: Rule, expected: list[int]) -> None:
    tags = "highway=motorway oneway=yes lanes=3 maxspeed=130 maxspeed:lanes=130|130|80"
    roads = Case(_LINE, {1: ("a b", tags)}).build(rule)
    lanes = [lane for lane in roads.roads[0].lane_sections[0].lanes if lane.type is LaneType.DRIVING]
    assert [round(lane.speed * 3.6) for lane in lanes if lane.speed is not None] == expected


@pytest.mark.parametrize("user", ["psv", "bus"])
def test_the_odd_lane_runs_where_buses_have_theirs(user: str) -> None:
    section = cross_section({"highway": "primary", "lanes": "3", f"lanes:{user}:backward": "1"}, 0, Rule.RIGHT_HAND)
    car, bus = LaneType.DRIVING, LaneType.BUS
    back, on = Direction.BACKWARD, Direction.FORWARD
    assert lanes_of(section) == [(bus, back), (car, back), (car, on)]
    section = cross_section({"highway": "primary", "lanes": "3", f"lanes:{user}:backward": "1"}, 0, Rule.LEFT_HAND)
    assert lanes_of(section) == [(car, on), (car, back), (bus, back)]


@pytest.mark.parametrize(
    ("lanes", "direction", "expected", "words"),
    [
        ("2+1", 0, [-1, 1, 1], "lanes=2+1 taken for lanes:forward=2, lanes:backward=1"),
        ("1 + 3", 0, [-1, -1, -1, 1], "lanes=1 + 3 taken for lanes:forward=1, lanes:backward=3"),
        ("1+1+1", 0, [-1, 0, 1], "lanes=1+1+1 taken for lanes:forward=1, lanes:both_ways=1, lanes:backward=1"),
        ("2+1", 1, [1, 1, 1], "lanes=2+1 taken for 3"),
    ],
)
def test_sums_of_lanes_are_read_by_direction(lanes: str, direction: int, expected: list[int], words: str) -> None:
    section = cross_section({"highway": "primary", "lanes": lanes}, direction, Rule.RIGHT_HAND)
    assert [int(lane.direction) for lane in section.lanes_ltr] == expected
    assert [text for _, code, text in section.findings if code == "lane-count"] == [words]


def test_taxis_that_may_drive_against_the_one_way_have_a_lane() -> None:
    section = cross_section({"highway": "primary", "lanes": "2", "oneway:taxi": "no"}, 1, Rule.LEFT_HAND)
    assert lanes_of(section) == [(LaneType.DRIVING, Direction.FORWARD), (LaneType.TAXI, Direction.BACKWARD)]


@pytest.mark.parametrize("user", ["psv", "bus"])
def test_one_of_two_lanes_is_for_buses_against_the_one_way(user: str) -> None:
    section = cross_section({"highway": "primary", "lanes": "2", f"oneway:{user}": "no"}, 1, Rule.RIGHT_HAND)
    assert lanes_of(section) == [(LaneType.BUS, Direction.BACKWARD), (LaneType.DRIVING, Direction.FORWARD)]


@pytest.mark.parametrize("user", ["psv", "bus", "taxi"])
def test_users_without_a_lane_against_the_one_way_are_reported(user: str) -> None:
    section = cross_section({"highway": "primary", "lanes": "1", f"oneway:{user}": "no"}, 1, Rule.RIGHT_HAND)
    assert lanes_of(section) == [(LaneType.DRIVING, Direction.FORWARD)]
    assert any("oneway:bus" in words for _, code, words in section.findings if code == "contraflow")
