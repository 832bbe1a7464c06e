"""What OSM files know beside roads.

That is water (lakes, rivers, basins and the coast of the sea) and buildings.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.curves import sorted_unique
from osm2xodr.model import Building, FloatArray, OpenWater, Surroundings, Water, WaterArea
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
from osm2xodr.osmParsing.tags import parse_length

# OSM wiki, Key:water, Tag:waterway=riverbank, Tag:waterway=dock, Tag:landuse=reservoir: areas of open water.
WATER_AREAS: Final = (("natural", "water"), ("waterway", "riverbank"), ("waterway", "dock"), ("landuse", "reservoir"))
# Tag:natural=coastline: the sea is on its right.
COASTLINE: Final = (("natural", "coastline"),)
# Keys of areas that are buildings or parts of them, and values of them that mean there is none.
BUILDING_KEYS: Final = ("building:part", "building")
_NONE: Final = frozenset({"no", "demolished", "collapsed", "proposed", "abandoned:no"})
# What lies below the ground.
_BELOW: Final = frozenset({"underground", "indoor"})
# Heights and storeys above the highest building's (828 m, 163 storeys) are mistakes.
_HEIGHT_MAX: Final = 830.0
_LEVELS_MAX: Final = 165.0
# What of a map is read here, as ways or as relations of `AREA_TYPE`: those with one of some keys, or of some tags.
SURROUNDINGS_KEYS: Final = frozenset(BUILDING_KEYS)
SURROUNDINGS_TAGS: Final = frozenset((*WATER_AREAS, *COASTLINE))


def in_surroundings(tags: Mapping[str, str]) -> bool:
    """Whether tags are those of what is read here."""
    return any(key in tags for key in SURROUNDINGS_KEYS) or any(
        tags.get(key) == value for key, value in SURROUNDINGS_TAGS
    )


def read_surroundings(path: Path) -> Surroundings:
    """Return the buildings and the water of an OSM file, without buildings whose outline is not whole in it.

    Raises
    ------
    InputError
        The file cannot be read or is not OSM data.
    """
    return Surroundings(read_buildings(path)[0], read_water(path))


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


def read_buildings(path: Path) -> tuple[tuple[Building, ...], tuple[str, ...]]:
    """Return the buildings of an OSM file, and the ids of those whose outline is not whole in it.

    Ways come first, then multipolygons, each in ascending id; an area with several outlines is as many buildings.

    Raises
    ------
    InputError
        The file cannot be read or is not OSM data.
    """
    file = open_osm_file(path)
    areas, broken = read_areas(file, frozenset(BUILDING_KEYS))
    areas = [area for area in areas if area.outer and _stands(area.tags)]
    rings = [ring for area in areas for ring in (*area.outer, *area.inner)]
    if not rings:
        return (), tuple(broken)
    wanted = sorted_unique(np.concatenate([np.array(ring, np.int64) for ring in rings]))
    nodes = read_nodes(file, wanted)
    out = []
    for area in areas:
        found = _buildings(area, nodes)
        if not found:
            broken.append(area.osm_id)
        out += found
    return tuple(out), tuple(broken)


def _stands(tags: Mapping[str, str]) -> bool:
    """Return whether tags are those of something that stands above the ground."""
    return (
        any(tags.get(key, "no") not in _NONE for key in BUILDING_KEYS)
        and tags.get("location") not in _BELOW
        and tags.get("tunnel", "no") == "no"
    )


def _buildings(area: RawArea, nodes: RawNodes) -> list[Building]:
    """Return the buildings of an area, without those of which nodes are missing."""
    tags = area.tags
    is_part = tags.get("building:part", "no") not in _NONE
    kind = tags["building:part" if is_part else "building"]
    outlines, holes = rings_of(area, nodes)
    return [
        Building(
            area.osm_id,
            outline,
            # Those of another outline are far from this one, and do not change it.
            holes,
            kind,
            is_part,
            height=_length(tags, "height", "building:height", "est_height"),
            min_height=_length(tags, "min_height", "building:min_height"),
            levels=_count(tags, "building:levels", "levels"),
            min_level=_count(tags, "building:min_level", "min_level"),
            roof_shape=tags.get("roof:shape", tags.get("building:roof:shape", "")),
            roof_height=_length(tags, "roof:height", "building:roof:height"),
            roof_levels=_count(tags, "roof:levels", "building:roof:levels"),
            ridge_across=tags.get("roof:orientation") == "across",
        )
        for outline in outlines
    ]


def _length(tags: Mapping[str, str], *keys: str) -> float | None:
    """Return the first length, m, of some keys that can be one of a building."""
    for key in keys:
        length = parse_length(tags.get(key, ""))
        if length is not None and 0.0 <= length <= _HEIGHT_MAX:
            return length
    return None


def _count(tags: Mapping[str, str], *keys: str) -> float | None:
    """Return the first number of storeys, halves among them, of some keys."""
    for key in keys:
        # Storeys have no unit: what is a length without one is a number.
        text = tags.get(key, "").split(";")[0].strip()
        number = parse_length(text) if text[-1:].isdigit() else None
        if number is not None and 0.0 <= number <= _LEVELS_MAX:
            return number
    return None
