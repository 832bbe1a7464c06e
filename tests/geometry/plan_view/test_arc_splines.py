"""Arc splines: exact for circles, near their points, closed, and without bends that the line does not have."""

from __future__ import annotations

import math

import numpy as np
import pytest
from road_measures import assert_smooth, curve_length, pose_at, records

from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.arc_splines import fit_arcs, turns_of
from osm2xodr.model import FloatArray


def on_ellipse(long: float, short: float, degrees: FloatArray) -> FloatArray:
    angle = np.deg2rad(degrees)
    return np.column_stack([long * np.cos(angle), short * np.sin(angle)])


def test_points_of_a_circle_get_the_circle() -> None:
    found = fit_arcs(on_ellipse(20.0, 20.0, np.arange(0.0, 360.0, 30.0)), closed=True)
    assert found is not None
    plan, s = found
    assert [item[3] for item in records(plan, 0)] == pytest.approx([1 / 20] * len(plan.s), rel=1e-3)
    assert s == pytest.approx(np.arange(12) * 2 * math.pi * 20 / 12, abs=0.02)


@pytest.mark.parametrize("sense", [1, -1])
def test_an_oval_closes_and_bends_to_one_side(sense: int) -> None:
    points = on_ellipse(24.0, 14.0, np.arange(0.0, 360.0, 20.0))[::sense]
    found = fit_arcs(points, closed=True)
    assert found is not None
    plan, s = found
    assert_smooth(plan, 0)
    assert pose_at(plan, 0, curve_length(plan, 0)).gap(pose_at(plan, 0, 0.0)) < 1e-6
    assert all(sense * item[3] >= 0 for item in records(plan, 0))
    poses = [pose_at(plan, 0, at) for at in s.tolist()]
    off = [math.hypot(pose.x - x, pose.y - y) for pose, (x, y) in zip(poses, points.tolist(), strict=True)]
    assert max(off) <= defaults.RING_TOLERANCE
    assert math.sqrt(sum(one * one for one in off) / len(off)) <= defaults.RING_CURVE_RMS


def test_an_open_row_ends_at_its_last_point() -> None:
    points = on_ellipse(20.0, 16.0, np.arange(0.0, 200.0, 20.0))
    found = fit_arcs(points, closed=False)
    assert found is not None
    plan, s = found
    assert s[-1] == pytest.approx(curve_length(plan, 0))
    last = pose_at(plan, 0, float(s[-1]))
    assert math.hypot(last.x - points[-1, 0], last.y - points[-1, 1]) < defaults.RING_TOLERANCE


def test_sharp_corners_and_lines_that_do_not_go_round_once_have_no_spline() -> None:
    square = np.array([(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0)])
    eight = np.column_stack([20 * np.sin(np.arange(12) * math.pi / 6), 10 * np.sin(np.arange(12) * math.pi / 3)])
    sides = np.concatenate([a + (b - a) * np.arange(8)[:, None] / 8 for a, b in zip(square, np.roll(square, -1, 0))])  # noqa: B905
    assert fit_arcs(sides, closed=True) is None
    assert fit_arcs(eight, closed=True) is None


def test_turns_of_a_square() -> None:
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    assert turns_of(square, closed=True) == pytest.approx([math.pi / 2] * 4)
    assert turns_of(square[::-1], closed=False) == pytest.approx([-math.pi / 2] * 2)
