"""Lines across lanes at which traffic stops or yields, and arrows from turn:lanes before junctions."""

from __future__ import annotations

from collections import Counter
from math import pi

import pytest
from object_cases import road_of_way, said, side, world_of
from street_cases import Case

from osm2xodr.furniture.objects.road_marks import arrow_name, arrows, lane_ids, stop_lines
from osm2xodr.furniture.world.approaches import find_approaches
from osm2xodr.furniture.world.world import Crossing, Stop, World
from osm2xodr.model import Direction, LaneSpec, LaneType, RoadObject, Rule, StreetAttributes, Structure

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


def test_no_line_lies_on_a_crossing() -> None:
    world = world_of(ROAD)
    road = road_of_way(world, 1)
    crossing = Crossing(road, 2.0, 3.0, 7.0, -7.0, "node/6", signals=True)
    stops = [stop(road, s, (-1,), "+", "traffic_signals") for s in (0.2, 0.5, 1.2, 3.9, 4.05)]
    lines = [stop_lines(world, [item], [crossing]) for item in stops]
    assert [[line.s for line in found] for found in lines] == [[0.25], [0.25], [], [], [pytest.approx(3.8)]]
    words = "its stop line is left out: the road is too short for it before the crossing"
    assert said(world)["stop-line-left-out"] == [words] * 2


NODES = {
    "w": (-150.0, 0.0),
    "m": (-60.0, 0.0),
    "o": (0.0, 0.0),
    "e": (100.0, 0.0),
    "s": (0.0, -99.0),
    "n": (0.0, 99.0),
}
SIDES = {2: ("o e", ""), 3: ("s o", ""), 4: ("o n", "")}


def place(world: World, stops: list[Stop] | None = None) -> list[RoadObject]:
    return arrows(world, find_approaches(world, ()), stops or [])


def turned(rule: Rule, word: str) -> str:
    """Return the subtype of an arrow as the mirrored case has it."""
    if rule is Rule.RIGHT_HAND:
        return word
    other = {"Left": "Right", "Right": "Left"}
    words = [other.get(item, item) for item in ("Left", "Right", "Straight") if item in word]
    return "arrow" + "".join(sorted(words))


@pytest.mark.parametrize(
    ("turns", "name"),
    [
        ({"left"}, "arrowLeft"),
        ({"through", "right"}, "arrowRightStraight"),
        ({"slight_left", "through"}, "arrowSlightLeftStraight"),
        ({"reverse"}, "arrowUTurn"),
        ({"merge_to_right"}, "arrowMergeRight"),
        ({"none"}, ""),
        (set(), ""),
    ],
)
def test_names(turns: set[str], name: str) -> None:
    assert arrow_name(frozenset(turns)) == name


@pytest.mark.parametrize(("rule", "ids"), [(Rule.RIGHT_HAND, [2, 1, -1, -2]), (Rule.LEFT_HAND, [3, 2, 1, -1])])
def test_lanes_count_from_the_centre(rule: Rule, ids: list[int]) -> None:
    """Left-hand traffic has what runs along and both ways on the left."""
    runs = [Direction.BACKWARD, Direction.BACKWARD, Direction.BOTH, Direction.FORWARD]
    if rule is Rule.LEFT_HAND:
        runs = [Direction.FORWARD, Direction.FORWARD, Direction.BOTH, Direction.BACKWARD]
    lanes = tuple(LaneSpec(LaneType.DRIVING, run, 3.0) for run in runs)
    attributes = StreetAttributes(
        1, False, "primary", "", "", lanes, 0.0, None, None, Structure.GROUND, 0, None, roundabout=False
    )
    assert list(lane_ids(attributes, rule)) == ids


@EITHER
def test_two_arrows_on_each_lane_that_has_turns(rule: Rule) -> None:
    ways = {1: ("w o", "lanes=3 lanes:backward=1 turn:lanes:forward=left|through;right width=10.5"), **SIDES}
    world = world_of(Case(NODES, ways), rule)
    road, hand = road_of_way(world, 1), int(side(rule))
    found = place(world)
    assert {item.road for item in found} == {road}
    (approach,) = (item for item in find_approaches(world, ()) if item.road == road)
    line = approach.stop_s
    by_lane: dict[int, list[RoadObject]] = {}
    for item in found:
        by_lane.setdefault(item.validity[0][0], []).append(item)
    assert sorted(by_lane) == sorted([-hand, -2 * hand])
    for lane, subtype, t in ((-hand, "arrowLeft", 0.0), (-2 * hand, "arrowRightStraight", -3.5 * hand)):
        one, other = by_lane[lane]
        assert one.subtype == other.subtype == turned(rule, subtype)
        # Tips 5 m and 25 m before the line, 5 m long.
        assert (one.s, other.s) == pytest.approx((line - 7.5, line - 27.5))
        # The lanes for the other direction take a third of the street.
        middle = next(place.middle for place in world.lanes.at(road, one.s) if place.id == lane)
        assert (one.t, middle) == pytest.approx((t, t))
        assert (one.hdg, one.orientation, one.length, one.width) == (0.0, "+", 5.0, 1.0)
        assert (one.type, one.osm_id, one.validity) == ("roadMark", "way/1", ((lane, lane),))


@EITHER
def test_arrows_against_the_road_point_back(rule: Rule) -> None:
    """The way is drawn away from the junction; its lanes to it run backward."""
    ways = {1: ("o w", "lanes=3 lanes:forward=1 turn:lanes:backward=left|right"), **SIDES}
    world = world_of(Case(NODES, ways), rule)
    hand = int(side(rule))
    found = place(world)
    assert {item.validity[0][0]: item.subtype for item in found} == {
        hand: turned(rule, "arrowLeft"),
        2 * hand: turned(rule, "arrowRight"),
    }
    assert {(item.hdg, item.orientation) for item in found} == {(pi, "-")}
    (stop,) = {item.stop_s for item in find_approaches(world, ()) if item.road == found[0].road}
    assert sorted(round(item.s - stop, 6) for item in found) == [7.5, 7.5, 27.5, 27.5]


def test_arrows_lie_before_the_stop_line_and_where_their_lane_is_wide() -> None:
    """The turning lane begins 60 m before the junction; the stop line is set back."""
    ways = {
        1: ("w m", "oneway=yes lanes=1"),
        5: ("m o", "oneway=yes lanes=2 turn:lanes=left|through"),
        **SIDES,
    }
    world = world_of(Case(NODES, ways))
    (approach,) = (item for item in find_approaches(world, ()) if world.lanes.road(item.road).osm_way_ids[-1] == 5)
    back = approach.stop_s - 12.0
    found = place(world, [Stop(approach.road, back, approach.lanes, "+", "stop", "")])
    assert max(item.s for item in found) == pytest.approx(back - 7.5)
    for item in found:
        (lane,) = (lane for lane in world.lanes.at(item.road, item.s - 2.5) if lane.id == item.validity[0][0])
        assert lane.left - lane.right >= 2.0


def test_a_road_with_other_lanes_than_its_street_gets_none() -> None:
    ways = {1: ("w o", "lanes=3 lanes:backward=1 turn:lanes:forward=left|through;right"), **SIDES}
    world = world_of(Case(NODES, ways))
    other = world_of(Case(NODES, {**ways, 1: ("w o", "lanes=2")}))
    mixed = World(world.network, other.road_map, other.places, other.lanes, world.options, world.diagnostics)
    assert place(mixed) == []
    assert said(mixed)["turn-arrows"] == ["1 road end without arrows: the lanes there are not those of the way"]


@EITHER
def test_arrows_stay_in_the_section_whose_lanes_they_are_for(rule: Rule) -> None:
    """Lanes with arrows for the last metres: before the new one opens, other lanes have their ids.

    There is room for one arrow on the lane that opens, and for two on the one that continues.
    """
    nodes = {**NODES, "p": (-35.0, 0.0)}
    arrow_lanes = "lanes=3 lanes:backward=1 turn:lanes:forward=left|through;right width=10.5"
    ways = {1: ("w p", "lanes=2 width=7"), 5: ("p o", arrow_lanes), **SIDES}
    world = world_of(Case(nodes, ways), rule)
    road = road_of_way(world, 5)
    sections = world.lanes.road(road).lane_sections
    assert len(sections) == 2
    found = [item for item in place(world) if item.road == road]
    assert sorted(Counter(item.subtype for item in found).values()) == [1, 2]
    assert all(item.s - 0.5 * item.length >= sections[1].s for item in found)
