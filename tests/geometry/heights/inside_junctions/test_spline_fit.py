"""Few cubics through samples of short curves."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.geometry.heights.inside_junctions.spline_fit import _basis, fit_records
from osm2xodr.model import CubicProfile, FloatArray

# Mutation tests change the code in copies of a process that has fitted curves already.
os.register_at_fork(after_in_child=_basis.cache_clear)


def fit(
    length: float, value: FloatArray, slope: FloatArray, tolerance: float = 0.01, slope_tolerance: float = 0.01
) -> CubicProfile:
    """Fit one curve."""
    start = np.array([0, len(value)])
    return fit_records(start, np.array([length]), value, slope, np.array([tolerance]), slope_tolerance)


def test_a_cubic_is_one_record() -> None:
    s = np.linspace(0.0, 12.0, 9)
    profile = fit(12.0, 700.0 + 0.05 * s - 2e-3 * s**2 + 1e-4 * s**3, 0.05 - 4e-3 * s + 3e-4 * s**2)
    assert [profile.s[0], profile.a[0], profile.b[0], profile.c[0], profile.d[0]] == pytest.approx(
        [0.0, 700.0, 0.05, -2e-3, 1e-4], abs=1e-12
    )
    assert len(profile.s) == 1


def bump(samples: int, length: float) -> tuple[FloatArray, FloatArray]:
    """Return heights and slopes of two cubics from 0 with slope 0 up to 0.1 half-way and down again."""
    u = np.linspace(0.0, 1.0, samples)
    w = 1 - np.abs(2 * u - 1)
    return 0.1 * (3 * w**2 - 2 * w**3), 0.6 * (w - w**2) * np.where(u < 0.5, 2.0, -2.0) / length


def test_a_bump_is_two_records() -> None:
    profile = fit(16.0, *bump(9, 16.0))
    assert profile.s.tolist() == [0.0, 8.0]
    assert profile.a.tolist() == pytest.approx([0.0, 0.1], abs=1e-9)
    assert profile.b.tolist() == pytest.approx([0.0, 0.0], abs=1e-9)


def test_tolerance_is_that_of_the_curve() -> None:
    value, slope = (np.tile(part, 2) for part in bump(17, 20.0))
    start = np.array([0, 17, 34])
    profile = fit_records(start, np.full(2, 20.0), value, slope, np.array([0.2, 0.01]), 0.1)
    assert np.diff(profile.start).tolist() == [1, 2]


def test_heights_within_tolerance_are_not_enough() -> None:
    # A ripple of 4 mm over 4 m: level for the eye, 0.6 % up and down for a wheel.
    s = np.linspace(0.0, 32.0, 33)
    value, slope = 0.004 * np.sin(np.pi * s / 2), 0.002 * np.pi * np.cos(np.pi * s / 2)
    every, at = np.zeros(33, np.int64), s
    followed = fit(32.0, value, slope, 0.01, 0.002)
    assert cubic_slope(followed, every, at) == pytest.approx(slope, abs=0.00201)
    smooth = fit(32.0, value, slope, 0.01, 0.02)
    assert len(smooth.s) <= len(followed.s) / 4


def test_what_fits_nowhere_has_a_knot_at_each_sample() -> None:
    value = np.array([0.0, 1.0, -1.0] * 6 + [0.0])
    slope = np.tile([0.5, -0.5], 10)[:19]
    profile = fit(36.0, value, slope, 1e-6, 1e-6)
    assert profile.s.tolist() == pytest.approx(np.arange(0.0, 36.0, 2.0).tolist())
    assert profile.a.tolist() == pytest.approx(value[:-1].tolist())
    assert profile.b.tolist() == pytest.approx(slope[:-1].tolist())


@pytest.mark.parametrize("samples", [9, 13, 17])
def test_no_piece_is_shorter_than_the_distance_of_samples(samples: int) -> None:
    # A steep end: knots close to it would follow the samples and swing between them.
    s = np.linspace(0.0, 16.0, samples)
    value, slope = 0.3 * np.exp(-s), -0.3 * np.exp(-s)
    profile = fit(16.0, value, slope, 0.002, 0.002)
    assert np.diff([*profile.s.tolist(), 16.0]).min() > 16.0 / (samples - 1) - 1e-3
    dense = np.linspace(0.0, 16.0, 400)
    assert np.abs(cubic_slope(profile, np.zeros(400, np.int64), dense)).max() < 0.31


@pytest.mark.parametrize("seed", range(12))
def test_knots_between_samples_do_not_swing(seed: int) -> None:
    """Twelve pieces over sixteen intervals: hardly any sample lies within a piece."""
    random = np.random.default_rng(seed)
    step = 0.024 * np.sign(random.normal(size=16)) * random.random(16) ** 0.3
    value = np.concatenate([[0.0], np.cumsum(step)])
    slope = np.concatenate([[0.0], (value[2:] - value[:-2]) / 4.0, [0.0]])
    profile = fit(32.0, value, slope, 0.007, 0.002)
    dense = np.linspace(0.0, 32.0, 400)
    # Samples change by 0.012 per metre at most; a cubic between two of them is up to 1.5 times as steep.
    assert np.abs(cubic_slope(profile, np.zeros(400, np.int64), dense)).max() < 0.018


def test_records_that_continue_one_another_are_one() -> None:
    """A trapezoid: its corners fit no spline of few pieces, but its sides are straight."""
    s = np.linspace(0.0, 40.0, 21)
    value = np.minimum(0.01 * np.minimum(s, 40.0 - s), 0.1)
    slope = np.where((s > 0.0) & (s < 10.0), 0.01, np.where((s > 30.0) & (s < 40.0), -0.01, 0.0))
    profile = fit(40.0, value, slope, 1e-4, 1e-4)
    assert profile.s.tolist() == pytest.approx([0.0, 2.0, 8.0, 10.0, 30.0, 32.0, 38.0])


def test_no_curves() -> None:
    none = np.zeros(0)
    assert fit_records(np.array([0]), none, none, none, none, 0.1).start.tolist() == [0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 9), min_size=1, max_size=6), st.integers(0, 10_000), st.floats(0.0, 0.3))
def test_ends_are_exact_and_cubics_join(quarters: list[int], seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    counts = 4 * np.array(quarters) + 1
    start = np.r_[0, np.cumsum(counts)]
    length = rng.uniform(0.1, 80.0, len(counts))
    value = 500.0 + size * rng.standard_normal(int(start[-1]))
    slope = rng.uniform(-0.2, 0.2, int(start[-1]))
    profile = fit_records(start, length, value, slope, np.full(len(counts), 0.01), 0.01)
    every = np.arange(len(counts))
    assert cubic_value(profile, every, np.zeros(len(counts))) == pytest.approx(value[start[:-1]], abs=1e-9)
    assert cubic_value(profile, every, length) == pytest.approx(value[start[1:] - 1], abs=1e-9)
    assert cubic_slope(profile, every, np.zeros(len(counts))) == pytest.approx(slope[start[:-1]], abs=1e-9)
    assert cubic_slope(profile, every, length) == pytest.approx(slope[start[1:] - 1], abs=1e-9)
    owner = np.repeat(every, np.diff(profile.start))
    inner = np.flatnonzero(np.diff(owner) == 0)
    h = profile.s[inner + 1] - profile.s[inner]
    ahead = profile.a[inner] + h * (profile.b[inner] + h * (profile.c[inner] + h * profile.d[inner]))
    steep = profile.b[inner] + h * (2 * profile.c[inner] + 3 * h * profile.d[inner])
    assert ahead == pytest.approx(profile.a[inner + 1], abs=1e-9)
    assert steep == pytest.approx(profile.b[inner + 1], abs=1e-9)


def test_a_curve_of_no_length_to_speak_of_stays_finite() -> None:
    profile = fit(1e-6, np.array([1.0, 1.5, 0.5, 1.5, 1.0]), np.zeros(5), 1e-9)
    assert np.isfinite(profile.c).all()
    assert (np.diff(profile.s) > 0).all()


@pytest.mark.parametrize("ratio", [0.1, 3.0])
def test_values_and_slopes_of_all_knots_are_interpolated_and_fitted(ratio: float) -> None:
    """A cubic of height and slope at 0, 1/4 and 1: its own knots come back, and its values at eighths of the way."""
    u = np.linspace(0.0, 1.0, 9)
    z, slope = 1.0 + 2.0 * u - 3.0 * u**2 + u**3, 2.0 - 6.0 * u + 3.0 * u**2
    values, slopes, inverse = _basis(8, (1 / 4,), ratio)
    ends, inner = np.array([z[0], slope[0], z[8], slope[8]]), np.array([z[2], slope[2]])
    assert values @ np.r_[ends, inner] == pytest.approx(z)
    assert slopes @ np.r_[ends, inner] == pytest.approx(slope)
    rest = np.r_[z - values[:, :4] @ ends, slope - slopes[:, :4] @ ends]
    assert inverse @ rest == pytest.approx(inner)


def test_slopes_weigh_as_the_tolerances_say() -> None:
    """Of heights that contradict the slopes, as of 0 with slopes of a bump, what weighs more is met better."""
    u = np.linspace(0.0, 1.0, 9)
    slope = np.sin(2 * np.pi * u)
    missed = []
    for ratio in (0.01, 10.0):
        _, slopes, inverse = _basis(8, (1 / 4, 3 / 4), ratio)
        missed.append(float(np.abs(slopes[:, 4:] @ (inverse @ np.r_[np.zeros(9), slope]) - slope).max()))
    assert missed[1] < 0.5 * missed[0]


def test_each_curve_gets_as_few_records_as_it_needs() -> None:
    """Of curves with equally many samples one is a cubic, one has a bump; a third has more samples."""
    u, v = np.linspace(0.0, 1.0, 17), np.linspace(0.0, 1.0, 25)
    value = np.r_[0.05 * u**3, 0.1 * np.sin(2 * np.pi * u) ** 2, 7.0 + 0.0 * v]
    slope = np.r_[0.15 * u**2 / 20.0, 0.2 * np.pi * np.sin(4 * np.pi * u) / 30.0, 0.0 * v]
    start, length = np.array([0, 17, 34, 59]), np.array([20.0, 30.0, 40.0])
    profile = fit_records(start, length, value, slope, np.full(3, 0.005), 0.003)
    count = np.diff(profile.start)
    assert (count[0], count[2]) == (1, 1)
    assert 3 < count[1] < 10
    for k, (at, n) in enumerate(((u, 17), (v[:0], 0), (v, 25))):
        found = cubic_value(profile, np.full(n, k), length[k] * at)
        assert found == pytest.approx(value[start[k] : start[k] + n], abs=1e-9)
    assert np.abs(cubic_value(profile, np.full(17, 1), 30.0 * u) - value[17:34]).max() <= 0.005
    assert np.abs(cubic_slope(profile, np.full(17, 1), 30.0 * u) - slope[17:34]).max() <= 0.00301


def test_four_samples_are_at_most_three_records() -> None:
    value = np.array([0.0, 0.5, 0.1, 0.0])
    assert fit(12.0, value, np.zeros(4), 1e-6).s.tolist() == [0.0, 4.0, 8.0]
    assert fit(12.0, 0.0 * value, np.zeros(4), 1e-6).s.tolist() == [0.0]
