"""One elevation model: its file, its cells, and its quality.

`raster_file` reads it (`containers` and `crs` help), `grid` finds heights in it, `quality` judges it, `voids` fills
it.
"""

from __future__ import annotations

from osm2xodr.surface.grids.containers import (
    is_virtual as is_virtual,
    rasters_in as rasters_in,
    virtual_sources as virtual_sources,
)
from osm2xodr.surface.grids.crs import (
    FOOT as FOOT,
    Unstated as Unstated,
    convert_heights as convert_heights,
    parse_datum as parse_datum,
    unstated as unstated,
)
from osm2xodr.surface.grids.grid import (
    Cells as Cells,
    GridFrame as GridFrame,
    Interpolator as Interpolator,
    all_corners as all_corners,
    empty_cells as empty_cells,
    make_interpolator as make_interpolator,
    nearest_known as nearest_known,
)
from osm2xodr.surface.grids.quality import (
    estimate_sigma as estimate_sigma,
    find_outliers as find_outliers,
    looks_covered as looks_covered,
    quantum_of as quantum_of,
    usual_sigma as usual_sigma,
)
from osm2xodr.surface.grids.raster_file import (
    DemSource as DemSource,
    describe_dem as describe_dem,
    read_heights as read_heights,
)
from osm2xodr.surface.grids.voids import (
    PolynomialTrend as PolynomialTrend,
    fill_voids as fill_voids,
    fit_polynomial as fit_polynomial,
    rim_of as rim_of,
    term_count as term_count,
)
