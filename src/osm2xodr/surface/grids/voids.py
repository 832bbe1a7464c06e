"""Heights where a grid has none: voids filled smoothly from their rims, and the polynomial trend of heights.

The filling is the height below the grid plus a correction r that meets the heights at the rim: the solution of the
screened Poisson equation laplace(r) = r / fade² with r given on the rim, like a membrane on springs. It has no step
at the rim, stays between 0 and the values there, and decays over the length `fade`.

The trend is a linear least-squares problem in scaled coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import solve_dense
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.surface.grids.grid import Cells
from osm2xodr.system import record

Below = Callable[[FloatArray, FloatArray], FloatArray]

# Sweeps of Gauss-Seidel on each grid, and the band around the rim in which they are done, cells of the coarser grid:
# on random voids the solution is then within 2 % of the range at the rim of a direct one (0.8 % in the median).
_SWEEPS: Final = 24
_BAND: Final = 4
# Number of positions at which the height below is evaluated; between them it is interpolated.
_EVALUATED: Final = 250_000
# Rows that are processed at a time, to bound memory.
_STRIP: Final = 256
# Gaps in adjacent blocks of this many cells in either direction are filled together.
_BLOCK: Final = 64

# Points that are processed at a time, to bound memory.
_CHUNK: Final = 2**16
# Terms whose share of the largest is below this are not determined by the points.
_DETERMINED: Final = 1e-12


def fill_voids(z: Cells, below: Below, steps: tuple[float, float], fade: float) -> Cells:
    """Return z (rows, cols), m, with its voids (NaN) filled by the heights below plus the correction from the rim.

    `below` gives the heights without the correction, m, by col and row; `steps` are the lengths of one column and of
    one row, `fade` is that over which the correction decays, m.
    """
    gap = np.isnan(z)
    filled = z.copy()
    for box, own in _groups(gap):
        np.copyto(filled[box], _fill_box(z[box], own, _shifted(below, box), steps, fade), where=own)
    return filled


def _fill_box(z: Cells, gap: BoolArray, below: Below, steps: tuple[float, float], fade: float) -> Cells:
    """Return z with its gaps filled; other cells are not valid."""
    rim = rim_of(gap)
    touched = gap | rim
    stride = max(1, int(np.ceil(np.sqrt(np.count_nonzero(touched) / _EVALUATED))))
    lattice = _evaluate_lattice(touched, stride, below)
    strips = [slice(first, min(first + _STRIP, len(z))) for first in range(0, len(z), _STRIP)]
    out = np.zeros_like(z)
    for strip in strips:
        out[strip] = np.where(rim[strip], z[strip] - interpolate_lattice(lattice, stride, strip, z.shape[1]), 0.0)
    fill_from_rim(out, rim, gap, steps, fade)
    for strip in strips:
        out[strip] += interpolate_lattice(lattice, stride, strip, z.shape[1])
    return out


def _groups(gap: BoolArray) -> Iterator[tuple[tuple[slice, slice], BoolArray]]:
    """Yield groups of gaps that are far enough apart to be filled one by one: the box, and the gaps in the box."""
    # Takes a while to load.
    from scipy import ndimage

    rows, cols = (-(-size // _BLOCK) for size in gap.shape)
    padded = np.pad(gap, ((0, rows * _BLOCK - gap.shape[0]), (0, cols * _BLOCK - gap.shape[1])))
    groups: IntArray = np.zeros((rows, cols), np.int64)
    ndimage.label(padded.reshape(rows, _BLOCK, cols, _BLOCK).any(axis=(1, 3)), np.ones((3, 3)), output=groups)
    for number, found in enumerate(ndimage.find_objects(groups), 1):
        # Every number has a group.
        assert found is not None
        down, across = found
        blocks = np.repeat(np.repeat(groups[down, across] == number, _BLOCK, axis=0), _BLOCK, axis=1)
        first_row, first_col = down.start * _BLOCK, across.start * _BLOCK
        own = padded[first_row : down.stop * _BLOCK, first_col : across.stop * _BLOCK] & blocks
        row, col = np.flatnonzero(own.any(axis=1)), np.flatnonzero(own.any(axis=0))
        # Including the rim around the gaps.
        box = (
            slice(max(first_row + int(row[0]) - 1, 0), min(first_row + int(row[-1]) + 2, gap.shape[0])),
            slice(max(first_col + int(col[0]) - 1, 0), min(first_col + int(col[-1]) + 2, gap.shape[1])),
        )
        inner = np.zeros((box[0].stop - box[0].start, box[1].stop - box[1].start), bool)
        at_row, at_col = np.nonzero(own)
        inner[at_row + first_row - box[0].start, at_col + first_col - box[1].start] = True
        yield box, inner


def _shifted(below: Below, box: tuple[slice, slice]) -> Below:
    """Return `below` for positions relative to a box's first cell."""
    return lambda col, row: below(col + box[1].start, row + box[0].start)


def rim_of(gap: BoolArray) -> BoolArray:
    """Return the cells around gaps that touch them by an edge or a corner."""
    return _spread(gap) & ~gap


def fill_from_rim(
    values: Cells, known: BoolArray, free: BoolArray, steps: tuple[float, float], fade: float = np.inf
) -> None:
    """Fill the free cells of values (rows, cols), in place, with the solution of laplace(r) = r / fade².

    Known cells, one at least, keep their values; free cells are surrounded by known and free ones; any others take no
    part, their values are finite. The normal derivative is 0 at the border of the grid. For `steps` and `fade` see
    `fill_voids`.

    Cascadic multigrid (Bornemann and Deuflhard 1996): the equation is solved on coarser grids first; on each finer
    grid only cells near the rim are relaxed, by red-black Gauss-Seidel, as those farther inside are smooth. The
    effort is proportional to the length of the rim.
    """
    if not free.any():
        return
    coarse, count = _coarser(values, known)
    coarse_free = np.logical_or.reduce(_quarters(free))
    near = count > 0
    # In blocks on the rim the majority decides; otherwise the void would shrink with every coarser grid.
    coarse_known = near & (~coarse_free | (count > 1))
    if not coarse_known.any():
        coarse_known = near
    coarse_free &= ~coarse_known
    coarse_known |= _surround(coarse, near, coarse_free)
    fill_from_rim(coarse, coarse_known, coarse_free, (2.0 * steps[0], 2.0 * steps[1]), fade)
    np.copyto(values, _twice(_twice(coarse, values.shape[0]).T, values.shape[1]).T, where=free)
    for _ in range(_BAND):
        near = _spread(near)
    near = np.repeat(np.repeat(near, 2, axis=0)[: values.shape[0]], 2, axis=1)[:, : values.shape[1]]
    _relax(values, near & free, steps, fade)


def _spread(mask: BoolArray) -> BoolArray:
    """Return the cells of a mask and all that touch them."""
    beside = mask.copy()
    beside[1:] |= mask[:-1]
    beside[:-1] |= mask[1:]
    around = beside.copy()
    around[:, 1:] |= beside[:, :-1]
    around[:, :-1] |= beside[:, 1:]
    return around


def _coarser(values: Cells, known: BoolArray) -> tuple[Cells, npt.NDArray[np.uint8]]:
    """Return the means of the known cells in blocks of 2 x 2, and their numbers."""
    count: npt.NDArray[np.uint8] = np.add.reduce([quarter.view(np.uint8) for quarter in _quarters(known)])
    total = np.add.reduce(_quarters(np.where(known, values, np.zeros((), values.dtype))))
    mean: Cells = (total / np.maximum(count, 1)).astype(values.dtype)
    return mean, count


def _surround(values: Cells, known: BoolArray, free: BoolArray) -> BoolArray:
    """Give cells beside free ones that take no part the mean of known ones around them; return which."""
    new: BoolArray = _spread(free) & ~known & ~free
    row, col = np.nonzero(new)
    weights = np.pad(known, 1)
    padded = np.pad(np.where(known, values, np.zeros((), values.dtype)), 1)
    count, total = np.zeros(len(row)), np.zeros(len(row))
    for i, j in np.ndindex(3, 3):
        count += weights[row + i, col + j]
        total += padded[row + i, col + j]
    values[row, col] = total / np.maximum(count, 1.0)
    new[row, col] = count > 0.0
    return new


def _quarters(cells: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
    """Return the four cells of each block of 2 x 2; beyond the grid they are 0 or False."""
    even = np.pad(cells, ((0, cells.shape[0] % 2), (0, cells.shape[1] % 2)))
    return [np.ascontiguousarray(even[i::2, j::2]) for i in (0, 1) for j in (0, 1)]


def _twice(coarse: npt.NDArray[Any], rows: int) -> npt.NDArray[Any]:
    """Interpolate to rows at half the spacing, two for each row, constant at the border."""
    before, after = np.concatenate([coarse[:1], coarse[:-1]]), np.concatenate([coarse[1:], coarse[-1:]])
    out = np.empty((2 * len(coarse), coarse.shape[1]), coarse.dtype)
    out[0::2] = 0.75 * coarse + 0.25 * before
    out[1::2] = 0.75 * coarse + 0.25 * after
    return out[:rows]


def _relax(values: Cells, free: BoolArray, steps: tuple[float, float], fade: float) -> None:
    """Do `_SWEEPS` sweeps of red-black Gauss-Seidel over the free cells, in place."""
    rows, cols = values.shape
    flat = values.reshape(-1)
    across, along = 1.0 / steps[0] ** 2, 1.0 / steps[1] ** 2
    total = 2.0 * (across + along) + 1.0 / fade**2
    row, col = np.nonzero(free)
    colours: list[tuple[npt.NDArray[np.intp], ...]] = []
    for colour in (0, 1):
        pick = (row + col) % 2 == colour
        r, c = row[pick], col[pick]
        # Beyond the border the neighbour is the cell itself, so that the normal derivative is 0.
        left, right = np.maximum(c - 1, 0), np.minimum(c + 1, cols - 1)
        up, down = np.maximum(r - 1, 0), np.minimum(r + 1, rows - 1)
        places = (r, c), (r, left), (r, right), (up, c), (down, c)
        colours.append(tuple(at_row * cols + at_col for at_row, at_col in places))
    for _ in range(_SWEEPS):
        for here, west, east, north, south in colours:
            flat[here] = (across * (flat[west] + flat[east]) + along * (flat[north] + flat[south])) / total


def _evaluate_lattice(touched: BoolArray, stride: int, below: Below) -> FloatArray:
    """Return heights at every stride-th row and column, where a touched cell lies between them."""
    rows, cols = (-(-size // stride) for size in touched.shape)
    padded = np.pad(touched, ((0, rows * stride - touched.shape[0]), (0, cols * stride - touched.shape[1])))
    block = padded.reshape(rows, stride, cols, stride).any(axis=(1, 3))
    wanted = np.zeros((rows + 1, cols + 1), bool)
    for i, j in np.ndindex(2, 2):
        wanted[i : i + rows, j : j + cols] |= block
    out = np.zeros(wanted.shape)
    row, col = np.nonzero(wanted)
    out[row, col] = below((col * stride).astype(np.float64), (row * stride).astype(np.float64))
    return out


def interpolate_lattice(lattice: FloatArray, stride: int, strip: slice, cols: int) -> FloatArray:
    """Interpolate a lattice bilinearly to all cells of some rows."""
    row, col = np.arange(strip.start, strip.stop), np.arange(cols)
    u, v = (col % stride / stride)[None, :], (row % stride / stride)[:, None]
    along = lattice[row // stride] * (1.0 - v) + lattice[row // stride + 1] * v
    out: FloatArray = along[:, col // stride] * (1.0 - u) + along[:, col // stride + 1] * u
    return out


@record(eq=False)
class PolynomialTrend:
    """A polynomial of total degree `order` in x and y."""

    order: int
    coefficients: FloatArray  # (order + 1, order + 1) c_ij of T_i(u) T_j(v), m; 0 where i + j > order
    # u = (x - centre[0]) / half_range[0], v likewise, m
    centre: tuple[float, float]
    half_range: tuple[float, float]
    rms: float  # Weighted root mean square of the residuals at the fitted points, m

    def heights(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z (n,), m, at x, y (n,), m. Away from the fitted points it grows without bound."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        i, j = _terms(self.order)
        out = np.empty(len(x))
        for first in range(0, len(x), _CHUNK):
            part = slice(first, first + _CHUNK)
            basis = _basis(*_scaled(x[part], y[part], self.centre, self.half_range), i, j)
            out[part] = (basis * self.coefficients[i, j]).sum(axis=1)
        return out

    def on_grid(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z (len(y), len(x)), m, at all pairs of x and y, m."""
        u, v = _scaled(np.asarray(x, np.float64), np.asarray(y, np.float64), self.centre, self.half_range)
        across, along = _chebyshev(u, self.order), _chebyshev(v, self.order)
        return np.asarray(np.einsum("ni,im->nm", np.einsum("nj,ij->ni", along, self.coefficients), across.T.copy()))


def term_count(order: int) -> int:
    """Return the number of terms of a bivariate polynomial of a total degree."""
    return (order + 1) * (order + 2) // 2


def fit_polynomial(
    x: FloatArray, y: FloatArray, z: FloatArray, order: int = 4, weights: FloatArray | None = None
) -> PolynomialTrend:
    """Fit a polynomial of a total degree to heights z at x, y, all (n,), m, by linear least squares.

    All numbers are finite, n is at least the number of terms (else `ValueError`); `weights` (n,), 0 or more, are
    those of the squared residuals, equal by default.

    A QR factorisation is updated with a chunk of points at a time (sequential TSQR, Demmel et al. 2012), so that
    memory is bounded and the normal matrix never formed. Where the points do not determine all terms (as on one
    line), the solution has minimum norm.
    """
    x, y, z = (np.asarray(value, np.float64).reshape(-1) for value in (x, y, z))
    root = np.ones(len(z)) if weights is None else np.sqrt(np.asarray(weights, np.float64).reshape(-1))
    if order < 0 or len(z) < term_count(order):
        raise ValueError(f"a polynomial of degree {order} needs {term_count(max(order, 0))} points, not {len(z)}")
    if not all(np.isfinite(value).all() for value in (x, y, z, root)):
        raise ValueError("positions, heights and weights must be finite to fit a polynomial to them")
    (west, east), (south, north) = (float(x.min()), float(x.max())), (float(y.min()), float(y.max()))
    centre = 0.5 * (west + east), 0.5 * (south + north)
    # Points on one line have no extent across it.
    half_range = 0.5 * (east - west) or 1.0, 0.5 * (north - south) or 1.0
    i, j = _terms(order)
    mean = float(z.mean())
    factor = np.zeros((0, len(i) + 1))
    for first in range(0, len(z), _CHUNK):
        part = slice(first, first + _CHUNK)
        basis = _basis(*_scaled(x[part], y[part], centre, half_range), i, j)
        rows = np.column_stack([basis, z[part] - mean]) * root[part, None]
        factor = _triangle(np.vstack([factor, rows]))
    coefficients = np.zeros((order + 1, order + 1))
    coefficients[i, j] = _solved(factor[:, :-1], factor[:, -1])
    coefficients[0, 0] += mean
    coefficients.flags.writeable = False
    trend = PolynomialTrend(order, coefficients, centre, half_range, 0.0)
    residual = trend.heights(x, y) - z
    rms = np.sqrt(np.sum((root * residual) ** 2) / max(float(np.sum(root**2)), np.finfo(float).tiny))
    return replace(trend, rms=float(rms))


def _triangle(rows: FloatArray) -> FloatArray:
    """Return the triangular factor of the QR factorisation of a matrix, by Householder's reflections.

    Those of libraries have other last digits on other machines.
    """
    work = np.asfortranarray(rows)
    for k in range(min(work.shape)):
        across = work[k:, k].copy()
        size = np.sqrt((across * across).sum())
        if size > 0.0:
            across[0] += size if across[0] >= 0.0 else -size
            share = (across[:, None] * work[k:, k:]).sum(axis=0) * (2.0 / (across * across).sum())
            work[k:, k:] -= across[:, None] * share
    return np.triu(work[: work.shape[1]])


def _solved(factor: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution, (terms,), of a triangular system, of minimum norm where it leaves some of it open."""
    terms = factor.shape[1]
    size = np.abs(np.diagonal(factor))
    if len(size) == terms and size.min() > _DETERMINED * size.max():
        return solve_dense(factor[:terms], right[:terms, None])[:, 0]
    return np.asarray(np.linalg.lstsq(factor, right, rcond=_DETERMINED)[0])


def _scaled(
    x: FloatArray, y: FloatArray, centre: tuple[float, float], half_range: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return u, v of x, y."""
    return (x - centre[0]) / half_range[0], (y - centre[1]) / half_range[1]


def _terms(order: int) -> tuple[IntArray, IntArray]:
    """Return i and j of all terms."""
    i, j = np.indices((order + 1, order + 1)).reshape(2, -1)
    keep = i + j <= order
    return i[keep], j[keep]


def _basis(u: FloatArray, v: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Return all terms at u, v, (n, terms)."""
    return _chebyshev(u, int(i.max()))[:, i] * _chebyshev(v, int(j.max()))[:, j]


def _chebyshev(u: FloatArray, order: int) -> FloatArray:
    """Return T_0 to T_order at u (n, order + 1) by the recurrence T_k = 2 u T_k-1 - T_k-2."""
    out = np.ones((len(u), order + 1))
    if order > 0:
        out[:, 1] = u
    for k in range(2, order + 1):
        out[:, k] = 2.0 * u * out[:, k - 1] - out[:, k - 2]
    return out
