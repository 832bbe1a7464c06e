"""Whether an elevation model shows the ground (terrain model) or what stands on it (surface model)."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.surface.grids.interpolation import Cells

# Surface models (canopy, roofs) are told from terrain models by their heights where their name does not say it, on
# gentle slopes: rise per metre, over some distance, m. Up to the first cell size, m, by the share of cells at which
# three heights in a row bend by more than 1.5 m and a quarter of a cell, which ground does at walls only: none in ten
# terrains of 5 m, 3 to 62 % with houses and trees over 5 to 60 % of them (cells of 1 and 5 m). Above it by the
# skewness of heights about the median around them: 1.3 to 1.8 with blobs of 3 to 12 m over a tenth of the ground, at
# most 0.8 in five models of 10 to 90 m that see the ground or through most of the canopy. Less scatter than this, m,
# is noise.
_COVER_GENTLE: Final = 0.3
_COVER_GENTLE_OVER: Final = 50.0
_COVER_FINE_CELL: Final = 5.5
_COVER_BEND: Final = 1.5
_COVER_BEND_PER_CELL: Final = 0.25
_COVER_WALLS: Final = 0.02
_COVER_SKEWNESS: Final = 1.0
_COVER_SCATTER: Final = 0.5

# Cells that are looked at; more would not change the answer.
_SAMPLES = 60_000
_MIN_SAMPLES = 500

# Words of file names for surface and for terrain models in English, German, French, Spanish, Portuguese and Dutch.
_SURFACE_WORDS = frozenset({"dsm", "dom", "bdom", "mns", "mne", "mds"})
_TERRAIN_WORDS = frozenset({"dtm", "dgm", "mnt", "mdt", "fabdem", "merit", "ned", "hydrodem", "bathymetry"})
# Products that name themselves otherwise. SRTM, NASADEM and their kin see through part of the canopy: their heights
# tell more than their names.
_SURFACE_PRODUCTS = ("copernicus_dsm", "glo30", "glo-30", "glo_30", "aw3d", "alpsmlc", "astgtm", "swisssurface3d")
_TERRAIN_PRODUCTS = ("usgs_13_", "usgs_1_", "usgs_1m_", "swissalti3d", "tinitaly", "bare_earth", "bareearth")
_SURFACE_PHRASES = ("digital surface model", "digitales oberflächenmodell", "modèle numérique de surface")
_TERRAIN_PHRASES = (
    "digital terrain model", "bare earth", "bare-earth", "digitales geländemodell", "modèle numérique de terrain",
)  # fmt: skip


def named_cover(name: str, texts: Iterable[str] = ()) -> bool | None:
    """Return whether a name or description is that of a surface model; None if it says nothing or both.

    Parameters
    ----------
    name
        Of the file, without its folders.
    texts
        What the file says about itself.
    """
    lower = name.casefold()
    words = set(re.findall(r"[a-zäöüéè]+", lower))
    phrases = " ".join(texts).casefold()
    surface = bool(words & _SURFACE_WORDS) or any(item in lower for item in _SURFACE_PRODUCTS)
    terrain = bool(words & _TERRAIN_WORDS) or any(item in lower for item in _TERRAIN_PRODUCTS)
    surface |= any(item in phrases for item in _SURFACE_PHRASES)
    terrain |= any(item in phrases for item in _TERRAIN_PHRASES)
    return surface if surface != terrain else None


def looks_covered(z: Cells, steps: tuple[float, float]) -> bool:
    """Return whether heights look like those of a surface model.

    Cells of a few metres show roofs and trees as walls, which gently sloping ground has nowhere: the share of cells
    is counted where heights bend by more than any such ground does. Larger cells show them as blobs that stand up
    from their neighbours, where ground stands up and down alike: the skewness of heights about the median of their
    5 x 5 neighbourhood is taken, in gently sloping places too.

    Parameters
    ----------
    z : (rows, cols)
        Heights, m; NaN in voids.
    steps
        Length of one column and of one row, m.
    """
    cell = float(np.sqrt(steps[0] * steps[1]))
    if cell <= _COVER_FINE_CELL:
        return _wall_share(z, steps, cell) > _COVER_WALLS
    return _skewness(z, steps) > _COVER_SKEWNESS


def _wall_share(z: Cells, steps: tuple[float, float], cell: float) -> float:
    """Return the share of cells on gentle slopes at which heights bend more sharply than ground."""
    reach = max(2, round(0.5 * _COVER_GENTLE_OVER / cell))
    near = _stars(z, (1, reach))
    if near.shape[1] < _MIN_SAMPLES:
        return 0.0
    middle, (west, east, north, south, far_west, far_east, far_north, far_south) = near[0], near[1:]
    slope = np.hypot(far_east - far_west, far_south - far_north) / (2.0 * reach * cell)
    gentle = slope < _COVER_GENTLE
    bend = np.maximum(np.abs(west - 2.0 * middle + east), np.abs(north - 2.0 * middle + south))
    if np.count_nonzero(gentle) < _MIN_SAMPLES:
        return 0.0
    return float(np.mean(bend[gentle] > _COVER_BEND + _COVER_BEND_PER_CELL * cell))


def _skewness(z: Cells, steps: tuple[float, float]) -> float:
    """Return the skewness of heights about the median of their neighbourhood, on gentle slopes; 0 if too few are."""
    row, col = _inner(z, 2)
    near = np.stack([z[row + i, col + j].astype(np.float64) for i in range(-2, 3) for j in range(-2, 3)])
    near = near[:, np.isfinite(near).all(axis=0)]
    if near.shape[1] < _MIN_SAMPLES:
        return 0.0
    grid = near.reshape(5, 5, -1)
    across = (grid[:, 4].mean(axis=0) - grid[:, 0].mean(axis=0)) / (4.0 * steps[0])
    along = (grid[4].mean(axis=0) - grid[0].mean(axis=0)) / (4.0 * steps[1])
    gentle: BoolArray = np.hypot(across, along) < _COVER_GENTLE
    residual = near[12, gentle] - np.median(near[:, gentle], axis=0)
    spread = float(np.sqrt(np.mean(residual**2))) if len(residual) >= _MIN_SAMPLES else 0.0
    # Scatter below this is that of the model's own rounding and noise.
    if spread < _COVER_SCATTER:
        return 0.0
    return float(np.mean(residual**3)) / spread**3


def _stars(z: Cells, reaches: tuple[int, ...]) -> FloatArray:
    """Return heights at sampled cells and at their west, east, north, south at some distances, (1 + 4 n, cells)."""
    row, col = _inner(z, max(reaches))
    at = [z[row, col]]
    for reach in reaches:
        at += [z[row, col - reach], z[row, col + reach], z[row - reach, col], z[row + reach, col]]
    near = np.stack(at).astype(np.float64)
    out: FloatArray = near[:, np.isfinite(near).all(axis=0)]
    return out


def _inner(z: Cells, reach: int) -> tuple[IntArray, IntArray]:
    """Return row and col of cells, evenly spread, that lie at least some cells inside."""
    rows, cols = z.shape[0] - 2 * reach, z.shape[1] - 2 * reach
    if rows <= 0 or cols <= 0:
        none = np.zeros(0, np.int64)
        return none, none
    index = np.arange(0, rows * cols, max(1, rows * cols // _SAMPLES))
    return index // cols + reach, index % cols + reach
