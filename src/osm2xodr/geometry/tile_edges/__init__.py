"""Areas side by side that are converted one by one: the results fit together where their roads are cut.

`find_borders` divides the roads of an area and its surroundings among the areas, `with_border_heights` fixes the
heights where roads are cut, and after all other stages `keep_own_area` cuts off the surroundings. Both it and
`cut_at_names`, for areas by themselves, cut roads where their names change.
"""

from __future__ import annotations

from osm2xodr.geometry.tile_edges.heights import COMMON_ORIGIN, Neighbourhood, with_border_heights
from osm2xodr.geometry.tile_edges.own_area import cut_at_names, keep_own_area
from osm2xodr.geometry.tile_edges.pieces import find_borders
from osm2xodr.geometry.tile_edges.report import default_speed_km

__all__ = [
    "COMMON_ORIGIN",
    "Neighbourhood",
    "cut_at_names",
    "default_speed_km",
    "find_borders",
    "keep_own_area",
    "with_border_heights",
]
