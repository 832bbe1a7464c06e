"""Gaps in the floor of junctions, which lanes enclose and none covers, and rays across them from lanes."""

from __future__ import annotations

from dataclasses import field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.curves import (
    Table,
    connected_groups,
    cosine_sine,
    heading_at,
    join_tables,
    project,
    ranks,
    repeated,
    runs,
    starts,
)
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cells import draw_across
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.junction_floor.faces import Faces
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

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

# Distance of places on a ray, m, and how many of them a gap may begin behind: cells that an edge runs through are
# covered.
RAY_STEP: Final = 0.5 * defaults.GAP_CELL
_FIRST: Final = 4
# How near strips come to the centre of a bend, where cross sections meet, as a share of its radius and at most, m.
_LEAST_SHARE: Final = 0.15
_LEAST_RADIUS: Final = 0.1
# A place lies abreast of a road, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01
# Least sine of the angle between a ray and the edge that it meets, and how often the meeting is improved.
_LEAST_SINE: Final = 0.3
_ROUNDS: Final = 2


@record(eq=False)
class Runs:
    """Runs of cells in rows of grids, (n,)."""

    area: IntArray  # The area that they belong to, ascending
    grid: IntArray
    # The first cell and that behind the last
    first: IntArray
    last: IntArray


@record(eq=False)
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


@record(eq=False)
class Rays(Table):
    """Rays across gaps, in the order of edges and along each of them."""

    # (n,) Index of the cross section that each begins at, and the side: left 1, right -1
    section: IntArray
    side: IntArray
    gap: IntArray  # (n,) Number of the gap
    cells: NDArray[np.int32]  # (n, steps) Cells on the way
    first: IntArray  # (n,) Index of the first place within the gap
    room: IntArray  # (n,) Index of the first place that is too far away

    def ends(self, grids: Grids) -> IntArray:
        """Return the index of the first place behind each gap (of the first one within, where it is closed), (n,)."""
        steps = np.arange(self.cells.shape[1])
        left = (grids.gap[self.cells] != self.gap[:, None]) & (steps >= self.first[:, None])
        left |= steps >= self.room[:, None]
        left[:, -1] = True
        end: IntArray = left.argmax(axis=1)
        return end

    def roads_at(self, end: IntArray, grids: Grids) -> IntArray:
        """Return the connecting road whose lanes each ray comes to at its `end`; -1 for none, (n,)."""
        out: IntArray = grids.road[self.cells[np.arange(len(end)), end]].astype(np.int64)
        return out


def cast_rays(grids: Grids, sections: CrossSections, junction: IntArray) -> Rays:
    """Return the rays that meet a gap next to the edge where they begin; `junction` is that of each section, (n,)."""
    step = RAY_STEP
    holed = np.maximum.reduceat(grids.gap, grids.start[:-1]) > 0
    near = np.flatnonzero(holed[junction])
    steps = np.arange(1, int(defaults.FLOOR_REACH / step) + 1) * step
    found: list[Rays] = []
    for side in (1, -1):
        edge = sections.edge(np.array(side), near)
        begin = grids.gap[grids.cells(near, (edge + side * steps[:_FIRST, None]).astype(np.float32))]
        meets = np.flatnonzero(begin.any(axis=0))
        k, edge, begin = near[meets], edge[meets], begin[:, meets]
        first = (begin > 0).argmax(axis=0)
        gap = begin[first, np.arange(len(first))].astype(np.int64)
        room = room_inside(sections, side, k) / step - 1.0
        cells = grids.cells_far(k, (edge + side * steps[:, None]).astype(np.float32)).T
        last = np.clip(room, 0, len(steps) - 1).astype(np.int64)
        found.append(Rays(k, np.full(len(k), side), gap, cells, first, last))
    rows = join_tables(found)
    return rows.chosen(rows.room > rows.first)


def room_inside(sections: CrossSections, side: int, k: IntArray) -> FloatArray:
    """Return how wide a strip may be on a side of the k-th cross sections, (n,), m: up to near a bend's centre.

    A bend may begin between two cross sections, and widths are linear there.
    """
    edge = sections.edge(np.array(side), k)
    radius = 1.0 / bend_beside(sections, np.array(side), k)
    return np.asarray(np.maximum((1.0 - _LEAST_SHARE) * radius, radius - _LEAST_RADIUS) - side * edge)


def bend_beside(sections: CrossSections, side: IntArray, k: IntArray) -> FloatArray:
    """Return the largest curvature towards a side at the k-th cross sections and those beside them, (n,), 1/m."""
    bend = np.full(len(k), 1e-9)
    for other in (k, np.maximum(k - 1, 0), np.minimum(k + 1, len(sections.road) - 1)):
        same = sections.road[other] == sections.road[k]
        bend = np.where(same, np.maximum(bend, side * sections.curvature[other]), bend)
    return bend


def meet(
    section: IntArray,
    side: IntArray,
    reach: FloatArray,
    other: IntArray,
    sections: CrossSections,
    roads: ConnectingRoads,
    edges: LaneEdges,
) -> tuple[FloatArray, BoolArray]:
    """Return where rays meet the lanes of the `other` roads (-1: none), beyond their edge, near `reach`, (n,), m.

    The second array says which of them do; the others keep their `reach`.
    """
    out, met = reach.copy(), np.zeros(len(reach), bool)
    rows = np.flatnonzero(other >= 0)
    for _ in range(_ROUNDS):
        k, road, sign = section[rows], other[rows], side[rows]
        t = sections.edge(sign, k) + sign * out[rows]
        x, y = sections.x[k] + t * sections.nx[k], sections.y[k] + t * sections.ny[k]
        s, aside, distance = project(roads.plan_view, road, x, y)
        left, right = edges.at(road, s)
        beyond_left = aside > (left + right) / 2
        outside = np.where(beyond_left, aside - left, right - aside)
        cos, sin = cosine_sine(heading_at(roads.plan_view, road, s))
        # How much nearer to that edge a step along the ray gets.
        nearer = sign * (sections.ny[k] * cos - sections.nx[k] * sin)
        nearer = np.where(beyond_left, -nearer, nearer)
        good = (np.abs(distance - np.abs(aside)) < _ABREAST) & (nearer > _LEAST_SINE)
        met[rows] = good
        # The others stay where they are.
        rows = rows[good]
        out[rows] += outside[good] / nearer[good]
    low, high = reach - 3 * defaults.GAP_CELL, reach + 2 * defaults.GAP_CELL
    return np.asarray(np.clip(out, np.maximum(low, 0.0), high)), met & (out <= high)
