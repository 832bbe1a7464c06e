"""Whether an elevation model is a terrain model (ground) or a surface model (canopy and roofs)."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

import numpy as np

from osm2xodr.curves import hypot
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.surface.grids.interpolation import Cells

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
_SAMPLES: Final = 60_000
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
    index = np.arange(0, rows * cols, max(1, rows * cols // _SAMPLES))
    return index // cols + reach, index % cols + reach
