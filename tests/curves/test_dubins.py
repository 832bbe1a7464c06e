"""Shortest curves of a given radius: exact at both ends, alike mirrored and backwards, never a full circle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st
from road_measures import Pose, assert_smooth, curve_length, pose_at, records, smallest_radius_of

from osm2xodr import defaults
from osm2xodr.curves.dubins import dubins_curves, dubins_without_slivers
from osm2xodr.curves.plan_views import curves_of
from osm2xodr.model import PlanView

RADIUS = 3.0


def shortest(one: Pose, other: Pose) -> PlanView:
    values = (one.x, one.y, one.hdg, other.x, other.y, other.hdg)
    return dubins_curves(*(np.array([value]) for value in values), radius=RADIUS)


def found(plan: PlanView) -> bool:
    return len(plan.s) > 0


PLACES, HEADINGS = st.floats(-20.0, 20.0), st.floats(-math.pi, math.pi)
POSES = st.builds(Pose, PLACES, PLACES, HEADINGS)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(POSES, POSES)
def test_they_join_the_poses_with_the_radius(one: Pose, other: Pose) -> None:
    assume(one.gap(other) > 0.1)
    plan = shortest(one, other)
    assume(found(plan))
    assert_smooth(plan, 0)
    # Records below 1e-7 m are left out, the first one too.
    assert pose_at(plan, 0, 0.0).gap(one) < 1e-6
    last = pose_at(plan, 0, curve_length(plan, 0))
    assert last.gap(other) < 1e-6
    assert last.turn(other) < 1e-6
    assert smallest_radius_of(plan, 0) >= RADIUS * (1 - 1e-12)
    turned = sum(abs(length * curvature) for _, _, length, curvature in records(plan, 0))
    assert turned < one.turn(other) + defaults.MOST_SWING_BACK + 1e-6


@settings(max_examples=150, deadline=None)
@given(POSES, POSES)
def test_mirrored_and_backwards_they_are_as_long(one: Pose, other: Pose) -> None:
    assume(abs(one.turn(other) - defaults.LEAST_TURN_BACK) > 1e-6)
    plan = shortest(one, other)
    back = shortest(other.turned(), one.turned())
    mirrored = shortest(Pose(one.x, -one.y, -one.hdg), Pose(other.x, -other.y, -other.hdg))
    assume(found(plan) and found(back) and found(mirrored))
    assert curve_length(back, 0) == pytest.approx(curve_length(plan, 0), abs=2e-3)
    assert curve_length(mirrored, 0) == pytest.approx(curve_length(plan, 0), abs=2e-3)


def test_a_turn_back_between_lanes_that_are_close_swings_out_on_both_sides() -> None:
    plan = shortest(Pose(0.0, 0.0, 0.0), Pose(0.0, 4.0, math.pi))
    rows = records(plan, 0)
    # Circles that touch: the middle one's centre lies 2 r from the others', which are r to the right of the lanes.
    lean = math.acos((2.0 + RADIUS) / (2 * RADIUS))
    assert [round(math.copysign(1.0, curvature)) for _, _, _, curvature in rows] == [-1, 1, -1]
    assert [length / RADIUS for _, _, length, _ in rows] == pytest.approx([lean, math.pi + 2 * lean, lean])


def test_lanes_six_metres_apart_are_joined_by_half_a_circle() -> None:
    plan = shortest(Pose(0.0, 0.0, 0.0), Pose(0.0, 6.0, math.pi))
    assert curve_length(plan, 0) == pytest.approx(math.pi * RADIUS)
    ahead = shortest(Pose(0.0, 0.0, 0.0), Pose(5.0, 6.0, math.pi))
    assert [round(length, 6) for _, _, length, _ in records(ahead, 0)] == [5.0, round(math.pi * RADIUS, 6)]


def test_a_full_circle_is_not_a_turn() -> None:
    # To be met one metre to the left in the same heading takes a circle.
    assert not found(shortest(Pose(0.0, 0.0, 0.0), Pose(-1.0, 1.0, 0.0)))


def test_a_radius_a_little_larger_leaves_no_tiny_record() -> None:
    """A line and an arc lead to the second pose, but for another arc of a tenth of a millimetre."""
    turn = 1.2
    one, other = Pose(0.0, 0.0, 0.0), Pose(20.0 + RADIUS * math.sin(turn), RADIUS * (1 - math.cos(turn)), turn + 5e-5)
    values = [np.array([value]) for value in (one.x, one.y, one.hdg, other.x, other.y, other.hdg)]
    assert 0 < shortest(one, other).length.min() < 1e-2
    plan = dubins_without_slivers(*values, radius=np.array([RADIUS]))
    assert_smooth(plan, 0)
    assert plan.length.min() > 0.02
    assert RADIUS * (1 - 1e-12) <= smallest_radius_of(plan, 0) <= 1.3 * RADIUS * (1 + 1e-12)
    assert pose_at(plan, 0, curve_length(plan, 0)).gap(other) < 1e-6


def test_of_two_that_are_as_long_it_is_the_same_mirrored_and_backwards() -> None:
    """With a line between two arcs it is 0.2 mm shorter than with three arcs, but the first arc is a sliver."""
    radius = 5.0
    pieces, curvature = np.array([[0.004388, 0.740769, 9.619467]]), np.array([[1.0, 0.0, -1.0]]) / radius
    origin = np.zeros(1)
    sliver = curves_of(origin, origin, origin, pieces, curvature)
    end = pose_at(sliver, 0, curve_length(sliver, 0))
    for one, other, sense, step in (
        (Pose(0.0, 0.0, 0.0), end, 1, 1),
        (Pose(0.0, 0.0, 0.0), Pose(end.x, -end.y, -end.hdg), -1, 1),
        (end.turned(), Pose(0.0, 0.0, 0.0).turned(), -1, -1),
    ):
        values = (one.x, one.y, one.hdg, other.x, other.y, other.hdg)
        plan = dubins_curves(*(np.array([value]) for value in values), radius=radius)
        rows = records(plan, 0)[::step]
        assert [round(sense * radius * curvature) for _, _, _, curvature in rows] == [-1, 1, -1]
        assert [length for _, _, length, _ in rows] == pytest.approx([0.183068, 0.37486, 9.806871], abs=2e-3)
