"""Few cubics through samples of short curves."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.geometry.heights.spline_fit import _basis, fit_records
from osm2xodr.model import CubicProfile, FloatArray

# Mutation tests change the code in copies of a process that has fitted curves already.
os.register_at_fork(after_in_child=_basis.cache_clear)


def fit(length: float, value: FloatArray, slope: tuple[float, float], tolerance: float = 0.01) -> CubicProfile:
    """Fit one curve."""
    start = np.array([0, len(value)])
    return fit_records(start, np.array([length]), value, np.array([slope]), np.array([tolerance]))


def test_a_cubic_is_one_record() -> None:
    s = np.linspace(0.0, 12.0, 9)
    profile = fit(12.0, 700.0 + 0.05 * s - 2e-3 * s**2 + 1e-4 * s**3, (0.05, 0.05 - 0.048 + 0.0432))
    assert [profile.s[0], profile.a[0], profile.b[0], profile.c[0], profile.d[0]] == pytest.approx(
        [0.0, 700.0, 0.05, -2e-3, 1e-4], abs=1e-12
    )
    assert len(profile.s) == 1


def test_a_bump_is_two_records() -> None:
    # Two cubics from 0 with slope 0 up to 0.1 half-way and down again.
    u = np.linspace(0.0, 1.0, 9)
    w = 1 - np.abs(2 * u - 1)
    profile = fit(16.0, 0.1 * (3 * w**2 - 2 * w**3), (0.0, 0.0))
    assert profile.s.tolist() == [0.0, 8.0]
    assert profile.a.tolist() == pytest.approx([0.0, 0.1], abs=1e-9)
    assert profile.b.tolist() == pytest.approx([0.0, 0.0], abs=1e-9)


def test_tolerance_is_that_of_the_curve() -> None:
    u = np.linspace(0.0, 1.0, 17)
    value = np.tile(0.1 * np.sin(2 * np.pi * u) ** 2, 2)
    start = np.array([0, 17, 34])
    profile = fit_records(start, np.full(2, 20.0), value, np.zeros((2, 2)), np.array([0.2, 0.01]))
    assert profile.start.tolist()[1] == 1
    assert profile.start.tolist()[2] > 3
    curve, s = np.repeat([0, 1], 17), np.tile(20.0 * u, 2)
    error = np.abs(cubic_value(profile, curve, s) - value).reshape(2, -1).max(axis=1)
    assert error[0] == pytest.approx(0.1, abs=1e-9)
    assert error[1] <= 0.01


def test_what_fits_nowhere_has_a_knot_at_every_other_sample() -> None:
    profile = fit(40.0, np.array([0.0, 1.0, -1.0] * 6 + [0.0]), (0.0, 0.0), 1e-6)
    assert profile.s.tolist() == pytest.approx(np.linspace(0.0, 40.0, 10)[:-1].round(3).tolist(), abs=1e-9)


def test_what_would_be_too_steep_has_a_knot_at_each_sample() -> None:
    # A step of 0.5 m within 2 m: few cubics rise more steeply.
    value = np.array([0.0] * 6 + [0.25] + [0.5] * 6)
    start, length = np.array([0, 13]), np.array([24.0])
    s = np.linspace(0.0, 24.0, 481)
    steep = {}
    for limit in (1.0, 0.16):
        profile = fit_records(start, length, value, np.zeros((1, 2)), np.array([0.2]), np.array([limit]))
        steep[limit] = len(profile.s), np.abs(cubic_slope(profile, np.zeros(481, np.int64), s)).max()
    assert steep[1.0][0] < 6
    assert steep[1.0][1] < 0.25
    none = fit_records(start, length, value, np.zeros((1, 2)), np.array([0.2]), np.array([0.01]))
    assert len(none.s) == 12
    assert np.abs(cubic_slope(none, np.zeros(481, np.int64), s)).max() == pytest.approx(0.1458, abs=1e-3)


def test_no_curves() -> None:
    none = np.zeros(0)
    assert fit_records(np.array([0]), none, none, np.zeros((0, 2)), none).start.tolist() == [0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 9), min_size=1, max_size=6), st.integers(0, 10_000), st.floats(0.0, 0.3))
def test_ends_are_exact_and_cubics_join(quarters: list[int], seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    counts = 4 * np.array(quarters) + 1
    start = np.r_[0, np.cumsum(counts)]
    length = rng.uniform(0.1, 80.0, len(counts))
    value = 500.0 + size * rng.standard_normal(int(start[-1]))
    slope = rng.uniform(-0.2, 0.2, (len(counts), 2))
    profile = fit_records(start, length, value, slope, np.full(len(counts), 0.01))
    every = np.arange(len(counts))
    assert cubic_value(profile, every, np.zeros(len(counts))) == pytest.approx(value[start[:-1]], abs=1e-9)
    assert cubic_value(profile, every, length) == pytest.approx(value[start[1:] - 1], abs=1e-9)
    assert cubic_slope(profile, every, np.zeros(len(counts))) == pytest.approx(slope[:, 0], abs=1e-9)
    assert cubic_slope(profile, every, length) == pytest.approx(slope[:, 1], abs=1e-9)
    owner = np.repeat(every, np.diff(profile.start))
    inner = np.flatnonzero(np.diff(owner) == 0)
    h = profile.s[inner + 1] - profile.s[inner]
    ahead = profile.a[inner] + h * (profile.b[inner] + h * (profile.c[inner] + h * profile.d[inner]))
    steep = profile.b[inner] + h * (2 * profile.c[inner] + 3 * h * profile.d[inner])
    assert ahead == pytest.approx(profile.a[inner + 1], abs=1e-9)
    assert steep == pytest.approx(profile.b[inner + 1], abs=1e-9)


def test_a_curve_of_no_length_to_speak_of_stays_finite() -> None:
    profile = fit(1e-6, np.array([1.0, 1.5, 0.5, 1.5, 1.0]), (0.0, 0.0), 1e-9)
    assert np.isfinite(profile.c).all()
    assert (np.diff(profile.s) > 0).all()


def test_values_and_slopes_of_all_knots_are_interpolated_and_fitted() -> None:
    """A cubic of height and slope at 0, 1/4 and 1: its own knots come back, and its values at eighths of the way."""
    u = np.linspace(0.0, 1.0, 9)
    z, slope = 1.0 + 2.0 * u - 3.0 * u**2 + u**3, 2.0 - 6.0 * u + 3.0 * u**2
    values, slopes, inverse = _basis(8, (1 / 4,))
    ends, inner = np.array([z[0], slope[0], z[8], slope[8]]), np.array([z[2], slope[2]])
    assert values @ np.r_[ends, inner] == pytest.approx(z)
    half = np.linspace(0.0, 1.0, 17)
    assert slopes @ np.r_[ends, inner] == pytest.approx(2.0 - 6.0 * half + 3.0 * half**2)
    assert inverse @ (z - values[:, :4] @ ends) == pytest.approx(inner)


def test_each_curve_gets_as_few_records_as_it_needs() -> None:
    """Of curves with equally many samples one is a cubic, one has a bump; a third has more samples."""
    u, v = np.linspace(0.0, 1.0, 17), np.linspace(0.0, 1.0, 25)
    value = np.r_[0.05 * u**3, 0.1 * np.sin(2 * np.pi * u) ** 2, 7.0 + 0.0 * v]
    slope = np.array([[0.0, 0.15 / 20.0], [0.0, 0.0], [0.0, 0.0]])
    start, length = np.array([0, 17, 34, 59]), np.array([20.0, 30.0, 40.0])
    profile = fit_records(start, length, value, slope, np.full(3, 0.005))
    count = np.diff(profile.start)
    assert (count[0], count[2]) == (1, 1)
    assert 3 < count[1] < 8
    for k, (at, n) in enumerate(((u, 17), (v[:0], 0), (v, 25))):
        found = cubic_value(profile, np.full(n, k), length[k] * at)
        assert found == pytest.approx(value[start[k] : start[k] + n], abs=1e-9)
    error = cubic_value(profile, np.full(17, 1), 30.0 * u) - value[17:34]
    assert np.abs(error).max() <= 0.005


def test_a_curve_may_be_as_steep_as_it_is_allowed_to() -> None:
    """An S that one cubic draws is one and a half times as steep in its middle as on average, 0.075."""
    u = np.linspace(0.0, 1.0, 9)
    value, start, length = 3 * u**2 - 2 * u**3, np.array([0, 9]), np.array([20.0])
    for limit, records in ((0.0751, 1), (0.0749, 8)):
        profile = fit_records(start, length, value, np.zeros((1, 2)), np.array([0.01]), np.array([limit]))
        assert len(profile.s) == records


def test_four_samples_are_one_record() -> None:
    """There is no inner knot at every other one of three intervals."""
    assert fit(12.0, np.array([0.0, 0.5, -0.5, 0.0]), (0.0, 0.0), 1e-6).s.tolist() == [0.0]
    assert fit(12.0, np.array([0.0, 0.5, -0.5, 0.5, 0.0]), (0.0, 0.0), 1e-6).s.tolist() == [0.0, 6.0]
