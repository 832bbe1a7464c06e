"""Polygons of areas with holes, which may be damaged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import shapely

from osm2xodr.model import FloatArray


def area_of(outline: FloatArray, holes: Sequence[FloatArray]) -> tuple[Any, bool]:
    """Return the area within an outline without its holes, (n, 2), m, each, and whether the outline was repaired."""
    shape = shapely.Polygon(outline)
    repaired = not shape.is_valid
    if repaired:
        shape = shapely.make_valid(shape)
    for hole in holes:
        shape = shapely.difference(shape, shapely.make_valid(shapely.Polygon(hole)))
    return shape, repaired


def polygons_of(shape: Any) -> list[Any]:
    """Return the polygons of a shape, without its lines and points."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if part.geom_type == "Polygon" and not part.is_empty]
