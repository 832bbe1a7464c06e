"""Outliers of elevation models: spikes, pits, and patches filled with a constant."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.surface.grids.grid import Cells, Indices, empty_cells
from osm2xodr.surface.grids.quality import MAD_TO_SIGMA, usual_sigma
from osm2xodr.surface.grids.trend import PolynomialTrend, fit_polynomial, term_count
from osm2xodr.surface.grids.voids import rim_of

# The step of an outlier from all ground around it is larger than each of these: m, times the cell size (a grade of
# 250 % on all sides: needles of rock have it, roads do not), and in standard errors of heights. Choices; no cell of
# 17 models of 10 to 90 m has it.
_STEP: Final = 30.0
_STEP_GRADE: Final = 2.5
_STEP_SIGMAS: Final = 8.0
# Patches are outliers if they also differ from the polynomial trend by this many standard deviations, or have a
# single value, and have the step along this share of their rim. Choices, checked likewise.
_TREND_SIGMAS: Final = 6.0
_RIM_SHARE: Final = 0.9
# Patches have at least this many cells; smaller blobs are only compared with the ring of cells around them.
_PATCH_CELLS_MIN: Final = 10
# Longest rim of a patch off the trend, in pairs of cells across it, by the root of its number of cells: discs have
# 13, squares 12. Gorges with sheer walls have more; fillings may have any shape.
_RIM_RATIO_MAX: Final = 20.0
_ANY_RIM_RATIO: Final = 1e9
# Outliers make up less than this share of a model; otherwise they are the ground.
_MODEL_SHARE: Final = 0.5
# Share of the cells around a blob that must have a height.
_KNOWN_SHARE: Final = 0.5
# The robust trend: number of fits, and residuals trimmed beyond this many standard deviations.
_FITS: Final = 3
_TRIM_SIGMAS: Final = 3.0
# Number of cells that are processed at a time, and that the trend is fitted to.
_STRIP_CELLS: Final = 2**21
_TREND_CELLS: Final = 5_000


def find_outliers(z: Cells, cell_size: float, averaged: bool = False) -> tuple[BoolArray, float]:
    """Find cells of z (rows, cols), m, that differ from all ground around them by more than ground does.

    Return which they are (rows, cols), and the least difference from the ground around them, m. Voids are NaN.
    `averaged` says that cells are means of several, so that those on the rim of a filling contain some of it. Blobs
    of up to 3 x 3 cells are compared with the ring of cells around them: they are outliers if they are above its
    highest (below its lowest) by the step, or its grade over the blob's reach, plus the range of the ring. Larger
    patches need the step along nearly all of their rim, and must either be compact and off the polynomial trend of
    the window by 6 standard deviations, or have the window's lowest or highest height throughout, as fillings do.
    Hills, ridges, cliffs, canyons and shores do neither.
    """
    step = max(_STEP, _STEP_GRADE * cell_size, _STEP_SIGMAS * usual_sigma(cell_size))
    mask = np.zeros(z.shape, bool)
    rows = max(1, _STRIP_CELLS // max(z.shape[1], 1))
    for first in range(0, z.shape[0], rows):
        # With three more rows on either side: the reach of blob and ring.
        low, high = max(first - 3, 0), min(first + rows + 3, z.shape[0])
        found = _spikes(z[low:high], step, cell_size)
        mask[first : first + rows] = found[first - low : first - low + rows]
    _add_fillings(z, mask, step, averaged)
    _add_patches(z, mask, step)
    return mask, step


def _spikes(z: Cells, step: float, cell_size: float) -> BoolArray:
    """Return the cells of small blobs that differ from the ring of cells around them."""
    padded = empty_cells(z.shape[0] + 6, z.shape[1] + 6, z.dtype == np.float32)
    padded[3:-3, 3:-3] = z
    mask = np.zeros(padded.shape, bool)
    for sign in (1.0, -1.0):
        row, col = _candidates(padded, sign, step)
        if len(row):
            for reach in (1, 2):
                bound = max(step, _STEP_GRADE * cell_size * reach)
                _mark_blobs(mask, padded, row * padded.shape[1] + col, sign, bound, reach)
    return mask[3:-3, 3:-3]


def _candidates(padded: Cells, sign: float, step: float) -> tuple[Indices, Indices]:
    """Return row, col of the cells far above (below) one that is one or two cells away, as all cells of blobs are."""
    rows, cols = padded.shape[0] - 6, padded.shape[1] - 6
    lowest = empty_cells(rows, cols, padded.dtype == np.float32)
    pick = np.fmin if sign > 0 else np.fmax
    for i, j in ((1, 0), (2, 0), (-1, 0), (-2, 0), (0, 1), (0, 2), (0, -1), (0, -2)):
        pick(lowest, padded[3 + i : 3 + i + rows, 3 + j : 3 + j + cols], out=lowest)
    lowest -= padded[3:-3, 3:-3]
    at = np.flatnonzero(lowest < -step if sign > 0 else lowest > step)
    return at // cols + 3, at % cols + 3


def _mark_blobs(mask: BoolArray, padded: Cells, here: Indices, sign: float, step: float, reach: int) -> None:
    """Mark, in place, cells of blobs around candidates that are above (below) the ring at a reach of some cells."""
    width = padded.shape[1]
    flat, marks = padded.reshape(-1), mask.reshape(-1)
    row, col = (place.reshape(-1) for place in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    on_ring = np.maximum(np.abs(row), np.abs(col)) == reach
    ring, core = (row * width + col)[on_ring], (row * width + col)[~on_ring]
    # The candidate may be any cell of the core.
    centre = np.unique((here[:, None] - core[None, :]).reshape(-1))
    centre = centre[(centre >= 2 * width + 2) & (centre < len(flat) - 2 * width - 2)]
    around = sign * flat[centre[:, None] + ring[None, :]].astype(np.float64)
    enough = np.isfinite(around).sum(axis=1) >= _KNOWN_SHARE * len(ring)
    centre, around = centre[enough], around[enough]
    if not len(centre):
        return
    highest, lowest = np.nanmax(around, axis=1), np.nanmin(around, axis=1)
    bound = highest + step + (highest - lowest)
    cells = centre[:, None] + core[None, :]
    with np.errstate(invalid="ignore"):
        marks[cells[sign * flat[cells] > bound[:, None]]] = True


def _add_fillings(z: Cells, mask: BoolArray, step: float, averaged: bool) -> None:
    """Mark, in place, patches of the lowest or highest height that differ from their surroundings."""
    known = np.isfinite(z) & ~mask
    if not known.any():
        return
    for extreme in (float(z[known].min()), float(z[known].max())):
        same = known & (z == extreme)
        if np.count_nonzero(same) < _PATCH_CELLS_MIN:
            continue
        held = z
        if averaged:
            rim = rim_of(same) & known
            held = np.where(rim, np.asarray(extreme, z.dtype), z)
            same |= rim
        mask |= _isolated_patches(held, known & ~mask, same, step, _ANY_RIM_RATIO)


def _add_patches(z: Cells, mask: BoolArray, step: float) -> None:
    """Mark, in place, compact patches that differ from the trend and from their surroundings."""
    known = np.isfinite(z) & ~mask
    trend, spread = _robust_trend(z, known)
    bound = max(step, _TREND_SIGMAS * spread)
    if trend is None:
        return
    off: IntArray = np.zeros(z.shape, np.int8)
    x = np.arange(z.shape[1], dtype=np.float64)
    rows = max(1, _STRIP_CELLS // max(z.shape[1], 1))
    for first in range(0, z.shape[0], rows):
        y = np.arange(first, min(first + rows, z.shape[0]), dtype=np.float64)
        residual = z[first : first + rows] - trend.on_grid(x, y)
        with np.errstate(invalid="ignore"):
            off[first : first + rows] = np.where(residual > bound, 1, np.where(residual < -bound, -1, 0))
    for sign in (1, -1):
        candidates = known & (off == sign)
        if np.count_nonzero(candidates) >= _PATCH_CELLS_MIN:
            mask |= _isolated_patches(z, known, candidates, step, _RIM_RATIO_MAX)


def _robust_trend(z: Cells, known: BoolArray) -> tuple[PolynomialTrend | None, float]:
    """Return the trend over columns and rows by trimmed least squares, and the standard deviation from it, m."""
    flat = known.reshape(-1)
    stride = max(1, int(np.count_nonzero(flat)) // _TREND_CELLS)
    at = np.arange(0, len(flat), stride)
    row, col = (place.astype(np.float64) for place in np.divmod(at[flat[at]], z.shape[1]))
    heights = z.reshape(-1)[at[flat[at]]].astype(np.float64)
    order = defaults.POLYNOMIAL_ORDER
    if len(row) < 4 * term_count(order):
        return None, 0.0
    keep = np.ones(len(row), bool)
    for _ in range(_FITS):
        trend = fit_polynomial(col[keep], row[keep], heights[keep], order)
        residual = np.abs(trend.heights(col, row) - heights)
        spread = MAD_TO_SIGMA * float(np.median(residual))
        trimmed = residual <= max(_TRIM_SIGMAS * spread, 1e-6)
        if np.count_nonzero(trimmed) < 4 * term_count(order):
            break
        keep = trimmed
    return trend, spread


def _isolated_patches(
    z: Cells, known: BoolArray, candidates: BoolArray, step: float, rim_ratio_max: float
) -> BoolArray:
    """Return the candidates in patches that are above, or below, nearly all known cells around them.

    Patches with a longer rim, in pairs of cells by the root of their number of cells, are not.
    """
    # Takes a while to load.
    from scipy import ndimage

    labelled: Any = ndimage.label(candidates, np.ones((3, 3)))
    patches: IntArray = labelled[0]
    count = int(labelled[1])
    sizes = np.bincount(patches.reshape(-1), minlength=count + 1)
    pairs, above, below = (np.zeros(count + 1) for _ in range(3))
    for i, j in ((0, 1), (1, 0), (1, 1), (1, -1)):
        one, other = _shifted(z.shape, i, j)
        for inner, outer in ((one, other), (other, one)):
            row, col = np.nonzero((patches[inner] > 0) & (patches[outer] == 0) & known[outer])
            number = patches[inner][row, col]
            rise = z[inner][row, col].astype(np.float64) - z[outer][row, col]
            pairs += np.bincount(number, minlength=count + 1)
            above += np.bincount(number, rise > step, count + 1)
            below += np.bincount(number, rise < -step, count + 1)
    off = (np.maximum(above, below) >= _RIM_SHARE * pairs) & (pairs > 0) & (sizes >= _PATCH_CELLS_MIN)
    off &= pairs <= rim_ratio_max * np.sqrt(sizes)
    off[0] = False
    off &= int(sizes[off].sum()) < _MODEL_SHARE * int(np.count_nonzero(known))
    return off[patches]


def _shifted(shape: tuple[int, ...], i: int, j: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the slices of a grid that pair each cell with the one i rows down and j columns on."""
    rows, cols = shape
    here = slice(0, rows - i), slice(max(0, -j), cols - max(0, j))
    return here, (slice(i, rows), slice(max(0, j), cols + min(0, j)))
