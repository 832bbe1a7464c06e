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
    most = np.maximum(np.maximum.reduceat(np.abs(grade), start[:-1]), steepest)
    best_z, best_grade = z.copy(), grade.copy()
    # Where bending in the slow part would be too steep, the least bending in all is what can be done.
    for weight in (speed, np.ones(len(s))):
        smooth_z, smooth_grade = _smoothest(start, s, weight, z, grade)
        left = felt > defaults.VERTICAL_ACCELERATION_MAX
        for part in _SHARES:
            tried = z + part * (smooth_z - z), grade + part * (smooth_grade - grade)
            now = largest_acceleration(start, s, speed, *tried)
            better = left & (now < felt) & (np.maximum.reduceat(np.abs(tried[1]), start[:-1]) <= most)
            felt[better] = now[better]
            at = better[curve]
            best_z[at], best_grade[at] = tried[0][at], tried[1][at]
            left &= felt > defaults.VERTICAL_ACCELERATION_MAX
    return best_z, best_grade


def largest_acceleration(
    start: IntArray, s: FloatArray, speed: FloatArray, z: FloatArray, grade: FloatArray
) -> FloatArray:
    """Return the largest v² |z''| of each curve, m/s²; between its ends z'' is the mean of both sides of a sample.

    That is what a car feels whose axles stand on either side.
    """
    a = np.setdiff1d(np.arange(len(s)), start[1:] - 1)
    h, secant = s[a + 1] - s[a], (z[a + 1] - z[a]) / (s[a + 1] - s[a])
    bend, sides = np.zeros((2, len(s)))
    bend[a] += (6 * secant - 4 * grade[a] - 2 * grade[a + 1]) / h
    bend[a + 1] += (2 * grade[a] + 4 * grade[a + 1] - 6 * secant) / h
    sides[a] += 1.0
    sides[a + 1] += 1.0
    return np.asarray(np.maximum.reduceat(speed**2 * np.abs(bend) / sides, start[:-1]))


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
