"""Stage 1: an OSM file becomes a `StreetNetwork`.

`parsing` has the steps in order. `file` reads OSM files and is all that touches them; the rest is pure:

- `selection` decides which ways become streets,
- `tags` knows what the tags of ways mean (start with `tags.cross_sections`),
- `corrections` applies what users know better,
- `network` makes streets and intersections of ways, and reads relations between them,
- `roadside` finds footways and things beside streets,
- `surroundings` reads what a scene has beside roads: buildings and water.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.osmParsing.corrections import (
        CORRECTION_KEYS as CORRECTION_KEYS,
        drops_relation as drops_relation,
        node_correction as node_correction,
        way_correction as way_correction,
    )
    from osm2xodr.osmParsing.file import (
        AREA_TYPE as AREA_TYPE,
        RELATION_TYPES as RELATION_TYPES,
        UNITS_PER_DEGREE as UNITS_PER_DEGREE,
        OsmFile as OsmFile,
        RawNodes as RawNodes,
        RawWay as RawWay,
        all_tags as all_tags,
        class_of as class_of,
        close_writer as close_writer,
        element_places as element_places,
        forgiving as forgiving,
        handle as handle,
        open_osm_file as open_osm_file,
        read_nodes as read_nodes,
        read_ways as read_ways,
        readable as readable,
    )
    from osm2xodr.osmParsing.options import (
        DRIVABLE as DRIVABLE,
        HIGHWAYS as HIGHWAYS,
        PRESETS as PRESETS,
        ParseOptions as ParseOptions,
        WaySelection as WaySelection,
        parse_ways_option as parse_ways_option,
    )
    from osm2xodr.osmParsing.parsing import parse_osm as parse_osm
    from osm2xodr.osmParsing.roadside import is_thing as is_thing, node_keys as node_keys, way_values as way_values
    from osm2xodr.osmParsing.surroundings import (
        SURROUNDINGS_KEYS as SURROUNDINGS_KEYS,
        SURROUNDINGS_TAGS as SURROUNDINGS_TAGS,
        in_surroundings as in_surroundings,
        read_surroundings as read_surroundings,
    )
    from osm2xodr.osmParsing.tags import ACCESS_TAGS as ACCESS_TAGS, reason_left_out as reason_left_out

# The command line uses the options alone, and should not wait for what reading needs.
__getattr__ = lazy_exports(
    __name__,
    {
        "corrections": ("CORRECTION_KEYS", "drops_relation", "node_correction", "way_correction"),
        "file": (
            "AREA_TYPE",
            "RELATION_TYPES",
            "UNITS_PER_DEGREE",
            "OsmFile",
            "RawNodes",
            "RawWay",
            "all_tags",
            "class_of",
            "close_writer",
            "element_places",
            "forgiving",
            "handle",
            "open_osm_file",
            "read_nodes",
            "read_ways",
            "readable",
        ),
        "options": ("DRIVABLE", "HIGHWAYS", "PRESETS", "ParseOptions", "WaySelection", "parse_ways_option"),
        "parsing": ("parse_osm",),
        "roadside": ("is_thing", "node_keys", "way_values"),
        "surroundings": ("SURROUNDINGS_KEYS", "SURROUNDINGS_TAGS", "in_surroundings", "read_surroundings"),
        "tags": ("ACCESS_TAGS", "reason_left_out"),
    },
)
