"""Points and segments within reach of an outline or of places."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, hypot, outline_bounds, ranks, repeated
from osm2xodr.model import BoolArray, FloatArray, Outline

# Length of the parts that long segments are divided into, m, and the largest number of them.
_PART: Final = 200.0
_PARTS_MAX: Final = 10_000


def reached(outline: Outline, start: FloatArray, end: FloatArray, far: FloatArray, reach: float) -> BoolArray:
    """Return which segments have a point within `reach` of an area, m; 0 for those that touch it.

    `start` and `end` (n, 2) are their ends, local x, y, m, `far` (n,) the distance of the nearer end from the area.
    """
    out = far <= reach
    west, south, east, north = outline_bounds(outline)
    beside = np.minimum(start, end) <= (east + reach, north + reach)
    beside &= np.maximum(start, end) >= (west - reach, south - reach)
    rest = np.flatnonzero(~out & beside.all(axis=1))
    # Segments without an end within reach come nearest to a corner, or cross an edge.
    for ring in outline.rings:
        for corner, following in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            if not len(rest):
                return out
            a, b = start[rest], end[rest]
            hit = (_to_point(a, b, corner) <= reach) | _crosses(a, b, corner, following)
            out[rest[hit]] = True
            rest = rest[~hit]
    return out


def _to_point(start: FloatArray, end: FloatArray, point: FloatArray) -> FloatArray:
    """Return the distance of segments (n, 2) from a point (2,), or from one each (n, 2), m."""
    along = end - start
    square = np.maximum((along * along).sum(axis=1), 1e-12)
    share = np.clip(((point - start) * along).sum(axis=1) / square, 0.0, 1.0)
    off = point - start - share[:, None] * along
    out: FloatArray = hypot(off[:, 0], off[:, 1])
    return out


def _crosses(start: FloatArray, end: FloatArray, corner: FloatArray, following: FloatArray) -> BoolArray:
    """Return which segments (n, 2) cross an edge; those in line with it meet it in a corner or not at all."""
    of_start, of_end = _side(corner, following, start), _side(corner, following, end)
    of_corner, of_following = _side(start, end, corner), _side(start, end, following)
    beside = (of_start != 0.0) | (of_end != 0.0)
    out: BoolArray = (of_start * of_end <= 0.0) & (of_corner * of_following <= 0.0) & beside
    return out


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> FloatArray:
    """Return the side of lines that points lie on: the sign of a cross product."""
    along, off = end - start, point - start
    out: FloatArray = np.sign(along[..., 0] * off[..., 1] - along[..., 1] * off[..., 0])
    return out


def near_places(start: FloatArray, end: FloatArray, places: FloatArray, reach: float) -> BoolArray:
    """Return which segments (n, 2) have a point within `reach` of any place (m, 2), m."""
    out = np.zeros(len(start), np.bool_)
    if not len(start) or not len(places):
        return out
    length = hypot(*(end - start).T)
    parts = np.clip(np.ceil(length / _PART), 1, _PARTS_MAX).astype(np.int64)
    segment = repeated(parts)
    share = ((ranks(parts) + 0.5) / parts[segment])[:, None]
    middle = start[segment] + share * (end[segment] - start[segment])
    index, found = PointTree(middle).within(places, reach + 0.5 * _PART)
    chosen = segment[found]
    out[chosen[_to_point(start[chosen], end[chosen], places[index]) <= reach]] = True
    return out


def points_near_places(points: FloatArray, places: FloatArray, reach: float) -> BoolArray:
    """Return which points (n, 2) are within `reach` of any place (m, 2), m."""
    if not len(points) or not len(places):
        return np.zeros(len(points), np.bool_)
    nearest, _ = PointTree(places).nearest(points)
    return np.asarray(nearest <= reach, np.bool_)
