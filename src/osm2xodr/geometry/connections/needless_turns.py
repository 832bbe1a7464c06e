"""Turns that hardly any car drives, and that nobody needs: another way leads there.

Where three junctions lie close together, a turn from one side of the small triangle between them into the next one
leads back to where a car could have gone at once. Such corners are often too sharp for cars.
"""

from __future__ import annotations

from collections import defaultdict
from heapq import heappop, heappush
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, smallest_radius, unique_rows
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import TURNING_RADIUS_ACUTE
from osm2xodr.geometry.connections.turn_backs import needs_own_tarmac
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import BoolArray

# Nobody sets out, or ends, on a road shorter than this, m, of a street of this place: two cars. A choice.
_NOBODY_STARTS: Final = 12.0
# Another way may be longer by this, m, and leads over streets shorter than this: it stays within the place. A choice.
_LONGER: Final = 30.0

_Ways = dict[int, dict[int, float]]
"""From each road end that traffic reaches, the next ones that it reaches, m from the one to the other."""


def turns_without_need(connecting: ConnectingRoads, parts: RoadParts) -> BoolArray:
    """Say which turns are too sharp, or turn back over ground of their own, and are not needed, (n,).

    They are not where all cars that come over them have another way that is hardly longer, and where their lanes are
    linked without them.
    """
    plan = connecting.plan_view
    found = (smallest_radius(plan) < TURNING_RADIUS_ACUTE * (1 - 1e-3)) | needs_own_tarmac(connecting)
    out = np.zeros(len(found), bool)
    rows = np.flatnonzero(found & connecting.for_vehicles() & (connecting.entry != connecting.exit))
    if not len(rows):
        return out
    graph = _Graph(connecting, parts)
    for row in rows[np.argsort(smallest_radius(plan)[rows], kind="stable")].tolist():
        out[row] = graph.leave_out(row)
    return out


def linked_without(connecting: ConnectingRoads, left_out: BoolArray) -> BoolArray:
    """Say of which roads for cars both lanes are linked by others than those that are left out, (n,)."""
    out = np.ones(len(connecting.length), bool)
    for end, lane in ((connecting.entry, connecting.entry_lane), (connecting.exit, connecting.exit_lane)):
        at = unique_rows(np.column_stack([end, lane])).inverse
        out &= np.bincount(at, ~left_out & connecting.for_vehicles())[at] > 0
    return out


class _Graph:
    """Where cars get from road end to road end."""

    def __init__(self, connecting: ConnectingRoads, parts: RoadParts) -> None:
        self._connecting = connecting
        self._street = lengths(parts.fitted.plan_view)[parts.street]
        far = np.arange(2 * len(parts.length)) ^ 1
        link = parts.end_link.ravel()[far]
        # By road end: the far end of the road that begins there, and of the one that touches it, and the way there, m
        self._other_end: list[int] = np.where(link >= 0, link ^ 1, far).tolist()
        beyond = np.where(link >= 0, parts.length[link // 2], 0.0)
        self._length: list[float] = (parts.length[far // 2] + beyond).tolist()
        row = np.flatnonzero(connecting.for_vehicles())
        item, length = connecting, connecting.length[row] + np.array(self._length)[connecting.exit[row]]
        columns = row, item.entry[row], item.entry_lane[row], item.exit[row], item.exit_lane[row], length
        self._rows: dict[tuple[int, int], set[int]] = defaultdict(set)
        self._at_lane: dict[tuple[int, int, bool], int] = defaultdict(int)
        self._onward: _Ways = defaultdict(dict)
        self._before: _Ways = defaultdict(dict)
        for number, entry, entry_lane, exit_, exit_lane, run in zip(*(c.tolist() for c in columns), strict=True):
            rows, reached = self._rows[entry, exit_], self._other_end[exit_]
            if not rows:
                self._onward[entry][reached] = self._before[reached][entry] = run
            rows.add(number)
            self._at_lane[entry, entry_lane, True] += 1
            self._at_lane[exit_, exit_lane, False] += 1

    def leave_out(self, row: int) -> bool:
        """Leave out a turn if nobody needs it, and say whether that is so."""
        pair = int(self._connecting.entry[row]), int(self._connecting.exit[row])
        if self._rows[pair] != {row} or any(self._at_lane[lane] < 2 for lane in self._lanes(row)):
            return False
        entry, reached = pair[0], self._other_end[pair[1]]
        there = self._onward[entry].pop(reached)
        del self._before[reached][entry]
        ways = self._ways_over(entry, reached, there)
        if not ways or not all(self._has_way(*way) for way in ways):
            self._onward[entry][reached] = self._before[reached][entry] = there
            return False
        for lane in self._lanes(row):
            self._at_lane[lane] -= 1
        return True

    def _lanes(self, row: int) -> tuple[tuple[int, int, bool], tuple[int, int, bool]]:
        item = self._connecting
        return (
            (int(item.entry[row]), int(item.entry_lane[row]), True),
            (int(item.exit[row]), int(item.exit_lane[row]), False),
        )

    def _in_place(self, end: int) -> bool:
        """Say whether a road is part of a short street."""
        return bool(self._street[end // 2] < _LONGER)

    def _ways_over(self, entry: int, reached: int, length: float) -> list[tuple[int, int, float]]:
        """Return from where to where cars drive over a way, and how far, m."""
        return [
            (origin, goal, before + length + behind)
            for origin, before in self._beyond_short_roads(entry, self._before).items()
            for goal, behind in self._beyond_short_roads(reached, self._onward).items()
            # Round a block, and back to where one has come from, nobody drives.
            if origin // 2 != goal // 2
        ]

    def _beyond_short_roads(self, begin: int, ways: _Ways) -> dict[int, float]:
        """Return where cars that pass a road end come from, or go, and how far away that is, m.

        Nobody comes from a short road, or goes there, that others lead to and go on from.
        """
        out: dict[int, float] = {}
        heap, seen = [(0.0, begin)], set()
        while heap:
            run, end = heappop(heap)
            if end in seen:
                continue
            seen.add(end)
            if not self._in_place(end) or self._length[end ^ 1] >= _NOBODY_STARTS or not ways[end]:
                out[end] = run
                continue
            for other, step in ways[end].items():
                heappush(heap, (run + step, other))
        return out

    def _has_way(self, origin: int, goal: int, length: float) -> bool:
        """Say whether another way leads from end to end that is not much longer, m."""
        heap, seen = [(0.0, origin)], set()
        while heap:
            run, end = heappop(heap)
            if end == goal and run > 0.0:
                return True
            if end in seen or (run > 0.0 and not self._in_place(end)):
                continue
            seen.add(end)
            for onward, step in self._onward[end].items():
                if run + step <= length + _LONGER:
                    heappush(heap, (run + step, onward))
        return False
