"""Lines across lanes at which traffic stops or yields."""

from __future__ import annotations

import pytest
from object_cases import road_of_way, side, world_of
from street_cases import Case

from osm2xodr.furniture.objects.stop_lines import stop_lines
from osm2xodr.furniture.world.world import Stop
from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
STREET = {"w": (0.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w e", "lanes=4 width=14")})


def stop(road: int, s: float, lanes: tuple[int, ...], orientation: str, kind: str) -> Stop:
    return Stop(road, s, lanes, orientation, kind, "node/5")


@EITHER
def test_a_line_lies_before_the_stop_across_its_lanes(rule: Rule) -> None:
    world = world_of(ROAD, rule)
    road, hand = road_of_way(world, 1), int(side(rule))
    (line,) = stop_lines(world, [stop(road, 90.0, (-hand, -2 * hand), "+", "traffic_signals")])
    assert (line.type, line.subtype, line.name) == ("roadMark", "stopLine", "stop line")
    assert (line.s, line.length) == pytest.approx((89.75, 0.5))
    assert (line.t, line.width) == pytest.approx((-3.5 * hand, 7.0))
    assert line.validity == (((-2, -1),) if hand == 1 else ((1, 2),))
    assert (line.orientation, line.osm_id, line.outline, line.height) == ("+", "node/5", (), 0.0)


@EITHER
def test_traffic_against_s_comes_from_beyond_its_line(rule: Rule) -> None:
    world = world_of(ROAD, rule)
    road, hand = road_of_way(world, 1), int(side(rule))
    (line,) = stop_lines(world, [stop(road, 10.0, (hand,), "-", "give_way")])
    assert (line.subtype, line.name) == ("giveWayLine", "give-way line")
    assert (line.s, line.t, line.width) == pytest.approx((10.25, 1.75 * hand, 3.5))
    assert line.validity == ((hand, hand),)


def test_lanes_apart_get_a_line_each() -> None:
    world = world_of(Case(STREET, {1: ("w e", "lanes=3 oneway=yes width=10.5")}))
    lines = stop_lines(world, [stop(road_of_way(world, 1), 90.0, (-1, -3), "+", "stop")])
    assert [(round(line.t, 6), round(line.width, 6), line.validity) for line in lines] == [
        (3.5, 3.5, ((-1, -1),)),
        (-3.5, 3.5, ((-3, -3),)),
    ]


def test_of_several_stops_at_one_place_the_strictest_counts() -> None:
    world = world_of(ROAD)
    road = road_of_way(world, 1)
    lines = stop_lines(
        world,
        [
            stop(road, 90.0, (-1, -2), "+", "give_way"),
            stop(road, 91.0, (-1, -2), "+", "traffic_signals"),
            stop(road, 90.0, (1,), "-", "give_way"),
            stop(road, 50.0, (-1, -2), "+", "give_way"),
        ],
    )
    assert [(line.subtype, line.orientation, round(line.s, 2)) for line in lines] == [
        ("stopLine", "+", 90.75),
        ("giveWayLine", "+", 49.75),
        ("giveWayLine", "-", 90.25),
    ]


def test_lines_stay_on_their_road() -> None:
    world = world_of(ROAD)
    road = road_of_way(world, 1)
    length = world.lanes.length(road)
    lines = stop_lines(world, [stop(road, 0.2, (-1,), "+", "stop"), stop(road, length, (1,), "-", "stop")])
    assert [line.s for line in lines] == [pytest.approx(0.25), pytest.approx(length - 0.25)]
