"""Curves of continuous curvature: where they come from roads whose true curvature is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from road_measures import curve_length, pose_at
from scene_files import SMALL_SCENES

from osm2xodr.checking import CheckOptions, Severity, check_drive
from osm2xodr.conventions import SPIRALS
from osm2xodr.curves import arc_step, curvature_at, curves_of, lengths, pose, project, smallest_radius
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import RoadOptions
from osm2xodr.geometry.plan_view import defaults, smooth_curves as smooth_curves_module
from osm2xodr.geometry.plan_view.fine_points import FinePoints
from osm2xodr.geometry.plan_view.polyline_fit import fit_polylines
from osm2xodr.geometry.plan_view.smooth_curves import smooth_curves
from osm2xodr.model import FloatArray, PlanView
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.xodrWriter import WriteOptions, write_xodr


def _smooth(points: FloatArray) -> tuple[PlanView, PlanView]:
    """Return the curve of lines and arcs through points, and the smooth one."""
    fitted = fit_polylines(points, np.array([0, len(points)]), np.array([15.0])).plan_view
    return fitted, smooth_curves(fitted, np.zeros((1, 2), bool)).plan_view


def _clothoid_road(spacing: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points along an S, s of each and the curvature there.

    Two bends of 80 m radius lie between spirals of 60 m; on either side is a line of 80 m.
    """
    knots = np.cumsum([0.0, 80.0, 60.0, 70.0, 60.0, 60.0, 70.0, 60.0, 80.0])
    bends = np.array([0.0, 0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0, 0.0]) / 80.0
    s = np.arange(0.0, knots[-1], 0.05)
    curvature = np.interp(s, knots, bends)
    hdg = np.cumsum(curvature) * 0.05
    place = np.cumsum(np.column_stack([np.cos(hdg), np.sin(hdg)]), axis=0) * 0.05
    chosen = np.append(np.arange(0, len(s) - 1, int(spacing / 0.05)), len(s) - 1)
    return place[chosen], s[chosen], curvature[chosen]


def _steps(plan: PlanView) -> float:
    """Return the largest step of curvature between records, 1/m."""
    end = plan.curvature + plan.rate * plan.length
    return float(np.abs(plan.curvature[1:] - end[:-1]).max())


def _gaps(plan: PlanView) -> float:
    """Return how far records end from where the next begin, m and rad."""
    u, v, turn = arc_step(plan.curvature, plan.length, plan.rate)
    cos, sin = np.cos(plan.hdg), np.sin(plan.hdg)
    x, y, hdg = plan.x + cos * u - sin * v, plan.y + sin * u + cos * v, plan.hdg + turn
    turned = np.angle(np.exp(1j * (plan.hdg[1:] - hdg[:-1])))
    return float(max(np.abs(plan.x[1:] - x[:-1]).max(), np.abs(plan.y[1:] - y[:-1]).max(), np.abs(turned).max()))


def test_an_s_curve_keeps_its_curvature_and_has_no_steps() -> None:
    points, _, truth = _clothoid_road(15.0)
    arcs, plan = _smooth(points)
    at, _, distance = project(plan, np.zeros(len(points), np.int64), *points.T.copy())
    assert distance.max() < defaults.SMOOTH_SHIFT
    assert np.abs(curvature_at(plan, np.zeros(len(at), np.int64), at) - truth).max() < 0.15 / 80.0
    assert _steps(plan) < 1e-7
    assert _gaps(plan) < 1e-6
    assert len(plan.s) < len(arcs.s) / 2


def test_ends_stay_where_they_are() -> None:
    points, *_ = _clothoid_road(15.0)
    _, plan = _smooth(points)
    start, end = pose_at(plan, 0, 0.0), pose_at(plan, 0, curve_length(plan, 0))
    assert (start.x, start.y) == pytest.approx(tuple(points[0]), abs=1e-9)
    assert (end.x, end.y) == pytest.approx(tuple(points[-1]), abs=1e-8)


def test_a_circle_of_noisy_nodes_is_one() -> None:
    """Of nodes half a metre off, every 15 m, on three quarters of a circle of 100 m radius, but for its ends.

    In the mean over 24 of them its curvature is right within 10 %.
    """
    angle, every = np.linspace(0.0, 1.5 * np.pi, 32), np.zeros(300, np.int64)
    off: list[FloatArray] = []
    before: list[FloatArray] = []
    for seed in range(24):
        noise = np.random.default_rng(seed).normal(0.0, 0.5, 32)
        curves = _smooth((100.0 + noise)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
        for plan, found in zip(curves, (before, off), strict=True):
            s = np.linspace(60.0, curve_length(plan, 0) - 60.0, 300)
            found.append(100.0 * curvature_at(plan, every, s) - 1.0)
    assert np.mean(off) == pytest.approx(0.0, abs=0.01)
    assert np.mean(np.abs(off)) < 0.1
    assert np.mean(np.abs(before)) > 0.4


def test_a_loop_of_spirals_keeps_its_radius() -> None:
    """A ramp that turns by 270 degrees: spirals of 40 m to a radius of 30 m."""
    knots = np.cumsum([0.0, 50.0, 40.0, 30.0 * 1.5 * np.pi - 40.0, 40.0, 50.0])
    s = np.arange(0.0, knots[-1], 0.05)
    hdg = np.cumsum(np.interp(s, knots, np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]) / 30.0)) * 0.05
    place = np.cumsum(np.column_stack([np.cos(hdg), np.sin(hdg)]), axis=0) * 0.05
    _, plan = _smooth(place[::160])
    assert smallest_radius(plan)[0] == pytest.approx(30.0, rel=0.1)
    assert _steps(plan) < 1e-7


def test_corners_of_streets_stay_corners() -> None:
    points = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0]])
    arcs, plan = _smooth(points)
    assert smallest_radius(plan)[0] > 0.9 * smallest_radius(arcs)[0]
    s = np.linspace(0.0, curve_length(plan, 0), 200)
    x, y, _ = pose(plan, np.zeros(200, np.int64), s)
    assert project(arcs, np.zeros(200, np.int64), x, y)[2].max() < 1.2 * defaults.SMOOTH_SHIFT
    assert _steps(plan) < 1e-7


def test_a_curve_is_the_same_with_others_in_the_table_and_without() -> None:
    points, *_ = _clothoid_road(15.0)
    other = points @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + 1000.0
    start = np.array([0, len(points), 2 * len(points)])
    both = fit_polylines(np.concatenate([points, other]), start, np.full(2, 15.0)).plan_view
    alone = _smooth(points)[1]
    found = smooth_curves(both, np.zeros((2, 2), bool))
    assert found.good.all()
    assert lengths(found.plan_view)[0] == pytest.approx(lengths(alone)[0], abs=1e-9)
    assert found.plan_view.start[1] == len(alone.s)


def test_more_processes_find_the_same_curves(monkeypatch: pytest.MonkeyPatch) -> None:
    points, *_ = _clothoid_road(15.0)
    start, radius = np.arange(4) * len(points), np.full(3, 15.0)
    moved = [points + 1000.0 * k for k in range(3)]
    several = fit_polylines(np.concatenate(moved), start, radius).plan_view
    # Less than one curve, so that each is a block of its own.
    monkeypatch.setattr(smooth_curves_module, "_BLOCK", 100.0)
    one, two = (smooth_curves(several, np.zeros((3, 2), bool), jobs=jobs) for jobs in (1, 2))
    assert one.good.all()
    assert two.good.all()
    for item in ("x", "y", "hdg", "length", "curvature", "rate"):
        assert (getattr(one.plan_view, item) == getattr(two.plan_view, item)).all(), item
    assert (one.first == two.first).all()
    assert (one.after == two.after).all()


@pytest.mark.parametrize("held", [(True, True), (False, True), (True, False)])
def test_ends_that_are_held_keep_their_headings(held: tuple[bool, bool]) -> None:
    zero = np.zeros(1)
    bends = np.array([[30.0, 40.0, 30.0]]), np.array([[0.0, 0.02, 0.0]])
    plan = curves_of(zero, zero, zero, *bends)
    smooth = smooth_curves(plan, np.array([held])).plan_view
    off = [pose_at(smooth, 0, 0.0).hdg, pose_at(smooth, 0, curve_length(smooth, 0)).hdg - 0.8]
    for value, is_held in zip(off, held, strict=True):
        assert (abs(value) < 1e-9) == is_held


def test_nodes_hold_curves_near_them() -> None:
    """A node half a metre aside of a straight road: the curve passes it nearer if it counts more."""
    points = np.array([[0.0, 0.0], [40.0, 0.0], [80.0, 0.5], [120.0, 0.0], [160.0, 0.0]])
    fitted = fit_polylines(points, np.array([0, len(points)]), np.array([15.0])).plan_view
    x, y = points[2:3].T.copy()
    s, _, _ = project(fitted, np.array([0]), x, y)
    off = []
    for nodes in ((np.zeros(0, np.int64), np.zeros(0)), (np.array([0]), s)):
        plan = smooth_curves(fitted, np.zeros((1, 2), bool), nodes).plan_view
        off.append(float(project(plan, np.array([0]), x, y)[2][0]))
    assert off[1] < off[0] - 0.01


def test_corners_that_are_cut_already_move_less() -> None:
    """What a fillet cuts off and what it moves by are within the limit together."""
    points = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0]])
    for radius in (5.0, 10.0):
        fitted = fit_polylines(points, np.array([0, 3]), np.array([radius])).plan_view
        plan = smooth_curves(fitted, np.zeros((1, 2), bool)).plan_view
        s = np.linspace(0.0, curve_length(plan, 0), 400)
        x, y, _ = pose(plan, np.zeros(400, np.int64), s)
        cut = FinePoints.along(fitted, np.array([0])).cut.max()
        off = np.minimum(np.abs(y), np.abs(x - 60.0)).max()
        assert off < max(defaults.SMOOTH_SHIFT_MOST, cut + 0.35)


def test_roads_with_spirals_are_sound(tmp_path: Path) -> None:
    """A real place, from OSM to the file: no gap or kink within and between roads."""
    scene = SMALL_SCENES[0]
    options = PipelineOptions(scene.osm, (scene.dem,), roads=RoadOptions(plan=SPIRALS))
    road_map = convert(options, Diagnostics()).road_map
    assert (road_map.plan_view.rate != 0.0).sum() > 10
    path = tmp_path / "spirals.xodr"
    with path.open("wb") as stream:
        write_xodr(road_map, stream, WriteOptions(), Diagnostics())
    assert b"<spiral " in path.read_bytes()
    found = check_drive(read_xodr(path), CheckOptions()).findings
    # Lanes of the widths of these tests touch at a fork, as those of the tables do not.
    assert {item.rule for item in found if item.severity is Severity.ERROR} <= {"clearance"}
