"""Heights between the cells of a grid without voids, in fractional columns and rows."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
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

    `method` is ``"nearest"``, ``"bilinear"``, or ``"bicubic"``: the bivariate spline of degree 3 through all cells
    (less where the grid has fewer than four rows or columns), C2, with the same cubics on both sides of the outermost
    lines but one ("not a knot"; de Boor, A Practical Guide to Splines, IV and XVII).
    """
    if method == "nearest":
        return lambda col, row: z.reshape(-1)[_nearest_index(z.shape, col, row)].astype(np.float64)
    if method == "bicubic" and min(z.shape) > 1:
        factors = _spline_factors(_spline_factors(z.astype(np.float64)).T).T
        return partial(_spline, np.ascontiguousarray(factors), z.shape)
    return lambda col, row: _bilinear(z, col, row)


def _spline_factors(z: FloatArray) -> FloatArray:
    """Return the factors of B-splines, (n + 2, m), of the cubic splines through the values z, (n, m), of columns.

    Those of line k are the factors k to k + 2, of which the middle one has four times the weight of the others.
    """
    while len(z) < 4:
        # What goes on as a line or parabola has no other cubic.
        z = np.concatenate([z, [2.0 * z[1] - z[0] if len(z) == 2 else 3.0 * (z[2] - z[1]) + z[0]]])
    n = len(z)
    out = np.empty((n + 2, *z.shape[1:]))
    # One cubic over two steps has the second difference as its second derivative in the middle.
    out[2], out[n - 1] = ((8.0 * z[k] - z[k - 1] - z[k + 1]) / 6.0 for k in (1, n - 2))
    # Elimination from the top down, then the unknowns from the bottom up.
    share = np.zeros(n)
    for k in range(2, n - 2):
        share[k] = 1.0 / (4.0 - share[k - 1])
        out[k + 1] = (6.0 * z[k] - out[k]) * share[k]
    for k in range(n - 3, 1, -1):
        out[k + 1] -= share[k] * out[k + 2]
    out[1] = 6.0 * z[1] - 4.0 * out[2] - out[3]
    out[0] = 6.0 * z[0] - 4.0 * out[1] - out[2]
    out[n] = 6.0 * z[n - 2] - 4.0 * out[n - 1] - out[n - 2]
    out[n + 1] = 6.0 * z[n - 1] - 4.0 * out[n] - out[n - 1]
    return out


def _spline(factors: FloatArray, shape: tuple[int, ...], col: FloatArray, row: FloatArray) -> FloatArray:
    """Return a spline between the cells of a grid, from the factors of B-splines, (rows + 2, cols + 2)."""
    rows, cols = shape
    col0, row0 = np.clip(col.astype(np.intp), 0, cols - 2), np.clip(row.astype(np.intp), 0, rows - 2)
    across, down = _weights(col - col0), _weights(row - row0)
    flat, first = factors.reshape(-1), row0 * factors.shape[1] + col0
    out = np.zeros(len(col))
    for i in range(4):
        line = across[0] * flat[first]
        for j in range(1, 4):
            line += across[j] * flat[first + j]
        out += down[i] * line
        first += factors.shape[1]
    return out


def _weights(u: FloatArray) -> tuple[FloatArray, ...]:
    """Return the weights of the four B-splines at shares of a step."""
    v = 1.0 - u
    return v * v * v / 6.0, 2.0 / 3.0 - u * u * (1.0 - u / 2.0), 2.0 / 3.0 - v * v * (1.0 - v / 2.0), u * u * u / 6.0


def _nearest_index(shape: tuple[int, ...], col: FloatArray, row: FloatArray) -> Indices:
    """Return the flat index of the nearest cell; half-way positions belong to the next one."""
    rows, cols = shape
    near_col = np.clip(np.floor(col + 0.5).astype(np.intp), 0, cols - 1)
    near_row = np.clip(np.floor(row + 0.5).astype(np.intp), 0, rows - 1)
    out: Indices = near_row * cols + near_col
    return out
