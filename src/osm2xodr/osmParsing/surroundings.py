"""What OSM files know beside roads."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from osm2xodr.model import Surroundings
from osm2xodr.osmParsing.buildings import BUILDING_KEYS, read_buildings
from osm2xodr.osmParsing.water import COASTLINE, WATER_AREAS, read_water

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
