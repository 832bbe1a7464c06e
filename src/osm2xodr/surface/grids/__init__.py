"""One elevation model: its file, its cells, and its quality.

`raster_file` reads it (`containers` and `crs` help), `grid` finds heights in it, `quality` judges it, `voids` fills
it.
"""

from __future__ import annotations

from osm2xodr.surface.grids.containers import is_virtual, rasters_in, virtual_sources
from osm2xodr.surface.grids.crs import FOOT, Unstated, convert_heights, parse_datum, unstated
from osm2xodr.surface.grids.grid import (
    Cells,
    GridFrame,
    Interpolator,
    all_corners,
    empty_cells,
    make_interpolator,
    nearest_known,
)
from osm2xodr.surface.grids.quality import estimate_sigma, find_outliers, looks_covered, quantum_of, usual_sigma
from osm2xodr.surface.grids.raster_file import DemSource, describe_dem, read_heights
from osm2xodr.surface.grids.voids import PolynomialTrend, fill_voids, fit_polynomial, rim_of, term_count

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
