"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from osm2xodr.geometry.elevation import ElevationOptions
from osm2xodr.geometry.grade_table import parse_grade_limits
from osm2xodr.geometry.roads import build_roads
from osm2xodr.geometry.turnarounds import RoadOptions

__all__ = ["ElevationOptions", "RoadOptions", "build_roads", "parse_grade_limits"]
