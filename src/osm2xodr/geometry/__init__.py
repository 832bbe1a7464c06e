"""Stage 3: streets and a surface become roads, junctions and connecting roads."""

from osm2xodr.geometry.roads import build_roads

__all__ = ["build_roads"]
