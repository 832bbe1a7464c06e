"""Points and polygons, places along polylines, and which curves and segments cross."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.ragged import sorted_unique
from osm2xodr.curves.records import pose
from osm2xodr.curves.trigonometry import hypot
from osm2xodr.model import BoolArray, FloatArray, IntArray, Outline, Partition, PlanView

# Pairs of a point and an edge that are compared at a time: some 8 MB a table.
_POINTS_AT_ONCE: Final = 1 << 20

# Curves are compared as polylines of this many segments, this many pairs at a time: the processor's cache holds them.
_SEGMENTS: Final = 12
_PAIRS_AT_ONCE: Final = 300


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
    step = max(1, _POINTS_AT_ONCE // len(x0))
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


def running_lengths(points: FloatArray) -> FloatArray:
    """Return how far along a polyline each of its points (n, 2) is, (n,), from 0 at the first, in their unit."""
    return np.concatenate([[0.0], np.cumsum(hypot(*np.diff(points, axis=0).T))])


def curves_cross(plan: PlanView, one: IntArray, other: IntArray) -> BoolArray:
    """Say which pairs of curves, one and other (n,) by their indices, cross, (n,)."""
    used = sorted_unique(np.concatenate([one, other]))
    share = np.linspace(0.0, 1.0, _SEGMENTS + 1)
    s = lengths(plan, used)[:, None] * share
    x, y, _ = pose(plan, np.repeat(used, _SEGMENTS + 1), s.ravel())
    points = np.column_stack([x, y]).reshape(*s.shape, 2)
    one, other = np.searchsorted(used, one), np.searchsorted(used, other)
    low, high = points.min(axis=1), points.max(axis=1)
    found: BoolArray = ((low[one] <= high[other]) & (low[other] <= high[one])).all(axis=1)
    near = np.flatnonzero(found)
    for part in np.array_split(near, max(1, -(-len(near) // _PAIRS_AT_ONCE))):
        first, second = points[one[part]][:, :, None], points[other[part]][:, None]
        cross = segments_cross(first[:, :-1], first[:, 1:], second[:, :, :-1], second[:, :, 1:])
        found[part] = cross.any(axis=(1, 2))
    return found


def segments_cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> BoolArray:
    """Say which segments a-b cross segments c-d, by the sides that their ends lie on; points (..., 2 or 3), level."""
    return (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)


def rays_to_segments(origin: FloatArray, ray: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    """Return how far from their origins rays meet segments, (n, m), m: negative behind, infinite where they do not.

    Origins and directions of length 1 are (n or 1, 2), ends of segments (m, 2).
    """
    along = end - begin
    off = begin - origin[:, None]
    ray = ray[:, None]
    turned = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0]) / turned
        share = (off[..., 0] * ray[..., 1] - off[..., 1] * ray[..., 0]) / turned
    return np.where((share >= 0.0) & (share <= 1.0), far, np.inf)


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> FloatArray:
    """Return on which side of the lines from a to b points lie: positive on the left."""
    along_x, along_y = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return along_x * (p[..., 1] - a[..., 1]) - along_y * (p[..., 0] - a[..., 0])
