"""The meaning of a way's tags: access, direction, lanes, strips beside them, limits, structures.

Pure functions; `way_attributes` combines them. `cross_sections` is the place to start reading about lanes.
"""

from __future__ import annotations

from osm2xodr.osmParsing.tags.access import ACCESS_TAGS, changes_direction, is_roundabout, oneway, reason_left_out
from osm2xodr.osmParsing.tags.beside_lanes import BESIDE_TAGS, near_side
from osm2xodr.osmParsing.tags.cross_sections import WIDTH_TAGS, Kerbs, StreetFacts, is_transition, tagged_width
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS
from osm2xodr.osmParsing.tags.lane_lists import LIST_TAGS, TURN_TAGS
from osm2xodr.osmParsing.tags.legal_speeds import in_town, is_town_street, limit_words, with_urban_speeds
from osm2xodr.osmParsing.tags.margins import (
    PARKING_TAGS,
    kerb_height,
    read_parking,
    tells_of_shoulders,
    tells_of_sidewalks,
)
from osm2xodr.osmParsing.tags.neighbours import ends_of_streets, street_of
from osm2xodr.osmParsing.tags.node_facts import (
    SIGN_KEYS,
    node_heights,
    parse_ele,
    read_node_facts,
    read_thing_facts,
    turning_circles,
    with_speed_zones,
)
from osm2xodr.osmParsing.tags.values import (
    LEFT_RIGHT,
    NO,
    Tags,
    parse_count,
    parse_layer,
    parse_length,
    parse_speed,
    sides_of,
)
from osm2xodr.osmParsing.tags.way_facts import layer_of, structure_of
from osm2xodr.osmParsing.tags.ways import WAY_TAGS, turned_round, way_attributes, without_margins

__all__ = [
    "ACCESS_TAGS",
    "BESIDE_TAGS",
    "COUNT_TAGS",
    "LEFT_RIGHT",
    "LIST_TAGS",
    "NO",
    "PARKING_TAGS",
    "SIGN_KEYS",
    "TURN_TAGS",
    "WAY_TAGS",
    "WIDTH_TAGS",
    "Kerbs",
    "StreetFacts",
    "Tags",
    "changes_direction",
    "ends_of_streets",
    "in_town",
    "is_roundabout",
    "is_town_street",
    "is_transition",
    "kerb_height",
    "layer_of",
    "limit_words",
    "near_side",
    "node_heights",
    "oneway",
    "parse_count",
    "parse_ele",
    "parse_layer",
    "parse_length",
    "parse_speed",
    "read_node_facts",
    "read_parking",
    "read_thing_facts",
    "reason_left_out",
    "sides_of",
    "street_of",
    "structure_of",
    "tagged_width",
    "tells_of_shoulders",
    "tells_of_sidewalks",
    "turned_round",
    "turning_circles",
    "way_attributes",
    "with_speed_zones",
    "with_urban_speeds",
    "without_margins",
]
