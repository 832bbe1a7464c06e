"""The surfaces that the surface stage hands on, and what it says about the elevation models they are made of."""

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
    """What an elevation model is and what was used of it."""

    # As the file says; `crs` is its code, or its name where it has none
    path: Path
    driver: str
    crs: str
    dtype: str
    unit: str
    nodata: float | None
    cell_size: float  # Geometric mean of the lengths of a column and a row near the roads, m
    bounds_deg: Bounds  # West, south, east, north of the whole file, degrees, WGS 84
    # Cells that were read, and how many of them have no height
    cells: int
    voids: int
    share: float  # Share of the road points in whose cell there is a height
    outliers: int  # How many of the voids hold heights that are no ground


@dataclass(frozen=True, slots=True, eq=False)
class DemSurface:
    """The height of the ground from elevation models (a `osm2xodr.model.Surface`)."""

    cell_size: float  # Distance between heights, m, of the elevation model that most roads lie on
    sigma: float  # Standard error of its heights, m
    coverage: float  # Share of the road points whose height is measured
    extent_deg: Bounds  # West, south, east, north of all elevation models used, degrees, WGS 84
    dems: tuple[DemSummary, ...]  # What was read, in the order given
    polynomial: PolynomialTrend  # The trend
    layers: LayeredSurface  # What the heights are made of
    # Quality of the heights that each layer measures, and last that of heights which none does
    qualities: SurfaceQuality

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        Measured is what lies within the cells of an elevation model with a height in every cell that takes part.
        Elsewhere, and farther than the margin (`_DEM_MARGIN`) from the points the surface was made for, z is
        continued without a step from the nearest measured heights along the trend.
        """
        z, source = self.layers.sample(x, y)
        return z, source >= 0

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted.

        They are as good as those of the elevation model that measures them. Where none does, the standard error is
        that of a guess (`defaults.GUESS_SIGMA`), and the cell size that of the model that most roads lie on.
        """
        # Layers count from 0; -1, no layer, is the last.
        source = self.layers.sources(x, y)
        table = self.qualities
        return SurfaceQuality(table.cell_size[source], table.sigma[source], table.covered[source])


def qualities_of(layers: LayeredSurface, main: int, sigmas: FloatArray) -> SurfaceQuality:
    """Return the quality of the heights that each layer measures, and last that of a guess.

    Parameters
    ----------
    layers
        The layers.
    main
        Index of the one that most roads lie on.
    sigmas : (layers,)
        Standard errors, m.
    """
    sizes = [layer.cell_size for layer in layers.layers]
    covered = [layer.covered for layer in layers.layers]
    return SurfaceQuality(
        np.array([*sizes, sizes[main]]),
        np.array([*sigmas, max(defaults.GUESS_SIGMA, float(np.max(sigmas)))]),
        np.array([*covered, False]),
    )
