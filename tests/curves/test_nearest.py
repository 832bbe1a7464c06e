"""Places on curves that are nearest to points."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.curves.nearest import CurveFinder
from osm2xodr.curves.plan_views import curvature_at, curves_of
from osm2xodr.curves.records import pose, project
from osm2xodr.model import FloatArray, PlanView


def plan(curvature: list[float]) -> PlanView:
    """Return one curve of pieces of 50 m."""
    zero = np.zeros(1)
    return curves_of(zero + 3.0, zero - 2.0, zero + 0.4, np.full((1, len(curvature)), 50.0), np.array([curvature]))


def beside(view: PlanView, s: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    x, y, hdg = pose(view, np.zeros(len(s), np.int64), s)
    return x - t * np.sin(hdg), y + t * np.cos(hdg)


@pytest.mark.parametrize("curvature", [[0.0], [0.02], [-0.02], [0.05, -0.05], [-0.01, 0.0, 0.03]], ids=str)
@pytest.mark.parametrize("aside", [-8.0, -0.5, 0.0, 0.5, 8.0])
def test_points_beside_a_curve_get_its_s_and_t(curvature: list[float], aside: float) -> None:
    view = plan(curvature)
    s = np.linspace(0.5, 50.0 * len(curvature) - 0.5, 23)
    t = np.full(len(s), aside)
    found_s, found_t, distance = project(view, np.zeros(len(s), np.int64), *beside(view, s, t))
    np.testing.assert_allclose(found_s, s, atol=1e-9)
    np.testing.assert_allclose(found_t, t, atol=1e-9)
    np.testing.assert_allclose(distance, np.abs(t), atol=1e-9)


@pytest.mark.parametrize("curvature", [0.0, 0.02, -0.02])
def test_points_beyond_the_ends_get_the_ends(curvature: float) -> None:
    view = plan([curvature])
    x, y, hdg = pose(view, np.zeros(2, np.int64), np.array([0.0, 50.0]))
    step = np.array([-4.0, 4.0])
    s, t, distance = project(view, np.zeros(2, np.int64), x + step * np.cos(hdg), y + step * np.sin(hdg))
    np.testing.assert_allclose(s, [0.0, 50.0], atol=1e-9)
    np.testing.assert_allclose(t, 0.0, atol=1e-9)
    np.testing.assert_allclose(distance, 4.0, atol=1e-9)


def test_the_nearest_of_two_curves_is_found() -> None:
    zero, length = np.zeros(2), np.full((2, 1), 80.0)
    view = curves_of(zero, np.array([0.0, 10.0]), zero, length, np.zeros((2, 1)))
    places = np.array([20.0, 30.0, 40.0]), np.array([2.0, 7.0, 40.0])
    for samples, points, curves in ((1, [0, 1], [0, 1]), (12, [0, 0, 1, 1], [0, 1, 0, 1])):
        point, curve, s, t, distance = CurveFinder(view).nearest(*places, 15.0, samples)
        assert (point.tolist(), curve.tolist()) == (points, curves)
        np.testing.assert_allclose(s, places[0][point])
        np.testing.assert_allclose(t, places[1][point] - 10.0 * curve)
        np.testing.assert_allclose(distance, np.abs(t))
    assert curvature_at(plan([0.02, -0.01]), np.zeros(2, np.int64), np.array([10.0, 60.0])).tolist() == [0.02, -0.01]
