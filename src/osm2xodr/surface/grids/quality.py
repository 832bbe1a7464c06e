"""How good an elevation model is, by itself: outliers, the standard error of its heights, canopy and roofs.

Outliers are spikes, pits, and patches filled with a constant. A terrain model (ground) has no canopy and roofs, a
surface model has.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.curves import exp, hypot, log
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.surface.grids.grid import Cells, Indices, empty_cells
from osm2xodr.surface.grids.voids import PolynomialTrend, fit_polynomial, rim_of, term_count

# The step of an outlier from all ground around it is larger than each of these: m, times the cell size (a grade of
# 250 % on all sides: needles of rock have it, roads do not), and in standard errors of heights. Choices; no cell of
# 17 models of 10 to 90 m has it.
_OUTLIER_STEP: Final = 30.0
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

# Usual standard error of heights, m, by the size of cells, m, interpolated on logarithmic scales. Airborne laser 1 m:
# 0.1-0.15; national models of 5 to 10 m: 0.5-1; Copernicus GLO-30 and AW3D30: 2-3 (product handbooks and comparisons
# against geodetic points); SRTM at 3 arc seconds: 5-6.
_USUAL_SIGMA: Final = ((1.0, 0.12), (2.0, 0.15), (5.0, 0.5), (10.0, 1.0), (30.0, 2.0), (90.0, 5.0))
# Number of cells that are sampled; more would not change the result.
_NOISE_SAMPLES: Final = 50_000
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

# Heights are examined on gentle slopes: largest grade, and the distance that it is measured over, m.
_GENTLE_GRADE: Final = 0.3
_GENTLE_OVER: Final = 50.0
# Cells up to the first size, m, show houses and trees as walls: the second difference of three heights in a row
# exceeds a constant, m, plus a share of the cell size. A surface model has more walls than the last share of cells:
# ten terrains of 5 m have none, with houses and trees over 5 to 60 % of them it is 3 to 62 % (cells of 1 and 5 m).
_FINE_CELL_MAX: Final = 5.5
_WALL_BEND: Final = 1.5
_WALL_BEND_PER_CELL: Final = 0.25
_WALL_SHARE: Final = 0.02
# Larger cells show them as blobs: the skewness of heights about their local median is 1.3 to 1.8 with blobs of 3 to
# 12 m over a tenth of the ground, at most 0.8 in five models of 10 to 90 m that see the ground or through most of the
# canopy. Less scatter than the second, m, is noise.
_SKEWNESS_MIN: Final = 1.0
_SCATTER_MIN: Final = 0.5
# Number of cells that are sampled, as more would not change the result, and least number for a result.
_TYPE_SAMPLES: Final = 60_000
_SAMPLES_MIN: Final = 500

# Words of file names for surface and for terrain models in English, German, French, Spanish, Portuguese and Dutch.
_SURFACE_WORDS: Final = frozenset({"dsm", "dom", "bdom", "mns", "mne", "mds"})
_TERRAIN_WORDS: Final = frozenset({"dtm", "dgm", "mnt", "mdt", "fabdem", "merit", "ned", "hydrodem", "bathymetry"})
# Products with other names. SRTM, NASADEM and similar models see through part of the canopy: they are judged by their
# heights.
_SURFACE_PRODUCTS: Final = (
    "copernicus_dsm", "glo30", "glo-30", "glo_30", "aw3d", "alpsmlc", "astgtm", "swisssurface3d",
)  # fmt: skip
_TERRAIN_PRODUCTS: Final = ("usgs_13_", "usgs_1_", "usgs_1m_", "swissalti3d", "tinitaly", "bare_earth", "bareearth")
_SURFACE_PHRASES: Final = ("digital surface model", "digitales oberflächenmodell", "modèle numérique de surface")
_TERRAIN_PHRASES: Final = (
    "digital terrain model", "bare earth", "bare-earth", "digitales geländemodell", "modèle numérique de terrain",
)  # fmt: skip


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
    step = max(_OUTLIER_STEP, _STEP_GRADE * cell_size, _STEP_SIGMAS * usual_sigma(cell_size))
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
    sample = z.reshape(-1)[:: max(1, z.size // _NOISE_SAMPLES)].astype(np.float64) / unit
    sample = sample[np.isfinite(sample)]
    whole = len(sample) > 0 and bool((np.abs(sample - np.round(sample)) < _WHOLE).all())
    # A single height says nothing about rounding.
    return unit if whole and float(np.ptp(sample)) > 0.0 else 0.0


def _flat_residuals(z: Cells, steps: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Return height minus mean of 3 x 3 heights in flat places, m: of neighbours, and of every other cell around."""
    rows, cols = z.shape
    if rows < 5 or cols < 5:
        return np.zeros(0), np.zeros(0)
    inner = np.arange(0, (rows - 4) * (cols - 4), max(1, (rows - 4) * (cols - 4) // _NOISE_SAMPLES))
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


def named_cover(name: str, texts: Iterable[str] = ()) -> bool | None:
    """Whether a file's name (without folders) or descriptions are those of a surface model; None if undecided."""
    lower = name.casefold()
    words = set(re.findall(r"[a-zäöüéè]+", lower))
    phrases = " ".join(texts).casefold()
    surface = bool(words & _SURFACE_WORDS) or any(item in lower for item in _SURFACE_PRODUCTS)
    terrain = bool(words & _TERRAIN_WORDS) or any(item in lower for item in _TERRAIN_PRODUCTS)
    surface |= any(item in phrases for item in _SURFACE_PHRASES)
    terrain |= any(item in phrases for item in _TERRAIN_PHRASES)
    return surface if surface != terrain else None


def looks_covered(z: Cells, steps: tuple[float, float]) -> bool:
    """Whether heights z (rows, cols), m, NaN in voids, look like those of a surface model.

    Cells of a few metres show roofs and trees as walls, which gently sloping ground does not have: the test is the
    share of cells with sharper bends than ground. Larger cells show them as blobs above their surroundings, while
    ground deviates up and down alike: the test is the skewness (Pearson's moment coefficient) of heights about the
    median of their 5 x 5 neighbourhood on gentle slopes. `steps` are the lengths of one column and of one row, m.
    """
    cell = float(np.sqrt(steps[0] * steps[1]))
    if cell <= _FINE_CELL_MAX:
        return _wall_share(z, cell) > _WALL_SHARE
    return _skewness(z, steps) > _SKEWNESS_MIN


def _wall_share(z: Cells, cell: float) -> float:
    """Return the share of cells on gentle slopes with sharper bends than ground."""
    reach = max(2, round(0.5 * _GENTLE_OVER / cell))
    near = _stars(z, (1, reach))
    if near.shape[1] < _SAMPLES_MIN:
        return 0.0
    middle, (west, east, north, south, far_west, far_east, far_north, far_south) = near[0], near[1:]
    slope = hypot(far_east - far_west, far_south - far_north) / (2.0 * reach * cell)
    gentle = slope < _GENTLE_GRADE
    bend = np.maximum(np.abs(west - 2.0 * middle + east), np.abs(north - 2.0 * middle + south))
    if np.count_nonzero(gentle) < _SAMPLES_MIN:
        return 0.0
    return float(np.mean(bend[gentle] > _WALL_BEND + _WALL_BEND_PER_CELL * cell))


def _skewness(z: Cells, steps: tuple[float, float]) -> float:
    """Return the skewness of heights about their local median on gentle slopes; 0 if there are too few."""
    row, col = _inner(z, 2)
    near = np.stack([z[row + i, col + j].astype(np.float64) for i in range(-2, 3) for j in range(-2, 3)])
    near = near[:, np.isfinite(near).all(axis=0)]
    if near.shape[1] < _SAMPLES_MIN:
        return 0.0
    grid = near.reshape(5, 5, -1)
    across = (grid[:, 4].mean(axis=0) - grid[:, 0].mean(axis=0)) / (4.0 * steps[0])
    along = (grid[4].mean(axis=0) - grid[0].mean(axis=0)) / (4.0 * steps[1])
    gentle: BoolArray = hypot(across, along) < _GENTLE_GRADE
    # The median, which numpy finds several times faster where the numbers lie side by side.
    residual = near[12, gentle] - np.median(np.ascontiguousarray(near[:, gentle].T), axis=1)
    spread = float(np.sqrt(np.mean(residual**2))) if len(residual) >= _SAMPLES_MIN else 0.0
    if spread < _SCATTER_MIN:
        return 0.0
    return float(np.mean(residual * residual * residual)) / (spread * spread * spread)


def _stars(z: Cells, reaches: tuple[int, ...]) -> FloatArray:
    """Return heights (1 + 4 n, cells) at sampled cells, and west, east, north, south of them at n distances."""
    row, col = _inner(z, max(reaches))
    at = [z[row, col]]
    for reach in reaches:
        at += [z[row, col - reach], z[row, col + reach], z[row - reach, col], z[row + reach, col]]
    near = np.stack(at).astype(np.float64)
    out: FloatArray = near[:, np.isfinite(near).all(axis=0)]
    return out


def _inner(z: Cells, reach: int) -> tuple[IntArray, IntArray]:
    """Return row and col of evenly spread cells at least `reach` cells away from the border."""
    rows, cols = z.shape[0] - 2 * reach, z.shape[1] - 2 * reach
    if rows <= 0 or cols <= 0:
        none = np.zeros(0, np.int64)
        return none, none
    index = np.arange(0, rows * cols, max(1, rows * cols // _TYPE_SAMPLES))
    return index // cols + reach, index % cols + reach
