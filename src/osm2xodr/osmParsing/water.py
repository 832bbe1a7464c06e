"""Water of OSM files: lakes, rivers and basins, and the coast of the sea."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.model import FloatArray, OpenWater, Water, WaterArea
from osm2xodr.osmParsing.file import (
    RawArea,
    RawNodes,
    known_pieces,
    open_osm_file,
    places_of,
    read_areas,
    read_bounds,
    read_lines,
    read_nodes,
    rings_of,
)

# OSM wiki, Key:water, Tag:waterway=riverbank, Tag:waterway=dock, Tag:landuse=reservoir: areas of open water.
WATER_AREAS: Final = (("natural", "water"), ("waterway", "riverbank"), ("waterway", "dock"), ("landuse", "reservoir"))
# Tag:natural=coastline: the sea is on its right.
COASTLINE: Final = (("natural", "coastline"),)


def read_water(path: Path) -> Water:
    """Return the water of an OSM file.

    Raises
    ------
    InputError
        The file cannot be read or is not OSM data.
    """
    file = open_osm_file(path)
    found, open_ones = read_areas(file, WATER_AREAS)
    areas = [
        area for area in found if area.tags.get("intermittent") != "yes" and area.tags.get("tunnel", "no") == "no"
    ]
    unclosed = tuple(osm_id for osm_id in open_ones if osm_id.startswith("way/"))
    coast = read_lines(file, COASTLINE)
    refs = [ring for area in areas for ring in (*area.outer, *area.inner, *area.lines)] + coast
    if not refs:
        return Water(unclosed=unclosed)
    nodes = read_nodes(file, sorted_unique(np.concatenate([np.array(ring, np.int64) for ring in refs])))
    whole, open_areas = [], []
    for area in areas:
        outlines, holes = rings_of(area, nodes)
        whole += [WaterArea(area.osm_id, outline, holes) for outline in outlines]
        lines = _open_lines(area, nodes)
        if lines:
            open_areas.append(OpenWater(area.osm_id, tuple(lines), holes))
    shores = (places_of(line, nodes, least=2) for line in coast)
    known = tuple(line for line in shores if line is not None)
    return Water(tuple(whole), tuple(open_areas), read_bounds(file) if open_areas else None, known, unclosed)


def _open_lines(area: RawArea, nodes: RawNodes) -> list[FloatArray]:
    """Return what is known of the rings of an area that are not whole."""
    rings = [(*ring, ring[0]) for ring in (*area.outer, *area.inner) if places_of(ring, nodes) is None]
    return [piece for line in (*area.lines, *rings) for piece in known_pieces(line, nodes)]
