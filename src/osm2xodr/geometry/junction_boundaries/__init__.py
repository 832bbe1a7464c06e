"""The outer edges of junctions, as OpenDRIVE 1.8 describes them: segments across arms and along connecting roads.

`edges` where the edges of connecting roads are, and cross · `corners` the arms in order, what bounds a junction
between two · `boundaries` what lies outside of that, and records of both
"""

from __future__ import annotations

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import RoadMap

__all__ = ["with_boundaries"]


def with_boundaries(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return a road map whose junctions know their boundary (ASAM OpenDRIVE 1.8, 12.10).

    It runs counter-clockwise: across each arm, then along the outermost edges of connecting roads to the next one.
    Junctions whose roads leave a gap between two arms have none, which is counted in a diagnostic: only further roads
    could close it, which are none for traffic, and readers take them for such.
    """
    # Versions before 1.8 have none, and need not load this.
    from osm2xodr.geometry.junction_boundaries.boundaries import find_boundaries

    return find_boundaries(road_map, diagnostics)
