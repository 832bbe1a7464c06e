"""Roofs over any outline: heights over the smallest rectangle around it, and the faces between which they bend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from osm2xodr.model import Building, FloatArray

# Shapes as they are drawn by values of ``roof:shape``; the others are drawn flat.
SHAPES: Final = {
    **dict.fromkeys(("gabled", "half-hipped", "gambrel", "saltbox", "round"), "gabled"),
    **dict.fromkeys(("hipped", "mansard", "half_hipped", "side_hipped"), "hipped"),
    **dict.fromkeys(("pyramidal", "dome", "onion", "cone"), "pyramidal"),
}


@dataclass(frozen=True, eq=False)
class Box:
    """The smallest rectangle around an outline: u along its longer side (the ridge), v to the left of it."""

    middle: FloatArray  # x, y, m
    along: FloatArray  # Unit vector of u
    half_length: float  # m
    half_width: float  # m


def box_of(outline: shapely.Polygon, building: Building) -> Box:
    """Return the smallest rectangle around an outline, with the ridge as the building's tags want it."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(outline))[:4]
    one, other = corners[1] - corners[0], corners[2] - corners[1]
    if (np.hypot(*one) < np.hypot(*other)) != building.ridge_across:
        one, other = other, one
    length, width = float(np.hypot(*one)), float(np.hypot(*other))
    return Box(corners.mean(0), one / max(length, 1e-9), 0.5 * length, 0.5 * width)


def roof_pieces(outline: shapely.Polygon, box: Box, shape: str) -> FloatArray:
    """Return the triangles of a roof, (n, 3, 3): x, y, m, and the height from 0 at eaves to 1 at the ridge.

    `shape` is one of the values of `SHAPES`, or ``flat``.
    """
    regions, rise = _REGIONS[shape](box), _RISES[shape]
    pieces = outline if regions is None else shapely.intersection(outline, regions)
    parts = shapely.get_parts(shapely.get_parts(pieces))
    parts = parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(parts))
    xy = shapely.get_coordinates(shapely.orient_polygons(triangles)).reshape(-1, 4, 2)[:, :3]
    off = xy - box.middle
    u = np.abs(off @ box.along)
    v = np.abs(off @ np.array([-box.along[1], box.along[0]]))
    return np.concatenate([xy, np.clip(rise(u, v, box), 0.0, 1.0)[..., None]], -1)


def _polygons(box: Box, corners: list[list[tuple[float, float]]]) -> FloatArray:
    """Return polygons from their corners in shares of half the length and width, larger than the box by a half."""
    across = np.array([-box.along[1], box.along[0]])
    return np.array(
        [
            shapely.Polygon(
                [box.middle + u * box.half_length * box.along + v * box.half_width * across for u, v in ring]
            )
            for ring in corners
        ]
    )


def _gabled(box: Box) -> FloatArray:
    return _polygons(box, [[(-2, 0), (2, 0), (2, 2), (-2, 2)], [(-2, -2), (2, -2), (2, 0), (-2, 0)]])


def _hipped(box: Box) -> FloatArray:
    # The ridge ends as far from the short sides as from the long ones.
    end = max(1.0 - box.half_width / max(box.half_length, 1e-9), 0.0)
    slant = 2.0 * (1.0 - end) + end
    if end == 0.0:
        return _pyramidal(box)
    return _polygons(
        box,
        [
            [(-end, 0), (end, 0), (slant, 2), (-slant, 2)],
            [(-slant, -2), (slant, -2), (end, 0), (-end, 0)],
            [(end, 0), (slant, -2), (slant, 2)],
            [(-end, 0), (-slant, 2), (-slant, -2)],
        ],
    )


def _pyramidal(box: Box) -> FloatArray:
    a, b, c, d = (-2, -2), (2, -2), (2, 2), (-2, 2)
    return _polygons(box, [[(0, 0), *sides] for sides in ([a, b], [b, c], [c, d], [d, a])])


_REGIONS: Final[dict[str, Callable[[Box], FloatArray | None]]] = {
    "flat": lambda _: None,
    "gabled": _gabled,
    "hipped": _hipped,
    "pyramidal": _pyramidal,
}
_RISES: Final[dict[str, Callable[[FloatArray, FloatArray, Box], FloatArray]]] = {
    "flat": lambda u, v, box: np.zeros_like(u),
    "gabled": lambda u, v, box: 1.0 - v / box.half_width,
    "hipped": lambda u, v, box: np.minimum(
        1.0 - v / box.half_width, (box.half_length - u) / min(box.half_width, box.half_length)
    ),
    "pyramidal": lambda u, v, box: 1.0 - np.maximum(u / box.half_length, v / box.half_width),
}
