"""How densely residential streets lie around each way: the mark of a built-up area where no tag says so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray, IntArray
from osm2xodr.osmParsing.roadside.reach import sample_lines

# Streets with houses, by OSM's highway value (OSM wiki, Key:highway).
_RESIDENTIAL: Final = frozenset({"residential", "living_street"})
# Distance of the points at which it is measured, m: a quarter of a cell.
_SPACING: Final = 25.0
# Side of the cells, m; a place is judged by three by three of them, 9 ha: about a block on each side. A choice.
_CELL: Final = 100.0
_WINDOW_HA: Final = (3.0 * _CELL) ** 2 / 1e4
# Rows of cells between numbers of columns: more than any area has.
_ROW: Final = 2**31


def residential_density(points: FloatArray, counts: IntArray, ways: IntArray, highways: Sequence[str]) -> FloatArray:
    """Return the mean density of residential streets around each way (ways,), m per hectare.

    `points` (n, 2) are the nodes of all pieces of ways, piece after piece, m; `counts` (m,) the number of nodes and
    `ways` (m,) the way of each piece, `highways` the class of each way.
    """
    lines = sample_lines(points, counts, _SPACING)
    way = np.repeat(ways, counts)[lines.node]
    lived_on = np.array([highway in _RESIDENTIAL for highway in highways], np.bool_)
    column, row = np.floor(lines.points / _CELL).astype(np.int64).T
    cell = column * _ROW + row
    cells, index = np.unique(cell, return_inverse=True)
    metres = np.bincount(index, np.where(lived_on[way], lines.length, 0.0), len(cells))
    around = np.zeros(len(cells))
    for right in (-1, 0, 1):
        for up in (-1, 0, 1):
            beside = cells + right * _ROW + up
            at = np.minimum(np.searchsorted(cells, beside), len(cells) - 1)
            around += np.where(cells[at] == beside, metres[at], 0.0)
    total = np.bincount(way, lines.length * around[index], len(highways))
    length = np.bincount(way, lines.length, len(highways))
    density: FloatArray = total / np.maximum(length, 1e-9) / _WINDOW_HA
    return density
