"""Stage 1: an OSM file becomes a `StreetNetwork`.

`file_format` and `reader` touch files; everything else is pure: `access` and `tags` (with `lane_lists`,
`lane_counts`, `beside_lanes`, `cross_sections`, `neighbours`, `values`) say what a way's tags mean, `restrictions`
and `connectivity` (with `relation_members`) what relations mean, `pieces`, `chains` and `network` make streets and
intersections of ways, `country` knows on which side a place drives.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.osmParsing.file import (
        RELATION_TYPES as RELATION_TYPES,
        UNITS_PER_DEGREE as UNITS_PER_DEGREE,
        OsmFile as OsmFile,
        RawNodes as RawNodes,
        RawWay as RawWay,
        element_places as element_places,
        handle as handle,
        open_osm_file as open_osm_file,
        read_nodes as read_nodes,
        read_ways as read_ways,
        readable as readable,
    )
    from osm2xodr.osmParsing.options import DRIVABLE as DRIVABLE
    from osm2xodr.osmParsing.roadside import is_thing as is_thing, node_keys as node_keys, way_values as way_values
    from osm2xodr.osmParsing.tags import ACCESS_TAGS as ACCESS_TAGS, reason_left_out as reason_left_out

from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.osmParsing.options import HIGHWAYS, PRESETS, ParseOptions, WaySelection, parse_ways_option
from osm2xodr.system import release_memory

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.model import StreetNetwork

__all__ = ["HIGHWAYS", "PRESETS", "ParseOptions", "WaySelection", "parse_osm", "parse_ways_option"]


def parse_osm(path: Path, options: ParseOptions, diagnostics: Diagnostics) -> StreetNetwork:
    """Read the streets of an OSM file.

    Parameters
    ----------
    path
        An OSM file: .osm, .osm.gz, .osm.bz2 or .osm.pbf, told by its content.
    options
        What to read of it.
    diagnostics
        Gets what is guessed, dropped or repaired.

    Raises
    ------
    InputError
        The file cannot be read, is not OSM data, or has no way that cars may drive on.
    """
    # What reading needs takes a while to import, which a command line that only prints its help should not wait for.
    from osm2xodr.osmParsing.parsing import parse

    network = parse(path, options, diagnostics)
    # Many times the network's size was needed to read it.
    release_memory()
    return network


__getattr__ = lazy_exports(
    __name__,
    {
        "file": (
            "OsmFile",
            "RELATION_TYPES",
            "RawNodes",
            "RawWay",
            "UNITS_PER_DEGREE",
            "element_places",
            "handle",
            "open_osm_file",
            "read_nodes",
            "read_ways",
            "readable",
        ),
        "options": ("DRIVABLE",),
        "roadside": ("is_thing", "node_keys", "way_values"),
        "tags": ("ACCESS_TAGS", "reason_left_out"),
    },
)
