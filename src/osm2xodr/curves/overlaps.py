"""Which of many small quadrilaterals, as pieces of roads are, lie over each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves.ragged import blocks, ranks, repeated, runs, sorted_unique
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Size of the grid's cells, m: a few times that of a piece of a carriageway.
_CELL: Final = 12.0
# Size of the table that rules out most quadrilaterals far from those asked about: bounds its memory.
_HASHES: Final = 1 << 22
# So many quadrilaterals begin in one band of rows: some 15 MB.
_BAND: Final = 1 << 16
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
    box = np.empty((4, len(corners)))
    for rows in blocks(len(corners)):
        # Faster than along an axis of four.
        first, second, third, fourth = (corners[rows, k] for k in range(4))
        box[:2, rows] = np.minimum(np.minimum(first, second), np.minimum(third, fourth)).T
        box[2:, rows] = np.maximum(np.maximum(first, second), np.maximum(third, fourth)).T
    return overlapping_boxes(box, probe, group)


def overlapping_boxes(box: FloatArray, probe: BoolArray, group: IntArray | None = None) -> tuple[IntArray, IntArray]:
    """Return what `overlapping_pairs` does, of boxes: their west, south, east and north end, (4, n), m."""
    west, south, east, north = box
    found: list[IntArray] = [np.zeros(0, np.int64)]
    for quad, cell in _cells(box, probe):
        order = np.argsort(cell, kind="stable")
        quad, cell = quad[order], cell[order]
        if group is not None:
            begins = np.flatnonzero(np.diff(cell, prepend=-1))
            several = np.minimum.reduceat(group[quad], begins) < np.maximum.reduceat(group[quad], begins)
            keep = np.repeat(several, np.diff(np.append(begins, len(cell))))
            quad, cell = quad[keep], cell[keep]
        pairs: list[IntArray] = [np.zeros(0, np.int64)]
        for a, b in _in_one_cell(quad, cell):
            near = (west[a] < east[b]) & (west[b] < east[a]) & (south[a] < north[b]) & (south[b] < north[a])
            a, b = a[near], b[near]
            good = probe[a] | probe[b]
            a, b = np.minimum(a, b)[good], np.maximum(a, b)[good]
            pairs.append(a * len(probe) + b)
        # Most pairs have several cells in common.
        found.append(sorted_unique(np.concatenate(pairs)))
    code = sorted_unique(np.concatenate(found))
    return code // max(len(probe), 1), code % max(len(probe), 1)


def _cells(box: FloatArray, probe: BoolArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs of a quadrilateral and a cell that its `box` reaches, where a probed one may be.

    They come by bands of rows of cells, each with some quadrilaterals, which saves memory.
    """
    west, south, east, north = box
    good = np.isfinite(box).all(axis=0)
    x, y = (float(side.min(where=good, initial=np.inf)) for side in (west, south))
    with np.errstate(invalid="ignore", over="ignore"):
        low, high = np.floor((south - y) / _CELL), np.floor((north - y) / _CELL)
        good &= _columns(west, east, x)[1] * (high - low + 1.0) <= _MOST_CELLS
    if not good.any():
        return
    every = bool(probe.all())
    stride = int((float(east.max(where=good, initial=x)) - x) / _CELL) + 2
    borders = np.append(np.unique(np.sort(low[good])[::_BAND]), high.max(where=good, initial=0.0) + 1.0)
    for begin, end in pairwise(borders.tolist()):
        at = np.flatnonzero(good & (low < end) & (high >= begin))
        first, wide = (column.astype(np.int64) for column in _columns(west[at], east[at], x))
        bottom = np.maximum(low[at], begin)
        count = wide * (np.minimum(high[at], end - 1.0) - bottom + 1.0).astype(np.int64)
        of = repeated(count)
        row, column = np.divmod(ranks(count), wide[of])
        cell = (row + bottom.astype(np.int64)[of]) * stride + column + first[of]
        quad = at[of]
        if not every:
            wanted = np.zeros(_HASHES, bool)
            wanted[cell[probe[quad]] % _HASHES] = True
            near = wanted[cell % _HASHES]
            quad, cell = quad[near], cell[near]
        if len(cell):
            yield quad, cell


def _columns(west: FloatArray, east: FloatArray, origin: float) -> tuple[FloatArray, FloatArray]:
    """Return the first column of cells that boxes reach, and the number of them, (n,)."""
    first = np.floor((west - origin) / _CELL)
    return first, np.floor((east - origin) / _CELL) - first + 1.0


def _in_one_cell(quad: IntArray, cell: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the pairs of quadrilaterals that reach one cell, by some at once; `cell` ascends."""
    begins = np.flatnonzero(np.diff(cell, prepend=-1))
    size = np.diff(np.append(begins, len(cell)))
    # Each row of a cell with all rows behind it.
    behind = np.repeat(begins + size, size) - np.arange(len(cell)) - 1
    begin, total = 0, np.cumsum(behind)
    while begin < len(cell):
        done = int(total[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS_AT_ONCE)))
        rows = np.arange(begin, end)
        yield np.repeat(quad[rows], behind[rows]), quad[runs(rows + 1, behind[rows])]
        begin = end


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
