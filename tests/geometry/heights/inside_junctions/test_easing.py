"""Connecting roads that would throw a car are drawn toward the smoothest profile."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from osm2xodr.geometry.heights.defaults import VERTICAL_ACCELERATION_MAX
from osm2xodr.geometry.heights.inside_junctions.easing import _smoothest, ease_profiles, largest_acceleration
from osm2xodr.model import FloatArray

START = np.array([0, 17], np.int64)
S = np.linspace(0.0, 24.0, 17)


def bump(height: float) -> tuple[FloatArray, FloatArray]:
    """Return a wave of two metres' length beside the start, and its slope."""
    wave = np.exp(-((S - 4.0) ** 2) / 8.0)
    return height * wave, -height * (S - 4.0) / 4.0 * wave


def test_gentle_profiles_stay_as_they_are() -> None:
    z, grade = bump(0.01)
    eased = ease_profiles(START, S, np.full(17, 10.0), z, grade, 0.3)
    assert eased[0].tolist() == z.tolist()
    assert eased[1].tolist() == grade.tolist()


def test_sharp_profiles_are_eased_as_far_as_they_need_and_keep_their_ends() -> None:
    z, grade = bump(0.08)
    z, grade = z + 0.02 * S, grade + 0.02
    speed = np.full(17, 12.0)
    before = largest_acceleration(START, S, speed, z, grade)
    eased = ease_profiles(START, S, speed, z, grade, 0.3)
    assert before[0] > VERTICAL_ACCELERATION_MAX
    assert largest_acceleration(START, S, speed, *eased)[0] <= VERTICAL_ACCELERATION_MAX
    for old, new in zip((z, grade), eased, strict=True):
        assert new[[0, -1]] == pytest.approx(old[[0, -1]], abs=1e-12)
    # It still shows some of the surface: not all of the way is gone.
    assert not np.allclose(eased[0], _smoothest(START, S, speed, z, grade)[0])


def test_smoothest_profile_at_one_speed_is_the_cubic() -> None:
    z, grade = bump(0.0)
    z[-1], grade[0], grade[-1] = 0.5, 0.04, -0.01
    u = S / 24.0
    want = 24.0 * 0.04 * (u - 2 * u**2 + u**3) + 0.5 * (3 * u**2 - 2 * u**3) - 24.0 * 0.01 * (u**3 - u**2)
    assert _smoothest(START, S, np.full(17, 9.0), z, grade)[0] == pytest.approx(want, abs=1e-12)


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-1.0, 1.0))
def test_smoothest_profile_bends_where_cars_are_slow(g0: float, g1: float, rise: float) -> None:
    z, grade = np.zeros(17), np.zeros(17)
    z[-1], grade[0], grade[-1] = rise, g0, g1
    speed = np.where(S < 8.0, 20.0, 6.0)
    plain, slow = (
        largest_acceleration(START, S, speed, *_smoothest(START, S, v, z, grade)) for v in (0 * S + 9, speed)
    )
    assert slow[0] <= plain[0] + 1e-9


def test_steeper_profiles_are_not_taken() -> None:
    # All the bend would fall into a slow end, which would then be too steep.
    z, grade = bump(0.2)
    z[-1] = 6.0
    grade[-1] = 0.25
    eased = ease_profiles(START, S, np.full(17, 14.0), z, grade, 0.1)
    assert np.abs(eased[1]).max() <= max(0.1, np.abs(grade).max()) + 1e-12


def test_acceleration_at_a_sample_is_that_of_the_mean_curvature_of_both_sides() -> None:
    # z'' is 0.02 up to 2 m and 0.06 from there on.
    start, s = np.array([0, 3], np.int64), np.array([0.0, 2.0, 4.0])
    z, grade = np.array([0.0, 0.04, 0.24]), np.array([0.0, 0.04, 0.16])
    for speed, most in (((10.0, 1.0, 1.0), 2.0), ((1.0, 10.0, 1.0), 4.0), ((1.0, 1.0, 10.0), 6.0)):
        assert largest_acceleration(start, s, np.array(speed), z, grade) == pytest.approx([most])
