"""Things and footways beside streets.

`things` collects what lies within `reach` of streets; `parallel_footways` makes sidewalks and bicycle tracks of
footways that are mapped apart, `guessed_strips` adds sidewalks of streets in towns that nobody has tagged and
shoulders of motorways, and `guessed_parking` that cars park along streets in towns.
"""

from __future__ import annotations

from osm2xodr.osmParsing.roadside.guessed_parking import with_guessed_parking as with_guessed_parking
from osm2xodr.osmParsing.roadside.guessed_strips import (
    with_guessed_shoulders as with_guessed_shoulders,
    with_guessed_sidewalks as with_guessed_sidewalks,
)
from osm2xodr.osmParsing.roadside.kerbs import WayPieces as WayPieces, kerbs_along as kerbs_along
from osm2xodr.osmParsing.roadside.parallel_footways import attach_footways as attach_footways
from osm2xodr.osmParsing.roadside.reach import sample_streets as sample_streets
from osm2xodr.osmParsing.roadside.things import (
    is_thing as is_thing,
    kerbs_beside as kerbs_beside,
    node_keys as node_keys,
    read_beside as read_beside,
    street_node_tags as street_node_tags,
    way_values as way_values,
    ways_beside as ways_beside,
)
from osm2xodr.osmParsing.roadside.way_surroundings import (
    crossing_densities as crossing_densities,
    street_densities as street_densities,
    street_facts as street_facts,
)
