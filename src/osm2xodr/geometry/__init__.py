"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from osm2xodr.geometry.elevation import ElevationOptions, Ground, ground_around
from osm2xodr.geometry.grade_table import parse_grade_limits
from osm2xodr.geometry.roads import build_roads
from osm2xodr.geometry.turnarounds import RoadOptions

__all__ = ["ElevationOptions", "Ground", "RoadOptions", "build_roads", "ground_around", "parse_grade_limits"]
