"""Streets, intersections and turn restrictions."""

from __future__ import annotations

from osm2xodr.osmParsing.network.connectivity import read_connectivities
from osm2xodr.osmParsing.network.country import find_place
from osm2xodr.osmParsing.network.pieces import cut_at_shared_nodes, cut_gaps, join_same_places, make_lines
from osm2xodr.osmParsing.network.restrictions import read_restrictions
from osm2xodr.osmParsing.network.streets import make_streets, tags_on_streets

__all__ = [
    "cut_at_shared_nodes",
    "cut_gaps",
    "find_place",
    "join_same_places",
    "make_lines",
    "make_streets",
    "read_connectivities",
    "read_restrictions",
    "tags_on_streets",
]
