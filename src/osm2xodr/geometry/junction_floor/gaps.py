"""Gaps in the floor of junctions: places that the lanes of connecting roads enclose and none of them covers.

Lanes are drawn into a grid of small cells, one for each junction; what is connected to its border is outside.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.curves import connected_groups, ranks, repeated, runs, starts
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cells import draw_across
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections
from osm2xodr.geometry.junction_floor.faces import Faces
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Distance of points within lanes and of cross sections, as a share of a cell's size: none is missed (below 1 / √2).
POINTS_PER_CELL: Final = 0.7
# Share of their width by which narrow lanes are drawn narrower on both sides at most. A choice.
_INSET_SHARE: Final = 0.4
# What cells hold that no lane covers: nothing, a strip of an island, or a paved one.
FREE: Final = -1
STRIP: Final = -2
PAVED: Final = -3
# The end face of a carriageway.
FACE: Final = -4
# Cells around the lanes of a junction: outside.
_BORDER: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Runs of cells in rows of grids, (n,)."""

    area: IntArray  # The area that they belong to, ascending
    grid: IntArray
    # The first cell and that behind the last
    first: IntArray
    last: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Grids:
    """A grid of cells for each of J junctions, one behind the other, and cross sections in them."""

    start: IntArray  # (J + 1,) Index of each junction's first cell
    wide: IntArray  # (J,) How many cells it has from west to east
    # (cells,) The connecting road whose lanes cover each, one of several, or `FREE`, `STRIP`, `PAVED` or `FACE`
    road: NDArray[np.int32]
    # (cells,) The number of the gap that it belongs to, from 1; 0 where it is covered or outside
    gap: NDArray[np.int32]
    corner: IntArray  # (J, 2) Column and row of each grid's first cell, counted from the origin
    # (n,) Cross sections in cells from the corner of their grid: where they are, and the direction of t for one metre
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    nx: NDArray[np.float32]
    ny: NDArray[np.float32]
    # (n,) Their grid: its first cell, that behind its last, and how many cells it is wide
    first: NDArray[np.int32]
    end: NDArray[np.int32]
    across: NDArray[np.int32]
    holes: Runs | None = None  # What may be islands
    faces: Faces | None = None  # What else bounds gaps
    # By number of the gap: whether it is part of the carriageway, not of an island; [0] is none
    paved: BoolArray = field(default_factory=lambda: np.zeros(1, bool))

    def cells(self, k: IntArray, t: NDArray[np.float32]) -> NDArray[np.int32]:
        """Return the cells at t, m, (steps, n), of the k-th cross sections, (n,); t is at most a cell off lanes."""
        column, row = self._places(k, t)
        row *= self.across[k]
        row += self.first[k]
        row += column
        return row

    def without_pavement(self, gaps: IntArray) -> Grids:
        """Return them with some gaps, by their numbers, that are islands."""
        paved = self.paved.copy()
        paved[gaps] = False
        return replace(self, paved=paved)

    def cells_far(self, k: IntArray, t: NDArray[np.float32]) -> NDArray[np.int32]:
        """Return the cells at any t; where that is beyond the grid, its first cell, which is outside of all lanes."""
        column, row = self._places(k, t)
        first, across = self.first[k], self.across[k]
        cell = first + row * across + column
        within = (column >= 0) & (column < across) & (row >= 0) & (cell < self.end[k])
        return np.where(within, cell, first)

    def _places(self, k: IntArray, t: NDArray[np.float32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return columns and rows in the grids at t, m, (steps, n), of the k-th cross sections, (n,)."""
        at = t * self.nx[k]
        at += self.x[k]
        column = at.astype(np.int32)
        np.multiply(t, self.ny[k], out=at)
        at += self.y[k]
        return column, at.astype(np.int32)

    def draw(self, low: FloatArray, high: FloatArray, value: NDArray[np.int32]) -> None:
        """Write values into the cells of cross sections from t = low to t = high, m, all (n,)."""
        count = np.ceil((high - low) / (POINTS_PER_CELL * defaults.GAP_CELL)).astype(np.int16)
        order = np.argsort(count, kind="stable")
        order = order[np.searchsorted(count[order], 0, side="right") :]
        begin, end, grid = low.astype(np.float32), high.astype(np.float32), (self.first, self.across)
        # Cross sections of equal width at once.
        for equal in np.split(order, np.flatnonzero(np.diff(count[order])) + 1) if len(order) else ():
            shares = np.linspace(0.0, 1.0, int(count[equal[0]]) + 1, dtype=np.float32)
            draw_across(equal, shares, begin, end, self.x, self.y, self.nx, self.ny, *grid, value, self.road)


def find_gaps(sections: CrossSections, junction: IntArray, faces: Faces) -> Grids:
    """Return the junctions' grids; `junction` is that of each cross section, 0 … J - 1, (n,).

    `faces` bound gaps as lanes do. Gaps are paved but for what is left beside a strip of an island.
    """
    grids = _empty_grids(sections, junction, faces)
    _draw(grids, sections, faces)
    owner, first, last = _free_runs(grids)
    area = _connected(grids, owner, first, last)
    size = np.bincount(area, last - first)
    # The first area of each grid is that of its corner, which is outside.
    outside = area[np.searchsorted(owner, np.arange(len(grids.wide)))]
    good = (size >= defaults.GAP_LEAST_AREA / defaults.GAP_CELL**2) & (
        size <= defaults.GAP_LARGEST_AREA / defaults.GAP_CELL**2
    )
    good[outside] = False
    large = (size >= defaults.ISLAND_LEAST_AREA / defaults.GAP_CELL**2) & (
        size <= defaults.ISLAND_LARGEST_AREA / defaults.GAP_CELL**2
    )
    large[outside] = False
    some = np.flatnonzero(large[area])
    some = some[np.argsort(area[some], kind="stable")]
    holes = Runs(area[some], owner[some], first[some], last[some])
    number = np.where(good, np.cumsum(good), 0)[area]
    rows = np.flatnonzero(number)
    count = (last - first)[rows]
    cells, of = runs(first[rows], count), np.repeat(number[rows], count)
    grids.gap[cells] = of
    wide = np.repeat(grids.wide[owner[rows]], count)
    paved = np.append(False, np.ones(int(good.sum()), bool))
    paved[of[_beside(grids, cells, wide, STRIP)]] = False
    return replace(grids, holes=holes, faces=faces, paved=paved)


def _beside(grids: Grids, cells: IntArray, wide: IntArray, wanted: int) -> BoolArray:
    """Say beside which cells lies one that holds what is `wanted`, (n,); their grids are `wide` (n,)."""
    out = np.zeros(len(cells), bool)
    for step in (-1, 1, -wide, wide):
        out |= grids.road[cells + step] == wanted
    return out


def _free_runs(grids: Grids) -> tuple[IntArray, IntArray, IntArray]:
    """Return the runs of free cells in the rows of all grids: their grid, first cell and that behind their last."""
    free = grids.road == FREE
    change = np.empty(len(free) + 1, bool)
    change[0] = change[-1] = True
    np.not_equal(free[1:], free[:-1], out=change[1:-1])
    deep = np.diff(grids.start) // grids.wide
    # The borders of grids are free: each row begins with a run.
    change[np.repeat(grids.start[:-1], deep) + ranks(deep) * np.repeat(grids.wide, deep)] = True
    border = np.flatnonzero(change)
    kept = np.flatnonzero(free[border[:-1]])
    first, last = border[kept], border[kept + 1]
    return np.searchsorted(grids.start, first, side="right") - 1, first, last


def _connected(grids: Grids, owner: IntArray, first: IntArray, last: IntArray) -> IntArray:
    """Return the areas that runs belong to, numbered from 0 in the order of their first runs, (n,)."""
    # Those of the next row that overlap with a run; none below the last row, where grids are free from side to side.
    below = np.minimum(first + grids.wide[owner], grids.start[owner + 1]), last + grids.wide[owner]
    begin = np.searchsorted(last, below[0], side="right")
    count = np.searchsorted(first, np.minimum(below[1], grids.start[owner + 1])) - begin
    return connected_groups(len(first), repeated(count), runs(begin, count))


def _empty_grids(sections: CrossSections, junction: IntArray, faces: Faces) -> Grids:
    """Return grids around all lanes."""
    count = int(junction.max()) + 1
    low, high = np.full((2, count), np.inf), np.full((2, count), -np.inf)
    first = np.flatnonzero(np.diff(junction, prepend=-1))
    for t in (sections.left + sections.more_left, sections.right - sections.more_right):
        for k, (v, n) in enumerate(((sections.x, sections.nx), (sections.y, sections.ny))):
            edge = (v + t * n) / defaults.GAP_CELL
            np.minimum.at(low[k], junction[first], np.minimum.reduceat(edge, first))
            np.maximum.at(high[k], junction[first], np.maximum.reduceat(edge, first))
    for k, v in enumerate((faces.x, faces.y)):
        np.minimum.at(low[k], faces.junction, v / defaults.GAP_CELL)
        np.maximum.at(high[k], faces.junction, v / defaults.GAP_CELL)
    low = np.floor(low) - _BORDER
    wide, deep = (np.ceil(high - low) + _BORDER).astype(np.int64)
    start = starts(wide * deep)
    road = np.full(int(start[-1]), FREE, np.int32)
    places = (
        (sections.x / defaults.GAP_CELL - low[0, junction]).astype(np.float32),
        (sections.y / defaults.GAP_CELL - low[1, junction]).astype(np.float32),
        (sections.nx / defaults.GAP_CELL).astype(np.float32),
        (sections.ny / defaults.GAP_CELL).astype(np.float32),
        *(column[junction].astype(np.int32) for column in (start[:-1], start[1:], wide)),
    )
    return Grids(start, wide, road, np.zeros(len(road), np.int32), low.T.astype(np.int64), *places)


def _draw(grids: Grids, sections: CrossSections, faces: Faces) -> None:
    """Draw end faces, strips, then lanes into the grids."""
    place = np.floor(np.column_stack([faces.x, faces.y]) / defaults.GAP_CELL).astype(np.int64)
    column, row = (place - grids.corner[faces.junction]).T
    grids.road[grids.start[faces.junction] + row * grids.wide[faces.junction] + column] = FACE
    left, right = (
        np.where(item, PAVED, STRIP).astype(np.int32) for item in (sections.paved_left, sections.paved_right)
    )
    grids.draw(sections.left, sections.left + sections.more_left, left)
    grids.draw(sections.right - sections.more_right, sections.right, right)
    # The tips of sidewalks are narrower than that.
    inset = np.minimum(defaults.GAP_INSET, _INSET_SHARE * (sections.left - sections.right))
    grids.draw(sections.right + inset, sections.left - inset, sections.road.astype(np.int32))
