"""Gaps in the floor of junctions: places that the lanes of connecting roads enclose and none of them covers.

Lanes are drawn into a grid of small cells, one for each junction; what is connected to its border is outside.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from osm2xodr.curves import starts
from osm2xodr.geometry.pavement import defaults
from osm2xodr.geometry.pavement.cross_sections import CrossSections
from osm2xodr.model import FloatArray, IntArray

# Distance of points within lanes and of cross sections, as a share of a cell's size: none is missed (below 1 / √2).
POINTS_PER_CELL: Final = 0.7
# What cells hold that no lane covers: nothing, or a strip of pavement.
FREE: Final = -1
STRIP: Final = -2
# Points are drawn so many at a time: few enough for a processor's cache.
_AT_ONCE: Final = 16384
# Cells around the lanes of a junction: outside.
_BORDER: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class Grids:
    """A grid of cells for each of J junctions, one behind the other, and cross sections in them."""

    start: IntArray  # (J + 1,) Index of each junction's first cell
    wide: IntArray  # (J,) How many cells it has from west to east
    # (cells,) The connecting road whose lanes cover each, one of them where there are several, or `FREE` or `STRIP`
    road: NDArray[np.int32]
    # (cells,) The number of the gap that it belongs to, from 1; 0 where it is covered or outside
    gap: NDArray[np.int32]
    # (n,) Cross sections in cells from the corner of their grid: where they are, and the direction of t for one metre
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    nx: NDArray[np.float32]
    ny: NDArray[np.float32]
    # (n,) Their grid: its first cell, that behind its last, and how many cells it is wide
    first: NDArray[np.int32]
    end: NDArray[np.int32]
    across: NDArray[np.int32]

    def cells(self, k: IntArray, t: FloatArray) -> NDArray[np.int32]:
        """Return the cells at t, m, (n, steps), of the k-th cross sections, (n,); t is at most a cell off lanes."""
        near = t.astype(np.float32)
        column = (self.x[k, None] + near * self.nx[k, None]).astype(np.int32)
        row = (self.y[k, None] + near * self.ny[k, None]).astype(np.int32)
        return np.asarray(self.first[k, None] + row * self.across[k, None] + column, np.int32)

    def cells_far(self, k: IntArray, t: FloatArray) -> NDArray[np.int32]:
        """Return the cells at any t; where that is beyond the grid, its first cell, which is outside of all lanes."""
        far = t.astype(np.float32)
        column = (self.x[k, None] + far * self.nx[k, None]).astype(np.int32)
        row = (self.y[k, None] + far * self.ny[k, None]).astype(np.int32)
        first, across = self.first[k, None], self.across[k, None]
        cell = first + row * across + column
        within = (column >= 0) & (column < across) & (row >= 0) & (cell < self.end[k, None])
        return np.where(within, cell, first)

    def draw(self, low: FloatArray, high: FloatArray, value: NDArray[np.int32]) -> None:
        """Write values into the cells of cross sections from t = low to t = high, m, all (n,)."""
        count = np.ceil((high - low) / (POINTS_PER_CELL * defaults.GAP_CELL)).astype(np.int64)
        order = np.argsort(count, kind="stable")
        order = order[count[order] > 0]
        # Cross sections of equal width at once.
        for equal in np.split(order, np.flatnonzero(np.diff(count[order])) + 1) if len(order) else ():
            share = np.linspace(0.0, 1.0, int(count[equal[0]]) + 1, dtype=np.float32)
            some = max(_AT_ONCE // len(share), 1)
            for k in (equal[at : at + some] for at in range(0, len(equal), some)):
                begin, end = low[k, None].astype(np.float32), high[k, None].astype(np.float32)
                self.road[self.cells(k, begin + (end - begin) * share)] = value[k, None]


def find_gaps(sections: CrossSections, junction: IntArray) -> Grids:
    """Return the junctions' grids; `junction` is that of each cross section, 0 … J - 1, (n,)."""
    grids = _empty_grids(sections, junction)
    _draw(grids, sections)
    last = 0
    least = defaults.GAP_LEAST_AREA / defaults.GAP_CELL**2
    most = defaults.GAP_LARGEST_AREA / defaults.GAP_CELL**2
    for k in range(len(grids.wide)):
        cells = slice(int(grids.start[k]), int(grids.start[k + 1]))
        label, found = ndimage.label(grids.road[cells].reshape(-1, int(grids.wide[k])) == FREE)
        if found < 2:
            continue
        # The first label is that of the corner, which is outside.
        size = np.bincount(label.ravel(), minlength=found + 1)
        good = np.flatnonzero((size >= least) & (size <= most))
        good = good[good > 1]
        number = np.zeros(found + 1, np.int32)
        number[good] = last + 1 + np.arange(len(good))
        grids.gap[cells] = number[label].ravel()
        last += len(good)
    return grids


def _empty_grids(sections: CrossSections, junction: IntArray) -> Grids:
    """Return grids around all lanes."""
    count = int(junction.max()) + 1
    low, high = np.full((2, count), np.inf), np.full((2, count), -np.inf)
    first = np.flatnonzero(np.diff(junction, prepend=-1))
    for t in (sections.left + sections.more_left, sections.right - sections.more_right):
        for k, (v, n) in enumerate(((sections.x, sections.nx), (sections.y, sections.ny))):
            edge = (v + t * n) / defaults.GAP_CELL
            np.minimum.at(low[k], junction[first], np.minimum.reduceat(edge, first))
            np.maximum.at(high[k], junction[first], np.maximum.reduceat(edge, first))
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
    return Grids(start, wide, road, np.zeros(len(road), np.int32), *places)


def _draw(grids: Grids, sections: CrossSections) -> None:
    """Draw strips, then lanes into the grids."""
    strip = np.full(len(sections.s), STRIP, np.int32)
    grids.draw(sections.left, sections.left + sections.more_left, strip)
    grids.draw(sections.right - sections.more_right, sections.right, strip)
    inset = defaults.GAP_INSET
    grids.draw(sections.right + inset, sections.left - inset, sections.road.astype(np.int32))
