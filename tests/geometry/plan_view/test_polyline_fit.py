"""Curves through polylines: what they are for lines, circles and corners, and that they are smooth for any input."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, example, given, settings, strategies as st
from road_measures import assert_smooth, curve_length, pose_at, records

from osm2xodr.curves.plan_views import cut_curves, snap_cuts
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.polyline_fit import FittedPolylines, fit_polylines
from osm2xodr.model import PlanView

Points = list[tuple[float, float]]


def fit(*lines: Points, radius: float = 6.0, closed: list[bool] | None = None) -> FittedPolylines:
    start = np.cumsum([0, *map(len, lines)], dtype=np.int64)
    points = np.array([point for line in lines for point in line], dtype=np.float64)
    rings = None if closed is None else np.array(closed, bool)
    return fit_polylines(points, start, np.full(len(lines), radius), rings)


def on_circle(radius: float, degrees: npt.NDArray[np.float64]) -> Points:
    angle = np.deg2rad(degrees)
    return list(zip((radius * np.cos(angle)).tolist(), (radius * np.sin(angle)).tolist(), strict=True))


def distances_to_line(plan: PlanView, curve: int, line: Points, step: float = 0.25) -> list[float]:
    """Distances of places along a curve from a polyline."""
    length = curve_length(plan, curve)
    corners = np.array(line)
    a, b = corners[:-1], corners[1:]
    found = []
    for s in np.linspace(0.0, length, max(3, int(length / step))):
        pose = pose_at(plan, curve, float(s))
        p = np.array([pose.x, pose.y])
        share = np.clip(((p - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0.0, 1.0)
        found.append(float(np.hypot(*(p - a - share[:, None] * (b - a)).T).min()))
    return found


def test_a_straight_line_is_one_record_however_many_points_it_has() -> None:
    fitted = fit([(0.0, 0.0), (3.0, 4.0), (30.0, 40.0), (33.0, 44.0), (60.0, 80.0)])
    assert fitted.plan_view.start.tolist() == [0, 1]
    ((s, pose, length, curvature),) = records(fitted.plan_view, 0)
    assert (s, pose.x, pose.y, curvature) == (0.0, 0.0, 0.0, 0.0)
    assert pose.hdg == pytest.approx(math.atan2(4, 3), abs=1e-12)
    assert length == pytest.approx(100.0, abs=1e-9)
    assert fitted.station == pytest.approx([0.0, 5.0, 50.0, 55.0, 100.0], abs=1e-9)
    assert fitted.spikes.tolist() == []


def test_points_within_the_tolerance_of_a_line_leave_no_trace() -> None:
    fitted = fit([(0.0, 0.0), (20.0, 0.1), (40.0, 0.05), (60.0, 0.0)])
    assert len(fitted.plan_view.s) == 1
    assert fitted.plan_view.hdg.tolist() == [0.0]


def test_two_points_are_a_line() -> None:
    fitted = fit([(1.0, 2.0), (1.0, 12.0)])
    ((_, pose, length, curvature),) = records(fitted.plan_view, 0)
    assert (pose.x, pose.y, curvature) == (1.0, 2.0, 0.0)
    assert pose.hdg == pytest.approx(math.pi / 2, abs=1e-12)
    assert length == pytest.approx(10.0, abs=1e-12)


def test_a_polyline_to_and_fro_over_a_centimetre_comes_to_a_point() -> None:
    """Nodes 1 cm apart, of which the last lies on the first: nothing is left but a place and a heading."""
    c, d = 0.0111, 0.0069
    points = [(0.0, -c), (0.0, 0.0), (0.0, c), (0.0, 0.0), (0.0, -c), (d, 0.0), (-d, c), (d, 0.0), (0.0, -c)]
    plan = fit(points).plan_view
    assert len(plan.s) > 0
    assert np.isfinite([plan.x, plan.y, plan.hdg, plan.curvature]).all()
    assert 0.0 < curve_length(plan, 0) < 1e-3


def test_a_square_corner_is_an_arc_between_its_tangents() -> None:
    """Fixed points are not moved, so the arc is the fillet that cuts the corner by 2 m at most."""
    points = np.array([(-50.0, 0.0), (0.0, 0.0), (0.0, 50.0)])
    fitted = fit_polylines(points, np.array([0, 3]), np.array([3.0]), fixed=np.array([False, True, False]))
    line, arc, last = records(fitted.plan_view, 0)
    assert arc[3] == pytest.approx(1 / 3.0, rel=1e-9)
    assert arc[2] == pytest.approx(3.0 * math.pi / 2, rel=1e-9)
    assert (arc[1].x, arc[1].y, arc[1].hdg) == pytest.approx((-3.0, 0.0, 0.0), abs=1e-9)
    assert (last[1].x, last[1].y, last[1].hdg) == pytest.approx((0.0, 3.0, math.pi / 2), abs=1e-9)
    assert line[2] == pytest.approx(47.0, abs=1e-9)
    assert fitted.station == pytest.approx([0.0, 47.0 + 3.0 * math.pi / 4, 94.0 + 3.0 * math.pi / 2], abs=1e-9)


@pytest.mark.parametrize("radius", [12.0, 30.0, 80.0, 250.0, 800.0])
@pytest.mark.parametrize("step_m", [6.0, 15.0])
def test_a_true_circle_sampled_coarsely_is_met(radius: float, step_m: float) -> None:
    step = math.degrees(min(step_m / radius, math.radians(40.0)))
    line = on_circle(radius, np.arange(0.0, 170.0, step))
    fitted = fit(line, radius=100.0)
    plan, station = fitted.plan_view, fitted.station
    inner = [item for item in records(plan, 0)[2:-2]]
    length = sum(item[2] for item in inner)
    bend = sum(item[2] * item[3] for item in inner)
    assert length / bend == pytest.approx(radius, rel=0.05)
    # Half of what a chord leaves of the circle is given to either side; the outermost chords have no next one.
    off_chord = radius * (1 - math.cos(math.radians(step / 2)))
    for s in np.linspace(station[1], station[-2], 60):
        pose = pose_at(plan, 0, float(s))
        assert abs(math.hypot(pose.x, pose.y) - radius) < max(0.75 * off_chord, defaults.SIMPLIFY_TOLERANCE)


def test_a_closed_ring_goes_on_smoothly_where_it_was_cut() -> None:
    square: Points = [(0.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0), (-20.0, -20.0), (0.0, -20.0)]
    plan = fit(square, closed=[True]).plan_view
    first, last = pose_at(plan, 0, 0.0), pose_at(plan, 0, curve_length(plan, 0))
    assert first.gap(last) < 1e-9
    assert first.turn(last) < 1e-9
    assert_smooth(plan, 0)


def test_a_spike_is_left_out_and_reported() -> None:
    fitted = fit([(0.0, 0.0), (20.0, 0.0), (50.0, 0.0), (20.0, 0.01), (20.0, 40.0)])
    assert fitted.spikes.tolist() == [2]
    assert_smooth(fitted.plan_view, 0)
    assert max(distances_to_line(fitted.plan_view, 0, [(0.0, 0.0), (20.0, 0.0), (20.0, 40.0)])) < 2.0


def test_curves_do_not_depend_on_their_neighbours_in_the_table() -> None:
    one: Points = [(0.0, 0.0), (40.0, 3.0), (60.0, 40.0), (90.0, 40.0)]
    other: Points = [(90.0, 40.0), (95.0, 10.0), (20.0, 10.0)]
    both = fit(one, other, one)
    for curve, line in enumerate((one, other, one)):
        alone = fit(line)
        for (s, pose, length, k), (s1, pose1, length1, k1) in zip(
            records(both.plan_view, curve), records(alone.plan_view, 0), strict=True
        ):
            assert (s, length, k) == pytest.approx((s1, length1, k1), abs=1e-9)
            assert pose.gap(pose1) < 1e-9
    assert both.station[: len(one)] == pytest.approx(both.station[-len(one) :], abs=1e-9)


def test_reversed_polylines_have_reversed_curves() -> None:
    line: Points = [(0.0, 0.0), (40.0, 3.0), (60.0, 40.0), (61.0, 70.0), (90.0, 90.0)]
    there, back = fit(line).plan_view, fit(line[::-1]).plan_view
    length = curve_length(there, 0)
    assert curve_length(back, 0) == pytest.approx(length, abs=1e-9)
    for s in np.linspace(0.0, length, 50):
        a, b = pose_at(there, 0, float(s)), pose_at(back, 0, float(length - s))
        assert a.gap(b) < 1e-6
        assert a.turn(b.turned()) < 1e-6


@st.composite
def polylines(draw: st.DrawFn) -> Points:
    """Walks with any turns (also straight back) and steps from 1 mm on; some come back to where they began."""
    steps = draw(
        st.lists(
            st.tuples(
                st.one_of(st.floats(0.001, 0.5), st.floats(0.5, 60.0)),
                st.one_of(st.floats(-0.4, 0.4), st.floats(-3.14159, 3.14159), st.sampled_from([0.0, math.pi, 2.2])),
            ),
            min_size=1,
            max_size=24,
        )
    )
    x = y = hdg = 0.0
    points = [(x, y)]
    for length, turn in steps:
        hdg += turn
        x, y = x + length * math.cos(hdg), y + length * math.sin(hdg)
        points.append((x, y))
    if draw(st.booleans()) and math.hypot(x, y) > 1.0:
        points.append((0.0, 0.0))
    assume(not _retraced(points))
    return points


def _retraced(points: Points) -> bool:
    """Whether a line comes back to where it began and turns straight back on the way: little is left without it."""
    back = math.dist(points[-1], points[0]) < 1.0
    # Points closer than half a metre may be left out.
    far = points[:1]
    for point in points[1:]:
        if math.dist(point, far[-1]) > 0.6:
            far.append(point)
    return back and any(_largest_turn(line) > math.radians(165.0) for line in (points, [*far, points[-1]]))


def _largest_turn(points: Points) -> float:
    legs = [(q[0] - p[0], q[1] - p[1]) for p, q in itertools.pairwise(points) if p != q]
    headings = [math.atan2(y, x) for x, y in legs]
    return max((abs(math.remainder(b - a, math.tau)) for a, b in itertools.pairwise(headings)), default=0.0)


@settings(max_examples=200, deadline=None)
@example([(0.0, 0.0), (0.001, 0.0)])
@example([(0.0, 0.0), (10.0, 0.0), (0.0, 0.0), (10.0, 0.0), (10.0, 5.0)])
@given(polylines())
def test_every_curve_is_smooth_and_keeps_its_ends(line: Points) -> None:
    fitted = fit(line)
    plan = fitted.plan_view
    assert plan.start[1] > 0
    assert_smooth(plan, 0)
    first, last = pose_at(plan, 0, 0.0), pose_at(plan, 0, curve_length(plan, 0))
    assert math.hypot(first.x - line[0][0], first.y - line[0][1]) < 1e-9
    assert math.hypot(last.x - line[-1][0], last.y - line[-1][1]) < 1e-6


@settings(max_examples=200, deadline=None)
@given(polylines())
def test_stations_never_run_back(line: Points) -> None:
    fitted = fit(line)
    assert fitted.station[0] == 0.0
    assert (np.diff(fitted.station) >= -1e-9).all()
    assert fitted.station[-1] == pytest.approx(curve_length(fitted.plan_view, 0), abs=1e-7)


@st.composite
def streets(draw: st.DrawFn) -> Points:
    """Walks as streets are: steps of 3 m and more, turns of up to 90 degrees."""
    steps = draw(
        st.lists(st.tuples(st.floats(3.0, 60.0), st.floats(-math.pi / 2, math.pi / 2)), min_size=1, max_size=12)
    )
    x = y = hdg = 0.0
    points = [(x, y)]
    for length, turn in steps:
        hdg += turn
        x, y = x + length * math.cos(hdg), y + length * math.sin(hdg)
        points.append((x, y))
    return points


@settings(max_examples=60, deadline=None)
@given(streets(), st.sampled_from([4.0, 6.0, 15.0, 100.0]))
def test_streets_stay_near_their_nodes(line: Points, radius: float) -> None:
    """A corner is cut by 2 m at most, and what was simplified away may add its tolerance."""
    plan = fit(line, radius=radius).plan_view
    furthest = max(distances_to_line(plan, 0, line, 0.5))
    assert furthest <= defaults.CORNER_CUT_MAX + defaults.SIMPLIFY_TOLERANCE + 1e-6


@settings(max_examples=60, deadline=None)
@given(polylines(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_part_of_a_curve_lies_on_it(line: Points, one: float, other: float) -> None:
    plan = fit(line).plan_view
    length = curve_length(plan, 0)
    lo, hi = sorted((one * length, other * length))
    if hi - lo < 1e-6:
        return
    part = cut_curves(plan, np.array([lo]), np.array([hi]), [0])
    assert_smooth(part, 0)
    assert curve_length(part, 0) == pytest.approx(hi - lo, abs=1e-7)
    for share in (0.0, 0.3, 0.7, 1.0):
        a = pose_at(part, 0, share * (hi - lo))
        b = pose_at(plan, 0, lo + share * (hi - lo))
        assert a.gap(b) < 1e-7


def test_one_curve_can_be_cut_many_times() -> None:
    plan = fit([(0.0, 0.0), (100.0, 0.0)], [(0.0, 5.0), (50.0, 5.0)]).plan_view
    parts = cut_curves(plan, np.array([0.0, 20.0, 30.0]), np.array([50.0, 80.0, 100.0]), [1, 0, 0])
    assert parts.start.tolist() == [0, 1, 2, 3]
    assert parts.s.tolist() == [0.0, 0.0, 0.0]
    assert parts.x == pytest.approx([0.0, 20.0, 30.0], abs=1e-12)
    assert parts.y == pytest.approx([5.0, 0.0, 0.0], abs=1e-12)
    assert parts.length == pytest.approx([50.0, 60.0, 70.0], abs=1e-12)


def test_cuts_next_to_a_border_of_records_move_onto_it() -> None:
    points = np.array([(-50.0, 0.0), (0.0, 0.0), (0.0, 50.0)])
    plan = fit_polylines(points, np.array([0, 3]), np.array([3.0]), fixed=np.ones(3, bool)).plan_view
    cuts = np.array([0.004, 46.995, 47.006, 47.2, 30.0])
    snapped = snap_cuts(plan, np.zeros(5, np.int64), cuts)
    assert snapped == pytest.approx([0.0, 47.0, 47.0, 47.2, 30.0], abs=1e-9)


def test_no_line_between_two_arcs_is_too_short_to_count() -> None:
    """Corners of 25 degrees and more wish for tangents that leave almost nothing of the segment between them."""
    for between in np.linspace(3.0, 12.0, 181).tolist():
        turn = math.radians(40.0)
        x, y = 30.0 + between * math.cos(turn), between * math.sin(turn)
        line = [(0.0, 0.0), (30.0, 0.0), (x, y), (x + 20 * math.cos(2 * turn), y + 20 * math.sin(2 * turn))]
        plan = fit(line).plan_view
        assert_smooth(plan, 0)
        assert plan.length.min() > 0.01


@settings(max_examples=60, deadline=None)
@given(streets(), st.sampled_from([4.0, 6.0, 15.0, 100.0]))
def test_no_record_is_shorter_than_a_centimetre(line: Points, radius: float) -> None:
    assert fit(line, radius=radius).plan_view.length.min() > 0.0099
