"""The meaning of a way's tags: access, direction, lanes, strips beside them, limits, structures.

Pure functions; `way_attributes` combines them. `cross_sections` is the place to start reading about lanes.
"""

from __future__ import annotations

from osm2xodr.osmParsing.tags.access import (
    ACCESS_TAGS as ACCESS_TAGS,
    changes_direction as changes_direction,
    is_roundabout as is_roundabout,
    oneway as oneway,
    reason_left_out as reason_left_out,
)
from osm2xodr.osmParsing.tags.beside_lanes import BESIDE_TAGS as BESIDE_TAGS, near_side as near_side
from osm2xodr.osmParsing.tags.cross_sections import (
    WIDTH_TAGS as WIDTH_TAGS,
    Kerbs as Kerbs,
    StreetFacts as StreetFacts,
    is_transition as is_transition,
    tagged_width as tagged_width,
)
from osm2xodr.osmParsing.tags.lane_counts import COUNT_TAGS as COUNT_TAGS
from osm2xodr.osmParsing.tags.lane_lists import LIST_TAGS as LIST_TAGS, TURN_TAGS as TURN_TAGS
from osm2xodr.osmParsing.tags.legal_speeds import (
    in_town as in_town,
    is_town_street as is_town_street,
    limit_words as limit_words,
    with_urban_speeds as with_urban_speeds,
)
from osm2xodr.osmParsing.tags.margins import (
    PARKING_TAGS as PARKING_TAGS,
    kerb_height as kerb_height,
    read_parking as read_parking,
    tells_of_shoulders as tells_of_shoulders,
    tells_of_sidewalks as tells_of_sidewalks,
)
from osm2xodr.osmParsing.tags.neighbours import ends_of_streets as ends_of_streets, street_of as street_of
from osm2xodr.osmParsing.tags.node_facts import (
    SIGN_KEYS as SIGN_KEYS,
    node_heights as node_heights,
    parse_ele as parse_ele,
    read_node_facts as read_node_facts,
    read_thing_facts as read_thing_facts,
    turning_circles as turning_circles,
    with_speed_zones as with_speed_zones,
)
from osm2xodr.osmParsing.tags.values import (
    LEFT_RIGHT as LEFT_RIGHT,
    NO as NO,
    Tags as Tags,
    parse_count as parse_count,
    parse_layer as parse_layer,
    parse_length as parse_length,
    parse_speed as parse_speed,
    sides_of as sides_of,
)
from osm2xodr.osmParsing.tags.way_facts import layer_of as layer_of, structure_of as structure_of
from osm2xodr.osmParsing.tags.ways import (
    WAY_TAGS as WAY_TAGS,
    turned_round as turned_round,
    way_attributes as way_attributes,
    without_margins as without_margins,
)
