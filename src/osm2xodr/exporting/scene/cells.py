"""The squares that the ground consists of: where it is, which are not whole, and levels of detail of the others.

Squares are one, two or four of `Cells` wide, and meet along whole sides or halves of them. Whatever the detail,
those at borders of tiles are the same, so that tiles of different detail meet without a crack.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import shapely
from scipy import ndimage

from osm2xodr.curves import PointTree, ranks
from osm2xodr.errors import InputError
from osm2xodr.exporting.scene.model import GROUND_CELL, LARGEST_GAP
from osm2xodr.exporting.scene.water import WaterShapes
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Most squares in the rectangle around a scene: 1,000 km², some 2 GB. A choice.
_MOST_CELLS: Final = 40_000_000
# How far corners of squares keep from roads at least, m, so that no triangle is a sliver. A choice.
_KEEP_OFF: Final = 1.5
# Largest distance between points that stand for edges and faces of roads, m. A fifth of a square.
_SAMPLE: Final = 1.0

# Squares per side of the largest squares, of which the extent of the ground consists.
GROUND_BLOCK: Final = 4
# Corners closer to the outline of the ground than this lie on it, m, so that no triangle there is a sliver. A choice.
_ON_OUTLINE: Final = 0.1
# The largest squares that the outline crosses have corners a diagonal away, and distances between the corners that
# are nearest to two places are off by one of the smallest, m.
_ABOUT_OUTLINE: Final = np.sqrt(2.0) * GROUND_CELL * (GROUND_BLOCK + 1)
_AROUND: Final = np.ones((3, 3), np.bool_)
# Corners and middles of the sides of a square in half sides, row and column, counter-clockwise from the south-west.
_RING: Final = ((0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0))


@record(eq=False)
class Cells:
    """Squares of `GROUND_CELL` metres, in rows from south to north. Their corners lie at whole multiples of it.

    There is a block of squares without ground all around.
    """

    # Column and row of the first square, counted from x = y = 0
    column: int
    row: int
    ground: BoolArray  # (rows, columns) Squares that have ground, in whole blocks of `GROUND_BLOCK` x `GROUND_BLOCK`
    roads: BoolArray  # (rows, columns) Squares with a road on them or too close to one
    shores: BoolArray  # (rows, columns) Other squares with ground at a shore
    # (rows + 1, columns + 1) How far corners lie within the outline of land and of water, m; negative beyond it
    inside: FloatArray
    inside_water: FloatArray
    water: IntArray  # (rows + 1, columns + 1) The area of water in which corners lie; -1 for none

    @property
    def nodes(self) -> tuple[int, int]:
        """Rows and columns of corners."""
        rows, columns = self.ground.shape
        return rows + 1, columns + 1

    def node_xy(self) -> FloatArray:
        """Return x, y of all corners, (corners, 2), m, in rows from south to north."""
        return _node_xy(self.column, self.row, self.nodes)

    def has(self, squares: BoolArray, xy: FloatArray) -> BoolArray:
        """Return whether places (n, 2), m, lie in some squares, (rows, columns)."""
        column, row = _squares_at(xy, self.column, self.row, squares.shape)
        out: BoolArray = (row >= 0) & squares[row, column]
        return out

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

    def sides(self, squares: BoolArray) -> IntArray:
        """Return the sides of squares, (n, 2), as rows of corners, counter-clockwise around each."""
        stride = self.nodes[1]
        row, column = np.nonzero(squares)
        ring = (row * stride + column)[:, None] + np.array([0, 1, stride + 1, stride])
        return np.column_stack([ring.ravel(), np.roll(ring, -1, axis=1).ravel()])


def _node_xy(column: int, row: int, nodes: tuple[int, int]) -> FloatArray:
    """Return x, y of rows and columns of corners, (corners, 2), m."""
    out = np.empty((*nodes, 2))
    out[..., 0] = GROUND_CELL * (column + np.arange(nodes[1]))
    out[..., 1] = GROUND_CELL * (row + np.arange(nodes[0]))[:, None]
    return out.reshape(-1, 2)


def _squares_at(xy: FloatArray, column: int, row: int, shape: tuple[int, ...]) -> IntArray:
    """Return column and row of the squares at places, (2, n); both -1 off all squares."""
    at = np.floor(xy / GROUND_CELL).astype(np.int64).T - np.array([[column], [row]])
    on = (at >= 0).all(0) & (at < np.array([[shape[1]], [shape[0]]])).all(0)
    return np.where(on, at, -1)


def corners_of(squares: BoolArray) -> BoolArray:
    """Return which corners belong to any of some squares, (rows + 1, columns + 1)."""
    return _any_of_four(np.pad(squares, 1))


def along_edges(edges: FloatArray, step: float = _SAMPLE) -> tuple[FloatArray, IntArray]:
    """Return points along edges (n, 2, 2 or 3), both ends among them, and the edge of each.

    They are at most `step` apart, m.
    """
    start, end = edges[:, 0], edges[:, 1]
    count = np.maximum(np.ceil(np.hypot(*(end - start)[:, :2].T) / step), 1).astype(np.int64)
    at = ranks(count + 1) / np.repeat(count, count + 1)
    edge = np.repeat(np.arange(len(start)), count + 1)
    # Ends are exact.
    out: FloatArray = start[edge] * (1.0 - at)[:, None] + end[edge] * at[:, None]
    return out, edge


def _any_of_four(field: BoolArray) -> BoolArray:
    """Return which groups of two by two have any, (rows - 1, columns - 1)."""
    out: BoolArray = field[1:, 1:] | field[1:, :-1] | field[:-1, 1:] | field[:-1, :-1]
    return out


# ---------------------------------------------------------------- extent


def cells_around(
    rim: FloatArray,
    others: FloatArray,
    covered: Callable[[FloatArray], BoolArray],
    reach: float,
    water: WaterShapes,
    water_reach: float,
) -> Cells:
    """Return the squares up to `reach` metres from roads on the ground, and those of water beyond.

    `rim`, (n, 2), are points along the edges of roads on the ground, m; `others`, (k, 2), those of other roads.
    `covered` says whether places lie on a road on the ground. Water that begins on the ground goes on up to
    `water_reach` metres from the roads. `InputError` if roads span too much for the memory.
    """
    points = np.concatenate([rim, others])
    size = GROUND_CELL * GROUND_BLOCK
    margin = int(np.ceil(max(reach, water_reach) / size)) + 3
    low = np.floor(points.min(0) / size).astype(np.int64) - margin
    columns, rows = (np.floor(points.max(0) / size).astype(np.int64) + margin + 1 - low).tolist()
    if columns * rows * GROUND_BLOCK**2 > _MOST_CELLS:
        extent = columns * rows * size**2 / 1e6
        raise InputError(f"the roads span {extent:,.0f} km², too much for one scene; crop the file first")
    column, row = (GROUND_BLOCK * low).tolist()
    nodes = GROUND_BLOCK * rows + 1, GROUND_BLOCK * columns + 1
    wet = water.found_at(*_node_xy(column, row, nodes).T).reshape(nodes)
    near, far = (_closed(field, field.max()) for field in _inside(points, column, row, nodes, (reach, water_reach)))
    inside, beyond = _with_water(near, far, wet >= 0, reach)
    ground = _spread(_groups(_any_of_four(beyond > 0.0), GROUND_BLOCK).any((1, 3)), GROUND_BLOCK)
    # Half a sample lies between a point of an edge and the next one.
    roads = _touched(rim, _KEEP_OFF + 0.5 * _SAMPLE, column, row, ground.shape)
    if len(rim):
        # The squares at rims part those on roads from those beside them.
        label, _ = ndimage.label(~roads)
        of, first = np.unique(label, return_index=True)
        at_row, at_column = np.divmod(first, ground.shape[1])
        on_road = covered(GROUND_CELL * (np.column_stack([at_column + column, at_row + row]) + 0.5))
        roads |= np.where(of == 0, True, on_road)[label]
    shore = along_edges(shapely.get_coordinates(water.shores).reshape(-1, 2, 2))[0]
    shores = _touched(shore, 0.5 * _SAMPLE, column, row, ground.shape) & ground & ~roads
    return Cells(column, row, ground, roads, shores, inside, beyond, wet)


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


def _inside(
    points: FloatArray, column: int, row: int, nodes: tuple[int, int], reaches: tuple[float, ...]
) -> list[FloatArray]:
    """Return how much nearer to points than each of `reaches` corners of squares are, m, exact about the outline."""
    tree = PointTree(np.unique(points, axis=0))
    occupied = np.zeros(nodes, np.bool_)
    at = np.rint(points / GROUND_CELL).astype(np.int64) - (column, row)
    occupied[at[:, 1], at[:, 0]] = True
    away = ndimage.distance_transform_edt(~occupied, sampling=GROUND_CELL)
    found = []
    for reach in reaches:
        out = reach - away
        rows, columns = np.nonzero(np.abs(out) < _ABOUT_OUTLINE)
        exact = reach - tree.nearest(GROUND_CELL * np.column_stack([columns + column, rows + row]))[0]
        out[rows, columns] = np.where(np.abs(exact) < _ON_OUTLINE, 0.0, exact)
        found.append(out)
    return found


def _closed(inside: FloatArray, reach: float) -> FloatArray:
    """Return the same with gaps of up to `LARGEST_GAP` closed."""
    gaps, count = ndimage.label(inside <= 0.0)
    fill = np.bincount(gaps.ravel(), minlength=count + 1) * GROUND_CELL**2 <= LARGEST_GAP
    # The first corner lies beyond the ground.
    fill[[0, gaps[0, 0]]] = False
    return np.where(fill[gaps], reach, inside)


def _touched(points: FloatArray, off: float, column: int, row: int, shape: tuple[int, ...]) -> BoolArray:
    """Return which squares, (rows, columns), come as close to points as `off`, m."""
    out = np.zeros(shape, np.bool_)
    for dx in (-off, 0.0, off):
        for dy in (-off, 0.0, off):
            at = _squares_at(points + np.array([dx, dy]), column, row, shape)
            out[at[1], at[0]] = True
    # What lies off all squares.
    out[-1, -1] = False
    return out


# ---------------------------------------------------------------- levels of detail


def leaf_sizes(cells: Cells, detail: int, tile: float) -> IntArray:
    """Return in squares how wide the leaf is that each of them is part of, (rows, columns); 0 without ground.

    Those at roads and shores have 1. `detail` 0 is the finest level; borders of tiles lie at multiples of `tile`, m.
    """
    count = round(tile / GROUND_CELL)
    rows, columns = (
        np.isin((first + np.arange(size)) % count, (0, count - 1))
        for first, size in zip((cells.row, cells.column), cells.ground.shape, strict=True)
    )
    border = rows[:, None] | columns
    whole = cells.ground & ~cells.roads & ~cells.shores
    # Water is smooth: it needs no small squares.
    water = whole & (cells.water[:-1, :-1] >= 0)
    pairs = _all(whole, 2)
    if detail == 0:
        pairs &= ~_all(~border, 2) | _all(water, 2)
    out = np.where(pairs, 2, cells.ground.astype(np.int64))
    # Beside the largest leaves lie none of the smallest.
    beside = ndimage.binary_dilation(out == 1)
    large = (out == 2) & ~border & ~beside
    if detail < 2:
        large &= water
    return np.where(_all(large, GROUND_BLOCK), GROUND_BLOCK, out)


def _groups(squares: BoolArray, size: int) -> BoolArray:
    """Return squares by groups of size x size: (rows, size, columns, size)."""
    rows, columns = squares.shape
    return squares.reshape(rows // size, size, columns // size, size)


def _spread(groups: BoolArray, size: int) -> BoolArray:
    """Return the squares of groups."""
    return groups.repeat(size, 0).repeat(size, 1)


def _all(squares: BoolArray, size: int) -> BoolArray:
    """Return the squares of groups of size x size of which all are among some."""
    return _spread(_groups(squares, size).all((1, 3)), size)


def leaf_triangles(cells: Cells, sizes: IntArray, z: FloatArray) -> IntArray:
    """Return the triangles (n, 3) of all whole leaves, counter-clockwise, as rows of corners.

    z, (rows + 1, columns + 1), are the heights of corners, m: diagonals of squares join those of less difference.
    """
    row, column = np.nonzero(sizes)
    size = sizes[row, column]
    first = (row % size == 0) & (column % size == 0)
    row, column, size = row[first], column[first], size[first]
    used = np.zeros(z.shape, np.bool_)
    for dy in (0, 1):
        for dx in (0, 1):
            used[row + dy * size, column + dx * size] = True
    whole = ~(cells.roads | cells.shores)[row, column]
    row, column, size = row[whole], column[whole], size[whole]
    # Sides with a middle: there is a smaller leaf beside them.
    ring = np.stack([(row + dy * size // 2) * z.shape[1] + column + dx * size // 2 for dy, dx in _RING], axis=1)
    split = used.ravel()[ring[:, 1::2]] & (size[:, None] > 1)
    plain = ~split.any(1)
    corner, middle = ring[:, 0::2], (row + size // 2) * z.shape[1] + column + size // 2
    height = z.ravel()[corner[plain]]
    rising = np.abs(height[:, 0] - height[:, 2]) <= np.abs(height[:, 1] - height[:, 3])
    halves = np.where(rising[:, None], [[0, 1, 2, 0, 2, 3]], [[0, 1, 3, 1, 2, 3]])
    found = [np.take_along_axis(corner[plain], halves, axis=1).reshape(-1, 3)]
    for side in range(4):
        a, b, c = ring[:, 2 * side], ring[:, 2 * side + 1], ring[:, (2 * side + 2) % 8]
        two, one = split[:, side], ~split[:, side] & ~plain
        found += [
            np.column_stack([middle, *ends])[rows] for ends, rows in (((a, b), two), ((b, c), two), ((a, c), one))
        ]
    return np.concatenate(found)
