"""Gaps in the floor of junctions: places that the lanes of connecting roads enclose and none of them covers.

Lanes are drawn into a grid of small cells, one for each junction; what is connected to its border is outside.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from osm2xodr.curves import starts
from osm2xodr.geometry.pavement import defaults
from osm2xodr.geometry.pavement.cross_sections import CrossSections
from osm2xodr.model import FloatArray, IntArray

# Distance of points within lanes and of cross sections, as a share of a cell's size: none is missed (below 1 / √2).
POINTS_PER_CELL: Final = 0.7
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
    # (cells,) The connecting road whose lanes cover each, one of them where there are several; -1 for none
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


def find_gaps(sections: CrossSections, junction: IntArray) -> tuple[Grids, FloatArray]:
    """Return the junctions' grids and the area of each gap, m² (0 for number 0, which is none).

    `junction` is that of each cross section, 0 … J - 1, (n,).
    """
    grids = _empty_grids(sections, junction)
    _draw_lanes(grids, sections, junction)
    area = [0.0]
    for k in range(len(grids.wide)):
        cells = slice(int(grids.start[k]), int(grids.start[k + 1]))
        shape = -1, int(grids.wide[k])
        label, found = ndimage.label(grids.road[cells].reshape(shape) < 0)
        if found < 2:
            continue
        # The first label is that of the corner, which is outside.
        size = np.bincount(label.ravel(), minlength=found + 1) * defaults.GAP_CELL**2
        size[:2] = 0.0
        good = np.flatnonzero((size >= defaults.GAP_LEAST_AREA) & (size <= defaults.GAP_LARGEST_AREA))
        number = np.zeros(found + 1, np.int32)
        number[good] = len(area) + np.arange(len(good))
        grids.gap[cells] = number[label].ravel()
        area += size[good].tolist()
    return grids, np.array(area)


def _empty_grids(sections: CrossSections, junction: IntArray) -> Grids:
    """Return grids around all lanes."""
    count = int(junction.max()) + 1
    low, high = np.full((2, count), np.inf), np.full((2, count), -np.inf)
    first = np.flatnonzero(np.diff(junction, prepend=-1))
    for t in (sections.left, sections.right):
        for k, (v, n) in enumerate(((sections.x, sections.nx), (sections.y, sections.ny))):
            edge = (v + t * n) / defaults.GAP_CELL
            np.minimum.at(low[k], junction[first], np.minimum.reduceat(edge, first))
            np.maximum.at(high[k], junction[first], np.maximum.reduceat(edge, first))
    low = np.floor(low) - _BORDER
    wide, deep = (np.ceil(high - low) + _BORDER).astype(np.int64)
    start = starts(wide * deep)
    road = np.full(int(start[-1]), -1, np.int32)
    return Grids(start, low[0], low[1], wide, road, np.zeros(len(road), np.int32))


def _draw_lanes(grids: Grids, sections: CrossSections, junction: IntArray) -> None:
    """Write the connecting roads into the cells that their lanes cover."""
    step = POINTS_PER_CELL * defaults.GAP_CELL
    count = np.ceil((sections.left - sections.right) / step).astype(np.int64)
    # Cross sections of equal width at once. In cells, from the grid's corner.
    x = (sections.x / defaults.GAP_CELL - grids.west[junction]).astype(np.float32)
    y = (sections.y / defaults.GAP_CELL - grids.south[junction]).astype(np.float32)
    nx, ny = ((n / defaults.GAP_CELL).astype(np.float32) for n in (sections.nx, sections.ny))
    first, wide = grids.start[junction].astype(np.int32), grids.wide[junction].astype(np.int32)
    road = sections.road.astype(np.int32)
    order = np.argsort(count, kind="stable")
    for k in np.split(order, np.flatnonzero(np.diff(count[order])) + 1):
        share = np.linspace(0.0, 1.0, int(count[k[0]]) + 1, dtype=np.float32)
        right, left = sections.right[k, None].astype(np.float32), sections.left[k, None].astype(np.float32)
        t = right + (left - right) * share
        column, row = (x[k, None] + t * nx[k, None]).astype(np.int32), (y[k, None] + t * ny[k, None]).astype(np.int32)
        grids.road[first[k, None] + row * wide[k, None] + column] = road[k, None]
