"""Lines and arcs against their closed formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from osm2xodr.curves.plan_views import (
    chosen_curves,
    curve_ends,
    heading_at,
    lengths,
    reverse_curves,
    smallest_radius,
    stack_plan_views,
)
from osm2xodr.curves.records import find_record, pose
from osm2xodr.curves.spirals import arc_step
from osm2xodr.model import PlanView


def line_arc_line() -> PlanView:
    """Make a line of 10 m to the east, a left quarter circle of 20 m radius, a line of 5 m north; and one line."""
    quarter = 20.0 * math.pi / 2
    return PlanView(
        np.array([0, 3, 4]),
        np.array([0.0, 10.0, 10.0 + quarter, 0.0]),
        np.array([0.0, 10.0, 30.0, 7.0]),
        np.array([0.0, 0.0, 20.0, 8.0]),
        np.array([0.0, 0.0, math.pi / 2, math.pi]),
        np.array([10.0, quarter, 5.0, 4.0]),
        np.array([0.0, 0.05, 0.0, 0.0]),
    )


def spirals() -> PlanView:
    """Make spirals of 60 m that begin at the origin, from curves of 30 m and 1000 m radius, and one behind a line."""
    start, rate = np.array([0, 1, 2, 4]), np.array([0.002, -0.0004, 0.0, 0.001])
    x, hdg, length = (
        np.array([0.0, 0.0, 0.0, 20.0]),
        np.array([0.3, -3.0, 0.0, 0.0]),
        np.array([60.0, 60.0, 20.0, 60.0]),
    )
    return PlanView(start, x.copy(), x, np.zeros(4), hdg, length, np.array([1 / 30, -1e-3, 0.0, 0.0]), rate)


@given(st.floats(-0.5, 0.5), st.floats(0.0, 200.0))
def test_a_step_along_an_arc_has_its_chord_and_turn(curvature: float, ds: float) -> None:
    u, v, turn = arc_step(np.array([curvature]), np.array([ds]))
    assert turn[0] == pytest.approx(curvature * ds, abs=1e-12)
    if abs(curvature) > 1e-4:
        assert u[0] == pytest.approx(math.sin(curvature * ds) / curvature, abs=1e-8)
        assert v[0] == pytest.approx((1 - math.cos(curvature * ds)) / curvature, abs=1e-8)
    else:
        assert u[0] == pytest.approx(ds, abs=1e-4 * ds + 1e-12)
        assert v[0] == pytest.approx(curvature * ds * ds / 2, abs=1e-4 * ds + 1e-12)


def test_a_step_along_a_line_is_exact() -> None:
    u, v, turn = arc_step(np.zeros(2), np.array([3.0, 0.0]))
    assert (u.tolist(), v.tolist(), turn.tolist()) == ([3.0, 0.0], [0.0, 0.0], [0.0, 0.0])


def test_poses_along_line_and_arc() -> None:
    plan = line_arc_line()
    quarter = 20.0 * math.pi / 2
    s = np.array([0.0, 4.0, 10.0, 10.0 + quarter / 2, 10.0 + quarter, 15.0 + quarter, 1.0])
    x, y, hdg = pose(plan, np.array([0, 0, 0, 0, 0, 0, 1]), s)
    half = math.sqrt(0.5)
    assert x == pytest.approx([0.0, 4.0, 10.0, 10.0 + 20.0 * half, 30.0, 30.0, 6.0], abs=1e-12)
    assert y == pytest.approx([0.0, 0.0, 0.0, 20.0 * (1 - half), 20.0, 25.0, 8.0], abs=1e-12)
    assert hdg == pytest.approx([0.0, 0.0, 0.0, math.pi / 4, math.pi / 2, math.pi / 2, math.pi], abs=1e-12)


def test_poses_beyond_the_ends_go_on_with_the_outermost_records() -> None:
    x, y, hdg = pose(line_arc_line(), np.array([0, 1]), np.array([-2.0, 10.0]))
    assert (x.tolist(), hdg.tolist()) == ([-2.0, -3.0], [0.0, math.pi])
    assert y == pytest.approx([0.0, 8.0], abs=1e-12)


def test_lengths_and_smallest_radii_of_curves() -> None:
    plan = line_arc_line()
    assert lengths(plan) == pytest.approx([15.0 + 10.0 * math.pi, 4.0])
    assert smallest_radius(plan).tolist() == [20.0, math.inf]


def test_lengths_of_no_curves() -> None:
    none = np.zeros(0)
    plan = PlanView(np.array([0]), none, none.copy(), none.copy(), none.copy(), none.copy(), none.copy())
    assert lengths(plan).tolist() == []


@given(st.lists(st.lists(st.floats(0.1, 10.0), min_size=1, max_size=40), min_size=1, max_size=4), st.data())
def test_records_are_found_where_they_hold(table: list[list[float]], data: st.DataObject) -> None:
    begins = [np.concatenate([[0.0], np.cumsum(row[:-1])]) for row in table]
    start = np.cumsum([0, *map(len, table)], dtype=np.int64)
    curve = data.draw(st.integers(0, len(table) - 1))
    s = data.draw(st.floats(-1.0, sum(table[curve]) + 1.0))
    (found,) = find_record(start, np.concatenate(begins), np.array([curve]), np.array([s])).tolist()
    held = [k for k, begin in enumerate(begins[curve]) if begin <= s]
    assert found == int(start[curve]) + (held[-1] if held else 0)


def test_records_of_many_places_are_those_of_single_ones() -> None:
    random = np.random.default_rng(7)
    count = random.integers(1, 9, 40)
    start = np.concatenate([[0], np.cumsum(count)])
    begins = np.concatenate([np.append(0.0, np.sort(random.integers(0, 50, n - 1))) for n in count])
    curve = random.integers(0, len(count), 500)
    s = random.integers(-5, 60, 500) / 1.0
    single = [int(find_record(start, begins, curve[k : k + 1], s[k : k + 1])[0]) for k in range(len(s))]
    assert find_record(start, begins, curve, s).tolist() == single


def test_stacked_tables_hold_the_curves_of_both() -> None:
    plan = line_arc_line()
    both = stack_plan_views(plan, plan)
    assert both.start.tolist() == [0, 3, 4, 7, 8]
    curve, s = np.array([0, 1]), np.array([20.0, 2.0])
    for one, other in zip(pose(plan, curve, s), pose(both, curve + 2, s), strict=True):
        assert one.tolist() == other.tolist()


def test_reversed_curves_pass_the_same_places() -> None:
    plan = line_arc_line()
    whole = lengths(plan)
    turned = reverse_curves(plan, np.array([True, False]))
    assert lengths(turned) == pytest.approx(whole)
    share = np.linspace(0.0, 1.0, 13)
    curve, s = np.repeat([0, 1], len(share)), np.concatenate([share * whole[0], share * whole[1]])
    back = curve == 0
    x, y, hdg = pose(plan, curve, np.where(back, whole[curve] - s, s))
    found_x, found_y, found_hdg = pose(turned, curve, s)
    assert found_x == pytest.approx(x, abs=1e-9)
    assert found_y == pytest.approx(y, abs=1e-9)
    assert np.cos(found_hdg - hdg) == pytest.approx(np.where(back, -1.0, 1.0))
    assert turned.s.tolist() == pytest.approx([0.0, 5.0, 5.0 + 10.0 * math.pi, 0.0])
    assert turned.curvature.tolist() == [0.0, -0.05, 0.0, 0.0]


def test_ends_of_curves_are_where_their_lines_and_arcs_begin_and_end() -> None:
    start, end = curve_ends(line_arc_line())
    assert [column.tolist() for column in start] == [[0.0, 7.0], [0.0, 8.0], [0.0, math.pi]]
    x, y, hdg = end
    assert (x.tolist(), y.tolist()) == (pytest.approx([30.0, 3.0]), pytest.approx([25.0, 8.0]))
    assert hdg == pytest.approx([math.pi / 2, math.pi])
    assert curve_ends(line_arc_line(), np.array([1]))[1][0].tolist() == x[1:].tolist()


@pytest.mark.parametrize("plan", [line_arc_line(), spirals()])
def test_ends_and_headings_are_those_of_poses_to_the_last_bit(plan: PlanView) -> None:
    every, length = np.arange(len(plan.start) - 1), lengths(plan)
    for share, found in zip((0.0, 1.0), curve_ends(plan), strict=True):
        for one, other in zip(found, pose(plan, every, share * length), strict=True):
            assert one.tolist() == other.tolist()
    curve, s = np.repeat(every, 7), (length[:, None] * np.linspace(0.0, 1.0, 7)).ravel()
    assert heading_at(plan, curve, s).tolist() == pose(plan, curve, s)[2].tolist()


def test_headings_on_a_spiral_are_the_integral_of_its_curvature() -> None:
    s = np.array([0.0, 20.0, 50.0, 80.0])
    assert heading_at(spirals(), np.full(4, 2), s) == pytest.approx([0.0, 0.0, 0.45, 1.8])
    assert heading_at(spirals(), np.array([0]), np.array([60.0])) == pytest.approx([0.3 + 2.0 + 3.6])


def test_chosen_curves_come_in_their_order_without_pieces_of_no_length() -> None:
    plan = line_arc_line()
    found = chosen_curves(plan, np.array([1, 0, 1]))
    assert found.start.tolist() == [0, 1, 4, 5]
    assert found.x.tolist() == [7.0, 0.0, 10.0, 30.0, 7.0]
    assert found.length == pytest.approx([4.0, 10.0, 10.0 * math.pi, 5.0, 4.0])
    tiny = PlanView(
        np.array([0, 2]), *np.array([[0.0, 3.0], [0.0, 3.0], [0.0, 0.0], [0.0, 0.0], [3.0, 1e-10], [0.0, 0.1]])
    )
    assert chosen_curves(tiny, np.array([0])).length.tolist() == [3.0]
