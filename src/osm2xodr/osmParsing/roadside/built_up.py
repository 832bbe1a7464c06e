"""How densely streets lie around each way, and people cross it: marks of a built-up area where no tag says so."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import unique_inverse, unique_rows
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.osmParsing.roadside.kerbs import WayPieces
from osm2xodr.osmParsing.roadside.reach import sample_lines

# Streets with houses, by OSM's highway value (OSM wiki, Key:highway).
_RESIDENTIAL: Final = frozenset({"residential", "living_street"})
# And what makes the grid of a town with them; primary roads and faster ones have several carriageways in the country.
_STREETS: Final = _RESIDENTIAL | {"unclassified", "tertiary", "secondary"}
# Distance of the points at which it is measured, m: a quarter of a cell.
_SPACING: Final = 25.0
# Side of the cells, m; a place is judged by three by three of them, 9 ha: about a block on each side. A choice.
_CELL: Final = 100.0
_WINDOW_HA: Final = (3.0 * _CELL) ** 2 / 1e4
# Rows of cells between numbers of columns: more than any area has.
_ROW: Final = 2**31


def street_densities(points: FloatArray, counts: IntArray, ways: IntArray, highways: Sequence[str]) -> FloatArray:
    """Return the mean density of residential streets, and of all streets, around each way (2, ways), m per hectare.

    `points` (n, 2) are the nodes of all pieces of ways, piece after piece, m; `counts` (m,) the number of nodes and
    `ways` (m,) the way of each piece, `highways` the class of each way.
    """
    lines = sample_lines(points, counts, _SPACING)
    way = np.repeat(ways, counts)[lines.node]
    column, row = np.floor(lines.points / _CELL).astype(np.int64).T
    cell = column * _ROW + row
    cells, index = unique_inverse(cell)
    counted = np.array([[highway in kinds for highway in highways] for kinds in (_RESIDENTIAL, _STREETS)], np.bool_)
    metres = np.array([np.bincount(index, lines.length * some[way], len(cells)) for some in counted])
    around = np.zeros((2, len(cells)))
    for right in (-1, 0, 1):
        for up in (-1, 0, 1):
            beside = cells + right * _ROW + up
            at = np.minimum(np.searchsorted(cells, beside), len(cells) - 1)
            around += np.where(cells[at] == beside, metres[:, at], 0.0)
    total = np.array([np.bincount(way, lines.length * near[index], len(highways)) for near in around])
    length = np.bincount(way, lines.length, len(highways))
    density: FloatArray = total / np.maximum(length, 1e-9) / _WINDOW_HA
    return density


def crossing_densities(
    pieces: WayPieces, ways: int, node_ids: IntArray, tags: Mapping[int, Mapping[str, str]]
) -> FloatArray:
    """Return how many places each of so many ways has at which people cross, (ways,), per m.

    `node_ids` are those of the numbers of `pieces`; `tags` are those of nodes by id.
    """
    crossed = [
        node for node, item in tags.items() if item.get("highway") == "crossing" and item.get("crossing") != "no"
    ]
    on_way = np.isin(node_ids[pieces.node], np.array(crossed, np.int64))
    way = np.repeat(pieces.way, pieces.count)[on_way]
    # Once, where two pieces of a way share the node.
    pairs = unique_rows(np.column_stack([way, pieces.node[on_way]])).values
    density: FloatArray = np.bincount(pairs[:, 0], minlength=ways) / np.maximum(pieces.way_lengths(ways), 1e-9)
    return density
