"""The middle of loops at dead ends: cars go round it, and it belongs to the turning circle."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Final

import numpy as np

from osm2xodr.curves import owners, record_turns, unique_first, unique_inverse
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor.cross_sections import CrossSections
from osm2xodr.geometry.junction_floor.gaps import bend_beside
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Strips end this far before the middle of a loop, m: cross sections meet there.
_MIDDLE: Final = 0.05
# By how much strips reach beyond the middle of the arm, as a share of their width: readers draw them with chords.
_BEYOND: Final = 0.05
# Least sine of the angle between a cross section and the line that it is to reach.
_LEAST_SINE: Final = 1e-3


@record(eq=False)
class Loops:
    """Loops for cars at dead ends, of several round one middle the innermost, (n,)."""

    road: IntArray  # Index of the connecting road, ascending
    side: IntArray  # The side of its middle: left 1, right -1
    paved: BoolArray  # Whether they go round pavement

    @classmethod
    def of(cls, roads: ConnectingRoads, cars: BoolArray, unpaved: AbstractSet[int]) -> Loops:
        """Return the loops among connecting roads, of which some are for `cars`, (roads,).

        `unpaved` are the junctions whose loops go round something else than pavement.
        """
        turn = np.bincount(owners(roads.plan_view.start), record_turns(roads.plan_view), len(roads.length))
        road = _innermost(np.flatnonzero(cars & (np.abs(turn) >= LEAST_TURN_BACK)), roads)
        return cls(road, np.where(turn[road] > 0.0, 1, -1), ~np.isin(roads.junction[road], sorted(unpaved)))


def fill_loops(sections: CrossSections, loops: Loops) -> tuple[FloatArray, BoolArray]:
    """Return the widths of strips within loops, left and right (2, n), m, and which of them are paved, (2, n).

    Loops are symmetric about the middle of their arm, and strips reach up to there.
    """
    width, paved = np.zeros((2, len(sections.road))), np.zeros((2, len(sections.road)), bool)
    k = np.flatnonzero(np.isin(sections.road, loops.road))
    if not len(k):
        return width, paved
    number = np.searchsorted(loops.road, sections.road[k])
    loop = unique_inverse(number)[1]
    first, last = np.flatnonzero(np.diff(loop, prepend=-1)), np.flatnonzero(np.diff(loop, append=-1))
    mx, my = ((place[k[first]] + place[k[last]]) / 2 for place in (sections.x, sections.y))
    # Seen from the arm, which the cross sections at both ends are square to.
    ax, ay = sections.ny[k[first]], -sections.nx[k[first]]
    side = loops.side[number]
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
    paved[row, k] = loops.paved[number] & (reach > 0.0)
    return width, paved


def _innermost(rows: IntArray, roads: ConnectingRoads) -> IntArray:
    """Return those of some roads, by their rows, that are the shortest on the only arm of their junction, (n,)."""
    if not len(rows):
        return rows
    of = unique_inverse(roads.junction)[1]
    low, high = np.full(int(of.max()) + 1, np.iinfo(np.int64).max), np.full(int(of.max()) + 1, -1)
    for end in (roads.entry, roads.exit):
        np.minimum.at(low, of, end)
        np.maximum.at(high, of, end)
    back = rows[(low == high)[of[rows]]]
    order = np.lexsort((roads.length[back], roads.junction[back]))
    return np.sort(back[order][unique_first(roads.junction[back][order])[1]])
