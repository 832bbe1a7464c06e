"""Turns that are sharper than a car drives swing out where there is room for it.

Turns that hardly any car drives, and that nobody needs, are left out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from road_measures import assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.curves import lengths, smallest_radius
from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections import ConnectingRoads, connect, curves_apart, runs_backwards, swing_out
from osm2xodr.geometry.connections.defaults import OFF_CARRIAGEWAY
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import Access, FloatArray, LaneType, PlanView, RoadMap, Rule

# Two carriageways, 4.6 m apart, and a street that crosses them, where one may turn back.
DUAL = Case(
    {
        "w1": (-80.0, 2.3), "w2": (-80.0, -2.3), "e1": (80.0, 2.3), "e2": (80.0, -2.3),
        "o1": (0.0, 2.3), "o2": (0.0, -2.3), "n": (0.0, 60.0), "s": (0.0, -60.0),
    },
    {
        1: ("o1 w1", "oneway=yes"), 2: ("w2 o2", "oneway=yes"),
        3: ("e1 o1", "oneway=yes"), 4: ("o2 e2", "oneway=yes"),
        5: ("s o2", ""), 6: ("o2 o1", ""), 7: ("o1 n", ""),
    },
)  # fmt: skip


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("apart", [2.2, 2.8, 3.4, 4.0])
def test_no_turn_back_folds_its_lane(apart: float, rule: Rule) -> None:
    """Even where there is no room to swing out, the inner edge keeps a radius."""
    nodes = {name: (x, math.copysign(apart / 2, y) if abs(y) < 10 else y) for name, (x, y) in DUAL.nodes.items()}
    case = replace(DUAL, nodes=nodes)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    widths = {road.id: lane.widths[0].a for road in roads.roads for lane in road.lane_sections[0].lanes if lane.id}
    inner = [
        smallest_radius_of(roads.plan_view, k) - widths[road.id] / 2
        for k, road in enumerate(roads.roads)
        if road.junction is not None
    ]
    assert min(inner) > 0.1 * defaults.INNER_EDGE_RADIUS - 1e-9


@pytest.mark.parametrize(
    ("end", "ahead", "turned", "backwards"),
    [
        (1, 3.0, 0.0, False),
        (1, -3.0, 0.0, True),
        (0, -3.0, 0.0, False),
        # Arms that lie on each other: no curve leads back in so little room.
        (1, 0.004, math.pi, True),
        (0, -0.004, math.pi, True),
    ],
)
def test_roads_run_backwards_if_they_leave_or_arrive_against_lanes(
    end: int, ahead: float, turned: float, backwards: bool
) -> None:
    """From either end of a road of 50 m to a road that begins some way to the east, m, `turned` against the first."""
    x, hdg = 50.0 * end, 0.0 if end else math.pi
    on = hdg + turned
    begin, heading = np.array([0.0, x + ahead]), np.array([0.0, on])
    zero, length = np.zeros(2), np.array([50.0, 20.0])
    roads = PlanView(np.arange(3), zero, begin, zero, heading, length, zero)
    line = PlanView(
        np.arange(2), *(np.array([item]) for item in (0.0, x, 0.0, math.pi * (ahead < 0), abs(ahead), 0.0))
    )
    connecting = SimpleNamespace(plan_view=line, entry=np.array([end]), exit=np.array([2]))
    parts = SimpleNamespace(plan_view=roads, length=length)
    assert runs_backwards(cast("ConnectingRoads", connecting), cast("RoadParts", parts)).tolist() == [backwards]


def turned_right(before: float, after: float, beside: float, off: float = 0.0) -> tuple[ConnectingRoads, FloatArray]:
    """Draw a right turn between tangents of these lengths and the way back beside it, swing out; all m.

    What swings out leaves the carriageways by `off`, m. The second item are the lengths before.
    """
    x0, y0, hdg0 = np.array([[0.0, 0.0, 0.0], [before + beside, -after, math.pi / 2]]).T
    x1, y1, hdg1 = np.array([[before, -after, -math.pi / 2], [0.0, beside, math.pi]]).T
    plan = connect(x0, y0, hdg0, x1, y1, hdg1)
    zero = np.zeros(2)
    columns: dict[str, Any] = dict.fromkeys(("entry_t", "exit_t", "entry_aside", "exit_aside", "height"), zero)
    columns |= dict.fromkeys(("entry_width", "exit_width"), zero + 3.0)
    columns |= dict.fromkeys(("entry_lane", "exit_lane"), np.full(2, -1))
    ways = ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=np.zeros(2, np.int64),
        entry=np.array([1, 2]),
        exit=np.array([2, 1]),
        against=np.zeros(2, bool),
        joins_cars=np.zeros(2, bool),
        lane_type=(LaneType.DRIVING,) * 2,
        access=(Access.ALL,) * 2,
        inner=((),) * 2,
        **columns,
    )

    def beyond(some: ConnectingRoads) -> FloatArray:
        return np.where(np.isin(some.length, ways.length), 0.0, off)

    return swing_out(ways, beyond), ways.length


@pytest.mark.parametrize(
    ("before", "after", "radius"), [(3.2, 12.0, 4.2), (3.2, 8.0, 3.95), (2.8, 8.0, 3.6), (2.0, 8.0, 3.3)]
)
def test_a_sharp_turn_swings_out_with_the_largest_radius_for_which_there_is_room(
    before: float, after: float, radius: float
) -> None:
    ways, length = turned_right(before, after, 20.0)
    assert smallest_radius(ways.plan_view)[0] == pytest.approx(radius, rel=1e-6)
    assert length[0] < ways.length[0] < 1.1 * length[0]


def test_a_turn_swings_out_less_where_it_would_meet_cars_that_come_back() -> None:
    """With 3.95 and 3.6 m it would come within 1.8 m of their way, which begins and ends 2 m beside it."""
    ways, _ = turned_right(3.2, 8.0, 2.0)
    assert smallest_radius(ways.plan_view)[0] == pytest.approx(3.3, rel=1e-6)
    there, back = ways.there_and_back()
    assert curves_apart(ways.plan_view, there, ways.plan_view, back, 32)[0] >= defaults.CAR_WIDTH


@pytest.mark.parametrize(
    ("off", "radius"), [(OFF_CARRIAGEWAY - 0.01, 3.95), (OFF_CARRIAGEWAY + 0.01, 3.2)], ids=["on them", "off them"]
)
def test_turns_do_not_swing_out_of_the_carriageways(off: float, radius: float) -> None:
    """Its arc of 3.2 m stays where nothing larger keeps to them."""
    ways, _ = turned_right(3.2, 8.0, 20.0, off)
    assert smallest_radius(ways.plan_view)[0] == pytest.approx(radius, rel=1e-6)


def test_ways_there_and_back_join_the_same_arms() -> None:
    ways, _ = turned_right(3.2, 8.0, 4.0)
    assert [item.tolist() for item in ways.there_and_back()] == [[0], [1]]
    assert [item.tolist() for item in ways.chosen(np.array([1])).there_and_back()] == [[], []]
    three = ways.joined(ways.chosen(np.array([1])))
    assert [item.tolist() for item in three.there_and_back()] == [[0, 0], [1, 2]]
    shared = replace(ways, lane_type=(LaneType.BIDIRECTIONAL, LaneType.DRIVING))
    assert [item.tolist() for item in shared.there_and_back()] == [[], []]


def triangle(side: float, branch: float) -> Case:
    """Return a main street to the east and a side street to the north that splits before it, at places some way off.

    Each corner of the small triangle has an acute angle.
    """
    return Case(
        {
            "w": (-150.0, 0.0), "a": (-side, 0.0), "b": (side, 0.0), "e": (150.0, 0.0),
            "c": (0.0, branch), "n": (0.0, 150.0),
        },
        {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("a c", ""), 5: ("b c", ""), 6: ("c n", "")},
    )  # fmt: skip


def turns(roads: RoadMap) -> set[tuple[int, int]]:
    """Return the OSM ways that connecting roads join."""
    way = {road.id: road.osm_way_ids[0] for road in roads.roads if road.junction is None and road.osm_way_ids}
    joined = ((road.predecessor, road.successor) for road in roads.roads if road.junction is not None)
    return {(way[one.id], way[other.id]) for one, other in joined if one is not None and other is not None}


SIDES = {(2, 4), (4, 2), (4, 5), (5, 4), (5, 2), (2, 5)}


@pytest.mark.parametrize("rule", list(Rule))
def test_nobody_turns_sharply_within_a_small_triangle(rule: Rule) -> None:
    """Its inner lanes are not linked at its corners, all other turns are."""
    case = triangle(10.0, 18.0)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert SIDES - turns(roads) == {(2, 4), (4, 5), (5, 2)}
    assert len(turns(roads)) == 15
    assert smallest_radius(roads.plan_view).min() > 4.2


def test_cars_turn_at_the_corners_of_a_block() -> None:
    """However sharp they are: people live there."""
    roads = triangle(20.0, 14.0).build()
    assert turns(roads) >= SIDES
    assert smallest_radius(roads.plan_view).min() < 4.2


def test_cars_turn_where_only_that_leads_on() -> None:
    """Without the side along the main street, its traffic has no other way."""
    small = triangle(10.0, 18.0)
    case = Case(small.nodes, {**small.ways, 2: ("a b", "oneway=yes"), 5: ("b c", "oneway=yes")})
    assert (2, 5) in turns(case.build())
