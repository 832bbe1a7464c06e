"""Few cubics for many short curves: least-squares splines of as few pieces as a tolerance allows.

Connecting roads are some ten metres long and curved in height everywhere. Cubics through exact values at chosen
places need twice as many records for them as cubics that may pass every place within a centimetre.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np

from osm2xodr.geometry.heights.elements import hermite, hermite_slope
from osm2xodr.geometry.heights.records import Knots, hermite_records, short_numbers
from osm2xodr.model import CubicProfile, FloatArray, IntArray

# Inner knots that are tried, as shares of the length, fewest first.
_TRIALS: Final = (
    (), (1 / 2,), (1 / 3,), (2 / 3,), (1 / 3, 2 / 3), (1 / 4, 3 / 4), (1 / 6, 5 / 6), (1 / 4, 1 / 2), (1 / 2, 3 / 4),
    (1 / 4, 1 / 2, 3 / 4), (1 / 6, 1 / 3, 2 / 3), (1 / 3, 2 / 3, 5 / 6),
    (1 / 5, 2 / 5, 3 / 5, 4 / 5), (1 / 8, 1 / 4, 3 / 4, 7 / 8), (1 / 12, 1 / 6, 1 / 4, 1 / 2),
    (1 / 2, 3 / 4, 5 / 6, 11 / 12), (1 / 6, 1 / 3, 1 / 2, 2 / 3, 5 / 6),
    (1 / 12, 1 / 6, 1 / 3, 2 / 3, 5 / 6, 11 / 12),
    tuple(k / 8 for k in range(1, 8)), tuple(k / 12 for k in range(1, 12)),
)  # fmt: skip
# Samples per piece of the spline that is taken where no trial fits.
_SAMPLES_PER_PIECE: Final = 2


@lru_cache(maxsize=1024)
def _basis(intervals: int, inner: tuple[float, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how knots give values and slopes, and how values give inner knots by least squares.

    Knots have a value and a slope per length of the curve. The first matrix gives values at equal intervals, the
    second slopes at these and half-way between them; their 4 + 2 inner columns have both ends first. The third is
    (2 inner, intervals + 1).
    """
    knots = np.array([0.0, *inner, 1.0])
    values = _interpolation(knots, np.linspace(0.0, 1.0, intervals + 1), hermite)
    slopes = _interpolation(knots, np.linspace(0.0, 1.0, 2 * intervals + 1), hermite_slope)
    return values, slopes, np.linalg.pinv(values[:, 4:])


def _interpolation(
    knots: FloatArray, u: FloatArray, weights: Callable[[FloatArray, FloatArray], FloatArray]
) -> FloatArray:
    """Return the matrix from the values and slopes of knots to places, the columns of both ends first."""
    piece = np.clip(np.searchsorted(knots, u, side="right") - 1, 0, len(knots) - 2)
    h = np.diff(knots)[piece]
    matrix = np.zeros((len(u), 2 * len(knots)))
    matrix[np.arange(len(u))[:, None], 2 * piece[:, None] + np.arange(4)] = weights((u - knots[piece]) / h, h)
    return np.hstack([matrix[:, [0, 1, -2, -1]], matrix[:, 2:-2]])


def fit_records(
    start: IntArray,
    length: FloatArray,
    value: FloatArray,
    slope: FloatArray,
    tolerance: FloatArray,
    steepest: FloatArray | None = None,
) -> CubicProfile:
    """Return few cubics that pass all samples within a tolerance and are continuous in value and slope.

    Where no choice of a few knots does, there is a knot at every other sample, or, for the slope's sake, at each. The
    samples of a curve, from `start`, (curves + 1,), on, lie at equal intervals over its length, (curves,), m, at
    least four of them. The values, (samples,), at both ends and the slopes there, (curves, 2), per m, are met
    exactly. `tolerance`, (curves,), is the largest distance of a sample, `steepest`, (curves,), the largest slope,
    per m, of curves that do not have a knot at each sample.
    """
    intervals = np.diff(start) - 1
    pieces = np.zeros(len(length), np.int64)
    found: list[tuple[IntArray, FloatArray, FloatArray, FloatArray]] = []
    for n in np.unique(intervals).tolist():
        group = np.flatnonzero(intervals == n)
        samples = value[start[group][:, None] + np.arange(n + 1)]
        limit = np.full(len(group), np.inf) if steepest is None else steepest[group] * length[group]
        for curve, inner, knots in _fit_group(samples, slope[group] * length[group, None], tolerance[group], limit):
            curve, at = group[curve], np.array([0.0, *inner, 1.0])
            pieces[curve] = len(at) - 1
            found.append((curve, length[curve, None] * at, knots[:, 0::2], knots[:, 1::2] / length[curve, None]))
    first = np.concatenate([[0], np.cumsum(pieces + 1)]).astype(np.int64)
    s, z, g = np.zeros((3, int(first[-1])))
    for curve, at, height, grade in found:
        place = first[curve][:, None] + np.arange(at.shape[1])
        s[place], z[place], g[place] = at, height, grade
    return hermite_records(short_numbers(Knots(first, s, z, g)))


def _fit_group(
    samples: FloatArray, slope: FloatArray, tolerance: FloatArray, steepest: FloatArray
) -> list[tuple[IntArray, tuple[float, ...], FloatArray]]:
    """Fit curves of equally many samples, (n, samples).

    Returns for each trial that fits some of them: these curves, the inner knots, value and slope at all knots.
    """
    intervals = samples.shape[1] - 1
    last, each = (tuple(k / n for k in range(1, n)) for n in (max(1, intervals // _SAMPLES_PER_PIECE), intervals))
    trials = [trial for trial in _TRIALS if len(trial) < len(last)] + [last]
    base = samples[:, :1]
    ends = np.column_stack([np.zeros(len(samples)), slope[:, 0], samples[:, -1] - base[:, 0], slope[:, 1]])
    left = np.arange(len(samples))
    out = []
    for trial in trials:
        if not len(left):
            break
        values, slopes, inverse = _basis(intervals, trial)
        rest = samples[left] - base[left] - ends[left] @ values[:, :4].T
        inner = rest @ inverse.T
        misfit = np.abs(rest - inner @ values[:, 4:].T).max(axis=1)
        steep = np.abs(np.hstack([ends[left], inner]) @ slopes.T).max(axis=1)
        good = ((misfit <= tolerance[left]) | (trial is last)) & (steep <= steepest[left])
        knots = np.hstack([ends[left, :2], inner, ends[left, 2:]])[good]
        knots[:, 0::2] += base[left[good]]
        out.append((left[good], trial, knots))
        left = left[~good]
    if len(left):
        out.append((left, each, _through_all(samples[left], slope[left])))
    return out


def _through_all(samples: FloatArray, slope: FloatArray) -> FloatArray:
    """Return value and slope at all samples of curves, (n, 2 samples): inner slopes are those of the neighbours."""
    knots = np.empty((len(samples), 2 * samples.shape[1]))
    knots[:, 0::2] = samples
    knots[:, 3:-1:2] = (samples[:, 2:] - samples[:, :-2]) * (samples.shape[1] - 1) / 2
    knots[:, [1, -1]] = slope
    return knots
