"""The standard error of an elevation model's heights, estimated from the model itself."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import exp, hypot, log
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.surface.grids.interpolation import Cells

# Usual standard error of heights, m, by the size of cells, m, interpolated on logarithmic scales. Airborne laser 1 m:
# 0.1-0.15; national models of 5 to 10 m: 0.5-1; Copernicus GLO-30 and AW3D30: 2-3 (product handbooks and comparisons
# against geodetic points); SRTM at 3 arc seconds: 5-6.
_USUAL_SIGMA: Final = ((1.0, 0.12), (2.0, 0.15), (5.0, 0.5), (10.0, 1.0), (30.0, 2.0), (90.0, 5.0))
# Number of cells that are sampled; more would not change the result.
_SAMPLES: Final = 50_000
# Largest grade of flat cells, rise per metre, and least number of them for a reliable median.
_FLAT_GRADE: Final = 0.05
_FLAT_CELLS_MIN: Final = 200
# The standard deviation of a normal distribution in median absolute deviations (Hampel 1974).
MAD_TO_SIGMA: Final = 1.4826
# From the residual against the mean of 3 x 3 cells to the noise itself, which is partly in that mean: 1.06 for white
# noise, more if the noise of adjacent cells is correlated.
_HIGH_PASS: Final = 1.2
# By how much the variance of such residuals grows with twice the distance of the cells: not at all for white noise,
# by 2^(p - 2) for relief whose spectrum falls with the power p of the wave number. 3.5 is between banks and hills.
_RELIEF_GROWTH: Final = 2.0**1.5
# Heights are multiples of a unit if they differ from them by less than this, units.
_WHOLE: Final = 1e-4


def usual_sigma(cell_size: float) -> float:
    """Return the usual standard error of elevation models with a cell size (m), m."""
    sizes, sigmas = np.array(_USUAL_SIGMA).T
    return float(exp(np.interp(log(max(cell_size, 1e-3)), log(sizes), log(sigmas))))


def estimate_sigma(z: Cells, steps: tuple[float, float], quantum: float) -> float:
    """Estimate the standard error of an elevation model's heights z (rows, cols), m, NaN in voids.

    It is the larger of the usual one for the cell size and of the robust scatter (median absolute deviation) of
    heights about the mean of their 3 x 3 neighbourhood in flat places, plus the error of rounding (Sheppard: variance
    quantum² / 12). `steps` are the lengths of one column and of one row, `quantum` is the step between possible
    heights, 0 for a continuous model, m.
    """
    usual = usual_sigma(float(np.sqrt(steps[0] * steps[1])))
    near, far = _flat_residuals(z, steps)
    scatter = 0.0
    if len(near) >= _FLAT_CELLS_MIN:
        one, two = ((MAD_TO_SIGMA * float(np.median(np.abs(item - np.median(item))))) ** 2 for item in (near, far))
        white = (_RELIEF_GROWTH * one - two) / (_RELIEF_GROWTH - 1.0)
        scatter = _HIGH_PASS * float(np.sqrt(np.clip(white, 0.0, one)))
    return float(hypot(max(usual, scatter), quantum / np.sqrt(12.0)))


def quantum_of(z: Cells, unit: float) -> float:
    """Return the unit (m) if all heights are whole multiples of it, else 0."""
    sample = z.reshape(-1)[:: max(1, z.size // _SAMPLES)].astype(np.float64) / unit
    sample = sample[np.isfinite(sample)]
    whole = len(sample) > 0 and bool((np.abs(sample - np.round(sample)) < _WHOLE).all())
    # A single height says nothing about rounding.
    return unit if whole and float(np.ptp(sample)) > 0.0 else 0.0


def _flat_residuals(z: Cells, steps: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Return height minus mean of 3 x 3 heights in flat places, m: of neighbours, and of every other cell around."""
    rows, cols = z.shape
    if rows < 5 or cols < 5:
        return np.zeros(0), np.zeros(0)
    inner = np.arange(0, (rows - 4) * (cols - 4), max(1, (rows - 4) * (cols - 4) // _SAMPLES))
    middle = (inner // (cols - 4) + 2) * cols + inner % (cols - 4) + 2
    near = _around(z, middle, 1)
    across = (near[[2, 5, 8]].sum(axis=0) - near[[0, 3, 6]].sum(axis=0)) / (6.0 * steps[0])
    along = (near[[6, 7, 8]].sum(axis=0) - near[[0, 1, 2]].sum(axis=0)) / (6.0 * steps[1])
    # Where something is unknown the comparison is false.
    is_flat = hypot(across, along) < _FLAT_GRADE
    one, middle = near[4, is_flat] - near[:, is_flat].mean(axis=0), middle[is_flat]
    del near
    far = _around(z, middle, 2)
    other = far[4] - far.mean(axis=0)
    known = np.isfinite(other)
    return one[known], other[known]


def _around(z: Cells, middle: IntArray, distance: int) -> FloatArray:
    """Return the heights of cells, (n,), and of those around at a distance in cells, row by row, (9, n)."""
    flat, cols, steps = z.reshape(-1), z.shape[1], (-distance, 0, distance)
    return np.stack([flat[middle + i * cols + j].astype(np.float64) for i in steps for j in steps])
