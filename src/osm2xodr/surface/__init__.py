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
    from osm2xodr.surface.flat_surface import FlatSurface as FlatSurface
    from osm2xodr.surface.grids import is_virtual as is_virtual, virtual_sources as virtual_sources
    from osm2xodr.surface.options import (
        DEM_ENCODINGS as DEM_ENCODINGS,
        DEM_ENDINGS as DEM_ENDINGS,
        DEM_TYPES as DEM_TYPES,
        METHODS as METHODS,
        SurfaceOptions as SurfaceOptions,
        expand as expand,
    )
    from osm2xodr.surface.reading import (
        judge_coverage as judge_coverage,
        points_along as points_along,
        read_surface as read_surface,
        suspect_feet as suspect_feet,
    )
    from osm2xodr.surface.sampling import DemSummary as DemSummary, DemSurface as DemSurface
    from osm2xodr.surface.survey import (
        DemComparison as DemComparison,
        MethodResult as MethodResult,
        SurfaceComparison as SurfaceComparison,
        compare_surfaces as compare_surfaces,
    )

# A flat world does without whatever reads elevation models, which takes a while to load.
__getattr__ = lazy_exports(
    __name__,
    {
        "survey": ("DemComparison", "MethodResult", "SurfaceComparison", "compare_surfaces"),
        "reading": ("judge_coverage", "points_along", "read_surface", "suspect_feet"),
        "sampling": ("DemSummary", "DemSurface"),
        "options": ("DEM_ENCODINGS", "DEM_ENDINGS", "DEM_TYPES", "METHODS", "SurfaceOptions", "expand"),
        "grids": ("is_virtual", "virtual_sources"),
        "flat_surface": ("FlatSurface",),
    },
)
