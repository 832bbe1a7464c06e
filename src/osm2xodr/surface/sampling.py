"""The surface made from elevation models: heights at any position from layers of grids and the trend below them.

The height at a position is that of the first layer whose cells surround it. Voids of a layer are filled from the
layers below, plus the residual at the void's rim, spread over the void. Beyond a layer's outermost cells the layers
below hold, plus the residual at the layer's nearest edge, which fades over the ramp. So heights have no step at any
seam, and within a layer's cells they are its own. The trend is a polynomial.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.curves import exp, hypot, smooth_step
from osm2xodr.model import BoolArray, FloatArray, IntArray, SurfaceQuality
from osm2xodr.surface.grids import (
    Cells,
    GridFrame,
    Interpolator,
    PolynomialTrend,
    all_corners,
    fill_voids,
    make_interpolator,
    nearest_known,
)
from osm2xodr.system import record

Bounds = tuple[float, float, float, float]

# Positions handled at a time: their arrays fit into the processor's cache.
_CHUNK: Final = 2**17
# Rounding error of the projection, cells.
_ROUNDING: Final = 1e-6


@record
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


@record(eq=False)
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


@record(eq=False)
class Layer:
    """One grid of heights."""

    frame: GridFrame
    z: Cells  # (rows, cols) Heights, m; NaN in voids
    sigma: float  # Standard error of its heights, m
    ramp: float  # Length over which its residual fades beyond its outermost cells, m
    covered: bool = False  # Whether it shows canopy and roofs rather than the ground

    @property
    def cell_size(self) -> float:
        """Geometric mean of the lengths of a column and a row, m."""
        return self.frame.cell_size()


@record(eq=False)
class _FilledLayer:
    """A layer with filled voids."""

    layer: Layer
    known: BoolArray | None  # (rows, cols) Which cells are not voids; None if all
    interpolate: Interpolator
    steps: tuple[float, float]  # Length of one column and of one row, m
    bounds: tuple[float, float, float, float]  # West, south, east, north of its influence, local m

    def is_near(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return which positions, local m, lie on the layer or within its ramp, (n,)."""
        west, south, east, north = self.bounds
        return (x > west) & (x < east) & (y > south) & (y < north)


@record(eq=False)
class Trend:
    """The polynomial trend, which goes on with a plane's slope beyond the heights it was fitted to, less and less."""

    polynomial: PolynomialTrend
    # West, south, east, north, local m: beyond, the trend is that at the nearest point of the box and what it rises
    # from there
    box: tuple[float, float, float, float]
    # Limits of its heights, m
    lowest: float
    highest: float
    # Rise per metre toward east and north beyond the box, and the length over which it fades, m
    slope: tuple[float, float] = (0.0, 0.0)
    fade: float = 1.0

    def heights(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z (n,), m, at local x, y.

        At a distance d from the box the slope is exp(-d / fade) of what it is there: all in all it rises as much as
        over one length of fading.
        """
        west, south, east, north = self.box
        near_x, near_y = np.clip(x, west, east), np.clip(y, south, north)
        z = self.polynomial.heights(near_x, near_y)
        dx, dy = x - near_x, y - near_y
        away = hypot(dx, dy) / self.fade
        share = np.where(away > 0.0, (1.0 - exp(-away)) / np.where(away > 0.0, away, 1.0), 1.0)
        z = z + share * (self.slope[0] * dx + self.slope[1] * dy)
        return np.clip(z, self.lowest, self.highest)


class LayeredSurface:
    """Layers, from top to bottom, over a trend.

    `method` is as of `make_interpolator`, or ``"polynomial"`` for the trend alone.
    """

    def __init__(self, layers: Sequence[Layer], trend: Trend, method: str) -> None:
        self.layers = tuple(layers)
        self.trend = trend
        self.method = method
        self._filled: list[_FilledLayer] = []
        # From the lowest up, as voids are filled from the layers below.
        for layer in reversed(layers):
            self._filled.insert(0, self._fill(layer))

    def sample(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return z (n,), m, at local x, y and the index of the layer that measures it, -1 where none does."""
        x, y = np.asarray(x, np.float64).reshape(-1), np.asarray(y, np.float64).reshape(-1)
        z, source = np.empty(len(x)), np.empty(len(x), np.int64)
        for first in range(0, len(x), _CHUNK):
            part = slice(first, first + _CHUNK)
            z[part], source[part] = self._compose(0, x[part], y[part])
            if self.method == "polynomial":
                z[part] = self.trend.heights(x[part], y[part])
        return z, source

    def sources(self, x: FloatArray, y: FloatArray) -> IntArray:
        """Return the index of the layer that measures the height at local x, y (n,), m, -1 where none does."""
        x, y = np.asarray(x, np.float64).reshape(-1), np.asarray(y, np.float64).reshape(-1)
        source = np.empty(len(x), np.int64)
        for first in range(0, len(x), _CHUNK):
            part = slice(first, first + _CHUNK)
            source[part] = self._sources(0, x[part], y[part])
        return source

    def _fill(self, layer: Layer) -> _FilledLayer:
        """Fill the voids of a layer from those filled already."""
        known, steps, z = np.isfinite(layer.z), layer.frame.steps(), layer.z

        def below(col: FloatArray, row: FloatArray) -> FloatArray:
            return self._compose(0, *layer.frame.positions(col, row))[0]

        all_known = bool(known.all())
        if not all_known:
            # Over other layers the residual fades as beyond the edge, over the trend alone it does not.
            z = fill_voids(z, below, steps, layer.ramp if self._filled else np.inf)
        x, y = layer.frame.positions(*layer.frame.rim())
        reach = layer.ramp + max(steps)
        bounds = float(x.min()) - reach, float(y.min()) - reach, float(x.max()) + reach, float(y.max()) + reach
        # The trend needs no interpolation, but coverage is still that of the cells.
        method = "bilinear" if self.method == "polynomial" else self.method
        return _FilledLayer(layer, None if all_known else known, make_interpolator(z, method), steps, bounds)

    def _compose(self, index: int, x: FloatArray, y: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return heights of the layers from an index on, and the layer that measures each, -1 for none."""
        if index == len(self._filled):
            return self.trend.heights(x, y), np.full(len(x), -1, np.int64)
        item = self._filled[index]
        near = item.is_near(x, y)
        z, source = np.empty(len(x)), np.empty(len(x), np.int64)
        if not near.all():
            z[~near], source[~near] = self._compose(index + 1, x[~near], y[~near])
        if near.any():
            z[near], source[near] = self._near(index, x[near], y[near])
        return z, source

    def _near(self, index: int, x: FloatArray, y: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return heights and measuring layers at positions on or near a layer."""
        item = self._filled[index]
        col, row, edge_col, edge_row, measured = self._places(item, x, y)
        z = item.interpolate(edge_col, edge_row)
        source = np.where(measured, index, -1)
        outside = (col != edge_col) | (row != edge_row)
        if outside.any():
            away = hypot((col - edge_col) * item.steps[0], (row - edge_row) * item.steps[1])[outside]
            low, low_source = self._compose(index + 1, x[outside], y[outside])
            at_edge = self._compose(index + 1, *item.layer.frame.positions(edge_col[outside], edge_row[outside]))[0]
            # From 1 at the footprint to 0 at the ramp's end, level at both (smoothstep).
            rest = np.clip(1.0 - (away - 0.5 * max(item.steps)) / item.layer.ramp, 0.0, 1.0)
            z[outside] = low + (z[outside] - at_edge) * smooth_step(rest)
            source[outside] = np.where(measured[outside], index, low_source)
        inner_void = ~measured & ~outside
        if inner_void.any() and index + 1 < len(self._filled):
            source[inner_void] = self._sources(index + 1, x[inner_void], y[inner_void])
        return z, source

    def _places(
        self, item: _FilledLayer, x: FloatArray, y: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return col and row of positions, those of the nearest positions within a layer, and where it measures."""
        frame = item.layer.frame
        col, row = frame.cells(x, y)
        # Nearest cells reach to the edge of the footprint, interpolation to the centres of the outermost cells.
        half = 0.5 if self.method == "nearest" else 0.0
        edge_col = np.clip(col, -half, frame.cols - 1.0 + half)
        edge_row = np.clip(row, -half, frame.rows - 1.0 + half)
        reach = 0.5 - half + _ROUNDING
        measured = (np.abs(col - edge_col) <= reach) & (np.abs(row - edge_row) <= reach)
        if item.known is not None:
            known = nearest_known if self.method == "nearest" else all_corners
            measured &= known(item.known, edge_col, edge_row)
        return col, row, edge_col, edge_row, measured

    def _sources(self, index: int, x: FloatArray, y: FloatArray) -> IntArray:
        """Return the first of the layers from an index on that measures each position, -1 for none."""
        source = np.full(len(x), -1, np.int64)
        left = np.arange(len(x))
        for number, item in enumerate(self._filled[index:], start=index):
            near = left[item.is_near(x[left], y[left])]
            measured = self._places(item, x[near], y[near])[-1]
            source[near[measured]] = number
            left = left[source[left] < 0]
        return source
