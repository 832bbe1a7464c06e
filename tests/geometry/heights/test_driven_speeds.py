"""How fast traffic drives: posted, or what bends allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import RoadSpec, make_problem, plan_view, straight

from osm2xodr.geometry.heights.limits import driven_speeds, fastest_around, span_speeds
from osm2xodr.model import PlanView


def test_unknown_limits_count_as_50_and_none_as_130() -> None:
    problem = make_problem([straight((0.0, 0.0), (9.0, 0.0)) for _ in range(3)])
    assert span_speeds(problem).tolist() == [50 / 3.6] * 3
    problem = replace(problem, span_speed=np.array([10.0, np.nan, np.inf]))
    assert span_speeds(problem).tolist() == [10.0, 50 / 3.6, 130 / 3.6]


def test_bends_slow_down_to_what_the_lateral_acceleration_allows() -> None:
    plan = plan_view([straight((0.0, 0.0), (50.0, 0.0)), RoadSpec(0.0, 0.0, 0.0, 50.0, curvature=-0.1)])
    speed = driven_speeds(plan, np.array([0, 1, 1, 1]), np.array([20.0, 20.0, 0.0, 50.0]), np.full(4, 14.0))
    bend = np.sqrt(3.0 / 0.1)
    assert speed == pytest.approx([14.0, bend, bend, bend])
    assert driven_speeds(plan, np.array([1]), np.array([20.0]), np.array([5.0])) == pytest.approx([5.0])


def test_cars_are_fastest_before_a_bend_begins() -> None:
    plan = PlanView(
        np.array([0, 2], np.int64), np.array([0.0, 30.0]), np.array([0.0, 30.0]), np.zeros(2), np.zeros(2),
        np.array([30.0, 20.0]), np.array([0.0, 0.1]),
    )  # fmt: skip
    road, place, posted = np.zeros(2, np.int64), np.array([30.0, 40.0]), np.full(2, 14.0)
    # A wheelbase of 2.7 m that ends where the bend begins is straight.
    assert fastest_around(plan, road, place, posted) == pytest.approx([14.0, np.sqrt(3.0 / 0.1)])
    assert driven_speeds(plan, road, place, posted)[0] == pytest.approx(np.sqrt(3.0 / 0.05))


def test_cars_are_as_slow_at_the_ends_of_a_bend_as_inside_it() -> None:
    plan = plan_view([RoadSpec(0.0, 0.0, 0.0, 20.0, curvature=1.0 / 12.0)])
    s = np.array([0.0, 0.4, 10.0, 20.0])
    # 3 m/s² sideways in a bend of 12 m; half a wheelbase of it counts for a whole one.
    found = fastest_around(plan, np.zeros(4, np.int64), s, np.full(4, 14.0))
    assert found == pytest.approx(np.full(4, 6.0), rel=1e-6)
