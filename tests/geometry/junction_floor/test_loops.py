"""The middle of loops at dead ends: how far strips reach, whose they are and when they are paved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from floor_cases import connecting
from road_measures import width_at

from osm2xodr.curves import lengths
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import lay_floor
from osm2xodr.geometry.junctions.dead_ends import draw_loops
from osm2xodr.geometry.junctions.movements import Loop
from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
EASE, RADIUS, HALF_LANE = 4.0, 6.0, 1.5
# Angle of the curves before and after the loop.
BEND = math.acos((1.5 + EASE) / (RADIUS + EASE))


def loops(rule: Rule, halves: Sequence[float] = (1.5,)) -> ConnectingRoads:
    """Return loops of 6 m radius, and more for lanes farther out, at the end of a road that runs east."""
    n = len(halves)
    side = -1.0 if rule is Rule.RIGHT_HAND else 1.0
    roads = connecting([(0.0, side * half, 1.0, side * half) for half in halves])
    half = np.array(halves)
    ways = [Loop(RADIUS - halves[0], EASE)] * n
    plan = draw_loops(roads.plan_view, np.arange(n), np.zeros(n, np.int64), ways, half, rule is Rule.LEFT_HAND)
    return replace(roads, plan_view=plan, length=lengths(plan))


@EITHER
def test_a_strip_reaches_to_the_middle_of_the_circle_and_of_the_arm(rule: Rule) -> None:
    roads = loops(rule)
    floor = lay_floor(roads, rule)
    strips, others = (floor.left, floor.right) if rule is Rule.RIGHT_HAND else (floor.right, floor.left)
    assert list(strips) == [0]
    assert others == {}
    whole = float(roads.length[0])
    assert whole == pytest.approx(2 * EASE * BEND + RADIUS * (math.pi + 2 * BEND))
    for s in np.linspace(EASE * BEND + 0.6, whole - EASE * BEND - 0.6, 20).tolist():
        assert width_at(strips[0], s) == pytest.approx(RADIUS - HALF_LANE - 0.05, abs=0.02)
    # Seen from the middle of the curve, the middle of the arm is 5.5 m aside.
    for angle in (0.0, 0.25, 0.5, 0.75, 0.85):
        for s in (EASE * angle, whole - EASE * angle):
            wanted = 1.05 * (HALF_LANE + EASE) * (1.0 / math.cos(angle) - 1.0)
            assert width_at(strips[0], s) == pytest.approx(wanted, abs=0.05)


@EITHER
def test_only_the_innermost_loop_has_a_strip(rule: Rule) -> None:
    floor = lay_floor(loops(rule, (1.5, 4.5)), rule)
    assert sorted((*floor.left, *floor.right)) == [0]


def test_turning_circles_are_paved_and_what_loops_go_round_is_not() -> None:
    roads = loops(Rule.RIGHT_HAND)
    assert lay_floor(roads, Rule.RIGHT_HAND).paved_left == {0}
    floor = lay_floor(roads, Rule.RIGHT_HAND, unpaved={0})
    assert list(floor.left) == [0]
    assert floor.paved_left == frozenset()
    assert lay_floor(roads, Rule.RIGHT_HAND, unpaved={1}).paved_left == {0}


def test_ways_between_two_arms_are_no_loops() -> None:
    roads = loops(Rule.RIGHT_HAND)
    assert lay_floor(replace(roads, exit=roads.entry + 2), Rule.RIGHT_HAND).paved_left == frozenset()


def test_a_way_that_turns_back_where_other_arms_are_is_no_loop() -> None:
    other = connecting([(0.0, 30.0, 20.0, 30.0)])
    both = loops(Rule.RIGHT_HAND).joined(replace(other, entry=other.entry + 2, exit=other.exit + 4))
    assert lay_floor(both, Rule.RIGHT_HAND).paved_left == frozenset()


def test_a_way_straight_on_is_no_loop_even_on_one_arm() -> None:
    floor = lay_floor(connecting([(0.0, 0.0, 20.0, 0.0)]), Rule.RIGHT_HAND)
    assert (floor.left, floor.right) == ({}, {})
