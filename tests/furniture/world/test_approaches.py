"""Where traffic stops before crossings, and which room they leave for it."""

from __future__ import annotations

import pytest
from object_cases import world_of
from street_cases import Case

from osm2xodr.furniture.world import Crossing, before_crossings, with_room_for_line
from osm2xodr.model import Rule

LENGTH = 100.0


def crossing(away: float, *, signals: bool = False) -> Crossing:
    """Return a crossing of 4 m whose middle is so far before the road's end, m."""
    return Crossing(1, LENGTH - away, 4.0, 3.5, -3.5, "node/1", signals, at_end=True)


@pytest.mark.parametrize(
    ("away", "stop"),
    [
        # In the junction, across its edge, before it: the line lies 1 m before it.
        ([-6.0], 1.0),
        ([-1.0], 2.0),
        ([5.0], 8.0),
        # 8 m and the line of 0.5 m do not fit between.
        ([9.5], 12.5),
        # They do if the line comes nearer to the junction.
        ([11.0], 0.5),
        # They do.
        ([12.0], 1.0),
        # From one to the next.
        ([5.0, 14.0], 17.0),
        ([5.0, 20.0], 8.0),
    ],
)
def test_traffic_stops_before_crossings_that_leave_no_room_for_a_car(away: list[float], stop: float) -> None:
    crossings = [crossing(item) for item in away]
    assert before_crossings(1.0, LENGTH, crossings, at_end=True) == pytest.approx(stop)


def test_traffic_stops_before_all_crossings_with_lights_at_a_junction() -> None:
    crossings = [crossing(18.0, signals=True)]
    assert before_crossings(1.0, LENGTH, crossings, at_end=True) == pytest.approx(21.0)
    # Those who leave the junction do not.
    assert before_crossings(1.0, LENGTH, crossings, at_end=False) == pytest.approx(1.0)


@pytest.mark.parametrize("away", [3.5, 4.3])
def test_on_a_short_road_the_line_lies_at_its_beginning(away: float) -> None:
    item = Crossing(1, 7.0 - away, 4.0, 3.5, -3.5, "node/1", signals=False, at_end=True)
    stop = before_crossings(1.0, 7.0, [item], at_end=True)
    assert stop == pytest.approx(min(away + 3.0, 6.5))
    # There is no room at all: the line stays at the junction.
    short = Crossing(1, 1.0, 4.0, 3.5, -3.5, "node/1", signals=False, at_end=True)
    assert before_crossings(1.0, 2.0, [short], at_end=True) == pytest.approx(1.0)


@pytest.mark.parametrize("rule", list(Rule))
def test_a_crossing_on_a_short_one_way_road_leaves_room_for_the_line(rule: Rule) -> None:
    case = Case({"a": (0.0, 0.0), "b": (6.0, 0.0), "c": (100.0, 0.0)}, {1: ("a b", "oneway=yes"), 2: ("b c", "")})
    world = world_of(case, rule)
    (road,) = (road.id for road in world.road_map.roads if road.osm_way_ids[0] == 1)
    length = world.lanes.length(road)
    if length < 10.0:
        # Half of the crossing, 0.2 m and the line of 0.5 m.
        assert with_room_for_line(world, road, 0.5, 3.0) == pytest.approx((2.2, 3.0))
        assert with_room_for_line(world, road, 4.0, 3.0) == (4.0, 3.0)
        # It would have to be moved by more than 3.5 m.
        assert with_room_for_line(world, road, -2.0, 3.0) == (-2.0, 3.0)
    else:
        assert with_room_for_line(world, road, 0.5, 3.0) == (0.5, 3.0)
