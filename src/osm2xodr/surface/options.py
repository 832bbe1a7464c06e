"""Options of the surface, and the flat surface: all that is needed where there is no elevation model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr import defaults
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, SurfaceQuality

METHODS = ("nearest", "bilinear", "bicubic", "polynomial")
DEM_TYPES = ("auto", "dtm", "dsm")
DEM_ENCODINGS = ("terrarium", "mapbox")


@dataclass(frozen=True, slots=True)
class SurfaceOptions:
    """How heights are made from elevation models; `InputError` if a value is not offered."""

    # One of `METHODS`: the interpolation between cells, or ``polynomial`` for the trend alone, which loses terrain
    # shorter than about 1 km
    method: str = defaults.SURFACE_METHOD
    polynomial_order: int = defaults.POLYNOMIAL_ORDER  # Total degree of the trend, 2 to 5
    allow_partial: bool = False  # Whether elevation models may cover less than half of the roads
    # Share of the roads that elevation models must cover, 0 to 1, whatever `allow_partial` says; None for the usual
    coverage_least: float | None = None
    # Standard error of the heights of all elevation models, m; None estimates it from each of them
    sigma: float | None = None
    # One of `DEM_TYPES`: elevation models show the ground (``dtm``), or canopy and roofs (``dsm``); ``auto`` decides
    # by each model's name and heights
    dem_type: str = "auto"
    vertical_datum: str | None = None  # Datum to convert heights to (`parse_datum`); None leaves them as they are
    # Datum of the elevation models' heights, likewise; None takes it from their files
    dem_vertical_datum: str | None = None
    # CRS and unit of heights of elevation models whose files do not say them, in any form that PROJ reads, and as in
    # ``ft``; None refuses those without a CRS, and takes heights for metres
    dem_crs: str | None = None
    dem_unit: str | None = None
    # How elevation models that are pictures code heights as colours, ``terrarium`` or ``mapbox``; None refuses those
    dem_encoding: str | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"surface '{self.method}' is not known; choose one of {', '.join(METHODS)}")
        if self.polynomial_order not in range(2, 6):
            raise InputError(f"the surface's polynomial order {self.polynomial_order} is not offered; choose 2 to 5")
        if self.sigma is not None and not 0.0 < self.sigma < np.inf:
            raise InputError(f"the elevation model's standard error {self.sigma} m is not above 0; give metres")
        if self.dem_type not in DEM_TYPES:
            remedy = f"choose one of {', '.join(DEM_TYPES)}"
            raise InputError(f"the type of elevation model '{self.dem_type}' is not known; {remedy}")
        if self.dem_vertical_datum is not None and self.vertical_datum is None:
            raise InputError(
                "the vertical datum of the elevation models is used only to convert heights to another; give "
                "--vertical-datum too"
            )


@dataclass(frozen=True, slots=True)
class FlatSurface:
    """The ground where there is no elevation model: exact, at height 0."""

    cell_size: float = 0.0
    sigma: float = 0.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return 0 m for local x, y (n,), and that it is measured."""
        return np.zeros(len(x)), np.ones(len(x), bool)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return that heights at local x, y (n,), m, are measured."""
        return np.ones(len(x), bool)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return that heights at local x, y (n,), m, are exact."""
        return SurfaceQuality(np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x), np.bool_))
