"""Junctions: which nodes make one, where its arms end, who may go where."""

from __future__ import annotations

from osm2xodr.geometry.junctions.absorbed_streets import refuse_without_roads, report_lost
from osm2xodr.geometry.junctions.clusters import JunctionLayout, lay_out_junctions
from osm2xodr.geometry.junctions.movements import Movement, find_movements
from osm2xodr.geometry.junctions.places import street_places
from osm2xodr.geometry.junctions.reference_line_shift import lines_outside_bends
from osm2xodr.geometry.junctions.road_parts import RoadParts, cut_roads, dead_ends_apart, without_idle_junctions
from osm2xodr.geometry.junctions.turnarounds import RoadOptions, add_turnarounds, with_loops

__all__ = [
    "JunctionLayout",
    "Movement",
    "RoadOptions",
    "RoadParts",
    "add_turnarounds",
    "cut_roads",
    "dead_ends_apart",
    "find_movements",
    "lay_out_junctions",
    "lines_outside_bends",
    "refuse_without_roads",
    "report_lost",
    "street_places",
    "with_loops",
    "without_idle_junctions",
]
