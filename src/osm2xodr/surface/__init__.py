"""Stage 2: elevation models to the height of the ground at local positions.

`read_surface` makes a `DemSurface` from any number of GeoTIFF, HGT or VRT files; `FlatSurface` stands in where there
are none. `fit_polynomial` is the least-squares trend alone. `compare_surfaces` tells how well ways to find heights do
on elevation models of one's own.

What reads elevation models is only imported when it is asked for: a flat world does without.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.surface.flat import FlatSurface as FlatSurface
from osm2xodr.surface.options import DEM_TYPES as DEM_TYPES, METHODS as METHODS, SurfaceOptions as SurfaceOptions
from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.model import FloatArray, LocalFrame
    from osm2xodr.surface.comparison import MethodResult as MethodResult
    from osm2xodr.surface.dem_surface import DemSummary as DemSummary, DemSurface as DemSurface
    from osm2xodr.surface.grids import (
        PolynomialTrend as PolynomialTrend,
        fit_polynomial as fit_polynomial,
        is_virtual as is_virtual,
        virtual_sources as virtual_sources,
    )
    from osm2xodr.surface.street_points import points_along as points_along
    from osm2xodr.surface.survey import (
        DemComparison as DemComparison,
        SurfaceComparison as SurfaceComparison,
        compare_surfaces as compare_surfaces,
    )


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
        A file is missing, damaged, no raster, an image, not local, or without CRS; or heights cannot be turned into
        the vertical datum that is wanted.
    CoverageError
        The elevation models lie elsewhere, have no heights at the roads, or cover too little of them.
    """
    from osm2xodr.surface.reading import read

    return read(paths, frame, x, y, options, diagnostics)


__getattr__ = lazy_exports(
    __name__,
    {
        "comparison": ("MethodResult",),
        "dem_surface": ("DemSummary", "DemSurface"),
        "grids": ("PolynomialTrend", "fit_polynomial", "is_virtual", "virtual_sources"),
        "street_points": ("points_along",),
        "survey": ("DemComparison", "SurfaceComparison", "compare_surfaces"),
    },
)
