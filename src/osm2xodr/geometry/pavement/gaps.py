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
# Cells around the lanes of a junction: outside.
_BORDER: Final = 2


@dataclass(frozen=True, slots=True, eq=False)
class Grids:
    """A grid of cells for each of J junctions, one behind the other."""

    start: IntArray  # (J + 1,) Index of each junction's first cell
    # (J,) Its west and south corner, in cells, and how many cells it has from west to east
    west: FloatArray
    south: FloatArray
    wide: IntArray
    # (cells,) The connecting road whose lanes cover each, one of them where there are several, or `FREE` or
    # `STRIP`
    road: IntArray
    # (cells,) The number of the gap that it belongs to, from 1; 0 where it is covered or outside
    gap: IntArray

    def cell(self, junction: IntArray, x: FloatArray, y: FloatArray) -> IntArray:
        """Return the cell at x, y, m, of junctions, their first one, which is outside, where a place is beyond all."""
        column = (x / defaults.GAP_CELL - self.west[junction]).astype(np.int64)
        row = (y / defaults.GAP_CELL - self.south[junction]).astype(np.int64)
        wide, first = self.wide[junction], self.start[junction]
        cell = first + row * wide + column
        within = (column >= 0) & (column < wide) & (row >= 0) & (cell < self.start[junction + 1])
        return np.where(within, cell, first)


def find_gaps(sections: CrossSections, junction: IntArray) -> Grids:
    """Return the junctions' grids; `junction` is that of each cross section, 0 … J - 1, (n,)."""
    grids = _empty_grids(sections, junction)
    _draw(grids, sections, junction)
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
    every = np.arange(len(junction))
    for side in (1, -1):
        t = sections.edge(np.array(side), every)
        for k, (v, n) in enumerate(((sections.x, sections.nx), (sections.y, sections.ny))):
            edge = (v + t * n) / defaults.GAP_CELL
            np.minimum.at(low[k], junction[first], np.minimum.reduceat(edge, first))
            np.maximum.at(high[k], junction[first], np.maximum.reduceat(edge, first))
    low = np.floor(low) - _BORDER
    wide, deep = (np.ceil(high - low) + _BORDER).astype(np.int64)
    start = starts(wide * deep)
    road = np.full(int(start[-1]), FREE, np.int32)
    return Grids(start, low[0], low[1], wide, road, np.zeros(len(road), np.int32))


def _draw(grids: Grids, sections: CrossSections, junction: IntArray) -> None:
    """Draw strips, then lanes into the grids."""
    # In cells, from the grid's corner.
    x = (sections.x / defaults.GAP_CELL - grids.west[junction]).astype(np.float32)
    y = (sections.y / defaults.GAP_CELL - grids.south[junction]).astype(np.float32)
    nx, ny = ((n / defaults.GAP_CELL).astype(np.float32) for n in (sections.nx, sections.ny))
    first, wide = grids.start[junction].astype(np.int32), grids.wide[junction].astype(np.int32)
    spread = _Spread(x, y, nx, ny, first, wide)
    strip = np.full(len(x), STRIP, np.int32)
    spread.draw(grids.road, sections.left, sections.left + sections.more_left, strip)
    spread.draw(grids.road, sections.right - sections.more_right, sections.right, strip)
    inset = defaults.GAP_INSET
    spread.draw(grids.road, sections.right + inset, sections.left - inset, sections.road.astype(np.int32))


@dataclass(frozen=True, slots=True, eq=False)
class _Spread:
    """Cross sections in cells."""

    # (n,) Where they are in their grid, and the direction of t, for one metre
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    nx: NDArray[np.float32]
    ny: NDArray[np.float32]
    # (n,) The grid's first cell and how many cells it is wide
    first: NDArray[np.int32]
    wide: NDArray[np.int32]

    def draw(self, cells: IntArray, low: FloatArray, high: FloatArray, value: NDArray[np.int32]) -> None:
        """Write values into the cells from t = low to t = high, m, all (n,); nothing where these are one."""
        count = np.ceil((high - low) / (POINTS_PER_CELL * defaults.GAP_CELL)).astype(np.int64)
        order = np.argsort(count, kind="stable")
        order = order[count[order] > 0]
        # Cross sections of equal width at once.
        for k in np.split(order, np.flatnonzero(np.diff(count[order])) + 1) if len(order) else ():
            share = np.linspace(0.0, 1.0, int(count[k[0]]) + 1, dtype=np.float32)
            begin, end = low[k, None].astype(np.float32), high[k, None].astype(np.float32)
            t = begin + (end - begin) * share
            column = (self.x[k, None] + t * self.nx[k, None]).astype(np.int32)
            row = (self.y[k, None] + t * self.ny[k, None]).astype(np.int32)
            cells[self.first[k, None] + row * self.wide[k, None] + column] = value[k, None]
