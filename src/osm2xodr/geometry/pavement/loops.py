"""The middle of loops at dead ends: cars go round it, and it belongs to the turning circle."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Final

import numpy as np

from osm2xodr.curves import owners, record_turns
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.pavement.cross_sections import CrossSections
from osm2xodr.geometry.pavement.rays import bend_beside
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Strips end this far before the middle of a loop, m: cross sections meet there.
_MIDDLE: Final = 0.05
# By how much strips reach beyond the middle of the arm, as a share of their width: readers draw them with chords.
_BEYOND: Final = 0.05
# Least sine of the angle between a cross section and the line that it is to reach.
_LEAST_SINE: Final = 1e-3


def fill_loops(
    sections: CrossSections, rows: IntArray, roads: ConnectingRoads, unpaved: AbstractSet[int]
) -> tuple[FloatArray, BoolArray]:
    """Return the widths of strips within loops, left and right (2, n), m, and which of them are paved, (2, n).

    `rows` are the roads of some whole junctions that the cross sections are of, `unpaved` the junctions whose loops
    go round something else. Loops are symmetric about the middle of their arm, and strips reach up to there. Of
    several loops round one middle the innermost has a strip.
    """
    width, paved = np.zeros((2, len(sections.road))), np.zeros((2, len(sections.road)), bool)
    turn = np.bincount(owners(roads.plan_view.start), record_turns(roads.plan_view), len(roads.length))
    loops = _innermost_loops(rows[np.abs(turn[rows]) >= LEAST_TURN_BACK], roads)
    if not len(loops):
        return width, paved
    number = np.full(len(roads.length), -1, np.int64)
    number[loops] = np.arange(len(loops))
    k = np.flatnonzero(number[sections.road] >= 0)
    loop = number[sections.road[k]]
    first, last = np.flatnonzero(np.diff(loop, prepend=-1)), np.flatnonzero(np.diff(loop, append=-1))
    mx, my = ((place[k[first]] + place[k[last]]) / 2 for place in (sections.x, sections.y))
    # Seen from the arm, which the cross sections at both ends are square to.
    ax, ay = sections.ny[k[first]], -sections.nx[k[first]]
    side = np.where(turn[loops] > 0.0, 1, -1)[loop]
    edge = sections.edge(side, k)
    ux, uy = side * sections.nx[k], side * sections.ny[k]
    x, y = sections.x[k] + edge * sections.nx[k] - mx[loop], sections.y[k] + edge * sections.ny[k] - my[loop]
    sine = ux * ay[loop] - uy * ax[loop]
    off = ax[loop] * y - ay[loop] * x
    # A cross section along that line ends before the middle of the loop alone.
    to_middle = np.where(np.abs(sine) > _LEAST_SINE, off / np.where(sine == 0.0, 1.0, sine), np.inf)
    within = np.maximum(1.0 / bend_beside(sections, side, k) - _MIDDLE - side * edge, 0.0)
    reach = np.clip((1.0 + _BEYOND) * to_middle, 0.0, within)
    row = (side < 0).astype(np.int64)
    width[row, k] = reach
    paved[row, k] = ~np.isin(roads.junction[loops], sorted(unpaved))[loop] & (reach > 0.0)
    return width, paved


def _innermost_loops(rows: IntArray, roads: ConnectingRoads) -> IntArray:
    """Return the shortest of the roads for cars that turn back on the only arm of their junction, (n,)."""
    rows = rows[roads.for_vehicles()[rows]]
    if not len(rows):
        return rows
    _, of = np.unique(roads.junction[rows], return_inverse=True)
    ends = np.stack([roads.entry[rows], roads.exit[rows]])
    low, high = np.full(int(of.max()) + 1, np.iinfo(np.int64).max), np.full(int(of.max()) + 1, -1)
    np.minimum.at(low, of, ends.min(axis=0))
    np.maximum.at(high, of, ends.max(axis=0))
    back = rows[(low == high)[of]]
    order = np.lexsort((roads.length[back], roads.junction[back]))
    return np.asarray(back[order][np.unique(roads.junction[back][order], return_index=True)[1]])
