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

from osm2xodr.curves import PointTree
from osm2xodr.exporting.scene.ground.cells import Cells, corners_of
from osm2xodr.exporting.scene.ground.defaults import CLASH_REACH, GROUND_CELL, SLOPE
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Corrections spread by one corner a round: by 300 m at most.
_ROUNDS: Final = 60
_NONE: Final = -1
_NEIGHBOURS: Final = tuple((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dx or dy)


@dataclass(frozen=True, eq=False)
class Limits:
    """Points that bound the height of the ground around them."""

    xyz: FloatArray  # (n, 3) m
    normal: FloatArray  # (n, 2) Direction toward the ground that is meant; 0, 0 if it is all around
    # (n,) Whether the ground may not be lower, and not be higher there
    lower: BoolArray
    upper: BoolArray


def node_heights(cells: Cells, base: FloatArray, limits: Limits, base_at: FloatArray) -> FloatArray:
    """Return the heights of all corners of squares, (rows, columns), m.

    `base` are those of the elevation model there, and `base_at`, (n,), at the points of `limits`; NaN where unknown.
    """
    wanted = limits.xyz[:, 2] - np.where(np.isnan(base_at), limits.xyz[:, 2], base_at)
    low, low_away = _bound(cells, limits, np.where(limits.lower, wanted, np.nan))
    high, high_away = _bound(cells, limits, np.where(limits.upper, -wanted, np.nan))
    high = -high
    correction = np.clip(0.0, low, np.maximum(low, high))
    clash = low > high
    # At the edges themselves, of which either limit comes.
    low, high, low_away, high_away = low[clash], high[clash], low_away[clash], high_away[clash]
    share = low_away / np.maximum(low_away + high_away, 1e-9)
    low, high = low + SLOPE * low_away, high - SLOPE * high_away
    correction[clash] = low + share * (high - low)
    out: FloatArray = base + correction
    _on_roads(cells, limits, out)
    return out


def _on_roads(cells: Cells, limits: Limits, z: FloatArray) -> None:
    """Give corners on roads the height of the nearest edge."""
    x, y = cells.node_xy()
    row, column = np.nonzero(corners_of(cells.near))
    rim = np.flatnonzero(limits.normal.any(1))
    if not len(rim):
        return
    at = np.column_stack([x[row, column], y[row, column]])
    nearest = rim[PointTree(limits.xyz[rim, :2]).nearest(at)[1]]
    inside = ((at - limits.xyz[nearest, :2]) * limits.normal[nearest]).sum(1) < 0.0
    z[row[inside], column[inside]] = limits.xyz[nearest[inside], 2]


def _bound(cells: Cells, limits: Limits, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the greatest of all values (n,) less the slope times the distance, at all corners, and that distance.

    Where no point is known to reach, -inf and inf.
    """
    x, y = (axis.ravel() for axis in cells.node_xy())
    known = np.flatnonzero(np.isfinite(value))
    (px, py), values, (nx, ny) = limits.xyz[known, :2].T, value[known], limits.normal[known].T
    best, reached = np.full(len(x), _NONE), np.full(len(x), -np.inf)
    away = np.full(len(x), np.inf)
    wanted = corners_of(cells.ground).ravel()

    def offer(node: IntArray, point: IntArray) -> IntArray:
        """Give corners (n,), each once, a point if it is better than what they have; return those that took it."""
        dx, dy = x[node] - px[point], y[node] - py[point]
        off = np.hypot(dx, dy)
        worth = values[point] - SLOPE * off
        better = wanted[node] & (worth > reached[node]) & ((worth > 0.0) | (off < CLASH_REACH))
        # An edge does not reach across its own road.
        better &= dx * nx[point] + dy * ny[point] >= 0.0
        at: IntArray = node[better]
        best[at], reached[at], away[at] = point[better], worth[better], off[better]
        return at

    stride = cells.nodes[1]
    row, column = (np.floor(axis / GROUND_CELL).astype(np.int64) for axis in (py, px))
    first = (row - cells.row) * stride + column - cells.column
    seeds = [np.zeros(0, np.int64)]
    for step in (0, 1, stride, stride + 1):
        point = np.arange(len(first))
        while len(point):
            # Of several points at one corner, one after the other.
            node, at = np.unique(first[point] + step, return_index=True)
            seeds.append(offer(node, point[at]))
            point = np.delete(point, at)
    fresh = np.unique(np.concatenate(seeds))
    for _ in range(_ROUNDS):
        if not len(fresh):
            break
        offered = best[fresh]
        # No corner in the outermost rows and columns is wanted.
        changed = [offer(fresh + dy * stride + dx, offered) for dy, dx in _NEIGHBOURS]
        fresh = np.unique(np.concatenate(changed))
    return reached.reshape(cells.nodes), away.reshape(cells.nodes)
