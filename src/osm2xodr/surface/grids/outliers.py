"""Heights that are no ground: spikes, pits, and patches that an elevation model was filled with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.surface.grids.interpolation import Cells, Indices, empty_cells
from osm2xodr.surface.grids.noise import usual_sigma
from osm2xodr.surface.grids.trend import PolynomialTrend, fit_polynomial, term_count
from osm2xodr.surface.grids.voids import rim_of

# What stands off all ground around it by more than this is no ground: m, times the cell size (a grade of 250 % on all
# sides: needles of rock have it, roads do not), and in standard errors. Small blobs (3 x 3 cells) must stand off by
# the range of the heights around them as well; larger ones by so many standard deviations from the polynomial trend,
# or have one single value, and on this share of their rim. Choices; no cell of 17 models of 10 to 90 m does.
_OUTLIER_STEP: Final = 30.0
_OUTLIER_GRADE: Final = 2.5
_OUTLIER_SIGMAS: Final = 8.0
_OUTLIER_TREND: Final = 6.0
_OUTLIER_RIM: Final = 0.9

# Cells that are looked at in one go, and cells that the trend is fitted to.
_STRIP_CELLS = 2**21
_TREND_CELLS = 5_000
# Blobs smaller than this are left to the comparison with the cells around them.
_PATCH_MIN = 10
# Longest rim of a patch that stands off the trend, in pairs of cells that touch across it, by the root of its cells:
# discs have 13, squares 12. Gorges with sheer walls have more.
_LONGEST_RIM = 20.0
# Rounds of fitting the trend without what stands off it, and where that begins, in standard deviations.
_ROUNDS = 3
_TRIM = 3.0
_MAD = 1.4826
# Share of the cells around a blob that must have a height.
_KNOWN_SHARE = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Outliers:
    """Cells whose height is no ground."""

    mask: BoolArray  # (rows, cols) Which
    step: float  # By how much they stand off the ground around them at least, m


def find_outliers(z: Cells, cell_size: float, averaged: bool = False) -> Outliers:
    """Find cells that stand off all ground around them by more than ground does.

    Parameters
    ----------
    z : (rows, cols)
        Heights, m; NaN in voids.
    cell_size
        m.
    averaged
        Whether cells are means of several, so that those on the rim of a filling are partly made of it.

    Notes
    -----
    Blobs of up to 3 x 3 cells are held against the ring of cells around them: they are outliers if they stand above
    its highest (below its lowest) by `step`, or its grade over the blob's reach, and by the range of the ring. Larger
    ones have to stand off their neighbours by `step` along nearly all of their rim, and either to be compact and off
    the polynomial trend of the window by `_OUTLIER_TREND` standard deviations, or to hold the window's lowest
    or highest height throughout, as fillings do. Hills, ridges, cliffs, canyons and shores do neither.
    """
    step = max(
        _OUTLIER_STEP,
        _OUTLIER_GRADE * cell_size,
        _OUTLIER_SIGMAS * usual_sigma(cell_size),
    )
    mask = np.zeros(z.shape, bool)
    rows = max(1, _STRIP_CELLS // max(z.shape[1], 1))
    for first in range(0, z.shape[0], rows):
        # Three rows beyond either side: the blob's own reach and the ring's.
        low, high = max(first - 3, 0), min(first + rows + 3, z.shape[0])
        found = _spikes(z[low:high], step, cell_size)
        mask[first : first + rows] = found[first - low : first - low + rows]
    _add_fillings(z, mask, step, averaged)
    _add_patches(z, mask, step)
    return Outliers(mask, step)


def _spikes(z: Cells, step: float, cell_size: float) -> BoolArray:
    """Return the cells of small blobs that stand off the ring of cells around them."""
    padded = empty_cells(z.shape[0] + 6, z.shape[1] + 6, z.dtype == np.float32)
    padded[3:-3, 3:-3] = z
    mask = np.zeros(padded.shape, bool)
    for sign in (1.0, -1.0):
        row, col = _candidates(padded, sign, step)
        if len(row):
            for reach in (1, 2):
                bound = max(step, _OUTLIER_GRADE * cell_size * reach)
                _mark_blobs(mask, padded, row * padded.shape[1] + col, sign, bound, reach)
    return mask[3:-3, 3:-3]


def _candidates(padded: Cells, sign: float, step: float) -> tuple[Indices, Indices]:
    """Return row, col of the cells that stand above a cell one or two away: of blobs, every cell does."""
    rows, cols = padded.shape[0] - 6, padded.shape[1] - 6
    lowest = empty_cells(rows, cols, padded.dtype == np.float32)
    pick = np.fmin if sign > 0 else np.fmax
    for i, j in ((1, 0), (2, 0), (-1, 0), (-2, 0), (0, 1), (0, 2), (0, -1), (0, -2)):
        pick(lowest, padded[3 + i : 3 + i + rows, 3 + j : 3 + j + cols], out=lowest)
    lowest -= padded[3:-3, 3:-3]
    at = np.flatnonzero(lowest < -step if sign > 0 else lowest > step)
    return at // cols + 3, at % cols + 3


def _mark_blobs(mask: BoolArray, padded: Cells, here: Indices, sign: float, step: float, reach: int) -> None:
    """Mark, in place, cells of blobs around candidates that stand above the ring of cells at some cells' reach."""
    width = padded.shape[1]
    flat, marks = padded.reshape(-1), mask.reshape(-1)
    row, col = (place.reshape(-1) for place in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    on_ring = np.maximum(np.abs(row), np.abs(col)) == reach
    ring, core = (row * width + col)[on_ring], (row * width + col)[~on_ring]
    # Every place of the core may be the candidate's.
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
    """Mark, in place, patches of the lowest or highest height that stand off their surroundings."""
    known = np.isfinite(z) & ~mask
    if not known.any():
        return
    for extreme in (float(z[known].min()), float(z[known].max())):
        same = known & (z == extreme)
        if np.count_nonzero(same) < _PATCH_MIN:
            continue
        held = z
        if averaged:
            rim = rim_of(same) & known
            held = np.where(rim, np.asarray(extreme, z.dtype), z)
            same |= rim
        mask |= _standing_off(held, known & ~mask, same, step, 1e9)


def _add_patches(z: Cells, mask: BoolArray, step: float) -> None:
    """Mark, in place, compact patches that stand off the trend and their surroundings."""
    known = np.isfinite(z) & ~mask
    trend, spread = _robust_trend(z, known)
    bound = max(step, _OUTLIER_TREND * spread)
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
        if np.count_nonzero(candidates) >= _PATCH_MIN:
            mask |= _standing_off(z, known, candidates, step, _LONGEST_RIM)


def _robust_trend(z: Cells, known: BoolArray) -> tuple[PolynomialTrend | None, float]:
    """Return the trend of heights over columns and rows without what stands off it, and the spread around it, m."""
    flat = known.reshape(-1)
    stride = max(1, int(np.count_nonzero(flat)) // _TREND_CELLS)
    at = np.arange(0, len(flat), stride)
    row, col = (place.astype(np.float64) for place in np.divmod(at[flat[at]], z.shape[1]))
    heights = z.reshape(-1)[at[flat[at]]].astype(np.float64)
    order = defaults.POLYNOMIAL_ORDER
    if len(row) < 4 * term_count(order):
        return None, 0.0
    keep = np.ones(len(row), bool)
    for _ in range(_ROUNDS):
        trend = fit_polynomial(col[keep], row[keep], heights[keep], order)
        residual = np.abs(trend.heights(col, row) - heights)
        spread = _MAD * float(np.median(residual))
        trimmed = residual <= max(_TRIM * spread, 1e-6)
        if np.count_nonzero(trimmed) < 4 * term_count(order):
            break
        keep = trimmed
    return trend, spread


def _standing_off(z: Cells, known: BoolArray, candidates: BoolArray, step: float, longest_rim: float) -> BoolArray:
    """Return the candidates in patches that stand off nearly all known cells around them, all to one side.

    Patches with a longer rim, in pairs of cells by the root of their size, are left alone.
    """
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
    off = (np.maximum(above, below) >= _OUTLIER_RIM * pairs) & (pairs > 0) & (sizes >= _PATCH_MIN)
    off &= pairs <= longest_rim * np.sqrt(sizes)
    off[0] = False
    # What is most of the model is the ground.
    off &= int(sizes[off].sum()) < 0.5 * int(np.count_nonzero(known))
    out: BoolArray = off[patches]
    return out


def _shifted(shape: tuple[int, ...], i: int, j: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the slices of a grid that put each cell beside the one i rows and j columns on."""
    rows, cols = shape
    here = slice(0, rows - i), slice(max(0, -j), cols - max(0, j))
    there = slice(i, rows), slice(max(0, j), cols + min(0, j))
    return here, there
