"""Lanes for buses and bicycles against one-way streets lead straight on through junctions; no car gets onto them."""

from __future__ import annotations

import pytest
from street_cases import Case, Stages

from osm2xodr.geometry.junctions import Movement, with_movements_against_cars
from osm2xodr.model import LaneType, Rule

_NODES = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "n": (0.0, 80.0)}
_AGAINST = "oneway=yes lanes=2 busway:left=opposite_lane"
_CYCLES = "oneway=yes cycleway:left=lane cycleway:left:oneway=-1 oneway:bicycle=no"
_CROSSED = {3: ("s o", ""), 4: ("o n", "")}


def against_cars(case: Case, rule: Rule = Rule.RIGHT_HAND) -> tuple[Stages, list[Movement]]:
    """Return the stages of a case, and the movements against cars."""
    stages = (case if rule is Rule.RIGHT_HAND else case.mirrored()).stages(rule)
    every = with_movements_against_cars(stages.network, stages.ends, stages.layout, stages.movements)
    found = [item for item in every if item.apart]
    assert [item for item in every if not item.apart] == stages.movements
    assert [item.junction for item in every] == sorted(item.junction for item in every)
    return stages, found


def ways(case: Case, rule: Rule = Rule.RIGHT_HAND) -> list[tuple[int, int]]:
    """Return (from way, to way) of the movements against cars."""
    stages, found = against_cars(case, rule)
    return [(stages.way(item.entry), stages.way(item.exit)) for item in found]


@pytest.mark.parametrize("rule", Rule)
def test_buses_go_on_against_a_one_way_street(rule: Rule) -> None:
    case = Case(_NODES, {1: ("w o", _AGAINST), 2: ("o e", _AGAINST), **_CROSSED})
    assert ways(case, rule) == [(2, 1)]


@pytest.mark.parametrize(
    ("first", "then", "expected"),
    [
        # To a street of both directions, and to one where they have a lane among others.
        ("", _AGAINST, [(2, 1)]),
        ("lanes=3 lanes:backward=2 lanes:bus:backward=1", _AGAINST, [(2, 1)]),
        # From a lane of their own alone: cars would follow them from others.
        (_AGAINST, "", []),
        (_AGAINST, "lanes=3 lanes:backward=2 lanes:bus:backward=1", [(2, 1)]),
        # Not where nobody may go on.
        ("oneway=yes", _AGAINST, []),
        ("oneway=yes", "oneway=yes", []),
    ],
)
def test_where_buses_go_on(first: str, then: str, expected: list[tuple[int, int]]) -> None:
    assert ways(Case(_NODES, {1: ("w o", first), 2: ("o e", then), **_CROSSED})) == expected


def test_buses_turn_into_no_other_street_against_cars() -> None:
    case = Case(_NODES, {1: ("w o", "oneway=yes"), 2: ("o e", _AGAINST), 3: ("s o", _AGAINST), 4: ("o n", "")})
    # Straight on is no way for them; the street from the south leads on to the north alone.
    assert ways(case) == []


def test_buses_go_over_one_way_streets_inside_a_junction() -> None:
    nodes = {**_NODES, "a": (-4.0, 0.0), "b": (4.0, 0.0), "s": (-4.0, -80.0), "n": (4.0, 80.0)}
    case = Case(
        nodes,
        {1: ("w a", _AGAINST), 2: ("b e", _AGAINST), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", _AGAINST)},
    )
    stages, (item,) = against_cars(case)
    assert (stages.way(item.entry), stages.way(item.exit)) == (2, 1)
    ((street, along),) = item.inner
    assert [piece.osm_way_id for _, piece in stages.network.streets[street].pieces] == [5]
    assert not along


@pytest.mark.parametrize(
    ("first", "then", "expected"),
    [
        (_CYCLES, _CYCLES, [(2, 1)]),
        ("", _CYCLES, [(2, 1)]),
        ("cycleway=lane", _CYCLES, [(2, 1)]),
        (_CYCLES, "cycleway=lane", [(2, 1)]),
        (_CYCLES, "", []),
        # A lane for buses is none for them.
        (_CYCLES, "lanes=3 lanes:backward=2 lanes:bus:backward=1", []),
    ],
)
def test_where_bicycles_go_on(first: str, then: str, expected: list[tuple[int, int]]) -> None:
    assert ways(Case(_NODES, {1: ("w o", first), 2: ("o e", then), **_CROSSED})) == expected


def test_bicycles_join_the_lane_for_cars_where_theirs_ends() -> None:
    road_map = Case(_NODES, {1: ("w o", ""), 2: ("o e", _CYCLES), **_CROSSED}).build()
    (through,) = (
        road
        for road in road_map.roads
        if road.junction is not None and any(lane.type is LaneType.BIKING for lane in road.lane_sections[0].lanes)
    )
    assert [(lane.predecessor, lane.successor) for lane in through.lane_sections[0].lanes if lane.id] == [(1, 1)]


def test_their_lane_through_the_junction_is_against_cars() -> None:
    road_map = Case(_NODES, {1: ("w o", _AGAINST), 2: ("o e", _AGAINST), **_CROSSED}).build()
    (through,) = (
        road
        for road in road_map.roads
        if road.junction is not None and any(lane.type is LaneType.BUS for lane in road.lane_sections[0].lanes)
    )
    lanes = [lane for lane in through.lane_sections[0].lanes if lane.type is LaneType.BUS]
    assert len(lanes) == 1
    assert (lanes[0].predecessor, lanes[0].successor) == (1, 1)
