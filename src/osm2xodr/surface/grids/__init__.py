"""One elevation model: its file, its cells, and its quality.

`raster_file` reads it (`archive`, `labels`, `vrt` and `vertical_crs` help), `grid` finds heights in it, `quality` and
`outliers` judge it, `voids` and `trend` fill it.
"""

from __future__ import annotations

from osm2xodr.surface.grids.archive import rasters_in
from osm2xodr.surface.grids.grid import (
    Cells,
    GridFrame,
    Interpolator,
    all_corners,
    empty_cells,
    make_interpolator,
    nearest_known,
)
from osm2xodr.surface.grids.labels import Unstated, unstated
from osm2xodr.surface.grids.outliers import find_outliers
from osm2xodr.surface.grids.quality import estimate_sigma, looks_covered, quantum_of, usual_sigma
from osm2xodr.surface.grids.raster_file import DemSource, describe_dem, read_heights
from osm2xodr.surface.grids.trend import PolynomialTrend, fit_polynomial, term_count
from osm2xodr.surface.grids.vertical_crs import FOOT, convert_heights, parse_datum
from osm2xodr.surface.grids.voids import fill_voids, rim_of
from osm2xodr.surface.grids.vrt import is_virtual, virtual_sources

__all__ = [
    "FOOT",
    "Cells",
    "DemSource",
    "GridFrame",
    "Interpolator",
    "PolynomialTrend",
    "Unstated",
    "all_corners",
    "convert_heights",
    "describe_dem",
    "empty_cells",
    "estimate_sigma",
    "fill_voids",
    "find_outliers",
    "fit_polynomial",
    "is_virtual",
    "looks_covered",
    "make_interpolator",
    "nearest_known",
    "parse_datum",
    "quantum_of",
    "rasters_in",
    "read_heights",
    "rim_of",
    "term_count",
    "unstated",
    "usual_sigma",
    "virtual_sources",
]
