"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.geometry.heights import Ground as Ground, ground_around as ground_around
    from osm2xodr.geometry.junction_boundaries import with_boundaries as with_boundaries
    from osm2xodr.geometry.options import (
        ElevationOptions as ElevationOptions,
        RoadOptions as RoadOptions,
    )
    from osm2xodr.geometry.roads import build_roads as build_roads
    from osm2xodr.geometry.tile_edges import (
        COMMON_ORIGIN as COMMON_ORIGIN,
        Neighbourhood as Neighbourhood,
        cut_at_names as cut_at_names,
        keep_own_area as keep_own_area,
    )
    from osm2xodr.geometry.unmeasured import mark_unmeasured as mark_unmeasured

# The options are read before anything is loaded that takes a while.
__getattr__ = lazy_exports(
    __name__,
    {
        "tile_edges": ("COMMON_ORIGIN", "Neighbourhood", "cut_at_names", "keep_own_area"),
        "junction_boundaries": ("with_boundaries",),
        "heights": ("Ground", "ground_around"),
        "options": ("ElevationOptions", "RoadOptions"),
        "roads": ("build_roads",),
        "unmeasured": ("mark_unmeasured",),
    },
)
