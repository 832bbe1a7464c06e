"""Few cubics for many short curves: least-squares splines of as few pieces as a tolerance allows.

Connecting roads are some ten metres long and curved in height everywhere. Cubics through exact values at chosen
places need twice as many records for them as cubics that may pass every place within a centimetre.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np

from osm2xodr.curves import solve_dense
from osm2xodr.geometry.heights.elements import hermite, hermite_slope
from osm2xodr.geometry.heights.records import Knots, thin_records
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
# What is below these is no difference: values, m or rad, and slopes, per m.
_SAME_VALUE: Final = 1e-4
_SAME_SLOPE: Final = 1e-5
# Shortest piece of a trial, in intervals of samples, which is 1 but for rounding.
_SHORTEST_PIECE: Final = 0.999


@lru_cache(maxsize=1024)
def _basis(intervals: int, inner: tuple[float, ...], ratio: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how knots give values and slopes, and how both give inner knots by least squares.

    Knots have a value and a slope per length of the curve. The first two matrices give values and slopes at equal
    intervals; their 4 + 2 inner columns have both ends first. The third is (2 inner, 2 intervals + 2); `ratio` is the
    weight of slopes beside values.
    """
    values, slopes = _interpolations(intervals, inner)
    weighted = np.vstack([values[:, 4:], ratio * slopes[:, 4:]])
    inverse = solve_dense(np.einsum("ki,kj->ij", weighted, weighted), weighted.T)
    return values, slopes, inverse * np.repeat([1.0, ratio], intervals + 1)


@lru_cache(maxsize=4096)
def _interpolations(intervals: int, inner: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the matrices from values and slopes of knots to values and to slopes at equal intervals."""
    knots = np.array([0.0, *inner, 1.0])
    u = np.linspace(0.0, 1.0, intervals + 1)
    return _interpolation(knots, u, hermite), _interpolation(knots, u, hermite_slope)


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
    slope_tolerance: float,
) -> CubicProfile:
    """Return few cubics that pass all samples within tolerances and are continuous in value and slope.

    Where no choice of a few knots does, there is a knot at each sample. The samples of a curve, from `start`,
    (curves + 1,), on, lie at equal intervals over its length, (curves,), m, at least four of them, and have a value
    and a slope per m, both (samples,). Those at both ends are met exactly. `tolerance`, (curves,), is the largest
    distance of a value, `slope_tolerance` that of a slope, per m.
    """
    intervals = np.diff(start) - 1
    pieces = np.zeros(len(length), np.int64)
    found: list[tuple[IntArray, FloatArray, FloatArray, FloatArray]] = []
    for n in np.unique(intervals).tolist():
        group = np.flatnonzero(intervals == n)
        at = start[group][:, None] + np.arange(n + 1)
        long = length[group, None]
        for curve, inner, knots in _fit_group(value[at], slope[at] * long, tolerance[group], slope_tolerance * long):
            curve, u = group[curve], np.array([0.0, *inner, 1.0])
            pieces[curve] = len(u) - 1
            found.append((curve, length[curve, None] * u, knots[:, 0::2], knots[:, 1::2] / length[curve, None]))
    first = np.concatenate([[0], np.cumsum(pieces + 1)]).astype(np.int64)
    s, z, g = np.zeros((3, int(first[-1])))
    for curve, knot_s, height, grade in found:
        place = first[curve][:, None] + np.arange(knot_s.shape[1])
        s[place], z[place], g[place] = knot_s, height, grade
    # Of records that continue one another, as on ramps of superelevation, one is enough.
    return thin_records(Knots(first, s, z, g), _SAME_VALUE, _SAME_SLOPE)


def _fit_group(
    value: FloatArray, slope: FloatArray, tolerance: FloatArray, slope_tolerance: FloatArray
) -> list[tuple[IntArray, tuple[float, ...], FloatArray]]:
    """Fit curves of equally many samples, with values and slopes per length of the curve, (n, samples).

    Returns for each trial that fits some of them: these curves, the inner knots, value and slope at all knots.
    """
    intervals = value.shape[1] - 1
    base = value[:, :1]
    ends = np.column_stack([np.zeros(len(value)), slope[:, 0], value[:, -1] - base[:, 0], slope[:, -1]])
    left = np.arange(len(value))
    ratio = float(np.median(tolerance / slope_tolerance[:, 0])) if len(value) else 0.0
    out = []
    for trial in (trial for trial in _TRIALS if _is_coarse(trial, intervals)):
        if not len(left):
            break
        values, slopes, inverse = _basis(intervals, trial, ratio)
        rest = value[left] - base[left] - ends[left] @ values[:, :4].T
        rest_slope = slope[left] - ends[left] @ slopes[:, :4].T
        inner = np.hstack([rest, rest_slope]) @ inverse.T
        misfit = np.abs(rest - inner @ values[:, 4:].T).max(axis=1)
        misfit_slope = np.abs(rest_slope - inner @ slopes[:, 4:].T).max(axis=1)
        good = (misfit <= tolerance[left]) & (misfit_slope <= slope_tolerance[left, 0])
        # Knots between samples are free to swing where there are hardly more samples than knots.
        steepest = np.abs(slope[left]).max(axis=1) + slope_tolerance[left, 0]
        good &= np.abs(inner[:, 1::2]).max(axis=1, initial=0.0) <= steepest
        knots = np.hstack([ends[left, :2], inner, ends[left, 2:]])[good]
        knots[:, 0::2] += base[left[good]]
        out.append((left[good], trial, knots))
        left = left[~good]
    if len(left):
        knots = np.stack([value[left], slope[left]], axis=2).reshape(len(left), -1)
        out.append((left, tuple(k / intervals for k in range(1, intervals)), knots))
    return out


def _is_coarse(inner: tuple[float, ...], intervals: int) -> bool:
    """Say whether no piece is shorter than an interval: samples would not determine it."""
    return len(inner) + 1 < intervals and min(np.diff([0.0, *inner, 1.0])) * intervals > _SHORTEST_PIECE
