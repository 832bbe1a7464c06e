"""Records from knots."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.geometry.heights import Pins
from osm2xodr.geometry.heights.records import (
    Knots,
    add_pins,
    hermite_records,
    only_curves,
    short_numbers,
    thin_records,
)


def test_cubic_of_two_knots() -> None:
    profile = hermite_records(
        Knots(np.array([0, 2]), np.array([0.0, 2.0]), np.array([1.0, 5.0]), np.array([0.0, 3.0]))
    )
    # 1 + c s² + d s³ with value 5 and slope 3 at 2.
    assert [profile.a[0], profile.b[0], profile.c[0], profile.d[0]] == pytest.approx([1.0, 0.0, 1.5, -0.25])


def test_one_cubic_stands_for_all_knots_of_itself() -> None:
    s = np.linspace(0.0, 90.0, 19)
    z, g = 3.0 + 0.02 * s - 1e-4 * s**2 + 1e-6 * s**3, 0.02 - 2e-4 * s + 3e-6 * s**2
    profile = thin_records(Knots(np.array([0, 19]), s, z, g))
    assert profile.start.tolist() == [0, 1]
    assert [profile.a[0], profile.b[0], profile.c[0], profile.d[0]] == pytest.approx(
        [3.0, 0.02, -1e-4, 1e-6], rel=1e-6
    )


def test_curves_stay_apart() -> None:
    s = np.array([0.0, 10.0, 20.0, 0.0, 5.0])
    profile = thin_records(Knots(np.array([0, 3, 5]), s, 2.0 * s, np.full(5, 2.0)))
    assert profile.start.tolist() == [0, 1, 2]
    assert profile.s.tolist() == [0.0, 0.0]


def test_knots_that_pairs_cannot_spare_go_in_the_next_round() -> None:
    # The first and the last third are cubics of their own; dyadic pairs straddle the places where they meet.
    s = np.arange(0.0, 191.0, 10.0)
    z = np.where(s < 60, 0.0, np.where(s < 130, 1e-3 * (s - 60) ** 2, 4.9 + 0.14 * (s - 130)))
    g = np.where(s < 60, 0.0, np.where(s < 130, 2e-3 * (s - 60), 0.14))
    profile = thin_records(Knots(np.array([0, 20]), s, z, g))
    assert profile.s.tolist() == [0.0, 60.0, 130.0]


def test_records_have_few_digits_and_stay_continuous() -> None:
    s = np.array([0.0, 100 / 3, 70.123456])
    z, g = np.array([1.123456789, 2.123456789, -1.0]), np.array([0.0123456789, -0.0123456789, 0.0])
    profile = thin_records(Knots(np.array([0, 3]), s, z, g))
    assert profile.s.tolist() == [0.0, 33.333]
    assert profile.a.tolist() == [1.123456789, 2.12346]
    assert profile.b.tolist() == [0.0123456789, -0.012346]
    h = 33.333
    assert profile.a[0] + h * (profile.b[0] + h * (profile.c[0] + h * profile.d[0])) == pytest.approx(
        2.12346, abs=1e-12
    )
    assert cubic_value(profile, np.array([0]), s[2:]) == pytest.approx([-1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("height", "slope", "records"), [(0.012, 0.0, 1), (0.018, 0.0, 2), (0.0, 8e-4, 1), (0.0, 1.2e-3, 2)]
)
def test_records_may_miss_knots_by_the_tolerances(height: float, slope: float, records: int) -> None:
    knots = Knots(np.array([0, 3]), np.array([0.0, 10.0, 20.0]), height * np.eye(3)[1], slope * np.eye(3)[1])
    assert len(thin_records(knots).s) == records


def test_no_curves() -> None:
    none = np.zeros(0)
    assert thin_records(Knots(np.array([0]), none, none, none)).start.tolist() == [0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.integers(2, 12), min_size=1, max_size=5), st.integers(0, 10_000), st.floats(0.0, 0.02))
def test_all_knots_are_fitted_and_kept_ones_are_exact(counts: list[int], seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    start = np.r_[0, np.cumsum(counts)]
    curve = np.repeat(np.arange(len(counts)), counts)
    s = np.concatenate([np.r_[0.0, np.cumsum(rng.uniform(0.3, 30.0, n - 1))] for n in counts])
    z = 1e-4 * s**2 + size * rng.standard_normal(len(s))
    g = 2e-4 * s + 0.1 * size * rng.standard_normal(len(s))
    profile = thin_records(Knots(start, s, z, g))
    assert (np.diff(profile.start) >= 1).all()
    assert np.abs(cubic_value(profile, curve, s) - z).max() <= 0.015 + 1e-4
    owner = np.repeat(np.arange(len(counts)), np.diff(profile.start))
    inner = np.flatnonzero(np.diff(owner) == 0)
    h = profile.s[inner + 1] - profile.s[inner]
    value = profile.a[inner] + h * (profile.b[inner] + h * (profile.c[inner] + h * profile.d[inner]))
    slope = profile.b[inner] + h * (2 * profile.c[inner] + 3 * h * profile.d[inner])
    assert value == pytest.approx(profile.a[inner + 1], abs=1e-9)
    assert slope == pytest.approx(profile.b[inner + 1], abs=1e-9)
    last = start[1:] - 1
    assert cubic_value(profile, curve[last], s[last]) == pytest.approx(z[last], abs=1e-9)
    assert cubic_slope(profile, curve[last], s[last]) == pytest.approx(g[last], abs=1e-9)


# ---------------------------------------------------------------- pins


def _slope_and_parabola() -> Knots:
    """Return three curves: two straight ones of 20 m around a parabola of 30 m, with knots every 10 m."""
    s = np.array([0.0, 10.0, 20.0, 0.0, 10.0, 20.0, 30.0, 0.0, 10.0, 20.0])
    curve = np.repeat([0, 1, 2], [3, 4, 3])
    value = np.where(curve == 1, 0.01 * s**2, 5.0 + 0.1 * s)
    slope = np.where(curve == 1, 0.02 * s, 0.1)
    return Knots(np.array([0, 3, 7, 10]), s, value, slope)


def _pins(*rows: tuple[int, float, float, float]) -> Pins:
    road, s, z, grade = zip(*rows, strict=True)
    return Pins(np.array(road), np.array(s), np.array(z), np.array(grade))


def test_pins_are_knots_with_what_they_give_or_what_was_there() -> None:
    """Given out of order, one with height and grade, one with either, one with neither."""
    none = np.nan
    pins = _pins((1, 25.0, 6.5, none), (1, 5.0, none, none), (2, 4.0, 1.0, -0.2), (1, 15.0, none, 0.4))
    knots, new = add_pins(_slope_and_parabola(), pins)
    assert knots.start.tolist() == [0, 3, 10, 14]
    assert knots.s.tolist() == [0.0, 10.0, 20.0, 0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 0.0, 4.0, 10.0, 20.0]
    assert new.tolist() == [s in (5.0, 15.0, 25.0, 4.0) for s in knots.s.tolist()]
    assert knots.value[:3] == pytest.approx([5.0, 6.0, 7.0])
    assert knots.value[3:10] == pytest.approx([0.0, 0.25, 1.0, 2.25, 4.0, 6.5, 9.0])
    assert knots.slope[3:10] == pytest.approx([0.0, 0.1, 0.2, 0.4, 0.4, 0.5, 0.6])
    assert knots.value[10:] == pytest.approx([5.0, 1.0, 6.0, 7.0])
    assert knots.slope[10:] == pytest.approx([0.1, -0.2, 0.1, 0.1])


@pytest.mark.parametrize(("off", "stays"), [(-0.11, True), (-0.09, False), (0.0, False), (0.09, False), (0.11, True)])
def test_a_knot_within_a_tenth_of_a_metre_makes_way_for_a_pin(off: float, stays: bool) -> None:
    knots, new = add_pins(_slope_and_parabola(), _pins((1, 10.0 + off, 1.5, 0.3)))
    assert sorted({10.0, 10.0 + off} if stays else {10.0 + off}) == knots.s[4 : 6 if stays else 5].tolist()
    # Knots at the same place on other roads, and all others of its own, are as they were.
    assert (knots.s == 10.0).sum() == 2 + (stays or off == 0.0)
    assert np.diff(knots.start).tolist() == [3, 5 if stays else 4, 3]
    assert knots.value[new].tolist() == [1.5]
    assert knots.slope[new].tolist() == [0.3]


def test_ends_of_curves_stay_beside_a_pin() -> None:
    knots, new = add_pins(_slope_and_parabola(), _pins((1, 0.05, 0.2, 0.0), (1, 29.95, 8.0, 0.0)))
    assert knots.s[3:9].tolist() == [0.0, 0.05, 10.0, 20.0, 29.95, 30.0]
    assert np.flatnonzero(new).tolist() == [4, 7]


def test_knots_that_are_held_stay_where_one_cubic_would_do() -> None:
    s = np.linspace(0.0, 40.0, 5)
    knots = Knots(np.array([0, 5]), s, 0.1 * s, np.full(5, 0.1))
    assert thin_records(knots).s.tolist() == [0.0]
    assert thin_records(knots, held=s == 30.0).s.tolist() == [0.0, 30.0]


def test_only_the_wanted_curves_keep_records() -> None:
    profile = hermite_records(_slope_and_parabola())
    found = only_curves(profile, np.array([False, True, False]))
    assert found.start.tolist() == [0, 0, 3, 3]
    for name in ("s", "a", "b", "c", "d"):
        assert getattr(found, name).tolist() == getattr(profile, name)[2:5].tolist()
    assert only_curves(profile, np.array([True, False, True])).s.tolist() == [0.0, 10.0, 0.0, 10.0]


@pytest.mark.parametrize(("before", "after"), [(0.009, 5.0), (5.0, 0.009), (0.011, 0.011)])
def test_places_are_rounded_where_neighbours_are_a_centimetre_away(before: float, after: float) -> None:
    place = 10.0004
    s = np.array([0.0, place - before, place, place + after, 20.0])
    found = short_numbers(Knots(np.array([0, 5]), s, 0.5 * s, np.full(5, 0.5)))
    assert found.s[2] == (10.0 if min(before, after) > 0.01 else place)
    # A knot that moves along the road moves along its tangent.
    assert found.value[2] == pytest.approx(0.5 * found.s[2], abs=5.1e-6)
    assert found.value[[0, 4]].tolist() == [0.0, 10.0]


@pytest.mark.parametrize(("value", "slope", "records"), [(0.1, 1.0, 1), (0.01, 1.0, 2), (0.1, 1e-3, 2)])
def test_tolerances_are_those_that_are_asked_for(value: float, slope: float, records: int) -> None:
    s = np.linspace(0.0, 20.0, 5)
    knots = Knots(np.array([0, 5]), s, 0.05 * np.eye(5)[2], 0.01 * np.array([0.0, 1.0, 0.0, -1.0, 0.0]))
    assert (len(thin_records(knots, value, slope).s) > 1) == (records > 1)


def test_even_knots_go_where_odd_ones_cannot() -> None:
    """Straight from 10 to 30 m, and a kink at either end of that: only the knot at 20 m can be spared."""
    s, z, g = np.linspace(0.0, 40.0, 5), np.array([0.0, 0.0, 1.0, 2.0, 2.0]), np.array([0.0, 0.1, 0.1, 0.1, 0.0])
    assert thin_records(Knots(np.array([0, 5]), s, z, g)).s.tolist() == [0.0, 10.0, 30.0]
