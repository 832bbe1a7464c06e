"""What OSM files know beside roads."""

from __future__ import annotations

from pathlib import Path

from osm2xodr.model import Surroundings
from osm2xodr.osmParsing.buildings import read_buildings
from osm2xodr.osmParsing.water import read_water


def read_surroundings(path: Path) -> Surroundings:
    """Return the buildings and the water of an OSM file, without buildings whose outline is not whole in it.

    Raises
    ------
    InputError
        The file cannot be read or is not OSM data.
    """
    return Surroundings(read_buildings(path)[0], read_water(path))
