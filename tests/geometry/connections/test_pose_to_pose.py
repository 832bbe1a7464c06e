"""Curves from pose to pose: exact at both ends, as wide as can be, the same mirrored and driven backwards."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from road_measures import Pose, assert_smooth, curve_length, pose_at, records, smallest_radius_of

from osm2xodr.curves.plan_views import curves_of
from osm2xodr.defaults import MOST_SWING
from osm2xodr.geometry.connections.pose_to_pose import connect, detours, has_kinks, swings_out
from osm2xodr.model import PlanView

# An arc of less than 1e-4 rad is written as its chord, which is off by half of that at either end.
TURN = 5.1e-5


def joined(one: Pose, other: Pose) -> PlanView:
    return connect(*(np.array([value]) for value in (one.x, one.y, one.hdg, other.x, other.y, other.hdg)))


def poses(near: float = 0.0) -> st.SearchStrategy[tuple[Pose, Pose]]:
    place, hdg = st.floats(-60.0, 60.0), st.floats(-math.pi, math.pi)
    pairs = st.tuples(st.builds(Pose, place, place, hdg), st.builds(Pose, place, place, hdg))
    return pairs.filter(lambda pair: pair[0].gap(pair[1]) > max(near, 0.1) and not _behind(*pair))


def _behind(one: Pose, other: Pose) -> bool:
    """Whether a pose lies behind and looks the same way: only turns by more than `MOST_SWING` lead there."""
    ahead = (other.x - one.x) * math.cos(one.hdg) + (other.y - one.y) * math.sin(one.hdg)
    return one.turn(other) < 2 * math.pi - MOST_SWING and ahead < 1.0


def assert_joins(plan: PlanView, one: Pose, other: Pose, close: float = 1e-6) -> None:
    assert_smooth(plan, 0, close, 2 * TURN)
    first, last = pose_at(plan, 0, 0.0), pose_at(plan, 0, curve_length(plan, 0))
    assert first.gap(one) < 1e-9
    assert last.gap(other) < close
    assert first.turn(one) < TURN
    assert last.turn(other) < TURN


def test_straight_on_is_a_line() -> None:
    plan = joined(Pose(1.0, 2.0, 0.5), Pose(1.0, 2.0, 0.5).moved(20.0, 0.0))
    assert {curvature for _, _, _, curvature in records(plan, 0)} == {0.0}
    assert [pose.hdg for _, pose, _, _ in records(plan, 0)] == pytest.approx([0.5] * len(plan.s), abs=1e-12)
    assert curve_length(plan, 0) == pytest.approx(20.0, abs=1e-9)
    assert_joins(plan, Pose(1.0, 2.0, 0.5), Pose(1.0, 2.0, 0.5).moved(20.0, 0.0))


@pytest.mark.parametrize("degrees", [-120.0, -90.0, -30.0, 5.0, 45.0, 90.0, 140.0])
@pytest.mark.parametrize("radius", [3.0, 12.0, 400.0])
def test_a_pose_on_an_arc_is_reached_by_that_arc(degrees: float, radius: float) -> None:
    angle = math.radians(degrees)
    length = radius * abs(angle)
    one = Pose(5.0, -7.0, 1.1)
    plan = joined(one, one.moved(length, math.copysign(1 / radius, angle)))
    assert smallest_radius_of(plan, 0) == pytest.approx(radius, rel=1e-6)
    assert curve_length(plan, 0) == pytest.approx(length, rel=1e-6)
    assert_joins(plan, one, one.moved(length, math.copysign(1 / radius, angle)))


@pytest.mark.parametrize("line_first", [True, False])
def test_a_turn_at_a_crossing_is_a_line_and_the_widest_arc(line_first: bool) -> None:
    """Tangents of 12 m and 8 m to the corner: the arc takes the shorter one, the rest is a line."""
    before, after = (12.0, 8.0) if line_first else (8.0, 12.0)
    plan = joined(Pose(-before, 0.0, 0.0), Pose(0.0, after, math.pi / 2))
    lines = [length for _, _, length, curvature in records(plan, 0) if curvature == 0.0]
    arcs = [(length, curvature) for _, _, length, curvature in records(plan, 0) if curvature != 0.0]
    assert lines == pytest.approx([4.0], abs=1e-9)
    assert arcs == [pytest.approx((8.0 * math.pi / 2, 1 / 8.0), rel=1e-9)]
    assert (records(plan, 0)[0][3] == 0.0) == line_first


def test_a_u_turn_is_a_half_circle() -> None:
    plan = joined(Pose(0.0, 0.0, 0.0), Pose(0.0, 9.0, math.pi))
    assert curve_length(plan, 0) == pytest.approx(4.5 * math.pi, abs=1e-9)
    assert smallest_radius_of(plan, 0) == pytest.approx(4.5, abs=1e-9)
    assert_joins(plan, Pose(0.0, 0.0, 0.0), Pose(0.0, 9.0, math.pi))


@pytest.mark.parametrize("off", [0.0, 1e-3, -0.4])
def test_a_pose_that_looks_back_from_far_ahead_is_met(off: float) -> None:
    one, other = Pose(0.0, 0.0, 0.0), Pose(60.0, off, math.pi - 1e-6)
    assert_joins(joined(one, other), one, other)


@pytest.mark.parametrize(("off", "turn"), [(0.0, 0.0), (0.0, 1e-4), (0.0, -1e-3), (-0.01, 1e-4), (0.05, 1e-3)])
def test_a_pose_straight_behind_is_met_by_a_line(off: float, turn: float) -> None:
    """Two arcs would need a radius of kilometres: the nearer the headings, the larger."""
    plan = joined(Pose(0.0, 0.0, 0.0), Pose(-5.0, off, turn))
    assert records(plan, 0)[0][3] == 0.0
    end = pose_at(plan, 0, curve_length(plan, 0))
    assert (end.x, end.y) == pytest.approx((-5.0, off), abs=1e-9)
    assert curve_length(plan, 0) == pytest.approx(5.0, abs=1e-3)


@pytest.mark.parametrize("turn", [0.0, 1e-14, 1e-13])
def test_a_pose_behind_and_aside_in_the_same_heading_is_met_without_a_detour(turn: float) -> None:
    one = Pose(3.55, 4.997, -1.669)
    other = one.moved(-3.02, 0.0).beside(0.3)
    other = Pose(other.x, other.y, other.hdg + turn)
    plan = joined(one, other)
    assert_joins(plan, one, other)
    # Three arcs of 5 m that turn by a full circle in all, or more.
    assert curve_length(plan, 0) < 100.0


def test_a_lane_beside_is_reached_by_two_equal_arcs() -> None:
    """A shift by w over d turns twice by 2 atan(w / d); its radius is (d² + w²) / (4 w)."""
    plan = joined(Pose(0.0, 0.0, 0.0), Pose(40.0, 3.5, 0.0))
    found = [(length, curvature) for _, _, length, curvature in records(plan, 0)]
    radius = (40.0**2 + 3.5**2) / (4 * 3.5)
    length = radius * 2 * math.atan(3.5 / 40.0)
    assert found == [pytest.approx((length, 1 / radius), rel=1e-9), pytest.approx((length, -1 / radius), rel=1e-9)]


@settings(max_examples=300, deadline=None)
@given(poses())
def test_every_pose_is_joined_to_every_other(pair: tuple[Pose, Pose]) -> None:
    one, other = pair
    plan = joined(one, other)
    # Two arcs come down to a point where a pose is passed on the way to itself.
    assume(smallest_radius_of(plan, 0) > 0.05 and curve_length(plan, 0) < 1e4)
    assert_joins(plan, one, other)


@settings(max_examples=200, deadline=None)
@given(st.floats(6.0, 40.0), st.floats(6.0, 40.0), st.floats(-2.4, 2.4))
def test_simple_turns_have_the_radius_that_their_room_gives(before: float, after: float, turn: float) -> None:
    assume(abs(turn) > 0.01)
    one = Pose(0.0, 0.0, 0.0)
    corner = one.moved(before, 0.0)
    other = Pose(corner.x, corner.y, turn).moved(after, 0.0)
    plan = joined(one, other)
    assert smallest_radius_of(plan, 0) >= min(before, after) / math.tan(abs(turn) / 2) * (1 - 5e-3)
    assert_joins(plan, one, other)


@settings(max_examples=150, deadline=None)
@given(poses(near=1.0))
def test_mirrored_poses_have_mirrored_curves(pair: tuple[Pose, Pose]) -> None:
    one, other = pair
    assume(one.turn(other) < math.pi - 1e-3)
    plan = joined(one, other)
    mirrored = joined(Pose(one.x, -one.y, -one.hdg), Pose(other.x, -other.y, -other.hdg))
    assume(curve_length(plan, 0) < 1e4 and smallest_radius_of(plan, 0) > 0.05)
    assert curve_length(mirrored, 0) == pytest.approx(curve_length(plan, 0), abs=1e-6)
    for share in (0.2, 0.5, 0.8):
        s = share * curve_length(plan, 0)
        a, b = pose_at(plan, 0, s), pose_at(mirrored, 0, s)
        assert a.gap(Pose(b.x, -b.y, 0.0)) < 1e-5


@settings(max_examples=150, deadline=None)
@given(poses(near=1.0))
def test_curves_driven_backwards_are_the_same(pair: tuple[Pose, Pose]) -> None:
    one, other = pair
    assume(one.turn(other) < math.pi - 1e-3)
    plan, back = joined(one, other), joined(other.turned(), one.turned())
    length = curve_length(plan, 0)
    assume(length < 1e4 and smallest_radius_of(plan, 0) > 0.05)
    assert curve_length(back, 0) == pytest.approx(length, abs=1e-6)
    for share in (0.2, 0.5, 0.8):
        a, b = pose_at(plan, 0, share * length), pose_at(back, 0, (1 - share) * length)
        assert a.gap(b) < 1e-5


def test_many_at_once_are_each_alone() -> None:
    pairs = [
        (Pose(0.0, 0.0, 0.0), Pose(20.0, 0.0, 0.0)),
        (Pose(0.0, 0.0, 0.0), Pose(20.0, 10.0, math.pi / 2)),
        (Pose(3.0, 0.0, 2.0), Pose(20.0, 3.0, -1.0)),
    ]
    rows = np.array([(one.x, one.y, one.hdg, other.x, other.y, other.hdg) for one, other in pairs])
    plan = connect(*rows.T)
    for k, (one, other) in enumerate(pairs):
        assert records(plan, k) == records(joined(one, other), 0)


def test_a_turn_that_first_goes_the_other_way_swings_out() -> None:
    swinging = joined(Pose(0.0, 0.0, 0.0), Pose(10.0, 1.0, -math.pi / 3))
    plain = joined(Pose(0.0, 0.0, 0.0), Pose(10.0, -5.0, -math.pi / 3))
    aside = joined(Pose(0.0, 0.0, 0.0), Pose(20.0, 4.0, 0.0))
    assert [bool(swings_out(plan)[0]) for plan in (swinging, plain, aside)] == [True, False, False]


def test_curves_far_longer_than_what_they_bridge_are_detours() -> None:
    around = joined(Pose(0.0, 0.0, 0.0), Pose(-40.0, 0.5, 0.0))
    ahead = joined(Pose(0.0, 0.0, 0.0), Pose(40.0, 0.5, 0.0))
    assert [bool(detours(plan)[0]) for plan in (around, ahead)] == [True, False]


def test_kinks_are_seen_within_curves_only() -> None:
    """Two lines at 90 degrees are a kink in one curve, none where they are two curves."""
    five, none = np.array([5.0, 5.0]), np.zeros(2)
    rest = np.array([0.0, 5.0]), none, np.array([0.0, np.pi / 2]), five, none
    one = PlanView(np.array([0, 2]), np.array([0.0, 5.0]), *rest)
    two = PlanView(np.array([0, 1, 2]), none, *rest)
    assert has_kinks(one).tolist() == [True]
    assert has_kinks(two).tolist() == [False, False]
    around = joined(Pose(0.0, 0.0, 3.0), Pose(-9.0, 9.0, -3.0))
    assert has_kinks(around).tolist() == [False]


def curve(*rows: tuple[float, float]) -> PlanView:
    """Return a curve of (length, curvature), from the origin to the east."""
    length, curvature = np.array(rows).T
    return curves_of(np.zeros(1), np.zeros(1), np.zeros(1), length[None], curvature[None])


@pytest.mark.parametrize(("more", "detour"), [(-3.0, False), (3.0, True)])
@pytest.mark.parametrize("bridged", [0.0, 10.0, 30.0])
def test_a_detour_is_60_m_longer_than_four_times_what_it_bridges(bridged: float, more: float, detour: bool) -> None:
    """Ahead and straight back again."""
    length = 4 * bridged + 60.0 + more
    ahead = (length + bridged) / 2
    tables = np.array([0.0, ahead]), np.array([0.0, ahead]), np.zeros(2), np.array([0.0, np.pi])
    plan = PlanView(np.array([0, 2]), *tables, np.array([ahead, length - ahead]), np.zeros(2))
    assert detours(plan).tolist() == [detour]


@pytest.mark.parametrize(
    ("first", "second", "swings"),
    [(-0.2, 1.0, True), (-0.15, 1.0, False), (1.0, -0.2, True), (-0.2, 0.85, False), (-0.2, 0.95, True)],
)
def test_two_arcs_swing_beyond_40_degrees_forth_and_back_by_20(first: float, second: float, swings: bool) -> None:
    assert swings_out(curve((10.0, first / 10), (10.0, second / 10))).tolist() == [swings]


@pytest.mark.parametrize(("degrees", "simple"), [(147.0, True), (153.0, False)])
def test_turns_of_up_to_150_degrees_are_a_line_and_an_arc(degrees: float, simple: bool) -> None:
    corner = Pose(20.0, 0.0, math.radians(degrees))
    plan = joined(Pose(0.0, 0.0, 0.0), corner.moved(14.0, 0.0))
    assert (0.0 in {curvature for _, _, _, curvature in records(plan, 0)}) == simple
