"""Strips beside the carriageway, and sidewalks round the corners of junctions."""

from __future__ import annotations

from osm2xodr.geometry.roadside.corner_lanes import with_lanes_of_sections
from osm2xodr.geometry.roadside.corner_narrowing import lay_out_corners
from osm2xodr.geometry.roadside.corner_strips import inner_width
from osm2xodr.geometry.roadside.cycle_tracks import ends_of_strips, with_cycle_tracks
from osm2xodr.geometry.roadside.sidewalk_ends import SidewalkEnds, ends_instead, find_sidewalk_ends, run_out
from osm2xodr.geometry.roadside.strip_clearance import margins_with_room
from osm2xodr.geometry.roadside.strip_lanes import add_margins, has_width
from osm2xodr.geometry.roadside.strips import Margins, find_margins

__all__ = [
    "Margins",
    "SidewalkEnds",
    "add_margins",
    "ends_instead",
    "ends_of_strips",
    "find_margins",
    "find_sidewalk_ends",
    "has_width",
    "inner_width",
    "lay_out_corners",
    "margins_with_room",
    "run_out",
    "with_cycle_tracks",
    "with_lanes_of_sections",
]
