"""Water of OSM files: lakes, rivers and basins, and the coast of the sea."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.model import Water, WaterArea
from osm2xodr.osmParsing.file import open_osm_file, places_of, read_areas, read_lines, read_nodes, rings_of

# OSM wiki, Key:water, Tag:waterway=riverbank, Tag:waterway=dock, Tag:landuse=reservoir: areas of open water.
_AREAS: Final = (("natural", "water"), ("waterway", "riverbank"), ("waterway", "dock"), ("landuse", "reservoir"))
# Tag:natural=coastline: the sea is on its right.
_COASTLINE: Final = (("natural", "coastline"),)


def read_water(path: Path) -> Water:
    """Return the water of an OSM file, without areas whose outline is not whole in it.

    Raises
    ------
    InputError
        The file cannot be read or is not OSM data.
    """
    file = open_osm_file(path)
    areas = [
        area
        for area in read_areas(file, _AREAS)[0]
        if area.tags.get("intermittent") != "yes" and area.tags.get("tunnel", "no") == "no"
    ]
    coast = read_lines(file, _COASTLINE)
    refs = [ring for area in areas for ring in (*area.outer, *area.inner)] + coast
    if not refs:
        return Water()
    nodes = read_nodes(file, np.unique(np.concatenate([np.array(ring, np.int64) for ring in refs])))
    found = []
    for area in areas:
        outlines, holes = rings_of(area, nodes)
        found += [WaterArea(area.osm_id, outline, holes) for outline in outlines]
    lines = (places_of(line, nodes, least=2) for line in coast)
    return Water(tuple(found), tuple(line for line in lines if line is not None))
