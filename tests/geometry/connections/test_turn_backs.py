"""Ways that turn back are one tight turn round the nose of the median."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from dual_carriageways import built, dual
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case, built_links

from osm2xodr.curves import lengths, pose
from osm2xodr.geometry.defaults import U_TURN_RADIUS
from osm2xodr.model import FloatArray, RoadMap, Rule


def turns_back(roads: RoadMap, entry: int = 2, exit_: int = 1) -> list[int]:
    """Return the indices of the connecting roads from way 2 to way 1."""
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    return [
        k
        for k, road in enumerate(roads.roads)
        if road.junction is not None
        and road.predecessor is not None
        and road.successor is not None
        and (ways[road.predecessor.id], ways[road.successor.id]) == ((entry,), (exit_,))
    ]


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize(
    ("apart", "radius", "swings"),
    [
        # A swing before the turn, one on either side, a half circle, two quarter circles.
        (5.0, U_TURN_RADIUS, 1),
        (7.0, U_TURN_RADIUS, 2),
        (10.0, 0.96 * 5.0, 0),
        (14.0, 5.0, 0),
    ],
)
def test_turns_back_swing_out_only_where_lanes_are_close(
    apart: float, radius: float, swings: int, rule: Rule
) -> None:
    case = dual(apart, "lanes=1 width=3")
    roads = built(case, rule, u_turns="all")
    assert_sound(roads)
    (k,) = turns_back(roads)
    assert smallest_radius_of(roads.plan_view, k) == pytest.approx(radius, rel=1e-3)
    rows = slice(roads.plan_view.start[k], roads.plan_view.start[k + 1])
    turned = roads.plan_view.curvature[rows] * roads.plan_view.length[rows]
    side = 1.0 if rule is Rule.RIGHT_HAND else -1.0
    assert (side * turned < -1e-3).sum() == swings
    assert turned.sum() == pytest.approx(side * math.pi, abs=1e-3)
    assert RoadMeasures(roads).length(roads.roads[k]) < 40.0


@pytest.mark.parametrize("rule", list(Rule))
def test_lanes_are_the_innermost_and_the_innermost_that_a_car_reaches(rule: Rule) -> None:
    """The innermost lanes are 4 m apart; the third one of the way back is 10 m away."""
    case = dual(7.0 + 6.0, "lanes=3 width=9")
    nodes = {name: (x, math.copysign(6.5, y) if abs(y) < 10 else y) for name, (x, y) in case.nodes.items()}
    roads = built(replace(case, nodes=nodes), rule, u_turns="all")
    side = 1 if rule is Rule.RIGHT_HAND else -1
    # Innermost lanes: 13 m between the lines, less 3 m to either side: 7 m; the next one is 10 m away.
    assert [(one, to) for way, one, out, to in built_links(roads) if (way, out) == (2, 1)] == [(-side * 1, -side * 2)]
    assert len(turns_back(roads)) == 1


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("shift", [-6.0, 6.0])
@pytest.mark.parametrize("apart", [5.0, 7.0, 9.0])
def test_arms_that_end_apart_are_joined_without_a_gap(apart: float, shift: float, rule: Rule) -> None:
    """The street across runs askew, so that one carriageway ends before the other."""
    case = dual(apart, "lanes=1 width=3")
    x, y = case.nodes["o1"]
    roads = built(replace(case, nodes={**case.nodes, "o1": (x + shift, y)}), rule, u_turns="all")
    assert_sound(roads)
    assert min(smallest_radius_of(roads.plan_view, k) for k in turns_back(roads)) >= U_TURN_RADIUS - 1e-6
    plan = roads.plan_view
    for k in turns_back(roads):
        bent = plan.curvature[plan.start[k] : plan.start[k + 1]] != 0
        assert (bent[1:] | bent[:-1]).all(), "two lines in a row"


@pytest.mark.parametrize("rule", list(Rule))
def test_cars_follow_a_street_that_itself_turns_back(rule: Rule) -> None:
    """A side street leaves at 39 degrees and turns sharply after 38 m: most of the way back is its bend."""
    nodes = {"w": (-100.0, 7.0), "o": (0.0, -33.0), "e": (19.2, -31.5), "f": (55.1, -19.5), "g": (100.0, -17.0)}
    nodes |= {"p": (18.8, -22.2), "q": (30.7, -9.5), "n": (-60.0, 33.0), "s": (52.0, -33.0)}
    home = "highway=residential"
    ways = {
        1: ("w o", home),
        2: ("o e f", home),
        3: ("o p q n", "highway=service"),
        4: ("f g", home),
        5: ("f s", home),
    }
    case = Case(nodes, ways) if rule is Rule.RIGHT_HAND else Case(nodes, ways).mirrored()
    roads = case.build(rule)
    assert_sound(roads)
    (k,) = turns_back(roads, 1, 3)
    s = np.linspace(0.0, float(lengths(roads.plan_view)[k]), 60)
    x, y, _ = pose(roads.plan_view, np.full(len(s), k), s)
    line = np.array([case.nodes[name] for name in "wopqn"])
    away = np.stack([_from_segment(x, y, *pair) for pair in itertools.pairwise(line)]).min(axis=0)
    # Half a carriageway, what a turn of 6 m in radius cuts off a corner of 110 degrees, and rounding of the origin.
    assert away.max() < 2.5 + 6.0 * (1.0 / math.cos(math.radians(55.0)) - 1.0) + 0.6


def _from_segment(x: FloatArray, y: FloatArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the distance of points, (n,), m, from a straight line between two others."""
    step = other - one
    share = np.clip(((x - one[0]) * step[0] + (y - one[1]) * step[1]) / float(step @ step), 0.0, 1.0)
    return np.asarray(np.hypot(x - one[0] - share * step[0], y - one[1] - share * step[1]))


def test_turns_at_acute_forks_stay_on_what_is_paved() -> None:
    """Cars turn from one arm of a fork of 15 degrees into the other: no half disc beside the street."""
    cos, sin = math.cos(math.radians(7.5)), math.sin(math.radians(7.5))
    nodes = {"w": (-90.0 * cos, -90.0 * sin), "x": (-90.0 * cos, 90.0 * sin), "o": (0.0, 0.0), "e": (90.0, 0.0)}
    tags = "highway=residential lanes=2 width=6"
    roads = Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)}).build(Rule.RIGHT_HAND)
    assert_sound(roads)
    found = [*turns_back(roads, 1, 3), *turns_back(roads, 3, 1)]
    assert len(found) == 2
    for k in found:
        s = np.linspace(0.0, float(lengths(roads.plan_view)[k]), 60)
        x, y, _ = pose(roads.plan_view, np.full(len(s), k), s)
        # The middle of the lane stays on what is paved, and nearly all of the lane.
        edge = 3.0 / cos + np.maximum(-x, 0.0) * sin / cos
        assert (np.abs(y) - edge).max() < 0.0
