"""Superelevation that spares lanes a step of grade between straight and arc."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import make_problem, plan_view, straight

from osm2xodr.curves import cubic_slope, cubic_value
from osm2xodr.geometry.heights.problem import Pins, ProfileProblem
from osm2xodr.geometry.heights.superelevation.cross_slope import ease_lane_grades
from osm2xodr.model import CubicProfile, PlanView


def hairpin(curvature: float) -> ProfileProblem:
    """Return a road of 40 m straight on and 20 m of arc."""
    problem = make_problem([straight((0.0, 0.0), (60.0, 0.0))])
    plan = PlanView(
        np.array([0, 2], np.int64), np.array([0.0, 40.0]), np.array([0.0, 40.0]), np.zeros(2), np.zeros(2),
        np.array([40.0, 20.0]), np.array([0.0, curvature]),
    )  # fmt: skip
    return replace(problem, plan_view=plan, span_width=np.array([6.5]))


def ramp(grade: float) -> CubicProfile:
    zero = np.zeros(1)
    return CubicProfile(np.array([0, 1], np.int64), zero, zero, zero + grade, zero, zero)


def lane_grade(found: CubicProfile, t: float, s: float, grade: float, curvature: float) -> float:
    at, road = np.array([s]), np.zeros(1, np.int64)
    return float((grade + t * cubic_slope(found, road, at)[0]) / (1 - curvature * t))


@pytest.mark.parametrize("t", [-1.65, 1.65])
@pytest.mark.parametrize("curvature", [-0.16, 0.16])
def test_lanes_lose_most_of_the_step_and_ends_stay_level(t: float, curvature: float) -> None:
    found = ease_lane_grades(hairpin(curvature), ramp(0.1))
    assert found is not None
    before, after = (lane_grade(found, t, s, 0.1, k) for s, k in ((40.0 - 1e-6, 0.0), (40.0 + 1e-6, curvature)))
    step = abs(0.1 / (1 - curvature * t) - 0.1)
    assert abs(after - before) < 0.45 * step
    # χ' is z' times the difference of the curvature and its average over 4 m on both sides.
    s = np.array([0.0, 35.9, 38.0, 40.0 - 1e-9, 42.0, 44.1, 60.0])
    slope = cubic_slope(found, np.zeros(7, np.int64), s)
    assert slope == pytest.approx(0.1 * curvature * np.array([0.0, 0.0, 0.25, 0.5, -0.25, 0.0, 0.0]), abs=1e-6)
    value = cubic_value(found, np.zeros(7, np.int64), s)
    assert value[[0, 1, 5, 6]] == pytest.approx(np.zeros(4), abs=1e-6)
    assert value[3] == pytest.approx(0.1 * curvature * 4.0 / 4, abs=1e-6)


def test_steps_that_nobody_feels_stay() -> None:
    assert ease_lane_grades(hairpin(0.16), ramp(0.02)) is None
    assert ease_lane_grades(hairpin(0.01), ramp(0.1)) is None
    slow = replace(hairpin(0.16), span_speed=np.array([20 / 3.6]))
    assert ease_lane_grades(slow, ramp(0.1)) is None


def test_twist_is_bounded_on_roads_that_would_need_more() -> None:
    found = ease_lane_grades(hairpin(0.3), ramp(0.2))
    assert found is not None
    slope = cubic_slope(found, np.zeros(600, np.int64), np.linspace(0.0, 60.0, 600))
    assert np.abs(slope).max() <= 0.018 + 1e-9


def test_roads_are_level_where_they_are_held() -> None:
    none = np.array([np.nan])
    pinned = replace(hairpin(0.16), pins=Pins(np.zeros(1, np.int64), np.array([42.0]), none, none))
    found = ease_lane_grades(pinned, ramp(0.1))
    assert found is not None
    at = np.zeros(1, np.int64), np.array([42.0])
    assert cubic_value(found, *at) == pytest.approx([0.0], abs=1e-7)
    assert cubic_slope(found, *at) == pytest.approx([0.0], abs=1e-7)


def test_plain_roads_need_none() -> None:
    problem = make_problem([straight((0.0, 0.0), (60.0, 0.0))])
    assert (
        ease_lane_grades(replace(problem, plan_view=plan_view([straight((0.0, 0.0), (60.0, 0.0))])), ramp(0.1))
        is None
    )
