"""Heights of the ground: those of the elevation model, cut and filled where roads are lower or higher.

At the edge of a road the elevation model is corrected by what the road differs from it. Away from the edge the
correction fades by a slope, so that every edge demands that the correction be within limits which widen with the
distance. Where limits exclude each other, as between close roads at different heights, the correction goes straight
from one to the other. Gaps of the elevation model are interpolated.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy import ndimage

from osm2xodr.curves import PointTree, solve_sparse
from osm2xodr.exporting.scene.cells import GROUND_BLOCK, Cells, corners_of
from osm2xodr.exporting.scene.model import APRON, GROUND_CELL, LARGEST_GAP
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Rise of cuts and fills per metre against the ground that was there: 1:2, for most soils stable; RAS-Q has 1:1.5.
_SLOPE: Final = 0.5
# How far from an edge of a road the ground there counts although it is neither cut nor filled, as roads at other
# heights may be close, m. A choice.
_CLASH_REACH: Final = 60.0

# Corrections spread by one corner a round: by 300 m at most.
_ROUNDS: Final = 60
_NONE: Final = -1
_NEIGHBOURS: Final = tuple((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dx or dy)


@record(eq=False)
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
    low, high = low + _SLOPE * low_away, high - _SLOPE * high_away
    correction[clash] = low + share * (high - low)
    out: FloatArray = base + correction
    _on_roads(cells, limits, out)
    return out


def _on_roads(cells: Cells, limits: Limits, z: FloatArray) -> None:
    """Give corners on roads the height of the nearest edge."""
    rim = np.flatnonzero(limits.normal.any(1))
    if not len(rim):
        return
    node = np.flatnonzero(corners_of(cells.roads))
    at = cells.node_xy()[node]
    nearest = rim[PointTree(limits.xyz[rim, :2]).nearest(at)[1]]
    inside = ((at - limits.xyz[nearest, :2]) * limits.normal[nearest]).sum(1) < 0.0
    z.ravel()[node[inside]] = limits.xyz[nearest[inside], 2]


def _bound(cells: Cells, limits: Limits, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the greatest of all values (n,) less the slope times the distance, at all corners, and that distance.

    Where no point is known to reach, -inf and inf.
    """
    x, y = cells.node_xy().T
    known = np.flatnonzero(np.isfinite(value))
    (px, py), values, (nx, ny) = limits.xyz[known, :2].T, value[known], limits.normal[known].T
    best, reached = np.full(len(x), _NONE), np.full(len(x), -np.inf)
    away = np.full(len(x), np.inf)
    wanted = corners_of(cells.ground).ravel()

    def offer(node: IntArray, point: IntArray) -> IntArray:
        """Give corners (n,), each once, a point if it is better than what they have; return those that took it."""
        dx, dy = x[node] - px[point], y[node] - py[point]
        off = np.hypot(dx, dy)
        worth = values[point] - _SLOPE * off
        better = wanted[node] & (worth > reached[node]) & ((worth > 0.0) | (off < _CLASH_REACH))
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


# ---------------------------------------------------------------- what no elevation model knows

# How far beyond the outline heights are needed, as triangles cross it, m: the diagonal of the largest squares.
_BEYOND: Final = np.sqrt(2) * GROUND_CELL * GROUND_BLOCK
_FARTHEST: Final = APRON + _BEYOND
_SIDES: Final = ((0, 1), (0, -1), (1, 0), (-1, 0))


def interpolated(z: FloatArray) -> FloatArray:
    """Return heights of corners of squares, (rows, columns), m, with gaps of NaN within them closed.

    These are at most as large as `LARGEST_GAP`, and have the smoothest heights in between: each is the mean of those
    around it. What reaches the sides of the rectangle stays unknown.
    """
    gaps, count = ndimage.label(np.isnan(z))
    fill = np.bincount(gaps.ravel(), minlength=count + 1) * GROUND_CELL**2 <= LARGEST_GAP
    fill[np.concatenate([[0], gaps[0], gaps[-1], gaps[:, 0], gaps[:, -1]])] = False
    row, column = np.nonzero(fill[gaps])
    if not len(row):
        return z
    number = np.full(z.shape, -1)
    number[row, column] = np.arange(len(row))
    known = np.zeros(len(row))
    pairs = []
    for dy, dx in _SIDES:
        other = number[row + dy, column + dx]
        inner = np.flatnonzero(other >= 0)
        pairs.append(np.column_stack([inner, other[inner]]))
        known += np.where(other >= 0, 0.0, z[row + dy, column + dx])
    one, other = np.concatenate([*pairs, np.tile(np.arange(len(row)), (2, 1)).T]).T
    # Each is four times there, less those around it.
    weight = np.append(np.full(len(one) - len(row), -1.0), np.full(len(row), 4.0))
    out = z.copy()
    out[row, column] = solve_sparse(sp.csr_matrix((weight, (one, other)), shape=(len(row), len(row))), known)
    return out


def with_strips(cells: Cells, base: FloatArray, rim: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return heights of corners, (rows, columns), m, and how far these lie within the outline of the ground, m.

    Where they are unknown, the ground is as high as the edge of the nearest road, of points `rim` (n, 3), m, and
    reaches no farther than `APRON` from it.
    """
    row, column = np.nonzero(np.isnan(base) & (cells.inside > -_BEYOND))
    if not len(row):
        return base, cells.inside
    out, inside = base.copy(), cells.inside.copy()
    inside[row, column] = np.minimum(inside[row, column], -GROUND_CELL)
    if len(rim):
        at = cells.node_xy().reshape(*cells.nodes, 2)[row, column]
        away, nearest = PointTree(rim[:, :2]).nearest(at, _FARTHEST)
        close = np.isfinite(away)
        row, column, away = row[close], column[close], away[close]
        out[row, column] = rim[nearest[close], 2]
        inside[row, column] = np.minimum(cells.inside[row, column], APRON - away)
    return out, inside


def continued(z: FloatArray) -> FloatArray:
    """Return heights of corners, (rows, columns), m: unknown ones are those of the nearest that is known."""
    unknown = np.isnan(z)
    if not unknown.any() or unknown.all():
        return z
    row, column = ndimage.distance_transform_edt(unknown, return_distances=False, return_indices=True)
    return np.asarray(z[row, column])
