"""Which curves cross each other."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.ragged import sorted_unique
from osm2xodr.curves.records import pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Curves are compared as polylines of this many segments, this many pairs at a time: the processor's cache holds them.
_SEGMENTS: Final = 12
_PAIRS_AT_ONCE: Final = 300


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
