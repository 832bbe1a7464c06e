"""Cells of grids, one for each junction: those in pieces of lanes, and those on rays from lanes' edges.

`grids` (3, n) are the grid of each cross section or ray: its first cell, that behind its last, how many it is wide.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.model import BoolArray, FloatArray, IntArray

_Cells = NDArray[np.int32]

# What a cell holds that no lane covers: nothing, a strip of an island, a paved one, or the end face of a carriageway.
# Those of gaps hold this less the number of the gap, from 1 on; those on lanes a road.
FREE: Final = -1
STRIP: Final = -2
PAVED: Final = -3
FACE: Final = -4
# The same in compiled loops.
_FREE: Final = FREE
_FACE: Final = FACE
# Columns are fewer than that.
_FAR: Final = 1e9


def draw_pieces(
    pieces: IntArray,
    places: FloatArray,
    t: FloatArray,
    grids: IntArray,
    value: _Cells,
    cells: _Cells,
    beside_gap: BoolArray,
    corners: FloatArray,
) -> None:
    """Write values into the cells whose middles pieces of lanes cover, but no lane yet; `FREE` is not written.

    A piece lies between a cross section, by its row, and the next, and between the two `t` (2, n) there, m. `places`
    (4, n) are column and row in its grid of each cross section at t = 0, and by how much they grow with t.
    `beside_gap` (n,) becomes true where a cell of the piece is in a gap; `corners` (5, 2) is room for those of a
    piece, the first one twice.
    """
    for i in range(len(pieces)):
        k = pieces[i]
        for axis in range(2):
            x, y, dx, dy = places[axis, k], places[axis, k + 1], places[axis + 2, k], places[axis + 2, k + 1]
            corners[0, axis] = corners[4, axis] = x + t[0, k] * dx
            corners[1, axis] = x + t[1, k] * dx
            corners[2, axis] = y + t[1, k + 1] * dy
            corners[3, axis] = y + t[0, k + 1] * dy
        wide = grids[2, k]
        south = min(corners[0, 1], corners[1, 1], corners[2, 1], corners[3, 1])
        north = max(corners[0, 1], corners[1, 1], corners[2, 1], corners[3, 1])
        first = grids[0, k] + _behind(south) * wide
        for row in range(_behind(south), _behind(north)):
            left, right, y = _FAR, 0.0, row + 0.5
            for one in range(4):
                if (corners[one, 1] <= y) != (corners[one + 1, 1] <= y):
                    share = (y - corners[one, 1]) / (corners[one + 1, 1] - corners[one, 1])
                    x = corners[one, 0] + share * (corners[one + 1, 0] - corners[one, 0])
                    left, right = min(left, x), max(right, x)
            if first < grids[1, k]:
                for cell in range(first + _behind(left), first + min(_behind(right), wide)):
                    if cells[cell] < _FACE:
                        beside_gap[k] = True
                    if value[k] != _FREE and cells[cell] < 0:
                        cells[cell] = value[k]
            first += wide


def _behind(place: float) -> int:
    """Return the first column or row whose middle lies behind a place."""
    return int(max(place, 0.0) + 0.5)


def gaps_beside(rays: FloatArray, grids: IntArray, most: int, cells: _Cells, out: IntArray) -> None:
    """Write the first step of each ray that is in a gap, 1 … `most`, or 0 for none, and the gap's number, (2, n).

    `rays` (4, n) are column and row in its grid where each begins, and by how much they grow with a step.
    """
    for k in range(rays.shape[1]):
        out[0, k] = 0
        for step in range(1, most + 1):
            cell = cells[_cell(rays, grids, k, step)]
            if cell < _FACE:
                out[0, k], out[1, k] = step, _FACE - cell
                break


def walk_gaps(rays: FloatArray, grids: IntArray, gap: IntArray, span: IntArray, cells: _Cells, out: IntArray) -> None:
    """Write the step at which each ray has left its gap, and what the cell there holds, (2, n).

    `span` (2, n) are the first one in it and the last that counts.
    """
    for k in range(rays.shape[1]):
        step = span[0, k]
        while step < span[1, k] and cells[_cell(rays, grids, k, step)] == _FACE - gap[k]:
            step += 1
        out[0, k], out[1, k] = step, cells[_cell(rays, grids, k, step)]


def close_gaps(rays: FloatArray, grids: IntArray, span: IntArray, cells: _Cells) -> None:
    """Make cells on rays those of no gap, from the first step to that before the last, (2, n)."""
    for k in range(rays.shape[1]):
        for step in range(span[0, k], span[1, k]):
            cells[_cell(rays, grids, k, step)] = _FREE


def _cell(rays: FloatArray, grids: IntArray, k: int, step: int) -> int:
    """Return the cell at a step of a ray; beyond its grid the first of that, which is outside of all lanes."""
    column, row = int(rays[0, k] + step * rays[2, k]), int(rays[1, k] + step * rays[3, k])
    cell: int = grids[0, k] + row * grids[2, k] + column
    if column < 0 or column >= grids[2, k] or row < 0 or cell >= grids[1, k]:
        cell = grids[0, k]
    return cell
