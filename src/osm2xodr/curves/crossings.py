"""Which connecting roads of a junction cross or merge."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves.plan_views import lengths, pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Connecting roads are compared as polylines of this many segments; pairs are worked off in parts of this many,
# which the processor's cache holds.
_SEGMENTS = 12
_PART = 300


def crossing(plan: PlanView, one: IntArray, other: IntArray) -> BoolArray:
    """Say which pairs of curves cross, (n,).

    Parameters
    ----------
    plan
        The curves.
    one, other : (n,)
        Indices of the curves of each pair.
    """
    used = np.unique(np.concatenate([one, other]))
    x, y = _polylines(plan, used)
    one, other = np.searchsorted(used, one), np.searchsorted(used, other)
    low, high = np.column_stack([x.min(1), y.min(1)]), np.column_stack([x.max(1), y.max(1)])
    found: BoolArray = ((low[one] <= high[other]) & (low[other] <= high[one])).all(axis=1)
    near = np.flatnonzero(found)
    for part in np.array_split(near, max(1, -(-len(near) // _PART))):
        found[part] = _cross(x[one[part]], y[one[part]], x[other[part]], y[other[part]])
    return found


def _polylines(plan: PlanView, curves: IntArray) -> tuple[FloatArray, FloatArray]:
    share = np.linspace(0.0, 1.0, _SEGMENTS + 1)
    s = lengths(plan)[curves][:, None] * share
    x, y, _ = pose(plan, np.repeat(curves, _SEGMENTS + 1), s.ravel())
    return x.reshape(s.shape), y.reshape(s.shape)


def _cross(x1: FloatArray, y1: FloatArray, x2: FloatArray, y2: FloatArray) -> BoolArray:
    """Say which polylines cross those of the same row, by the sides that the ends of their segments lie on."""
    ax, ay = x1[:, :-1, None], y1[:, :-1, None]
    bx, by = x1[:, 1:, None], y1[:, 1:, None]
    cx, cy = x2[:, None, :-1], y2[:, None, :-1]
    dx, dy = x2[:, None, 1:], y2[:, None, 1:]

    def side(
        px: FloatArray, py: FloatArray, qx: FloatArray, qy: FloatArray, x: FloatArray, y: FloatArray
    ) -> FloatArray:
        out: FloatArray = (qx - px) * (y - py) - (qy - py) * (x - px)
        return out

    apart_1 = side(ax, ay, bx, by, cx, cy) * side(ax, ay, bx, by, dx, dy) < 0
    apart_2 = side(cx, cy, dx, dy, ax, ay) * side(cx, cy, dx, dy, bx, by) < 0
    out: BoolArray = (apart_1 & apart_2).any(axis=(1, 2))
    return out
