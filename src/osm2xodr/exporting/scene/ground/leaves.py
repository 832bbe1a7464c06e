"""Whole squares of ground in levels of detail: small ones near roads, larger ones away from them.

Squares are one, two or four of `Cells` wide, and meet along whole sides or halves of them. Whatever the detail,
those at borders of tiles are the same, so that tiles of different detail meet without a crack.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.exporting.scene.ground.cells import GROUND_BLOCK, Cells
from osm2xodr.exporting.scene.ground.defaults import GROUND_CELL
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Corners and middles of the sides of a square in half sides, row and column, counter-clockwise from the south-west.
_RING: Final = ((0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0))


def leaf_sizes(cells: Cells, detail: int, tile: float) -> IntArray:
    """Return in squares how wide the leaf is that each of them is part of, (rows, columns); 0 without ground.

    Those near roads have 1. `detail` 0 is the finest level; borders of tiles lie at multiples of `tile`, m.
    """
    count = round(tile / GROUND_CELL)
    rows, columns = (
        np.isin((first + np.arange(size)) % count, (0, count - 1))
        for first, size in zip((cells.row, cells.column), cells.ground.shape, strict=True)
    )
    border = rows[:, None] | columns
    out = cells.ground.astype(np.int64)
    # Water is smooth: it needs no small squares.
    wet = cells.water >= 0
    water = wet[1:, 1:] & wet[1:, :-1] & wet[:-1, 1:] & wet[:-1, :-1]
    pairs = _every(cells.ground & ~cells.near, 2)
    if detail == 0:
        pairs &= ~_every(~border, 2) | _every(water, 2)
    out[_spread(pairs, 2)] = 2
    # Beside the largest leaves lie none of the smallest.
    small = out == 1
    beside = np.zeros_like(small)
    beside[1:] |= small[:-1]
    beside[:-1] |= small[1:]
    beside[:, 1:] |= small[:, :-1]
    beside[:, :-1] |= small[:, 1:]
    large = (out == 2) & ~border & ~beside
    if detail < 2:
        large &= water
    out[_spread(_every(large, GROUND_BLOCK), GROUND_BLOCK)] = GROUND_BLOCK
    return out


def _every(squares: BoolArray, size: int) -> BoolArray:
    """Return which groups of size x size squares have all of them."""
    rows, columns = squares.shape
    out: BoolArray = squares.reshape(rows // size, size, columns // size, size).all((1, 3))
    return out


def _spread(groups: BoolArray, size: int) -> BoolArray:
    """Return the squares of groups."""
    return groups.repeat(size, 0).repeat(size, 1)


def leaf_triangles(cells: Cells, sizes: IntArray, z: FloatArray) -> IntArray:
    """Return the triangles (n, 3) of all leaves that are not near roads, counter-clockwise, as indices of corners.

    z, (rows + 1, columns + 1), are the heights of corners, m: the diagonals of squares join those of less
    difference, and leaves of which a corner is unknown have no triangles.
    """
    found = [np.zeros((0, 3), np.int64)]
    for size in (1, 2, GROUND_BLOCK):
        at = sizes == size if size > 1 else (sizes == 1) & ~cells.near
        row, column = np.nonzero(at)
        first = ((row + cells.row) % size == 0) & ((column + cells.column) % size == 0)
        found.append(_of_size(size, row[first], column[first], sizes, z))
    triangles = np.concatenate(found)
    out: IntArray = triangles[np.isfinite(z.ravel()[triangles]).all(1)]
    return out


def _of_size(size: int, row: IntArray, column: IntArray, sizes: IntArray, z: FloatArray) -> IntArray:
    """Return the triangles of the leaves of one size, whose south-western squares are given."""
    stride = z.shape[1]
    corner = row * stride + column
    if size == 1:
        return _halves(corner, size, stride, z)
    # Sides with a middle: there is a smaller leaf beside them.
    ends = (0, size - 1)
    finer = np.zeros((len(row), 4), np.bool_)
    for side, (rows, columns) in enumerate((((-1,), ends), (ends, (size,)), ((size,), ends), (ends, (-1,)))):
        for dy in rows:
            for dx in columns:
                beside = sizes[row + dy, column + dx]
                finer[:, side] |= (beside > 0) & (beside < size)
    plain = ~finer.any(1)
    half, middle = size // 2, corner + size // 2 * (stride + 1)
    found = [_halves(corner[plain], size, stride, z)]
    for side in range(4):
        a, b, c = (
            corner + half * (_RING[k % 8][0] * stride + _RING[k % 8][1]) for k in range(2 * side, 2 * side + 3)
        )
        split, straight = finer[:, side], ~finer[:, side] & ~plain
        found.append(np.column_stack([middle, a, b])[split])
        found.append(np.column_stack([middle, b, c])[split])
        found.append(np.column_stack([middle, a, c])[straight])
    return np.concatenate(found)


def _halves(corner: IntArray, size: int, stride: int, z: FloatArray) -> IntArray:
    """Return both halves of squares along the diagonal whose ends differ less in height."""
    south_west, south_east = corner, corner + size
    north_west, north_east = corner + size * stride, corner + size * stride + size
    height = z.ravel()
    with np.errstate(invalid="ignore"):
        rising = np.abs(height[south_west] - height[north_east]) <= np.abs(height[south_east] - height[north_west])
    quads = np.column_stack([south_west, south_east, north_east, north_west])
    halves = np.concatenate([quads[rising][:, [0, 1, 2, 0, 2, 3]], quads[~rising][:, [0, 1, 3, 1, 2, 3]]])
    return np.reshape(halves, (-1, 3))
