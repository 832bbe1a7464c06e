"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from osm2xodr.geometry.borders import COMMON_ORIGIN, Neighbourhood, cut_at_names, keep_own_area
from osm2xodr.geometry.boundaries import with_boundaries
from osm2xodr.geometry.heights import ElevationOptions, Ground, ground_around, parse_grade_limits
from osm2xodr.geometry.junctions import RoadOptions
from osm2xodr.geometry.roads import build_roads
from osm2xodr.geometry.unmeasured import mark_unmeasured

__all__ = [
    "COMMON_ORIGIN",
    "ElevationOptions",
    "Ground",
    "Neighbourhood",
    "RoadOptions",
    "build_roads",
    "cut_at_names",
    "ground_around",
    "keep_own_area",
    "mark_unmeasured",
    "parse_grade_limits",
    "with_boundaries",
]
