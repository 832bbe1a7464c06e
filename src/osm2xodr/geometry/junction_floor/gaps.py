"""Gaps in the floor of junctions, which lanes enclose and none covers, and rays across them from lanes."""

from __future__ import annotations

from dataclasses import replace
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
    sorted_unique,
    starts,
    unique_first,
)
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import defaults
from osm2xodr.geometry.junction_floor.cells import (
    FACE,
    FREE,
    PAVED,
    STRIP,
    close_gaps,
    draw_pieces,
    gaps_beside,
    walk_gaps,
)
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections, LaneEdges
from osm2xodr.geometry.junction_floor.faces import Faces
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Cells around the lanes of a junction: outside.
_BORDER: Final = 4

# Distance of places on a ray, m, and how many of them a gap may begin behind: cells that an edge runs through may be
# covered.
RAY_STEP: Final = 0.5 * defaults.GAP_CELL
_FIRST: Final = 4
# Lanes from whose edge a ray may meet a gap at once have a cell of it within this distance, m: a ray's place may lie
# in the corner of a cell.
_BESIDE: Final = _FIRST * RAY_STEP + 0.75 * defaults.GAP_CELL
# How near strips come to the centre of a bend, where cross sections meet, as a share of its radius and at most, m.
_LEAST_SHARE: Final = 0.15
_LEAST_RADIUS: Final = 0.1
# A place lies abreast of a road, not beyond its ends, if its distance is |t| up to this, m.
_ABREAST: Final = 0.01
# Least sine of the angle between a ray and the edge that it meets, and how often the meeting is improved.
_LEAST_SINE: Final = 0.3
_ROUNDS: Final = 2


@record(eq=False)
class Runs(Table):
    """Runs of cells in rows of grids, (n,)."""

    grid: IntArray
    # The first cell and that behind the last
    first: IntArray
    last: IntArray
    area: IntArray  # The area of connected cells that they belong to


@record(eq=False)
class Grids:
    """A grid of cells for each of J junctions, one behind the other."""

    start: IntArray  # (J + 1,) Index of each junction's first cell
    wide: IntArray  # (J,) How many cells it has from west to east
    corner: IntArray  # (J, 2) Column and row of each grid's first cell, counted from the origin
    # (cells,) The connecting road whose lanes cover each, one of several, or what `cells` has for others
    cells: NDArray[np.int32]
    faces: Faces  # What else bounds gaps
    holes: Runs  # What may be islands, area after area
    # (cells of gaps,) Their indices, and the number of the gap
    gaps: IntArray
    number: IntArray
    paved: BoolArray  # By number of the gap: whether it is part of the carriageway, not of an island; [0] is none

    def without_pavement(self, gaps: IntArray) -> Grids:
        """Return them with some gaps, by their numbers, that are islands."""
        paved = self.paved.copy()
        paved[gaps] = False
        return replace(self, paved=paved)

    def places(self, sections: CrossSections, junction: IntArray) -> tuple[FloatArray, IntArray]:
        """Return column and row in their grids of cross sections in junctions, and how they grow with t, (4, n).

        And these grids, as `cells` takes them, (3, n).
        """
        out = np.array([sections.x, sections.y, sections.nx, sections.ny]) / defaults.GAP_CELL
        out[:2] -= self.corner.T[:, junction]
        return out, np.array([self.start[:-1], self.start[1:], self.wide])[:, junction]

    def draw(
        self, sections: CrossSections, junction: IntArray, low: FloatArray, high: FloatArray, value: IntArray
    ) -> BoolArray:
        """Write values into the cells without lanes from t = low to t = high, m, between cross sections, all (n,).

        Return between which of them and the next lies a cell of a gap, (n,).
        """
        found, wide = np.zeros(len(junction), bool), low < high
        pieces = np.flatnonzero((sections.road[:-1] == sections.road[1:]) & (wide[:-1] | wide[1:]))
        places, t, values = self.places(sections, junction), np.array([low, high]), value.astype(np.int32)
        draw_pieces(pieces, places[0], t, places[1], values, self.cells, found, np.empty((5, 2)))
        return found

    def draw_strips(self, sections: CrossSections, junction: IntArray) -> None:
        """Draw strips beside lanes into cells without these."""
        left, right = sections.left, sections.right
        for low, high, paved in (
            (left, left + sections.more_left, sections.paved_left),
            (right - sections.more_right, right, sections.paved_right),
        ):
            self.draw(sections, junction, low, high, np.where(paved, PAVED, STRIP))

    def beside_gaps(self, sections: CrossSections, junction: IntArray) -> IntArray:
        """Return the roads beside whose lanes there may be a gap, ascending."""
        holed = np.zeros(len(self.wide), bool)
        holed[np.searchsorted(self.start, self.gaps, side="right") - 1] = True
        near = np.flatnonzero(holed[junction])
        sections, nothing = sections.chosen(near), np.full(len(near), FREE)
        low, high = sections.right - _BESIDE, sections.left + _BESIDE
        return sorted_unique(sections.road[self.draw(sections, junction[near], low, high, nothing)])


def find_gaps(sections: CrossSections, junction: IntArray, faces: Faces) -> Grids:
    """Return the junctions' grids; `junction` is that of each cross section, 0 … J - 1, (n,).

    `faces` and strips bound gaps as lanes do, and all gaps are paved.
    """
    grids = _empty_grids(sections, junction, faces)
    place = np.floor(np.column_stack([faces.x, faces.y]) / defaults.GAP_CELL).astype(np.int64)
    column, row = (place - grids.corner[faces.junction]).T
    grids.cells[grids.start[faces.junction] + row * grids.wide[faces.junction] + column] = FACE
    low, high = sections.right - defaults.GAP_CLOSED, sections.left + defaults.GAP_CLOSED
    grids.draw(sections, junction, low, high, sections.road)
    grids.draw_strips(sections, junction)
    found = _free_runs(grids)
    size = np.bincount(found.area, found.last - found.first) * defaults.GAP_CELL**2
    # The first area of each grid is that of its corner, which is outside.
    size[found.area[np.searchsorted(found.grid, np.arange(len(grids.wide)))]] = 0.0
    some = (size >= defaults.ISLAND_LEAST_AREA) & (size <= defaults.ISLAND_LARGEST_AREA)
    holes = found.chosen(some[found.area])
    grids = replace(grids, holes=holes.chosen(np.argsort(holes.area, kind="stable")))
    gaps = found.chosen(((size >= defaults.GAP_LEAST_AREA) & (size <= defaults.GAP_LARGEST_AREA))[found.area])
    return _with_gaps(grids, gaps, np.ones(len(gaps.area), bool))


def gaps_left(grids: Grids) -> Grids:
    """Return grids with what is left of their gaps beside the strips that were drawn since."""
    value = grids.cells[grids.gaps]
    left = np.flatnonzero((value == FREE) | (value < FACE))
    cells = grids.gaps[left]
    first, last = np.diff(cells, prepend=-2) != 1, np.diff(cells, append=-2) != 1
    grid = np.searchsorted(grids.start, cells[first], side="right") - 1
    return _with_gaps(
        grids, _connected(grids, grid, cells[first], cells[last] + 1), grids.paved[grids.number[left[first]]]
    )


def _with_gaps(grids: Grids, gaps: Runs, paved: BoolArray) -> Grids:
    """Return grids with gaps that consist of runs, (n,), which are paved or not."""
    areas, begin = unique_first(gaps.area)
    count = gaps.last - gaps.first
    cells, number = runs(gaps.first, count), np.repeat(np.searchsorted(areas, gaps.area) + 1, count)
    grids.cells[cells] = FACE - number
    return replace(grids, gaps=cells, number=number, paved=np.append(False, paved[begin]))


def _free_runs(grids: Grids) -> Runs:
    """Return the runs of free cells in the rows of all grids."""
    free = grids.cells == FREE
    change = np.empty(len(free) + 1, bool)
    change[0] = change[-1] = True
    np.not_equal(free[1:], free[:-1], out=change[1:-1])
    deep = np.diff(grids.start) // grids.wide
    # The borders of grids are free: each row begins with a run.
    change[np.repeat(grids.start[:-1], deep) + ranks(deep) * np.repeat(grids.wide, deep)] = True
    border = np.flatnonzero(change)
    kept = np.flatnonzero(free[border[:-1]])
    first, last = border[kept], border[kept + 1]
    return _connected(grids, np.searchsorted(grids.start, first, side="right") - 1, first, last)


def _connected(grids: Grids, grid: IntArray, first: IntArray, last: IntArray) -> Runs:
    """Return runs with the areas that they belong to, numbered from 0 in the order of their first runs."""
    # Those of the next row that overlap with a run; none below the last row, where grids are free from side to side.
    below = np.minimum(first + grids.wide[grid], grids.start[grid + 1]), last + grids.wide[grid]
    begin = np.searchsorted(last, below[0], side="right")
    count = np.searchsorted(first, np.minimum(below[1], grids.start[grid + 1])) - begin
    return Runs(grid, first, last, connected_groups(len(first), repeated(count), runs(begin, count)))


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
    start, none = starts(wide * deep), np.zeros(0, np.int64)
    cells = np.full(int(start[-1]), FREE, np.int32)
    holes = Runs(none, none, none, none)
    return Grids(start, wide, low.T.astype(np.int64), cells, faces, holes, none, none, np.zeros(1, bool))


@record(eq=False)
class Rays(Table):
    """Rays across gaps, in the order of edges and along each of them."""

    # (n,) Index of the cross section that each begins at, and the side: left 1, right -1
    section: IntArray
    side: IntArray
    gap: IntArray  # (n,) Number of the gap
    places: FloatArray  # (n, 4) Column and row in their grids where they begin, and how much these grow with a step
    grids: IntArray  # (n, 3) What these are, as `cells` takes it
    first: IntArray  # (n,) The first step within the gap
    last: IntArray  # (n,) The first step that is too far away

    def ends(self, grids: Grids) -> tuple[IntArray, IntArray]:
        """Return the first step behind each gap, (n,), or the first one within, where it is closed.

        And what lies there: the connecting road whose lanes cover the place, or what `cells` has for others, (n,).
        """
        out, steps = np.empty((2, len(self.gap)), np.int64), np.array([self.first, self.last])
        walk_gaps(self.places.T, self.grids.T, self.gap, steps, grids.cells, out)
        return out[0], out[1]

    def close(self, end: IntArray, grids: Grids) -> None:
        """Make the cells on rays before their `end`, (n,), those of no gap."""
        close_gaps(self.places.T, self.grids.T, np.array([self.first, end]), grids.cells)


def cast_rays(grids: Grids, sections: CrossSections, junction: IntArray) -> Rays:
    """Return the rays that meet a gap next to the edge where they begin; `junction` is that of each section, (n,)."""
    every, most = np.arange(len(junction)), int(defaults.FLOOR_REACH / RAY_STEP)
    places, of = grids.places(sections, junction)
    found: list[Rays] = []
    for side in (1, -1):
        rays, meets = places.copy(), np.empty((2, len(every)), np.int64)
        rays[:2] += sections.edge(np.array(side), every) * places[2:]
        rays[2:] *= side * RAY_STEP
        gaps_beside(rays, of, _FIRST, grids.cells, meets)
        k = np.flatnonzero(meets[0])
        first, gap = meets[:, k]
        last = np.clip(room_inside(sections, side, k) / RAY_STEP, 0, most).astype(np.int64)
        found.append(Rays(k, np.full(len(k), side), gap, rays[:, k].T, of[:, k].T, first, last))
    rows = join_tables(found)
    return rows.chosen(rows.last > rows.first)


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
