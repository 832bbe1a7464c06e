"""Records from knots."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.geometry.heights.records import Knots, hermite_records, thin_records


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
