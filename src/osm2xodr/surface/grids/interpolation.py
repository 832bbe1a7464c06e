"""Heights between the cells of a grid without voids, in fractional columns and rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.model import BoolArray, FloatArray

Cells = npt.NDArray[np.float32] | npt.NDArray[np.float64]
Interpolator = Callable[[FloatArray, FloatArray], FloatArray]
Indices = npt.NDArray[np.intp]
# Weights below this are rounding errors.
_NO_WEIGHT: Final = 1e-6


def empty_cells(rows: int, cols: int, single: bool) -> Cells:
    """Return a grid of voids, in single or double precision."""
    if single:
        return np.full((rows, cols), np.nan, np.float32)
    return np.full((rows, cols), np.nan, np.float64)


def _corners(
    shape: tuple[int, ...], col: FloatArray, row: FloatArray
) -> tuple[Indices, int, int, FloatArray, FloatArray]:
    """Return the flat index of the cell before each position, the steps to the next column and row, the fractions.

    Positions must lie on the grid. A step is 0 where the grid has a single row or column.
    """
    rows, cols = shape
    col0 = np.clip(col.astype(np.intp), 0, max(cols - 2, 0))
    row0 = np.clip(row.astype(np.intp), 0, max(rows - 2, 0))
    return row0 * cols + col0, int(cols > 1), cols * int(rows > 1), col - col0, row - row0


def _bilinear(z: Cells, col: FloatArray, row: FloatArray) -> FloatArray:
    """Return z (rows, cols) between its cells, as a spline of degree 1, but several times as fast."""
    first, right, down, u, v = _corners(z.shape, col, row)
    flat = z.reshape(-1)
    top = flat[first] * (1.0 - u)
    top += flat[first + right] * u
    first += down
    bottom = flat[first] * (1.0 - u)
    bottom += flat[first + right] * u
    out: FloatArray = top + v * (bottom - top)
    return out


def all_corners(known: BoolArray, col: FloatArray, row: FloatArray) -> BoolArray:
    """Return where every cell that takes part in bilinear interpolation is known."""
    first, right, down, u, v = _corners(known.shape, col, row)
    flat = known.reshape(-1)
    # A cell of weight 0 takes no part, also after rounding errors of the projection.
    on_col, on_row = u < _NO_WEIGHT, v < _NO_WEIGHT
    off_col, off_row = u > 1.0 - _NO_WEIGHT, v > 1.0 - _NO_WEIGHT
    out: BoolArray = flat[first] | off_col | off_row
    out &= flat[first + right] | on_col | off_row
    out &= flat[first + down] | off_col | on_row
    out &= flat[first + down + right] | on_col | on_row
    return out


def nearest_known(known: BoolArray, col: FloatArray, row: FloatArray) -> BoolArray:
    """Return where the cell that the position lies in is known."""
    return known.reshape(-1)[_nearest_index(known.shape, col, row)]


def make_interpolator(z: Cells, method: str) -> Interpolator:
    """Return the function from col, row to heights between the cells of z (rows, cols).

    `method` is ``"nearest"``, ``"bilinear"``, or ``"bicubic"``: SciPy's bivariate spline of degree 3 through all
    cells (less where the grid has fewer than four rows or columns), C2.
    """
    if method == "nearest":
        return lambda col, row: z.reshape(-1)[_nearest_index(z.shape, col, row)].astype(np.float64)
    if method == "bicubic" and min(z.shape) > 1:
        # Takes a tenth of a second to load.
        from scipy.interpolate import RectBivariateSpline

        rows, cols = z.shape
        spline = RectBivariateSpline(
            np.arange(rows, dtype=np.float64),
            np.arange(cols, dtype=np.float64),
            z.astype(np.float64, copy=False),
            kx=min(3, rows - 1),
            ky=min(3, cols - 1),
        )
        return lambda col, row: np.asarray(spline.ev(row, col), np.float64)
    return lambda col, row: _bilinear(z, col, row)


def _nearest_index(shape: tuple[int, ...], col: FloatArray, row: FloatArray) -> Indices:
    """Return the flat index of the nearest cell; half-way positions belong to the next one."""
    rows, cols = shape
    near_col = np.clip(np.floor(col + 0.5).astype(np.intp), 0, cols - 1)
    near_row = np.clip(np.floor(row + 0.5).astype(np.intp), 0, rows - 1)
    out: Indices = near_row * cols + near_col
    return out
