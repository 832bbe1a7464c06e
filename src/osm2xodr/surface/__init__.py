"""Stage 2: elevation models to the height of the ground at local positions.

`read_surface` makes a `DemSurface` from any number of GeoTIFF, HGT or VRT files; `FlatSurface` stands in where there
are none. `fit_polynomial` is the least-squares trend alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from osm2xodr import defaults
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray, LocalFrame, SurfaceQuality
from osm2xodr.projection import to_geographic
from osm2xodr.surface.dem import DemSource
from osm2xodr.surface.grid import GridFrame
from osm2xodr.surface.mosaic import (
    DemWindow,
    bounds_deg,
    by_priority,
    describe_all,
    fit_trend,
    make_layers,
    read_windows,
)
from osm2xodr.surface.sampling import Layer, LayeredSurface
from osm2xodr.surface.trend import PolynomialTrend, fit_polynomial

__all__ = [
    "METHODS",
    "DemSummary",
    "DemSurface",
    "FlatSurface",
    "PolynomialTrend",
    "SurfaceOptions",
    "fit_polynomial",
    "read_surface",
]

METHODS = ("nearest", "bilinear", "bicubic", "polynomial")

Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class SurfaceOptions:
    """How heights are made from elevation models.

    Parameters
    ----------
    method
        One of `METHODS`: between cells ``nearest``, ``bilinear`` or ``bicubic``; ``polynomial`` takes the heights of
        the trend alone, which has lost the terrain beyond about 1 km.
    polynomial_order
        Total degree of the trend, 2 to 5.
    allow_partial
        Whether elevation models may cover less than half of the roads.
    sigma
        Standard error of the heights, m, where it is known better than from the elevation models themselves.

    Raises
    ------
    InputError
        A value is none of these.
    """

    method: str = defaults.SURFACE_METHOD
    polynomial_order: int = defaults.POLYNOMIAL_ORDER
    allow_partial: bool = False
    sigma: float | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"surface '{self.method}' is not known; choose one of {', '.join(METHODS)}")
        if self.polynomial_order not in range(2, 6):
            raise InputError(f"the surface's polynomial order {self.polynomial_order} is not offered; choose 2 to 5")
        if self.sigma is not None and not 0.0 < self.sigma < np.inf:
            raise InputError(f"the elevation model's standard error {self.sigma} m is not above 0; give metres")


@dataclass(frozen=True, slots=True)
class DemSummary:
    """What an elevation model is and what was used of it.

    Parameters
    ----------
    path, driver, crs, dtype, unit, nodata
        As the file says; `crs` is its code, or its name where it has none.
    cell_size
        Geometric mean of the lengths of a column and a row near the roads, m.
    bounds_deg
        West, south, east, north of the whole file, degrees, WGS 84.
    cells, voids
        Cells that were read, and how many of them have no height.
    share
        Share of the road points in whose cell there is a height.
    """

    path: Path
    driver: str
    crs: str
    dtype: str
    unit: str
    nodata: float | None
    cell_size: float
    bounds_deg: Bounds
    cells: int
    voids: int
    share: float


@dataclass(frozen=True, slots=True, eq=False)
class DemSurface:
    """The height of the ground from elevation models (a `osm2xodr.model.Surface`).

    Parameters
    ----------
    cell_size
        Distance between heights, m, of the elevation model that most roads lie on.
    sigma
        Standard error of its heights, m.
    coverage
        Share of the road points whose height is measured.
    extent_deg
        West, south, east, north of all elevation models used, degrees, WGS 84.
    dems
        What was read, in the order given.
    polynomial
        The trend.
    layers
        What the heights are made of.
    """

    cell_size: float
    sigma: float
    coverage: float
    extent_deg: Bounds
    dems: tuple[DemSummary, ...]
    polynomial: PolynomialTrend
    layers: LayeredSurface

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        Measured is what lies within the cells of an elevation model with a height in every cell that takes part.
        Elsewhere, and farther than the margin (`defaults.DEM_MARGIN`) from the points the surface was made for, z is
        continued without a step from the nearest measured heights along the trend.
        """
        z, source = self.layers.sample(x, y)
        return z, source >= 0

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted."""
        return SurfaceQuality(
            np.full(len(x), self.cell_size), np.full(len(x), self.sigma), np.zeros(len(x), np.bool_)
        )


@dataclass(frozen=True, slots=True)
class FlatSurface:
    """The ground where there is no elevation model: exact, at height 0."""

    cell_size: float = 0.0
    sigma: float = 0.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return 0 m for local x, y (n,), and that it is measured."""
        return np.zeros(len(x)), np.ones(len(x), bool)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return that the heights at local x, y (n,), m, are exact."""
        return SurfaceQuality(np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x), np.bool_))


def read_surface(
    paths: Sequence[Path],
    frame: LocalFrame,
    x: FloatArray,
    y: FloatArray,
    options: SurfaceOptions,
    diagnostics: Diagnostics,
) -> DemSurface:
    """Make the surface of the ground from elevation models.

    Where several overlap, finer cells come first, then the order given; their seams are blended. Neither positions
    nor cells are resampled: heights are found in each raster's own CRS.

    Parameters
    ----------
    paths
        Local raster files, one or more: any CRS, cell size, type of cells, unit of heights.
    frame
        Where x and y are.
    x, y : (n,)
        Points of all roads, m, evenly spaced: they decide what is read, and the coverage.
    options
        How.
    diagnostics
        Receives what was guessed or repaired, and the share of the roads without a measured height.

    Raises
    ------
    InputError
        A file is missing, damaged, no raster, an image, not local, or without CRS.
    CoverageError
        The elevation models lie elsewhere, have no heights at the roads, or cover too little of them.
    """
    if not paths:
        raise InputError("no elevation model was given; name at least one file")
    x, y = np.asarray(x, np.float64).reshape(-1), np.asarray(y, np.float64).reshape(-1)
    if not len(x):
        raise InputError("there are no roads to find heights for; choose an area that has some")
    described = describe_all(paths, frame, diagnostics)
    bounds = [bounds_deg(source, cells) for source, cells in described]
    cells_max = defaults.DEM_CELLS_MAX_BICUBIC if options.method == "bicubic" else defaults.DEM_CELLS_MAX
    windows = read_windows(described, x, y, cells_max, diagnostics)
    _say_averaged(windows, diagnostics)
    used = _used(paths, windows, bounds, frame, x, y, diagnostics)
    layers = make_layers(by_priority(used), cells_max, diagnostics)
    trend = fit_trend(layers, options.polynomial_order)
    if trend.polynomial.order < options.polynomial_order:
        diagnostics.note(
            "trend-order",
            "",
            f"{paths[0]}: too few heights for a trend of degree {options.polynomial_order}; degree "
            f"{trend.polynomial.order} was fitted.",
        )
    layered = LayeredSurface(layers, trend, options.method)
    source = layered.sample(x, y)[1]
    coverage = _checked_coverage(paths, source, options, diagnostics)
    main = layers[int(np.bincount(source[source >= 0]).argmax())]
    summaries = tuple(_summary(*item) for item in zip(described, windows, bounds, strict=True))
    return DemSurface(
        float(np.sqrt(np.prod(main.frame.steps()))),
        _sigma(main, trend.polynomial, options),
        coverage,
        _union([box for box, window in zip(bounds, windows, strict=True) if window is not None]),
        summaries,
        trend.polynomial,
        layered,
    )


def _say_averaged(windows: Sequence[DemWindow | None], diagnostics: Diagnostics) -> None:
    """Say which elevation models have more cells around the roads than are kept."""
    averaged = [window for window in windows if window is not None and window.block > 1]
    if averaged:
        block = max(window.block for window in averaged)
        diagnostics.note(
            "dem-averaged",
            "",
            f"{_names([window.source.path for window in averaged])}: the roads span more cells than are kept; "
            f"blocks of {block} x {block} cells were averaged.",
        )


def _used(
    paths: Sequence[Path],
    windows: Sequence[DemWindow | None],
    bounds: Sequence[Bounds],
    frame: LocalFrame,
    x: FloatArray,
    y: FloatArray,
    diagnostics: Diagnostics,
) -> list[DemWindow]:
    """Return the windows that have heights, say which elevation models have none at the roads, fail if none has."""
    used, away, empty = [], [], []
    for path, window in zip(paths, windows, strict=True):
        if window is None:
            away.append(path)
        elif bool(np.isfinite(window.z).any()):
            used.append(window)
        else:
            empty.append(path)
    for unused, why in ((away, "nothing of it reaches the roads"), (empty, "it is all nodata around the roads")):
        if unused:
            diagnostics.note("dem-unused", "", f"{_names(unused)}: not used, {why}.")
    if used:
        return used
    names = _names(paths)
    if empty:
        raise CoverageError(
            f"{names}: all cells around the roads are nodata; give an elevation model with heights there"
        )
    lon, lat = to_geographic(frame, x, y)
    roads = float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())
    raise CoverageError(
        f"{names}: the elevation model covers {_in_words(_union(bounds))} but the roads lie at {_in_words(roads)}; "
        "give one that covers the roads"
    )


def _checked_coverage(
    paths: Sequence[Path], source: IntArray, options: SurfaceOptions, diagnostics: Diagnostics
) -> float:
    """Return the share of measured points; fail if it is too small, and say what was filled."""
    coverage = float(np.mean(source >= 0))
    names = _names(paths)
    if coverage == 0.0:
        raise CoverageError(f"{names}: no road has a measured height; give an elevation model that covers the roads")
    if coverage < defaults.DEM_COVERAGE_MIN and not options.allow_partial:
        raise CoverageError(
            f"{names}: only {_percent(coverage)} of the roads have a measured height; give elevation models that "
            "cover the roads, or allow the rest to be guessed with --allow-partial"
        )
    if coverage < 1.0:
        diagnostics.guessed(
            "dem-gap",
            "",
            f"{names}: {_percent(1.0 - coverage)} of the roads have no measured height; it was filled in.",
        )
    return coverage


def _sigma(main: Layer, polynomial: PolynomialTrend, options: SurfaceOptions) -> float:
    """Return the standard error of heights: as given, else of the layer, and of the trend if that is the surface."""
    sigma = main.sigma if options.sigma is None else options.sigma
    return max(sigma, polynomial.rms) if options.method == "polynomial" else sigma


def _summary(described: tuple[DemSource, GridFrame], window: DemWindow | None, bounds: Bounds) -> DemSummary:
    """Sum up an elevation model."""
    source, cells = described
    code = source.crs.to_json_dict().get("id")
    return DemSummary(
        source.path,
        source.driver,
        f"{code['authority']}:{code['code']}" if code else source.crs.name,
        source.dtype,
        source.unit,
        source.nodata,
        float(np.sqrt(np.prod((cells if window is None else window.frame).steps()))),
        bounds,
        0 if window is None else int(window.z.size),
        0 if window is None else int(np.count_nonzero(np.isnan(window.z))),
        0.0 if window is None else window.share,
    )


def _names(paths: Sequence[Path]) -> str:
    """Name files in a sentence, the first few of many."""
    more = f" and {len(paths) - 3} more" if len(paths) > 3 else ""
    return ", ".join(str(path) for path in paths[:3]) + more


def _union(boxes: Sequence[Bounds]) -> Bounds:
    """Return the box around boxes."""
    west, south, east, north = zip(*boxes, strict=True)
    return min(west), min(south), max(east), max(north)


def _in_words(box: Bounds) -> str:
    """Say where a box is."""
    west, south, east, north = box
    return f"{west:.4f} to {east:.4f} E, {south:.4f} to {north:.4f} N"


def _percent(share: float) -> str:
    """Write a share with as many digits as it takes not to be rounded to nothing or everything."""
    percent = 100.0 * share
    return (
        f"{percent:.0f} %" if 1.0 <= percent <= 99.0 else f"{percent:.2g} %" if percent < 1.0 else f"{percent:.2f} %"
    )
