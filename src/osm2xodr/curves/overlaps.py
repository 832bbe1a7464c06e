"""Which of many small quadrilaterals, as pieces of roads are, lie over each other."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.ragged import ranks, runs
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Size of the grid's cells, m: a few times that of a piece of a carriageway.
_CELL: Final = 12.0
# Size of the table that rules out most quadrilaterals far from those asked about: bounds its memory.
_HASHES: Final = 1 << 22
# So many pairs are compared at once: some 6 MB.
_PAIRS_AT_ONCE: Final = 1 << 16
# Quadrilaterals that reach over more cells than this have wrong numbers and are left out.
_MOST_CELLS: Final = 400
# Edges shorter than this have no direction, m.
_SHORTEST_EDGE: Final = 1e-6


def overlapping_pairs(
    corners: FloatArray, probe: BoolArray, group: IntArray | None = None
) -> tuple[IntArray, IntArray]:
    """Return pairs (i, j) of quadrilaterals whose bounding boxes overlap, of which at least one is to be probed.

    `corners`, (n, 4, 2), are those of the quadrilaterals, m, `probe`, (n,), says which are asked about. Each pair
    comes once, with i < j, in ascending order. Pairs within one `group`, (n,), are left out where no other group is
    near.
    """
    # Faster than along an axis of four.
    first, second, third, fourth = (corners[:, k] for k in range(4))
    low = np.minimum(np.minimum(first, second), np.minimum(third, fourth))
    high = np.maximum(np.maximum(first, second), np.maximum(third, fourth))
    del first, second, third, fourth
    return overlapping_boxes(low, high, probe, group)


def overlapping_boxes(
    low: FloatArray, high: FloatArray, probe: BoolArray, group: IntArray | None = None
) -> tuple[IntArray, IntArray]:
    """Return what `overlapping_pairs` does for boxes from `low` to `high`, both (n, 2), m."""
    west, south, east, north = (np.ascontiguousarray(column) for column in (*low.T, *high.T))
    quad, cell = _cells(low, high, probe)
    del low, high
    order = np.argsort(cell, kind="stable")
    quad, cell = quad[order], cell[order]
    del order
    if group is not None and len(cell):
        begins = np.flatnonzero(np.diff(cell, prepend=-1))
        several = np.minimum.reduceat(group[quad], begins) < np.maximum.reduceat(group[quad], begins)
        keep = np.repeat(several, np.diff(np.append(begins, len(cell))))
        quad, cell = quad[keep], cell[keep]
    begins = np.flatnonzero(np.diff(cell, prepend=-1)) if len(cell) else np.zeros(0, np.int64)
    size = np.diff(np.append(begins, len(cell)))
    # Each row of a cell with all rows behind it.
    behind = np.repeat(begins + size, size) - np.arange(len(cell)) - 1
    found: list[IntArray] = [np.zeros(0, np.int64)]
    begin, total = 0, np.cumsum(behind)
    while begin < len(cell):
        done = int(total[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS_AT_ONCE)))
        rows = np.arange(begin, end)
        a = np.repeat(quad[rows], behind[rows]).astype(np.int64)
        b = quad[runs(rows + 1, behind[rows])].astype(np.int64)
        near = (west[a] < east[b]) & (west[b] < east[a]) & (south[a] < north[b]) & (south[b] < north[a])
        a, b = a[near], b[near]
        good = probe[a] | probe[b]
        a, b = np.minimum(a, b)[good], np.maximum(a, b)[good]
        found.append(a * len(probe) + b)
        begin = end
    code = np.unique(np.concatenate(found))
    return code // max(len(probe), 1), code % max(len(probe), 1)


def _cells(low: FloatArray, high: FloatArray, probe: BoolArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of a quadrilateral and a cell that its bounding box reaches, where a probed one may be."""
    good = np.flatnonzero(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1))
    if not len(good):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    origin = low[good].min(axis=0)
    # Half the memory where the cells of the whole area can be counted so.
    cells = np.prod((high[good].max(axis=0) - origin) / _CELL + 3.0)
    kind = np.int32 if cells < np.iinfo(np.int32).max else np.int64
    a, b = (np.floor((value[good] - origin) / _CELL).astype(kind) for value in (low, high))
    wide, count = b[:, 0] - a[:, 0] + 1, (b - a + 1).prod(axis=1)
    sane = count <= _MOST_CELLS
    good, a, wide, count = good[sane].astype(kind), a[sane], wide[sane], count[sane]
    stride = kind(b[:, 0].max() + 2)
    del low, high, b, sane
    of = np.repeat(np.arange(len(good), dtype=kind), count)
    row, column = np.divmod(ranks(count).astype(kind), wide[of])
    row += a[of, 1]
    row *= stride
    column += a[of, 0]
    cell = np.add(row, column, out=row)
    del a, wide, column
    if probe.all():
        return good[of], cell
    wanted = np.zeros(_HASHES, bool)
    wanted[cell[probe[good[of]]] % _HASHES] = True
    near = wanted[cell % _HASHES]
    return good[of[near]], cell[near]


def overlap_depths(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return by how much convex quadrilaterals, both (n, 4, 2), reach into each other, m; less than 0 where apart.

    It is the least way by which one would have to move to touch the other only: the least overlap of their shadows
    on the normals of all edges (separating axes).
    """
    out = np.full(len(one), np.inf)
    for shape in (one, other):
        for k in range(4):
            edge = shape[:, (k + 1) % 4] - shape[:, k]
            size = np.hypot(edge[:, 0], edge[:, 1])
            normal = np.column_stack([-edge[:, 1], edge[:, 0]]) / np.maximum(size, _SHORTEST_EDGE)[:, None]
            p, q = (np.einsum("nij,nj->ni", quad, normal) for quad in (one, other))
            depth = np.minimum(p.max(axis=1) - q.min(axis=1), q.max(axis=1) - p.min(axis=1))
            out = np.where(size > _SHORTEST_EDGE, np.minimum(out, depth), out)
    return out
