"""Which of many small quadrilaterals, as pieces of roads are, lie over each other."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from osm2xodr.curves.ragged import blocks, sorted_unique
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Size of the cells that boxes are sorted into, m: a few times that of a piece of a carriageway.
_CELL: Final = 12.0
# Boxes that reach over more cells than this, or so many cells away, have wrong numbers and are left out.
_MOST_CELLS: Final = 400
_FARTHEST: Final = 1 << 30
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
    n = len(probe)
    good = np.isfinite(box).all(axis=0)
    origin = box[:2].min(axis=1, where=good, initial=np.inf)
    with np.errstate(invalid="ignore", over="ignore"):
        reached = np.floor((box.reshape(2, 2, n) - origin[:, None]) / _CELL)
        good &= (reached[1] < _FARTHEST).all(axis=0) & ((reached[1] - reached[0] + 1.0).prod(axis=0) <= _MOST_CELLS)
    at = np.flatnonzero(good)
    cells = reached[..., at].astype(np.int64)
    # Cells are looked up in a table, in which those that are far from each other share places.
    stride = int(cells[1, 0].max(initial=0)) + 1 | 1
    rows = int((cells[1] - cells[0] + 1).prod(axis=0).sum())
    start = np.zeros((1 << rows.bit_length()) + 2, np.int64)
    count_cells(cells, stride, start)
    np.cumsum(start, out=start)
    quad, cell = np.empty((2, rows), np.int64)
    fill_cells(at, cells, stride, start, quad, cell)
    table = start, quad, cell, box, probe, np.arange(n) if group is None else group
    code = np.empty(pairs_in_cells(*table, np.empty(0, np.int64)), np.int64)
    pairs_in_cells(*table, code)
    # Many pairs have several cells in common.
    code = sorted_unique(code)
    return code // max(n, 1), code % max(n, 1)


def count_cells(cells: IntArray, stride: int, start: IntArray) -> None:
    """Count the boxes that reach each place of a table, two places farther on; `cells`, (2, 2, n): from, to; x, y."""
    for k in range(cells.shape[2]):
        for row in range(cells[0, 1, k], cells[1, 1, k] + 1):
            for column in range(cells[0, 0, k], cells[1, 0, k] + 1):
                start[((row * stride + column) & (len(start) - 3)) + 2] += 1


def fill_cells(at: IntArray, cells: IntArray, stride: int, start: IntArray, quad: IntArray, cell: IntArray) -> None:
    """Write boxes, by their numbers `at`, and the cells that they reach by places; `start` is moved one place on."""
    for k in range(len(at)):
        for row in range(cells[0, 1, k], cells[1, 1, k] + 1):
            for column in range(cells[0, 0, k], cells[1, 0, k] + 1):
                place = ((row * stride + column) & (len(start) - 3)) + 1
                quad[start[place]] = at[k]
                cell[start[place]] = row * stride + column
                start[place] += 1


def pairs_in_cells(
    start: IntArray,
    quad: IntArray,
    cell: IntArray,
    box: FloatArray,
    probe: BoolArray,
    group: IntArray,
    code: IntArray,
) -> int:
    """Count the pairs of boxes that overlap in a cell, and write them as i · n + j to `code`, if it is not empty."""
    count = 0
    for place in range(len(start) - 2):
        for i in range(start[place], start[place + 1]):
            a = quad[i]
            alone = True
            for j in range(start[place], start[place + 1]):
                if cell[j] == cell[i] and group[quad[j]] != group[a]:
                    alone = False
                    break
            if alone:
                continue
            for j in range(start[place], i):
                b = quad[j]
                if (
                    cell[j] == cell[i]
                    and (probe[a] or probe[b])
                    and box[0, a] < box[2, b]
                    and box[0, b] < box[2, a]
                    and box[1, a] < box[3, b]
                    and box[1, b] < box[3, a]
                ):
                    if len(code) > 0:
                        code[count] = min(a, b) * len(probe) + max(a, b)
                    count += 1
    return count


def overlap_depths(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return by how much convex quadrilaterals, both (n, 4, 2), reach into each other, m; less than 0 where apart.

    It is the least way by which one would have to move to touch the other only: the least overlap of their shadows
    on the normals of all edges (separating axes).
    """
    depth = np.full(len(one), np.inf)
    shadows(one, other, one, depth)
    shadows(one, other, other, depth)
    return depth


def shadows(one: FloatArray, other: FloatArray, edges: FloatArray, depth: FloatArray) -> None:
    """Lessen depths, (n,), to the overlaps of the shadows of quadrilaterals on the normals of one of them."""
    for i in range(len(depth)):
        for k in range(4):
            along_x = edges[i, (k + 1) % 4, 0] - edges[i, k, 0]
            along_y = edges[i, (k + 1) % 4, 1] - edges[i, k, 1]
            size = math.sqrt(along_x * along_x + along_y * along_y)
            if size > _SHORTEST_EDGE:
                low, high = shadow(one, i, -along_y / size, along_x / size)
                other_low, other_high = shadow(other, i, -along_y / size, along_x / size)
                depth[i] = min(depth[i], high - other_low, other_high - low)


def shadow(quads: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Return where the shadow of a quadrilateral on the axis (x, y) begins and ends, m."""
    low = high = quads[i, 0, 0] * x + quads[i, 0, 1] * y
    for k in range(1, 4):
        place = quads[i, k, 0] * x + quads[i, k, 1] * y
        low, high = min(low, place), max(high, place)
    return low, high
