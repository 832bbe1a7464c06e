"""Connecting roads that would throw a car at the speed that it drives there, drawn toward the smoothest way through.

The surface of a junction may bend within a few metres of an arm where cars still drive at the posted speed. Between
the heights and grades of its ends a connecting road has a profile with the least v² z''² in all, with the speed v: it
bends where cars are slow. Roads that bend too sharply go as far from the surface to that profile as they need to.
Formulas: docs/method/heights.md.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import sum_before
from osm2xodr.geometry.heights import defaults
from osm2xodr.model import FloatArray, IntArray

# Shares of the way from the surface to the smoothest profile that are tried, the least first.
_SHARES: Final = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
# Determinants below this share of their terms are 0: roads too short for two ends.
_SINGULAR: Final = 1e-12


def ease_profiles(
    start: IntArray, s: FloatArray, speed: FloatArray, z: FloatArray, grade: FloatArray, steepest: float
) -> tuple[FloatArray, FloatArray]:
    """Return heights, m, and grades at the samples of curves, (n,), of which none bends too sharply for its speed.

    Parameters
    ----------
    start : (curves + 1,)
        Index of each curve's first sample.
    s, speed, z, grade : (n,)
        Place, speed of cars, m/s, height, m, and grade at the samples. Those at both ends of a curve stay.
    steepest
        Grade above which no curve is changed to be steeper than it was.
    """
    if len(start) == 1:
        return z, grade
    curve = np.repeat(np.arange(len(start) - 1), np.diff(start))
    felt = largest_acceleration(start, s, speed, z, grade)
    rough = felt > defaults.VERTICAL_ACCELERATION_MAX
    if not rough.any():
        return z, grade
    smooth_z, smooth_grade = _smoothest(start, s, speed, z, grade)
    largest = np.maximum.reduceat(np.abs(grade), start[:-1])
    share = np.zeros(len(felt))
    left = rough & (np.maximum.reduceat(np.abs(smooth_grade), start[:-1]) <= np.maximum(largest, steepest))
    for part in _SHARES:
        tried = [value + part * (smooth - value) for value, smooth in ((z, smooth_z), (grade, smooth_grade))]
        now = largest_acceleration(start, s, speed, tried[0], tried[1])
        better = left & (now < felt)
        share[better], felt[better] = part, now[better]
        left &= felt > defaults.VERTICAL_ACCELERATION_MAX
    at = share[curve]
    return z + at * (smooth_z - z), grade + at * (smooth_grade - grade)


def largest_acceleration(
    start: IntArray, s: FloatArray, speed: FloatArray, z: FloatArray, grade: FloatArray
) -> FloatArray:
    """Return the largest v² |z''| of each curve's cubics between samples, m/s²."""
    a = np.setdiff1d(np.arange(len(s)), start[1:] - 1)
    h, secant = s[a + 1] - s[a], (z[a + 1] - z[a]) / (s[a + 1] - s[a])
    out = np.zeros(len(s))
    out[a] = speed[a] ** 2 * np.abs(6 * secant - 4 * grade[a] - 2 * grade[a + 1]) / h
    end = speed[a + 1] ** 2 * np.abs(6 * secant - 2 * grade[a] - 4 * grade[a + 1]) / h
    out[a] = np.maximum(out[a], end)
    return np.asarray(np.maximum.reduceat(out, start[:-1]))


def _smoothest(
    start: IntArray, s: FloatArray, speed: FloatArray, z: FloatArray, grade: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return heights and grades of the least integral of (v z'')² between the ends of curves.

    Its curvature is z'' = (a + b s) / v²: a and b follow from both ends.
    """
    first, last = start[:-1], start[1:] - 1
    counts = np.diff(start)
    share = (s / np.repeat(s[last], counts), np.repeat(np.min(speed), len(s)) / speed)
    parts = [_integrate(start, s, weight) for weight in (share[1] ** 2, share[0] * share[1] ** 2)]
    (g_a, z_a), (g_b, z_b) = parts
    want_g = grade[last] - grade[first]
    want_z = z[last] - z[first] - grade[first] * s[last]
    determinant = g_a[last] * z_b[last] - g_b[last] * z_a[last]
    size = np.abs(g_a[last] * z_b[last]) + np.abs(g_b[last] * z_a[last])
    good = np.abs(determinant) > _SINGULAR * size
    divisor = np.where(good, determinant, 1.0)
    a = (want_g * z_b[last] - want_z * g_b[last]) / divisor
    b = (want_z * g_a[last] - want_g * z_a[last]) / divisor
    a, b, keep = (np.repeat(value, counts) for value in (a, b, good))
    z0, g0 = np.repeat(z[first], counts), np.repeat(grade[first], counts)
    return np.where(keep, z0 + g0 * s + a * z_a + b * z_b, z), np.where(keep, g0 + a * g_a + b * g_b, grade)


def _integrate(start: IntArray, s: FloatArray, curvature: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return both integrals of curvatures that are linear between samples, 0 where curves begin."""
    h = np.diff(s, append=0.0)
    h[start[1:] - 1] = 0.0
    after = np.append(curvature[1:], 0.0)
    grade = sum_before(0.5 * h * (curvature + after), start)
    return grade, sum_before(h * grade + h * h * (2 * curvature + after) / 6, start)
