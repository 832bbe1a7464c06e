"""Reading OSM files: formats, then ways, relations and nodes as they are in the file."""

from __future__ import annotations

from osm2xodr.osmParsing.file.access import (
    RawNodes as RawNodes,
    RawRelation as RawRelation,
    RawWay as RawWay,
    all_tags as all_tags,
    close_writer as close_writer,
    forgiving as forgiving,
    handle as handle,
    readable as readable,
)
from osm2xodr.osmParsing.file.areas import (
    AREA_TYPE as AREA_TYPE,
    RawArea as RawArea,
    known_pieces as known_pieces,
    places_of as places_of,
    read_areas as read_areas,
    read_bounds as read_bounds,
    read_lines as read_lines,
    rings_of as rings_of,
)
from osm2xodr.osmParsing.file.file_format import OsmFile as OsmFile, open_osm_file as open_osm_file
from osm2xodr.osmParsing.file.reader import (
    RELATION_TYPES as RELATION_TYPES,
    UNITS_PER_DEGREE as UNITS_PER_DEGREE,
    OtherWays as OtherWays,
    class_of as class_of,
    count_contents as count_contents,
    element_places as element_places,
    read_nodes as read_nodes,
    read_ways as read_ways,
)
