"""Superelevation: how roads slope across.

`cross_slope` of fast roads, as measured or designed · `warp` of arms on hillsides
"""

from __future__ import annotations

from osm2xodr.geometry.heights.superelevation.cross_slope import road_superelevation
from osm2xodr.geometry.heights.superelevation.warp import (
    longest_warp,
    sloping_junctions,
    warp_ends,
    warp_profiles,
)

__all__ = [
    "longest_warp",
    "road_superelevation",
    "sloping_junctions",
    "warp_ends",
    "warp_profiles",
]
