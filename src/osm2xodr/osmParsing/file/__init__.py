"""Reading OSM files: formats, then ways, relations and nodes as they are in the file."""

from __future__ import annotations

from osm2xodr.osmParsing.file.access import (
    RawNodes,
    RawRelation,
    RawWay,
    all_tags,
    close_writer,
    forgiving,
    handle,
    readable,
)
from osm2xodr.osmParsing.file.areas import (
    AREA_TYPE,
    RawArea,
    known_pieces,
    places_of,
    read_areas,
    read_bounds,
    read_lines,
    rings_of,
)
from osm2xodr.osmParsing.file.file_format import OsmFile, open_osm_file
from osm2xodr.osmParsing.file.reader import (
    RELATION_TYPES,
    UNITS_PER_DEGREE,
    OtherWays,
    class_of,
    count_contents,
    element_places,
    read_nodes,
    read_ways,
)

__all__ = [
    "AREA_TYPE",
    "RELATION_TYPES",
    "UNITS_PER_DEGREE",
    "OsmFile",
    "OtherWays",
    "RawArea",
    "RawNodes",
    "RawRelation",
    "RawWay",
    "all_tags",
    "class_of",
    "close_writer",
    "count_contents",
    "element_places",
    "forgiving",
    "handle",
    "known_pieces",
    "open_osm_file",
    "places_of",
    "read_areas",
    "read_bounds",
    "read_lines",
    "read_nodes",
    "read_ways",
    "readable",
    "rings_of",
]
