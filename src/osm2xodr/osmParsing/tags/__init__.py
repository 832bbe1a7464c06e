"""What tags mean."""

from __future__ import annotations

from osm2xodr.osmParsing.tags.access import ACCESS_TAGS, left_out, oneway
from osm2xodr.osmParsing.tags.cross_sections import is_transition
from osm2xodr.osmParsing.tags.legal_speeds import with_urban_speeds
from osm2xodr.osmParsing.tags.sides import LEFT_RIGHT, NO, sides_of
from osm2xodr.osmParsing.tags.sidewalks import kerb_height
from osm2xodr.osmParsing.tags.structures import layer_of, structure_of
from osm2xodr.osmParsing.tags.turning_circles import turning_places
from osm2xodr.osmParsing.tags.values import parse_length
from osm2xodr.osmParsing.tags.ways import WAY_TAGS, turned_round, way_attributes, without_margins

__all__ = [
    "ACCESS_TAGS",
    "LEFT_RIGHT",
    "NO",
    "WAY_TAGS",
    "is_transition",
    "kerb_height",
    "layer_of",
    "left_out",
    "oneway",
    "parse_length",
    "sides_of",
    "structure_of",
    "turned_round",
    "turning_places",
    "way_attributes",
    "with_urban_speeds",
    "without_margins",
]
