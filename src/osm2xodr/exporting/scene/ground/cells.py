"""The squares that the ground consists of: where it is at all, and which are too close to roads for whole squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from osm2xodr.curves import PointTree, ranks
from osm2xodr.errors import InputError
from osm2xodr.exporting.scene.ground.defaults import (
    GROUND_CELL,
    KEEP_OFF,
    LARGEST_GAP,
    MOST_CELLS,
    REACH,
    SAMPLE,
    WATER_REACH,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Squares per side of the blocks of which the extent of the ground consists: the largest squares.
GROUND_BLOCK: Final = 4
# Corners closer to the outline of the ground than this lie on it, m, so that no triangle there is a sliver. A choice.
_ON_OUTLINE: Final = 0.1
# Points of blocks lie closer together or farther apart than their middles by a diagonal at most, and the largest
# squares that the outline crosses have corners another one away, m.
_DIAGONALS: Final = 2.0 * np.sqrt(2.0) * GROUND_CELL * GROUND_BLOCK
_AROUND: Final = np.ones((3, 3), np.bool_)


@dataclass(frozen=True, eq=False)
class Cells:
    """Squares of `GROUND_CELL` metres, in rows from south to north. Their corners lie at whole multiples of it.

    There is a block of squares without ground all around.
    """

    # Column and row of the first square, counted from x = y = 0
    column: int
    row: int
    ground: BoolArray  # (rows, columns) Squares that have ground, in whole blocks of `GROUND_BLOCK` x `GROUND_BLOCK`
    near: BoolArray  # (rows, columns) Squares with a road on them or too close to one: they are not whole
    # (rows + 1, columns + 1) How far corners lie within the outline of land and of water, m; negative beyond it
    inside: FloatArray
    inside_water: FloatArray
    water: IntArray  # (rows + 1, columns + 1) The area of water in which corners lie; -1 for none

    @property
    def nodes(self) -> tuple[int, int]:
        """Rows and columns of corners."""
        rows, columns = self.ground.shape
        return rows + 1, columns + 1

    def node_xy(self) -> tuple[FloatArray, FloatArray]:
        """Return x, y of all corners, each (rows + 1, columns + 1), m."""
        rows, columns = self.nodes
        return _node_xy(self.column, self.row, columns, rows)

    def between(self, values: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return values of corners, (rows + 1, columns + 1), interpolated at x, y (n,), m; NaN off all squares."""
        rows, columns = self.ground.shape
        column, row = x / GROUND_CELL - self.column, y / GROUND_CELL - self.row
        on = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        i, j = (np.where(on, np.floor(value), 0).astype(np.int64) for value in (row, column))
        u, v = column - j, row - i
        south = values[i, j] * (1 - u) + values[i, j + 1] * u
        north = values[i + 1, j] * (1 - u) + values[i + 1, j + 1] * u
        return np.where(on, south * (1 - v) + north * v, np.nan)


def _node_xy(column: int, row: int, columns: int, rows: int) -> tuple[FloatArray, FloatArray]:
    """Return x, y of rows and columns of corners, each (rows, columns), m."""
    x, y = GROUND_CELL * (column + np.arange(columns)), GROUND_CELL * (row + np.arange(rows))
    return np.broadcast_to(x, (rows, columns)), np.broadcast_to(y[:, None], (rows, columns))


def corners_of(squares: BoolArray) -> BoolArray:
    """Return which corners belong to any of some squares, (rows + 1, columns + 1)."""
    out = np.zeros((squares.shape[0] + 1, squares.shape[1] + 1), np.bool_)
    for rows in (slice(None, -1), slice(1, None)):
        for columns in (slice(None, -1), slice(1, None)):
            out[rows, columns] |= squares
    return out


def along_edges(start: FloatArray, end: FloatArray, step: float = SAMPLE) -> tuple[FloatArray, IntArray]:
    """Return points along edges between points (n, 2 or 3), both ends among them, and the edge of each.

    They are at most `step` apart, m.
    """
    count = np.maximum(np.ceil(np.hypot(*(end - start)[:, :2].T) / step), 1).astype(np.int64)
    at = ranks(count + 1) / np.repeat(count, count + 1)
    edge = np.repeat(np.arange(len(start)), count + 1)
    # Ends are exact.
    out: FloatArray = start[edge] * (1.0 - at)[:, None] + end[edge] * at[:, None]
    return out, edge


def nodes_within(triangles: FloatArray) -> FloatArray:
    """Return the points of triangles (n, 3, 3) that lie above or below corners of squares, (k, 3), m."""
    low = np.ceil(triangles[:, :, :2].min(1) / GROUND_CELL).astype(np.int64)
    count = np.floor(triangles[:, :, :2].max(1) / GROUND_CELL).astype(np.int64) - low + 1
    many = np.maximum(count, 0).prod(1)
    of = np.repeat(np.arange(len(triangles)), many)
    row, column = np.divmod(ranks(many), count[of, 0])
    at = GROUND_CELL * (low[of] + np.column_stack([column, row]))
    a, b, c = (triangles[of, k] for k in range(3))
    # Twice the areas opposite of the corners.
    parts = np.column_stack([_turn(b, c, at), _turn(c, a, at), _turn(a, b, at)])
    total = parts.sum(1)
    kept = (parts >= 0.0).all(1) & (total > 0.0)
    z = (parts * np.column_stack([a[:, 2], b[:, 2], c[:, 2]])).sum(1)[kept] / total[kept]
    return np.column_stack([at[kept], z])


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return twice the areas of triangles in plan, positive where they are counter-clockwise."""
    out: FloatArray = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return out


def cells_around(
    start: FloatArray,
    end: FloatArray,
    others: FloatArray,
    covered: Callable[[FloatArray], BoolArray],
    reach: float = REACH,
    found: Callable[[FloatArray, FloatArray], IntArray] | None = None,
) -> Cells:
    """Return the squares up to `reach` metres from roads on the ground, and those of water beyond.

    `start` and `end`, (n, 2), are those of the rim's edges, m; `others`, (k, 2), are points of roads that are not on
    the ground. `covered` says whether places lie on a road on the ground, `found` gives the area of water at x, y
    (n,), m, -1 where there is none. `InputError` if roads span too much for the memory.
    """
    rim, _ = along_edges(start, end)
    points = np.concatenate([rim, others])
    size = GROUND_CELL * GROUND_BLOCK
    margin = int(np.ceil((reach if found is None else max(reach, WATER_REACH)) / size)) + 3
    low, high = (np.floor(value / size).astype(np.int64) for value in (points.min(0), points.max(0)))
    low, high = low - margin, high + margin + 1
    columns, rows = (high - low).tolist()
    if columns * rows * GROUND_BLOCK**2 > MOST_CELLS:
        extent = columns * rows * size**2 / 1e6
        raise InputError(f"the roads span {extent:,.0f} km², too much for one scene; crop the file first")
    occupied = np.zeros((rows, columns), np.bool_)
    column, row = (np.floor(points / size).astype(np.int64) - low).T
    occupied[row, column] = True
    away = ndimage.distance_transform_edt(~occupied, sampling=size)
    column, row = (GROUND_BLOCK * low).tolist()
    inside = _closed(_inside(points, away, column, row, reach), reach)
    water, beyond = np.full(inside.shape, -1), inside
    if found is not None:
        x, y = _node_xy(column, row, *inside.shape[::-1])
        water = found(x.ravel(), y.ravel()).reshape(inside.shape)
        far = _closed(_inside(points, away, column, row, WATER_REACH), WATER_REACH)
        inside, beyond = _with_water(inside, far, water >= 0, reach)
    within = np.zeros((rows, columns), np.bool_)
    for i in range(GROUND_BLOCK + 1):
        for j in range(GROUND_BLOCK + 1):
            within |= (
                beyond[i : i + GROUND_BLOCK * rows : GROUND_BLOCK, j : j + GROUND_BLOCK * columns : GROUND_BLOCK] > 0
            )
    ground = _squares(within)
    return Cells(column, row, ground, _near(rim, covered, column, row, ground), inside, beyond, water)


def _with_water(inside: FloatArray, far: FloatArray, wet: BoolArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Return how far corners lie within the outlines of land and of water, which are `inside` without water.

    Water that is joined to the ground reaches `far`. Islands and moles within it are whole, up to `LARGEST_GAP`.
    """
    part, count = ndimage.label(wet & (far > 0.0))
    joined = np.bincount(part[inside > 0.0], minlength=count + 1) > 0
    joined[0] = False
    lake = joined[part]
    # Triangles at shores have corners on both sides.
    water = np.where(ndimage.binary_dilation(lake, _AROUND, GROUND_BLOCK), far, inside)
    ground = np.where(lake, far, inside)
    closed = _closed(ground, reach)
    whole = ~ndimage.binary_dilation(closed <= 0.0, _AROUND, GROUND_BLOCK) | (closed > ground)
    return np.where(whole, reach, inside), np.where(closed > ground, far.max(), water)


def _squares(blocks: BoolArray) -> BoolArray:
    """Return the squares of blocks."""
    return blocks.repeat(GROUND_BLOCK, 0).repeat(GROUND_BLOCK, 1)


def _inside(points: FloatArray, away: FloatArray, column: int, row: int, reach: float) -> FloatArray:
    """Return how much nearer than `reach` to points corners of squares are, m, exact about the outline.

    `away` are the distances of the middles of blocks to those of blocks with points, m.
    """
    out = np.where(corners_of(_squares(away < reach)), reach, -GROUND_CELL)
    rows, columns = np.nonzero(corners_of(_squares(np.abs(away - reach) <= _DIAGONALS)))
    at = GROUND_CELL * (np.column_stack([columns + column, rows + row]))
    found = reach - PointTree(np.unique(points, axis=0)).nearest(at)[0]
    out[rows, columns] = np.where(np.abs(found) < _ON_OUTLINE, 0.0, found)
    return out


def _closed(inside: FloatArray, reach: float) -> FloatArray:
    """Return the same with gaps of up to `LARGEST_GAP` closed."""
    gaps, count = ndimage.label(inside <= 0.0)
    fill = np.bincount(gaps.ravel(), minlength=count + 1) * GROUND_CELL**2 <= LARGEST_GAP
    # The first corner lies beyond the ground.
    fill[[0, gaps[0, 0]]] = False
    return np.where(fill[gaps], reach, inside)


def _near(
    rim: FloatArray, covered: Callable[[FloatArray], BoolArray], column: int, row: int, ground: BoolArray
) -> BoolArray:
    """Return which squares have a road on them or come too close to one."""
    out = np.zeros(ground.shape, np.bool_)
    if not len(rim):
        return out
    # Half a sample lies between a point of an edge and the next one.
    off = KEEP_OFF + 0.5 * SAMPLE
    for dx in (-off, 0.0, off):
        for dy in (-off, 0.0, off):
            at = np.floor((rim + np.array([dx, dy])) / GROUND_CELL).astype(np.int64) - (column, row)
            out[at[:, 1], at[:, 0]] = True
    # The squares at rims part those on roads from those beside them.
    label, _ = ndimage.label(~out)
    first = np.unique(label, return_index=True)[1]
    rows, columns = np.divmod(first, ground.shape[1])
    middle = GROUND_CELL * (np.column_stack([columns + column, rows + row]) + 0.5)
    road = covered(middle)
    # Those without a label are near already.
    road[label.ravel()[first] == 0] = True
    found: BoolArray = road[label]
    return found
