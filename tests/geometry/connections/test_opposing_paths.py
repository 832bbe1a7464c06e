"""Ways there and back keep beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves import chain_curves, lengths, pose, smallest_radius, stack_plan_views
from osm2xodr.geometry.connections.carriageways import Carriageways
from osm2xodr.geometry.connections.opposing_paths import draw_side_by_side, joined_arms
from osm2xodr.geometry.connections.pose_to_pose import connect, has_kinks
from osm2xodr.model import FloatArray, IntArray, PlanView

ARMS = np.array([1, 2]), np.array([2, 1])
WIDTH = np.array([2.75, 2.75])


def there_and_back(aside: float, side: float) -> PlanView:
    """Draw the ways between two parallel arms, 19 m apart and some way aside, by lanes right (left: -1) of them."""
    lane = -1.375 * side
    zero, east, west = np.zeros(1), np.zeros(1), np.full(1, np.pi)
    there = connect(zero, zero + lane, east, zero + 19.0, zero + aside + lane, east)
    back = connect(zero + 19.0, zero + aside - lane, west, zero, zero - lane, west)
    return stack_plan_views(there, back)


def nearest(plan: PlanView) -> float:
    """Return how near the two curves come, m."""
    points = []
    for k in (0, 1):
        s = np.linspace(2.0, float(lengths(plan)[k]) - 2.0, 200)
        points.append(np.column_stack(pose(plan, np.full(len(s), k), s)[:2]))
    return float(np.hypot(*(points[0][:, None] - points[1][None]).T).min())


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("aside", [8.0, -8.0])
def test_ways_aside_keep_their_distance(aside: float, side: float) -> None:
    plan = there_and_back(aside, side)
    drawn = draw_side_by_side(plan, *ARMS, WIDTH, np.zeros(2, bool))
    assert nearest(plan) < 2.1
    assert nearest(drawn) == pytest.approx(2.75, abs=0.02)
    assert smallest_radius(drawn).min() > 4.2
    assert not has_kinks(drawn).any()


def test_their_ends_stay() -> None:
    plan = there_and_back(8.0, 1.0)
    drawn = draw_side_by_side(plan, *ARMS, WIDTH, np.zeros(2, bool))
    rows = np.arange(2)
    for share in (0.0, 1.0):
        before, after = (np.array(pose(item, rows, share * lengths(item))) for item in (plan, drawn))
        assert after[:2] == pytest.approx(before[:2], abs=1e-6)
        assert np.cos(after[2] - before[2]) == pytest.approx(1.0, abs=1e-9)


def test_ways_that_keep_their_distance_stay_as_they_are() -> None:
    plan = there_and_back(2.0, 1.0)
    assert draw_side_by_side(plan, *ARMS, WIDTH, np.zeros(2, bool)) is plan


def test_one_way_is_drawn_beside_the_other_where_their_axis_is_no_way() -> None:
    """Both go round an island 12 m to the left, one of them more widely: the axis from arm to arm runs through it."""
    here = [np.array([v]) for v in (0.0, -1.375, 0.0)]
    over = [np.array([v]) for v in (20.0, 12.0 - 1.375, 0.0)]
    there_end = [np.array([v]) for v in (40.0, -1.375, 0.0)]
    there = chain_curves(stack_plan_views(connect(*here, *over), connect(*over, *there_end)), np.array([0, 2]))
    back = connect(*(np.array([v]) for v in (40.0, 1.375, np.pi, 0.0, 1.375, np.pi)))
    plan = stack_plan_views(there, back)
    drawn = draw_side_by_side(plan, *ARMS, WIDTH, np.zeros(2, bool), _Island())
    assert nearest(plan) < 0.1
    assert nearest(drawn) > 2.3
    assert float(_Island().beyond(drawn, np.arange(2), np.arange(2)).max()) <= 1.25


class _Island(Carriageways):
    """Carriageways round an island: ways leave them by as much as they stay right of its left side."""

    def __init__(self) -> None:
        pass

    def beyond(self, plan: PlanView, curve: IntArray, row: IntArray, most: float | FloatArray = np.inf) -> FloatArray:
        half = 0.5 * lengths(plan)[curve]
        return 10.0 - np.asarray(pose(plan, curve, half)[1])


def test_lanes_for_both_directions_stay_as_they_are() -> None:
    plan = there_and_back(8.0, 1.0)
    assert draw_side_by_side(plan, *ARMS, WIDTH, np.ones(2, bool)) is plan


def test_no_ways_are_no_pairs() -> None:
    none = np.zeros(0, np.int64)
    plan = connect(*(np.zeros(0) for _ in range(6)))
    assert draw_side_by_side(plan, none, none, np.zeros(0), np.zeros(0, bool)) is plan


@pytest.mark.parametrize(
    ("apart", "lanes_meet", "one_way"), [(4.0, True, True), (9.0, False, True), (4.0, False, False)]
)
def test_carriageways_that_end_face_to_face_are_one_arm(apart: float, lanes_meet: bool, one_way: bool) -> None:
    """Road end 1 has lanes both ways, 19 m east of it end the carriageways 2, which leads away, and 3."""
    zero, east, west = np.zeros(1), np.zeros(1), np.full(1, np.pi)
    there = connect(zero, zero - 1.5, east, zero + 19.0, zero + 5.0, east)
    back = connect(zero + 19.0, zero + 5.0 + apart, west, zero, zero + 1.5, west)
    plan = stack_plan_views(there, back)
    arms = joined_arms(
        plan, np.zeros(2, np.int64), np.array([1, 3]), np.array([2, 1]), np.array([False, False, one_way, one_way])
    )
    assert [arm.tolist() for arm in arms] == ([[1, 2], [2, 1]] if lanes_meet else [[1, 3], [2, 1]])
