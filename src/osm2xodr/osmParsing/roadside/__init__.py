"""Things and footways beside streets.

`things` collects what lies within `reach` of streets; `parallel_footways` makes sidewalks and bicycle tracks of
footways that are mapped apart, `guessed_strips` adds sidewalks of streets in towns that nobody has tagged and
shoulders of motorways, and `guessed_parking` that cars park along streets in towns.
"""

from __future__ import annotations

from osm2xodr.osmParsing.roadside.guessed_parking import with_guessed_parking
from osm2xodr.osmParsing.roadside.guessed_strips import with_guessed_shoulders, with_guessed_sidewalks
from osm2xodr.osmParsing.roadside.kerbs import WayPieces, kerbs_along
from osm2xodr.osmParsing.roadside.parallel_footways import attach_footways
from osm2xodr.osmParsing.roadside.reach import sample_streets
from osm2xodr.osmParsing.roadside.things import (
    is_thing,
    kerbs_beside,
    node_keys,
    read_beside,
    street_node_tags,
    way_values,
    ways_beside,
)
from osm2xodr.osmParsing.roadside.way_surroundings import crossing_densities, street_densities, street_facts

__all__ = [
    "WayPieces",
    "attach_footways",
    "crossing_densities",
    "is_thing",
    "kerbs_along",
    "kerbs_beside",
    "node_keys",
    "read_beside",
    "sample_streets",
    "street_densities",
    "street_facts",
    "street_node_tags",
    "way_values",
    "ways_beside",
    "with_guessed_parking",
    "with_guessed_shoulders",
    "with_guessed_sidewalks",
]
