"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from osm2xodr.geometry.border_heights import COMMON_ORIGIN, Neighbourhood
from osm2xodr.geometry.border_split import keep_own
from osm2xodr.geometry.elevation import ElevationOptions, Ground, ground_around
from osm2xodr.geometry.grade_table import parse_grade_limits
from osm2xodr.geometry.roads import build_roads
from osm2xodr.geometry.turnarounds import RoadOptions

__all__ = [
    "COMMON_ORIGIN",
    "ElevationOptions",
    "Ground",
    "Neighbourhood",
    "RoadOptions",
    "build_roads",
    "ground_around",
    "keep_own",
    "parse_grade_limits",
]
