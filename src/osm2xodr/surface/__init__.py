"""Stage 2: from elevation models to the height of the ground at local positions.

`read_surface` (in `reading`, with the steps in order) makes a `DemSurface` from any number of raster
files: `grids` reads and judges one elevation model, `mosaic` joins several into layers, `sampling` finds heights in
them. `FlatSurface` is the ground without elevation models. `compare_surfaces` (in `survey`) measures how well methods
of interpolation suit a user's own elevation models.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.surface.comparison import MethodResult as MethodResult
    from osm2xodr.surface.coverage import judge_coverage as judge_coverage
    from osm2xodr.surface.dem_surface import DemSummary as DemSummary, DemSurface as DemSurface
    from osm2xodr.surface.files import DEM_ENDINGS as DEM_ENDINGS, expand as expand
    from osm2xodr.surface.flat_surface import FlatSurface as FlatSurface
    from osm2xodr.surface.grids import is_virtual as is_virtual, virtual_sources as virtual_sources
    from osm2xodr.surface.options import (
        DEM_ENCODINGS as DEM_ENCODINGS,
        DEM_TYPES as DEM_TYPES,
        METHODS as METHODS,
        SurfaceOptions as SurfaceOptions,
    )
    from osm2xodr.surface.reading import (
        points_along as points_along,
        read_surface as read_surface,
        suspect_feet as suspect_feet,
    )
    from osm2xodr.surface.survey import (
        DemComparison as DemComparison,
        SurfaceComparison as SurfaceComparison,
        compare_surfaces as compare_surfaces,
    )

# A flat world does without whatever reads elevation models, which takes a while to load.
__getattr__ = lazy_exports(
    __name__,
    {
        "comparison": ("MethodResult",),
        "coverage": ("judge_coverage",),
        "dem_surface": ("DemSummary", "DemSurface"),
        "files": ("DEM_ENDINGS", "expand"),
        "grids": ("is_virtual", "virtual_sources"),
        "flat_surface": ("FlatSurface",),
        "options": ("DEM_ENCODINGS", "DEM_TYPES", "METHODS", "SurfaceOptions"),
        "reading": ("points_along", "read_surface", "suspect_feet"),
        "survey": ("DemComparison", "SurfaceComparison", "compare_surfaces"),
    },
)
