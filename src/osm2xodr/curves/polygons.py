"""Points and polygons: which points are inside, and how far off the others are."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.trigonometry import hypot
from osm2xodr.model import BoolArray, FloatArray, IntArray, Outline, Partition

# Pairs of a point and an edge that are compared at a time: some 8 MB a table.
_PAIRS_AT_ONCE: Final = 1 << 20


def inside_outline(outline: Outline, x: FloatArray, y: FloatArray) -> BoolArray:
    """Say which points (n,) are inside: an odd number of rings goes round them.

    A point on the common edge of two areas is inside exactly one of them: the same rounding decides for both.
    """
    out = np.zeros(len(x), np.bool_)
    for x0, y0, x1, y1 in _edges(outline).tolist():
        if y0 == y1:
            continue
        # From the lower end to the upper one, whichever way round the ring runs.
        if y0 > y1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        beside = (y0 <= y) & (y < y1)
        out[beside] ^= x0 + (y[beside] - y0) / (y1 - y0) * (x1 - x0) > x[beside]
    return out


def distance_to_outline(outline: Outline, x: FloatArray, y: FloatArray, reach: float) -> FloatArray:
    """Return how far points (n,) are off, m; 0 inside, infinite where that is certainly more than `reach`, m."""
    out = np.full(len(x), np.inf)
    west, south, east, north = outline_bounds(outline)
    near = np.flatnonzero((x >= west - reach) & (x <= east + reach) & (y >= south - reach) & (y <= north + reach))
    x0, y0, x1, y1 = _edges(outline).T
    dx, dy = x1 - x0, y1 - y0
    square = np.maximum(dx * dx + dy * dy, 1e-12)
    step = max(1, _PAIRS_AT_ONCE // len(x0))
    for first in range(0, len(near), step):
        part = near[first : first + step]
        px, py = x[part, None], y[part, None]
        share = np.clip(((px - x0) * dx + (py - y0) * dy) / square, 0.0, 1.0)
        out[part] = hypot(px - x0 - share * dx, py - y0 - share * dy).min(axis=1)
    out[near[inside_outline(outline, x[near], y[near])]] = 0.0
    return out


def outline_bounds(outline: Outline) -> tuple[float, float, float, float]:
    """Return west, south, east, north of an area, m."""
    corners = np.concatenate(outline.rings)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return west, south, east, north


def area_bounds(partition: Partition) -> FloatArray:
    """Return west, south, east, north of all areas, (areas, 4), m."""
    return np.array([outline_bounds(outline) for outline in partition.outlines]).reshape(-1, 4)


def area_at(partition: Partition, x: FloatArray, y: FloatArray, bounds: FloatArray | None = None) -> IntArray:
    """Return the index of the area that each point (n,) belongs to; -1 outside of all, the first where they overlap.

    `bounds` is the result of `area_bounds`, where it is at hand.
    """
    out = np.full(len(x), -1, np.int64)
    if not len(x):
        return out
    west, south, east, north = (area_bounds(partition) if bounds is None else bounds).T
    near = (east >= x.min()) & (west <= x.max()) & (north >= y.min()) & (south <= y.max())
    for index in np.flatnonzero(near)[::-1].tolist():
        out[inside_outline(partition.outlines[index], x, y)] = index
    return out


def _edges(outline: Outline) -> FloatArray:
    """Return x, y of both ends of all edges, (edges, 4)."""
    return np.concatenate([np.column_stack([ring, np.roll(ring, -1, axis=0)]) for ring in outline.rings])
