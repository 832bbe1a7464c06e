"""The surface made from elevation models, and a summary of each of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from osm2xodr import defaults
from osm2xodr.model import BoolArray, FloatArray, SurfaceQuality
from osm2xodr.surface.grids import PolynomialTrend
from osm2xodr.surface.sampling import LayeredSurface

Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class DemSummary:
    """An elevation model, and what was used of it."""

    # As in the file; `crs` is its code, or its name if it has none
    path: Path
    driver: str
    crs: str
    dtype: str
    unit: str
    nodata: float | None
    cell_size: float  # Geometric mean of the lengths of a column and a row near the roads, m
    bounds_deg: Bounds  # West, south, east, north of the whole file, degrees, WGS 84
    # Number of cells that were read, and of those without a height
    cells: int
    voids: int
    share: float  # Share of the road points whose cell has a height
    outliers: int  # Number of voids whose heights were removed as outliers
    attribution: str = ""  # Whom its data are owed, by the file's metadata


@dataclass(frozen=True, slots=True, eq=False)
class DemSurface:
    """The height of the ground from elevation models (an `osm2xodr.model.Surface`)."""

    cell_size: float  # Of the elevation model that most roads lie on, m
    sigma: float  # Standard error of its heights, m
    dems: tuple[DemSummary, ...]  # What was read, in the order given
    polynomial: PolynomialTrend  # The trend
    layers: LayeredSurface  # The grids of heights
    # Quality of the heights that each layer measures, and last that of unmeasured heights
    qualities: SurfaceQuality

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        It is measured within the cells of an elevation model where every cell that takes part has a height.
        Elsewhere, and farther than 50 m from the points that the surface was made for, z continues without a step
        from the nearest measured heights along the trend.
        """
        z, source = self.layers.sample(x, y)
        return z, source >= 0

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return where `heights` at local x, y (n,), m, are measured; nothing is interpolated."""
        return np.asarray(self.layers.sources(x, y) >= 0)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted, by the model that measures them.

        Elsewhere the standard error is that of a guess, the cell size that of the model that most roads lie on.
        """
        # Index -1, no layer, is the last row.
        source, table = self.layers.sources(x, y), self.qualities
        return SurfaceQuality(table.cell_size[source], table.sigma[source], table.covered[source])


def qualities_of(layers: LayeredSurface, main: int, sigmas: FloatArray) -> SurfaceQuality:
    """Return the quality of each layer's heights by `sigmas` (layers,), m, and last that of a guess.

    The cell size of a guess is that of layer `main`, on which most roads lie.
    """
    sizes = [layer.cell_size for layer in layers.layers]
    return SurfaceQuality(
        np.array([*sizes, sizes[main]]),
        np.array([*sigmas, max(defaults.GUESS_SIGMA, float(np.max(sigmas)))]),
        np.array([*(layer.covered for layer in layers.layers), False]),
    )
