"""Points and outlines: which are inside, and how far off the others are."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, IntArray, Outline, Partition

# Points times edges that are held against each other at a time: some 8 MB a table.
_CHUNK = 1 << 20


def inside(outline: Outline, x: FloatArray, y: FloatArray) -> BoolArray:
    """Return which points (n,) an odd number of rings goes round.

    Points on an edge are inside one of the two areas that share it: the same rounding decides for both.
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


def distance(outline: Outline, x: FloatArray, y: FloatArray, reach: float) -> FloatArray:
    """Return how far points (n,) are off, m; 0 inside, infinite for what is certainly beyond reach."""
    out = np.full(len(x), np.inf)
    west, south, east, north = box(outline)
    beside = (x >= west - reach) & (x <= east + reach) & (y >= south - reach) & (y <= north + reach)
    near = np.flatnonzero(beside)
    x0, y0, x1, y1 = _edges(outline).T
    dx, dy = x1 - x0, y1 - y0
    square = np.maximum(dx * dx + dy * dy, 1e-12)
    step = max(1, _CHUNK // len(x0))
    for first in range(0, len(near), step):
        part = near[first : first + step]
        px, py = x[part, None], y[part, None]
        share = np.clip(((px - x0) * dx + (py - y0) * dy) / square, 0.0, 1.0)
        out[part] = np.hypot(px - x0 - share * dx, py - y0 - share * dy).min(axis=1)
    out[near[inside(outline, x[near], y[near])]] = 0.0
    return out


def box(outline: Outline) -> tuple[float, float, float, float]:
    """Return west, south, east, north of an area, m."""
    corners = np.concatenate(outline.rings)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return west, south, east, north


def boxes(partition: Partition) -> FloatArray:
    """Return west, south, east, north of all areas, (areas, 4), m."""
    return np.array([box(outline) for outline in partition.outlines]).reshape(-1, 4)


def area_of(partition: Partition, x: FloatArray, y: FloatArray, known: FloatArray | None = None) -> IntArray:
    """Return the index of the area that each point (n,) belongs to, -1 outside of all.

    Parameters
    ----------
    partition
        The areas.
    x, y : (n,)
        Local position, m.
    known : (areas, 4), optional
        What `boxes` returns, if it is at hand.
    """
    out = np.full(len(x), -1, np.int64)
    if not len(x):
        return out
    west, south, east, north = (boxes(partition) if known is None else known).T
    near = (east >= x.min()) & (west <= x.max()) & (north >= y.min()) & (south <= y.max())
    for index in np.flatnonzero(near)[::-1].tolist():
        out[inside(partition.outlines[index], x, y)] = index
    return out


def _edges(outline: Outline) -> FloatArray:
    """Return x, y of both ends of all edges, (edges, 4)."""
    return np.concatenate([np.column_stack([ring, np.roll(ring, -1, axis=0)]) for ring in outline.rings])
