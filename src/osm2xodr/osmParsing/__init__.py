"""Stage 1: an OSM file becomes a `StreetNetwork`.

`file_format` and `reader` touch files; everything else is pure: `access` and `tags` (with `lane_lists`,
`lane_counts`, `beside_lanes`, `cross_sections`, `neighbours`, `values`) say what a way's tags mean, `restrictions`
and `connectivity` (with `relation_members`) what relations mean, `pieces`, `chains` and `network` make streets and
intersections of ways, `country` knows on which side a place drives.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.memory import release_memory
from osm2xodr.osmParsing.options import HIGHWAYS, PRESETS, ParseOptions, WaySelection, parse_ways_option

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
