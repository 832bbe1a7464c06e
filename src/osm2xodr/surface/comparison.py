"""How well interpolations and polynomials predict heights that they were not given.

Every other row and column of a grid is kept, and the cells between are predicted from them and compared with their
true heights. Cells are then twice as far apart as in the grid, so that errors are larger than those of a road; they
show which method is better, and by how much. Polynomials have far fewer terms than there are cells and are compared
with the very heights that they are fitted to.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.surface.grids import Cells, all_corners, fill_voids, fit_polynomial, make_interpolator, term_count

_INTERPOLATIONS: Final = ("nearest", "bilinear", "bicubic")
_ORDERS: Final = (2, 3, 4, 5)  # Total degrees of polynomials


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A part of a grid of heights."""

    # Its first cell in the grid
    first_col: int
    first_row: int
    z: Cells  # (rows, cols) Heights, m; NaN in voids


@dataclass(frozen=True, slots=True, eq=False)
class MethodResult:
    """The errors of one method to find heights."""

    name: str  # The interpolation, or the order of the polynomial
    count: int  # Number of cells that were predicted
    # Mean, root mean square, 95th percentile and maximum of the errors (the last two of their magnitude), predicted
    # minus true, m
    bias: float
    rms: float
    p95: float
    maximum: float
    grade_rms: float  # Root mean square of the error of the grade from cell to cell, rise per metre
    seconds: float  # Computing time
    errors: tuple[FloatArray, ...]  # (rows, cols) of each patch, m; NaN where nothing was predicted


@dataclass(frozen=True, slots=True, eq=False)
class GridComparison:
    """The errors of all methods on one grid."""

    patches: tuple[Patch, ...]
    steps: tuple[float, float]  # Length of one column and of one row, m
    # Polynomials of high order are left out where there are too few cells
    interpolations: tuple[MethodResult, ...]
    polynomials: tuple[MethodResult, ...]


def compare_grid(patches: Sequence[Patch], steps: tuple[float, float]) -> GridComparison:
    """Compare interpolations and polynomials on patches of one grid.

    There is at least one patch, each with three or more rows and columns and some heights; `steps` are the lengths of
    one column and of one row, m.
    """
    heights = sum(int(np.count_nonzero(np.isfinite(patch.z))) for patch in patches)
    return GridComparison(
        tuple(patches),
        steps,
        tuple(_leave_out(method, patches, steps) for method in _INTERPOLATIONS),
        tuple(_fit(order, patches, steps) for order in _ORDERS if heights >= 2 * term_count(order)),
    )


def _leave_out(method: str, patches: Sequence[Patch], steps: tuple[float, float]) -> MethodResult:
    """Predict the cells between every other row and column."""
    errors, seconds = [], 0.0
    for patch in patches:
        kept = np.ascontiguousarray(patch.z[::2, ::2])
        known = np.isfinite(kept)
        error = np.full(patch.z.shape, np.nan)
        errors.append(error)
        if not known.any():
            continue
        below = partial(_level, float(np.mean(kept[known])))
        filled = fill_voids(kept, below, (2.0 * steps[0], 2.0 * steps[1]), np.inf)
        # Cells beyond the last row and column kept are not predicted.
        rows, cols = 2 * kept.shape[0] - 1, 2 * kept.shape[1] - 1
        row, col = (place.reshape(-1) for place in np.mgrid[:rows, :cols])
        between = (row % 2 == 1) | (col % 2 == 1)
        at_row, at_col = 0.5 * row[between], 0.5 * col[between]
        began = time.perf_counter()
        predicted = make_interpolator(filled, method)(at_col, at_row)
        seconds += time.perf_counter() - began
        fair = all_corners(known, at_col, at_row)
        target = row[between][fair], col[between][fair]
        error[target] = predicted[fair] - patch.z[target]
    return _result(method, patches, errors, seconds, steps)


def _level(height: float, col: FloatArray, row: FloatArray) -> FloatArray:
    """Return one height at all positions."""
    return np.full(len(col), height)


def _fit(order: int, patches: Sequence[Patch], steps: tuple[float, float]) -> MethodResult:
    """Fit a polynomial to all patches."""
    parts = []
    for patch in patches:
        row, col = np.nonzero(np.isfinite(patch.z))
        x, y = (col + patch.first_col) * steps[0], (row + patch.first_row) * steps[1]
        parts.append((x, y, patch.z[row, col].astype(np.float64)))
    x, y, z = (np.concatenate(values) for values in zip(*parts, strict=True))
    began = time.perf_counter()
    trend = fit_polynomial(x, y, z, order)
    seconds = time.perf_counter() - began
    errors = []
    for patch in patches:
        rows, cols = patch.z.shape
        at_x = (np.arange(cols) + patch.first_col) * steps[0]
        at_y = (np.arange(rows) + patch.first_row) * steps[1]
        errors.append(trend.on_grid(at_x, at_y) - patch.z)
    return _result(str(order), patches, errors, seconds, steps)


def _result(
    name: str, patches: Sequence[Patch], errors: Sequence[FloatArray], seconds: float, steps: tuple[float, float]
) -> MethodResult:
    """Summarise errors (rows, cols) of each patch."""
    every = np.concatenate([error[np.isfinite(error)] for error in errors])
    grades = []
    for patch, error in zip(patches, errors, strict=True):
        # Cells that were not predicted have no error, unless they are voids.
        known = np.isfinite(patch.z)
        full = np.where(np.isfinite(error) | ~known, error, 0.0)
        for axis, step in ((1, steps[0]), (0, steps[1])):
            grade = np.diff(full, axis=axis) / step
            grades.append(grade[np.isfinite(grade)])
    size = np.abs(every)
    return MethodResult(
        name,
        len(every),
        float(np.mean(every)) if len(every) else 0.0,
        _rms(every),
        float(np.percentile(size, 95.0)) if len(every) else 0.0,
        float(size.max()) if len(every) else 0.0,
        _rms(np.concatenate(grades)),
        seconds,
        tuple(errors),
    )


def _rms(values: FloatArray) -> float:
    """Return the root mean square, 0 of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
