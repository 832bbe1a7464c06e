"""Stage 4: signals, signs and objects on and beside the roads of a `RoadMap`. It computes but places."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.furniture.options import EXTRA_OBJECTS, FurnitureOptions, parse_objects_option

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.model import RoadMap, StreetNetwork

__all__ = ["EXTRA_OBJECTS", "FurnitureOptions", "parse_objects_option", "place_furniture"]


def place_furniture(
    network: StreetNetwork, road_map: RoadMap, options: FurnitureOptions, diagnostics: Diagnostics
) -> RoadMap:
    """Return a road map with all that stands on and beside its roads.

    Parameters
    ----------
    network
        What OSM says.
    road_map
        The roads; with `RoadMap.places`.
    options
        What the user chose.
    diagnostics
        Gets what is guessed, and what is dropped and why.
    """
    # Here, so that the command line starts without numpy.
    from osm2xodr.furniture.placing import place

    return place(network, road_map, options, diagnostics)
