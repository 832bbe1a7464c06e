"""Turns that are sharper than a car drives swing out where there is room, or are left out where nobody needs them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from heapq import heappop, heappush
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    curve_ends,
    dubins_without_slivers,
    heading_at,
    lengths,
    replace_curves,
    smallest_radius,
)
from osm2xodr.defaults import CONNECTING_RADIUS, MOST_SWING, MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import LONGEST_REDRAWN, OFF_CARRIAGEWAY, TURNING_RADIUS_ACUTE
from osm2xodr.geometry.connections.pose_to_pose import curves_apart
from osm2xodr.geometry.connections.turn_backs import balloons, needs_own_tarmac, turn_back_rows
from osm2xodr.geometry.defaults import CAR_WIDTH, INNER_EDGE_RADIUS
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts, end_poses
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Ways there and back are compared at this many places each.
_PLACES: Final = 32
# They may be longer than the sharp turn by this factor; by `LONGEST_REDRAWN`, unless they turn back, if no car turns
# more sharply.
_LONGEST_SWING: Final = 1.3
# The first of these radii, m, that leaves room is taken: most cars drive the first, some the second, and small ones,
# with care, the others. Choices.
_RADII: Final = (TURNING_RADIUS_ACUTE, 3.95, 3.6, 3.3, CONNECTING_RADIUS)
# Where the inner edge of a lane has no room for its full radius, one of these shares of it does.
_INNER_EDGE_SHARES: Final = (1.0, 0.5, 0.1)

# Nobody sets out, or ends, on a road shorter than this, m, of a street of this place: two cars. A choice.
_NOBODY_STARTS: Final = 12.0
# Another way may be longer by this, m, and leads over streets shorter than this: it stays within the place. A choice.
_LONGER: Final = 30.0

_Ways = dict[int, dict[int, float]]


def swing_out(connecting: ConnectingRoads, beyond: Callable[[ConnectingRoads], FloatArray]) -> ConnectingRoads:
    """Replace turns that are too sharp by the shortest curves that are not.

    `beyond` returns how far roads leave the carriageways, (n,), m: they do so no more than before, or than they may,
    unless no car drives the sharper turn.

    Those that would swing far for the radius that most cars need get the largest one with which they do not.
    """
    plan, pairs, back = connecting.plan_view, connecting.there_and_back(), turn_back_rows(connecting)
    for radius in _RADII:
        # Ways back have their own room; bicycles need less than cars.
        sharp = (smallest_radius(plan) < radius * (1 - 1e-9)) & connecting.for_vehicles()
        row = np.setdiff1d(np.flatnonzero(sharp & (connecting.entry != connecting.exit)), back)
        if not len(row):
            break
        wide, found = _wide_curves(plan, row, np.full(len(row), radius))
        longest = LONGEST_REDRAWN if radius <= CONNECTING_RADIUS else _LONGEST_SWING
        # A turn that a car just misses is better than a balloon.
        found = found[(lengths(wide) < longest * lengths(plan, row))[found]]
        if radius > CONNECTING_RADIUS:
            found = found[~_meet(wide, found, plan, row[found], pairs)]
            found = found[_keeps_to_streets(wide, found, plan, row[found], connecting, beyond)]
        plan = replace_curves(plan, row[found], wide, found)
    plan = _without_folds(plan, connecting)
    return replace(connecting, plan_view=plan, length=lengths(plan))


def runs_backwards(connecting: ConnectingRoads, parts: RoadParts) -> BoolArray:
    """Say which connecting roads set out against the lane that they come from or arrive against the next one, (n,).

    The exit lies straight behind the entry, or in the same place: the arms that they join lie on each other.
    """
    plan = connecting.plan_view
    out = np.zeros(len(connecting.entry), bool)
    row = np.flatnonzero(np.diff(plan.start) > 0)
    for end, inwards, s in (
        (connecting.entry[row], 1, np.zeros(len(row))),
        (connecting.exit[row], 0, lengths(plan, row)),
    ):
        hdg = end_poses(parts, end)[2] + np.where(end % 2 == inwards, 0.0, np.pi)
        out[row] |= cosine(heading_at(plan, row, s) - hdg) < 0.0
    return out


def _wide_curves(
    plan: PlanView, row: IntArray, radius: FloatArray, most_swing: float = MOST_SWING
) -> tuple[PlanView, IntArray]:
    """Return the shortest curves of a radius between the ends of some curves, (rows,), and which of them exist."""
    start, end = curve_ends(plan, row)
    wide = dubins_without_slivers(*start, *end, radius=radius, most_swing=most_swing)
    return wide, np.flatnonzero(lengths(wide) > 0)


def _meet(
    wide: PlanView, curve: IntArray, plan: PlanView, row: IntArray, pairs: tuple[IntArray, IntArray]
) -> BoolArray:
    """Say which curves, drawn for some rows of a plan, come nearer to a way back than the way before, and meet it."""
    place = np.full(len(plan.start) - 1, -1)
    place[row] = np.arange(len(row))
    way, other = np.concatenate(pairs), np.concatenate(pairs[::-1])
    drawn = place[way] >= 0
    way, other = way[drawn], other[drawn]
    before = curves_apart(plan, way, plan, other, _PLACES)
    out = np.zeros(len(row), bool)
    meets = curves_apart(wide, curve[place[way]], plan, other, _PLACES) < np.minimum(before, CAR_WIDTH)
    out[place[way[meets]]] = True
    return out


def _keeps_to_streets(
    drawn: PlanView,
    curve: IntArray,
    plan: PlanView,
    row: IntArray,
    connecting: ConnectingRoads,
    beyond: Callable[[ConnectingRoads], FloatArray],
) -> BoolArray:
    """Say which curves, drawn for rows of a plan, leave the carriageways no more than before, or than they may."""
    off = []
    for tried in (plan, replace_curves(plan, row, drawn, curve)):
        off.append(beyond(replace(connecting, plan_view=tried, length=lengths(tried)).chosen(row)))
    return np.asarray(off[1] <= np.maximum(off[0], OFF_CARRIAGEWAY))


def _without_folds(plan: PlanView, connecting: ConnectingRoads) -> PlanView:
    """Replace turns so sharp that their one lane folds over itself, even where the way out lies on another road."""
    half = np.maximum(connecting.entry_width, connecting.exit_width) / 2
    for share in _INNER_EDGE_SHARES:
        row = np.flatnonzero((smallest_radius(plan) < half) & (connecting.entry != connecting.exit))
        if not len(row):
            break
        # Any way round is better than a fold.
        wide, found = _wide_curves(plan, row, half[row] + share * INNER_EDGE_RADIUS, MOST_SWING_BACK)
        plan = replace_curves(plan, row[found], wide, found)
    return plan


"""From each road end that traffic reaches, the next ones that it reaches, m from the one to the other."""


def turns_without_need(
    connecting: ConnectingRoads, parts: RoadParts, ends: StreetEnds, layout: JunctionLayout
) -> BoolArray:
    """Say which turns are too sharp, or turn back over ground of their own or far around, and are not needed, (n,).

    They are not where all cars that come over them have another way that is hardly longer, and where their lanes are
    linked without them; that is enough for those that swing far out.
    """
    plan = connecting.plan_view
    found = (smallest_radius(plan) < TURNING_RADIUS_ACUTE * (1 - 1e-3)) | needs_own_tarmac(connecting, ends, layout)
    swings_far = balloons(connecting)
    found |= swings_far
    out = np.zeros(len(found), bool)
    rows = np.flatnonzero(found & connecting.for_vehicles() & (connecting.entry != connecting.exit))
    if not len(rows):
        return out
    graph = _Graph(connecting, parts)
    for row in rows[np.argsort(smallest_radius(plan)[rows], kind="stable")].tolist():
        out[row] = graph.leave_out(row, anyway=bool(swings_far[row]))
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

    def leave_out(self, row: int, *, anyway: bool) -> bool:
        """Leave out a turn if its lanes are linked without it and nobody needs it, or `anyway`; say whether so."""
        pair = int(self._connecting.entry[row]), int(self._connecting.exit[row])
        if self._rows[pair] != {row} or any(self._at_lane[lane] < 2 for lane in self._lanes(row)):
            return False
        entry, reached = pair[0], self._other_end[pair[1]]
        there = self._onward[entry].pop(reached)
        del self._before[reached][entry]
        ways = self._ways_over(entry, reached, there)
        if not anyway and (not ways or not all(self._has_way(*way) for way in ways)):
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
