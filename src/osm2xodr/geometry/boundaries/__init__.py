"""The outer edges of junctions, as OpenDRIVE 1.8 describes them: segments across arms and along connecting roads.

`lines` lines that cross · `edges` where the edges of connecting roads are · `arms` the arms in order, their lanes ·
`corners` what bounds a junction between two arms · `bulges` what lies outside of that · `boundaries` records of it
"""

from __future__ import annotations

from osm2xodr.geometry.boundaries.boundaries import with_boundaries

__all__ = ["with_boundaries"]
