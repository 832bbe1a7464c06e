"""How far the heights of an elevation model are off, judged from the model itself."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.surface import defaults
from osm2xodr.surface.grids.interpolation import Cells

# Cells that are looked at; more would not change the answer.
_SAMPLES = 50_000
# What counts as flat, and how many flat cells make a median that can be trusted.
_FLAT = 0.05
_FLAT_MIN = 200
# From the median absolute deviation to a standard deviation, and from the residual against the mean of 3 x 3 cells to
# the noise itself, which is partly in that mean (the more the noise of neighbours is alike: 1.06 if not at all).
_MAD = 1.4826
_HIGH_PASS = 1.2


def usual_sigma(cell_size: float) -> float:
    """Return the standard error that elevation models of a cell size (m) usually have, m."""
    sizes, sigmas = np.array(defaults.DEM_SIGMA).T
    return float(np.exp(np.interp(np.log(max(cell_size, 1e-3)), np.log(sizes), np.log(sigmas))))


def estimate_sigma(z: Cells, steps: tuple[float, float], quantum: float) -> float:
    """Estimate the standard error of an elevation model's heights, m.

    The larger of what is usual for the cell size and of 1.2 times the scatter of heights about the mean of their
    3 x 3 neighbourhood in flat places, with the error of rounding to whole units added (its variance: quantum² / 12).

    Parameters
    ----------
    z : (rows, cols)
        Heights, m, NaN in voids.
    steps
        Length of one column and of one row, m.
    quantum
        Step between possible heights, m; 0 for a continuous model.
    """
    usual = usual_sigma(float(np.sqrt(steps[0] * steps[1])))
    residual = _flat_residuals(z, steps)
    scatter = 0.0
    if len(residual) >= _FLAT_MIN:
        scatter = _HIGH_PASS * _MAD * float(np.median(np.abs(residual - np.median(residual))))
    return float(np.hypot(max(usual, scatter), quantum / np.sqrt(12.0)))


def quantum_of(z: Cells, unit: float) -> float:
    """Return the unit (m) if all heights are whole multiples of it, else 0."""
    sample = z.reshape(-1)[:: max(1, z.size // _SAMPLES)].astype(np.float64) / unit
    sample = sample[np.isfinite(sample)]
    whole = len(sample) > 0 and bool((np.abs(sample - np.round(sample)) < 1e-4).all())
    # A model of one height only says nothing about its rounding.
    return unit if whole and float(np.ptp(sample)) > 0.0 else 0.0


def _flat_residuals(z: Cells, steps: tuple[float, float]) -> FloatArray:
    """Return height minus mean of the 3 x 3 neighbourhood in flat places, m."""
    rows, cols = z.shape
    if rows < 3 or cols < 3:
        return np.zeros(0)
    inner = np.arange(0, (rows - 2) * (cols - 2), max(1, (rows - 2) * (cols - 2) // _SAMPLES))
    first = inner // (cols - 2) * cols + inner % (cols - 2)
    flat = z.reshape(-1)
    near = np.stack([flat[first + i * cols + j].astype(np.float64) for i in range(3) for j in range(3)])
    near = near[:, np.isfinite(near).all(axis=0)]
    across = (near[[2, 5, 8]].sum(axis=0) - near[[0, 3, 6]].sum(axis=0)) / (6.0 * steps[0])
    along = (near[[6, 7, 8]].sum(axis=0) - near[[0, 1, 2]].sum(axis=0)) / (6.0 * steps[1])
    is_flat = np.hypot(across, along) < _FLAT
    out: FloatArray = near[4, is_flat] - near[:, is_flat].mean(axis=0)
    return out
