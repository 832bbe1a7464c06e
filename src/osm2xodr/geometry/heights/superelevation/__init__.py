"""Superelevation: how roads slope across.

`cross_slope` of fast roads, as measured or designed, and a little of it that spares lanes steps of their grade ·
`crossfall` that they are designed with · `warp` of arms on hillsides
"""

from __future__ import annotations

from osm2xodr.geometry.heights.superelevation.cross_slope import ease_lane_grades, road_superelevation
from osm2xodr.geometry.heights.superelevation.warp import (
    longest_warp,
    sloping_junctions,
    warp_ends,
    warp_profiles,
)

__all__ = [
    "ease_lane_grades",
    "longest_warp",
    "road_superelevation",
    "sloping_junctions",
    "warp_ends",
    "warp_profiles",
]
