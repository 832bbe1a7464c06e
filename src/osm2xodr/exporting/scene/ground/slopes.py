"""Heights of the ground between roads: those of the elevation model, cut and filled where roads are lower or higher.

At the edge of a road the elevation model is corrected by what the road differs from it. Away from the edge the
correction fades by a slope, so that every edge demands that the correction be within limits which widen with the
distance. Where limits exclude each other, as between close roads at different heights, the correction goes straight
from one to the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.cells import Cells, node_of
from osm2xodr.exporting.scene.ground.defaults import APRON, CLASH_REACH, SLOPE
from osm2xodr.model import BoolArray, FloatArray

# Corrections spread by one corner a round: by 300 m at most.
_ROUNDS: Final = 60
_NONE: Final = -1
_NEIGHBOURS: Final = tuple((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dx or dy)


@dataclass(frozen=True, eq=False)
class Limits:
    """Points that bound the height of the ground around them."""

    xyz: FloatArray  # (n, 3) m
    # (n,) Whether the ground may not be lower, and not be higher there
    lower: BoolArray
    upper: BoolArray


def node_heights(cells: Cells, base: FloatArray, limits: Limits, base_at: FloatArray) -> FloatArray:
    """Return the heights of all corners of squares, (rows, columns), m.

    `base` are those of the elevation model there, and `base_at`, (n,), at the points of `limits`; NaN where unknown.
    Unknown ones close to roads are taken for level, others stay NaN.
    """
    x, y = cells.node_xy()
    tree = cKDTree(limits.xyz[:, :2])
    unknown = np.isnan(base)
    out = base.copy()
    if unknown.any():
        away, nearest = tree.query(np.column_stack([x[unknown], y[unknown]]), distance_upper_bound=APRON)
        out[unknown] = np.append(limits.xyz[:, 2], np.nan)[np.where(np.isfinite(away), nearest, -1)]
    wanted = limits.xyz[:, 2] - np.where(np.isnan(base_at), limits.xyz[:, 2], base_at)
    low, low_away = _bound(cells, limits.xyz, np.where(limits.lower, wanted, np.nan))
    high, high_away = _bound(cells, limits.xyz, np.where(limits.upper, -wanted, np.nan))
    high = -high
    correction = np.clip(0.0, low, np.maximum(low, high))
    clash = low > high
    # At the edges themselves, of which either limit comes.
    low, high, low_away, high_away = low[clash], high[clash], low_away[clash], high_away[clash]
    share = low_away / np.maximum(low_away + high_away, 1e-9)
    low, high = low + SLOPE * low_away, high - SLOPE * high_away
    correction[clash] = low + share * (high - low)
    filled: FloatArray = out + correction
    return filled


def _bound(cells: Cells, xyz: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the greatest of all values (n,) less the slope times the distance, at all corners, and that distance.

    Where no point is known to reach, -inf and inf.
    """
    x, y = (axis.ravel() for axis in cells.node_xy())
    known = np.flatnonzero(np.isfinite(value))
    px, py, values = xyz[known, 0], xyz[known, 1], value[known]
    best, reached = np.full(len(x), _NONE), np.full(len(x), -np.inf)
    away = np.full(len(x), np.inf)
    row, column = node_of(cells, px, py)
    stride = cells.nodes[1]
    node, off = row * stride + column, np.hypot(px - x[row * stride + column], py - y[row * stride + column])
    # Each corner with points next to it begins with the best of them: the last one that is written stays.
    order = np.argsort(values - SLOPE * off, kind="stable")
    node, off = node[order], off[order]
    best[node], reached[node], away[node] = order, values[order] - SLOPE * off, off
    wanted = _nodes_of(cells).ravel()
    fresh = np.unique(node)
    for _ in range(_ROUNDS):
        if not len(fresh):
            break
        offered, changed = best[fresh], []
        for step in (dy * stride + dx for dy, dx in _NEIGHBOURS):
            # No corner in the outermost rows and columns is wanted.
            to = fresh + step
            off = np.hypot(x[to] - px[offered], y[to] - py[offered])
            worth = values[offered] - SLOPE * off
            better = wanted[to] & (worth > reached[to]) & ((worth > 0.0) | (off < CLASH_REACH))
            at = to[better]
            best[at], reached[at], away[at] = offered[better], worth[better], off[better]
            changed.append(at)
        fresh = np.unique(np.concatenate(changed))
    return reached.reshape(cells.nodes), away.reshape(cells.nodes)


def _nodes_of(cells: Cells) -> BoolArray:
    """Return which corners belong to squares with ground, (rows + 1, columns + 1)."""
    out = np.zeros(cells.nodes, np.bool_)
    for rows in (slice(None, -1), slice(1, None)):
        for columns in (slice(None, -1), slice(1, None)):
            out[rows, columns] |= cells.ground
    return out
