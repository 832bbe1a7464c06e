"""How heights are made from elevation models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr import defaults
from osm2xodr.errors import InputError

METHODS = ("nearest", "bilinear", "bicubic", "polynomial")
DEM_TYPES = ("auto", "dtm", "dsm")


@dataclass(frozen=True, slots=True)
class SurfaceOptions:
    """How heights are made from elevation models.

    Raises
    ------
    InputError
        A value is none of these.
    """

    # One of `METHODS`: between cells ``nearest``, ``bilinear`` or ``bicubic``; ``polynomial`` takes the heights of
    # the trend alone, which has lost the terrain beyond about 1 km.
    method: str = defaults.SURFACE_METHOD
    polynomial_order: int = defaults.POLYNOMIAL_ORDER  # Total degree of the trend, 2 to 5
    allow_partial: bool = False  # Whether elevation models may cover less than half of the roads
    # Standard error of the heights, m, where it is known better than from the elevation models themselves: one value
    # for all of them.
    sigma: float | None = None
    # One of `DEM_TYPES`: whether elevation models show the ground (``dtm``) or canopy and roofs (``dsm``); ``auto``
    # tells it from each model's name and heights.
    dem_type: str = "auto"
    vertical_datum: str | None = None  # Datum to turn heights into, as of `parse_datum`; None leaves them as they are
    # Datum of the elevation models' heights, likewise, instead of what their files say
    dem_vertical_datum: str | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"surface '{self.method}' is not known; choose one of {', '.join(METHODS)}")
        if self.polynomial_order not in range(2, 6):
            raise InputError(f"the surface's polynomial order {self.polynomial_order} is not offered; choose 2 to 5")
        if self.sigma is not None and not 0.0 < self.sigma < np.inf:
            raise InputError(f"the elevation model's standard error {self.sigma} m is not above 0; give metres")
        if self.dem_type not in DEM_TYPES:
            raise InputError(
                f"the type of elevation model '{self.dem_type}' is not known; choose one of {', '.join(DEM_TYPES)}"
            )
        if self.dem_vertical_datum is not None and self.vertical_datum is None:
            raise InputError(
                "the vertical datum of the elevation models is of use only to turn heights into another; give "
                "--vertical-datum too"
            )
