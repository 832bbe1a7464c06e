"""The squares that the ground consists of: where it is at all, and which are too close to roads for whole squares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from osm2xodr.curves import ranks
from osm2xodr.errors import InputError
from osm2xodr.exporting.scene.ground.defaults import GROUND_CELL, KEEP_OFF, LARGEST_GAP, MOST_CELLS, REACH, SAMPLE
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Squares per side of the blocks of which the extent of the ground consists: the largest squares.
GROUND_BLOCK: Final = 4
# Points and edges that are compared at once: some 8 MB a table.
_PAIRS: Final = 1 << 20


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

    @property
    def nodes(self) -> tuple[int, int]:
        """Rows and columns of corners."""
        rows, columns = self.ground.shape
        return rows + 1, columns + 1

    def node_xy(self) -> tuple[FloatArray, FloatArray]:
        """Return x, y of all corners, each (rows + 1, columns + 1), m."""
        rows, columns = self.nodes
        x, y = GROUND_CELL * (self.column + np.arange(columns)), GROUND_CELL * (self.row + np.arange(rows))
        return np.broadcast_to(x, (rows, columns)), np.broadcast_to(y[:, None], (rows, columns))


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


def cells_around(start: FloatArray, end: FloatArray, others: FloatArray, reach: float = REACH) -> Cells:
    """Return the squares up to `reach` metres from roads on the ground.

    `start` and `end`, (n, 2), are those of the rim's edges, which have the road on their left, m; `others`, (k, 2),
    are points of roads that are not on the ground. `InputError` if they span too much for the memory.
    """
    rim, _ = along_edges(start, end)
    points = np.concatenate([rim, others])
    size = GROUND_CELL * GROUND_BLOCK
    margin = int(np.ceil(reach / size)) + 2
    low, high = (np.floor(value / size).astype(np.int64) for value in (points.min(0), points.max(0)))
    low, high = low - margin, high + margin + 1
    columns, rows = (high - low).tolist()
    if columns * rows * GROUND_BLOCK**2 > MOST_CELLS:
        extent = columns * rows * size**2 / 1e6
        raise InputError(f"the roads span {extent:,.0f} km², too much for one scene; crop the file first")
    occupied = np.zeros((rows, columns), np.bool_)
    column, row = (np.floor(points / size).astype(np.int64) - low).T
    occupied[row, column] = True
    # From block to block: the distance between their middles less one diagonal or side is that between them.
    away = ndimage.distance_transform_edt(~occupied, sampling=size)
    blocks = _closed(away - size <= reach, int(LARGEST_GAP / size**2))
    ground = blocks.repeat(GROUND_BLOCK, 0).repeat(GROUND_BLOCK, 1)
    column, row = (GROUND_BLOCK * low).tolist()
    return Cells(column, row, ground, _near(rim, start, end, column, row, ground))


def _closed(blocks: BoolArray, largest: int) -> BoolArray:
    """Return blocks with those gaps filled that consist of at most so many blocks."""
    gaps, count = ndimage.label(~blocks)
    size = np.bincount(gaps.ravel(), minlength=count + 1)
    fill = (size <= largest) & (np.arange(count + 1) > 0)
    # The first corner lies beyond the ground.
    fill[gaps[0, 0]] = False
    out: BoolArray = blocks | fill[gaps]
    return out


def _near(rim: FloatArray, start: FloatArray, end: FloatArray, column: int, row: int, ground: BoolArray) -> BoolArray:
    """Return which squares have a road on them or come too close to one."""
    out = np.zeros(ground.shape, np.bool_)
    if not len(start):
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
    road = on_the_left(middle, start, end)
    # Those without a label are near already.
    road[label.ravel()[first] == 0] = True
    found: BoolArray = road[label]
    return found


def on_the_left(points: FloatArray, start: FloatArray, end: FloatArray) -> BoolArray:
    """Return which points (n, 2) lie inside of closed outlines of directed edges, counter-clockwise around it."""
    out = np.zeros(len(points), np.bool_)
    (x0, y0), (x1, y1) = start.T, end.T
    up = np.where(y1 > y0, 1, -1)
    low, high = np.minimum(y0, y1), np.maximum(y0, y1)
    step = max(1, _PAIRS // max(len(start), 1))
    for first in range(0, len(points), step):
        part = slice(first, first + step)
        x, y = points[part, 0, None], points[part, 1, None]
        beside = (low <= y) & (y < high)
        with np.errstate(divide="ignore", invalid="ignore"):
            right = x0 + (y - y0) / (y1 - y0) * (x1 - x0) > x
        out[part] = (np.where(beside & right, up, 0)).sum(1) > 0
    return out
