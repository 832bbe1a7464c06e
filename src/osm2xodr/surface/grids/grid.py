"""Positions of a raster's cells in the local frame, and heights between cells without voids.

Columns and rows are fractional, with the centre of the first cell at (0, 0); the footprint of a cell reaches half a
cell around its centre. Rasters are never resampled; positions are transformed to them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt
from pyproj import CRS, Transformer

from osm2xodr.curves import hypot
from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.projection import transformer_from
from osm2xodr.system import record

Affine = tuple[float, float, float, float, float, float]

# Grids coincide if their cells are nowhere farther apart than this, cells: far below any effect on heights.
_SAME_CELL: Final = 1e-3

Cells = npt.NDArray[np.float32] | npt.NDArray[np.float64]
Interpolator = Callable[[FloatArray, FloatArray], FloatArray]
Indices = npt.NDArray[np.intp]
# Weights below this are rounding errors.
_NO_WEIGHT: Final = 1e-6


@record(eq=False)
class GridFrame:
    """The cells of a raster, or of a window of it."""

    crs: CRS  # Horizontal CRS of the raster
    to_crs: Transformer  # From local x, y (m) to x, y of the CRS in its own units
    # a, b, c, d, e, f with x = a col + b row + c and y = d col + e row + f of cell *corners*, as in GDAL (but in the
    # order of rows of a matrix). Any rotation, shear and direction of rows is allowed.
    affine: Affine
    rows: int
    cols: int

    def crs_positions(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x, y of the CRS at local x, y; infinite where the projection is undefined."""
        return _transform(self.to_crs, x, y, "FORWARD")

    def cells_at(self, px: FloatArray, py: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return fractional col, row at x, y of the CRS; NaN or infinite where these are."""
        a, b, c, d, e, f = self.affine
        det = a * e - b * d
        with np.errstate(invalid="ignore"):
            dx, dy = self._unwrapped(px) - c, py - f
            return (e * dx - b * dy) / det - 0.5, (a * dy - d * dx) / det - 0.5

    def cells(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return fractional col, row at local x, y."""
        return self.cells_at(*self.crs_positions(x, y))

    def positions(self, col: FloatArray, row: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return local x, y at fractional col, row."""
        return _transform(self.to_crs, *self.in_crs(col, row), "INVERSE")

    def in_crs(self, col: npt.ArrayLike, row: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return x, y of the CRS at fractional col, row."""
        a, b, c, d, e, f = self.affine
        u, v = np.asarray(col, np.float64) + 0.5, np.asarray(row, np.float64) + 0.5
        return a * u + b * v + c, d * u + e * v + f

    def lon_lat(self, col: npt.ArrayLike, row: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return longitude and latitude, degrees, WGS 84, at fractional col, row."""
        lon, lat = transformer_from(self.crs).transform(*self.in_crs(col, row))
        return lon, lat

    def steps(self) -> tuple[float, float]:
        """Return the length of one column and of one row at the middle of the grid, m."""
        col, row = 0.5 * (self.cols - 1), 0.5 * (self.rows - 1)
        x, y = self.positions(np.array([col - 0.5, col + 0.5, col, col]), np.array([row, row, row - 0.5, row + 0.5]))
        return float(hypot(x[1] - x[0], y[1] - y[0])), float(hypot(x[3] - x[2], y[3] - y[2]))

    def cell_size(self) -> float:
        """Return the geometric mean of the lengths of a column and a row at the middle of the grid, m."""
        return float(np.sqrt(np.prod(self.steps())))

    def rim(self, per_side: int = 17) -> tuple[FloatArray, FloatArray]:
        """Return col, row of points all along the outer edge of the grid's cells."""
        t = np.linspace(-0.5, 0.5, per_side)
        low, high = np.full(per_side, -0.5), np.full(per_side, 0.5)
        col = 0.5 * (self.cols - 1) + self.cols * np.concatenate([t, high, t, low])
        row = 0.5 * (self.rows - 1) + self.rows * np.concatenate([low, t, high, t])
        return col, row

    def window(self, first_col: int, first_row: int, cols: int, rows: int, block: int = 1) -> GridFrame:
        """Return the frame of a window of the grid, its cells joined to blocks of block x block."""
        a, b, c, d, e, f = self.affine
        x, y = a * first_col + b * first_row + c, d * first_col + e * first_row + f
        affine = (a * block, b * block, x, d * block, e * block, y)
        return replace(self, affine=affine, rows=rows // block, cols=cols // block)

    def offset_in(self, other: GridFrame) -> tuple[int, int] | None:
        """Return col, row of this grid's first cell in another grid, None if their cells do not coincide."""
        mine, theirs = np.array(self.affine), np.array(other.affine)
        size = np.abs(theirs[[0, 1, 3, 4]]).max()
        stretch = np.abs(mine - theirs)[[0, 1, 3, 4]].max() / size * max(self.rows, self.cols, other.rows, other.cols)
        if self.crs != other.crs or stretch > _SAME_CELL:
            return None
        col, row = other.cells_at(np.array([self.affine[2]]), np.array([self.affine[5]]))
        first_col, first_row = float(col[0]) + 0.5, float(row[0]) + 0.5
        if max(abs(first_col - round(first_col)), abs(first_row - round(first_row))) > _SAME_CELL:
            return None
        return round(first_col), round(first_row)

    def _unwrapped(self, px: FloatArray) -> FloatArray:
        """Shift longitudes by full turns to the range of the raster (0 to 360, or across 180 degrees)."""
        if not self.crs.is_geographic:
            return px
        turn = 2.0 * np.pi / self.crs.axis_info[0].unit_conversion_factor
        a, b, c = self.affine[:3]
        middle = c + 0.5 * (a * self.cols + b * self.rows)
        return np.asarray(px + turn * np.round((middle - px) / turn), np.float64)


def _transform(
    transformer: Transformer, x: FloatArray, y: FloatArray, direction: str
) -> tuple[FloatArray, FloatArray]:
    """Transform positions (n,)."""
    # pyproj treats an array of one as a scalar, which NumPy deprecates.
    single = len(x) == 1
    both = (np.repeat(x, 2), np.repeat(y, 2)) if single else (x, y)
    px, py = (np.asarray(values, np.float64) for values in transformer.transform(*both, direction=direction))
    return (px[:1], py[:1]) if single else (px, py)


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
