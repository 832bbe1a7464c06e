"""Curves of lines and arcs become curves of continuous curvature: lines, arcs and spirals (docs/method/plan_view.md).

The curve of lines and arcs is the observation, some decimetres off. Points along it move aside until its curvature
changes as little as that allows (`fine_points`); where it then changes evenly, one spiral is enough; spirals
through the points between them have one curvature where they meet.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    chosen_curves,
    end_curvature,
    hypot,
    lengths,
    owners,
    runs,
    sine,
    smallest_radius,
    spirals_between,
    stack_plan_views,
    starts,
    sum_before,
    wrapped,
)
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.banded import solve_banded
from osm2xodr.geometry.plan_view.fine_points import (
    GENTLE,
    FinePoints,
    even_offsets,
    room_share,
    sharpest_near,
    smoothest_offsets,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import map_parallel, record

# An intersection within a curve counts like so many other points. A choice.
_NODE: Final = 3.0
# A knot that is off the curvature between its neighbours, w apart, by k moves the curve by k w² over this: between a
# bump whose ends turn with it and one whose ends stay.
_BUMP: Final = 16.0
# A knot that is off by this share of the largest curvature of its street stays: corners keep their radius.
_RADIUS_CHANGE: Final = 0.2
# A spiral turns by no more, rad.
_MOST_TURN: Final = 1.5
# So many points before and after a corner that became too sharp without, knots may be off by this share. Choices.
_CORNER_POINTS: Final = 4
_CORNER_KNOTS: Final = 0.15
# Rounds in which the points move to where curvature is even between knots, and in which headings settle.
_EVEN_ROUNDS: Final = 2
_HEADING_ROUNDS: Final = 30
# Headings have settled where no curvature steps by more, 1/m; in a round none turns by more than this, rad.
_SETTLED: Final = 1e-9
_TURN_AT_ONCE: Final = 0.3
# A curve that steps by more than this, 1/m, or moves by more than so many times `SMOOTH_SHIFT_MOST`, or whose radius
# shrinks to less than this share, is no better: it stays lines and arcs. Numerics and choices.
_STEP_OF_CURVATURE: Final = 1e-8
_SHIFT_TOO_MUCH: Final = 1.5
_RADIUS_SHARE: Final = 0.85
# Spirals that differ from an arc, and arcs that differ from a line, by less at either end are one, rad: readers that
# take spirals for part of a standard one lose their place on long thin parts.
_SAME_HEADING: Final = 1e-6
# Curves of so much length, m, are worked on at a time: what a processor's cache holds of them. Numerics.
_BLOCK: Final = 1e5

# Places on curves: index of the curve and s, m, both (n,).
OnCurves = tuple[IntArray, FloatArray]
NOWHERE: Final[OnCurves] = (np.zeros(0, np.int64), np.zeros(0))


@record(eq=False)
class SmoothCurves:
    """What curves of lines and arcs became."""

    plan_view: PlanView  # One curve for each
    good: BoolArray  # (curves,) Whether it is smooth, near the old one and hardly sharper
    worst: FloatArray  # (curves,) Where along the old curve it is not, m
    # (curves + 1,) Index of each curve's first knot; (knots,) all of a knot: along the old and the new curve, m
    first: IntArray
    before: FloatArray
    after: FloatArray


def smooth_curves(
    plan: PlanView, held: BoolArray, nodes: OnCurves = NOWHERE, corners: OnCurves = NOWHERE, jobs: int = 1
) -> SmoothCurves:
    """Return curves of continuous curvature near others, found by so many processes.

    Ends stay where they are; those that are `held`, (curves, 2), also keep their headings. Curves pass nearer to
    `nodes`, and have more knots at `corners`.
    """

    def smooth(ends: tuple[int, int]) -> SmoothCurves:
        block = chosen_curves(plan, np.arange(*ends))
        return _smooth(block, held[slice(*ends)], _between(nodes, *ends), _between(corners, *ends))

    found = list(map_parallel(smooth, _blocks(lengths(plan)), jobs))
    good, worst, before, after, knots = (
        np.concatenate(items)
        for items in zip(*((k.good, k.worst, k.before, k.after, np.diff(k.first)) for k in found), strict=True)
    )
    plan_view = stack_plan_views(*(item.plan_view for item in found))
    return SmoothCurves(plan_view, good, worst, starts(knots), before, after)


def _blocks(length: FloatArray) -> list[tuple[int, int]]:
    """Return first and last curve + 1 of blocks of curves, by their lengths, (curves,), m."""
    block = (np.cumsum(length) / _BLOCK).astype(np.int64)
    border = [0, *(np.flatnonzero(np.diff(block)) + 1).tolist(), len(length)]
    return list(pairwise(border))


def _between(places: OnCurves, first: int, end: int) -> OnCurves:
    """Return the places on some of the curves."""
    row = (places[0] >= first) & (places[0] < end)
    return places[0][row] - first, places[1][row]


def _smooth(plan: PlanView, held: BoolArray, nodes: OnCurves, corners: OnCurves) -> SmoothCurves:
    """Return smooth curves as `smooth_curves` does, all at once."""
    points = before = FinePoints.along(plan, np.arange(len(held)))
    weight = np.zeros(len(points.s))
    weight[points.nearest(*nodes)] = _NODE
    room = defaults.SMOOTH_KNOT * room_share(points)
    at, owner = points.nearest(*corners), owners(points.start)
    for further in range(-_CORNER_POINTS, _CORNER_POINTS + 1):
        row = np.clip(at + further, 0, len(room) - 1)
        room[row[owner[row] == owner[at]]] *= _CORNER_KNOTS
    aside = smoothest_offsets(points, held, weight)
    knot = _knots(points, points.bent(aside), room)
    for _ in range(_EVEN_ROUNDS):
        points = points.moved(aside)
        aside = even_offsets(points, knot, held)
    points = points.moved(aside)
    ends = np.column_stack([before.start[:-1], before.start[1:] - 1])[held]
    # Both may count full circles differently.
    points.hdg[ends] += wrapped(before.hdg[ends] - points.hdg[ends])
    first = np.searchsorted(knot, points.start)
    curves, step = spirals_through(points.x[knot], points.y[knot], points.hdg[knot], first)
    good, worst = _faults(before, points, knot, first, curves, step, 1.0 / smallest_radius(plan))
    whole = lengths(curves)
    after = np.empty(len(knot))
    after[np.delete(np.arange(len(knot)), first[1:] - 1)] = curves.s
    after[first[1:] - 1] = whole
    return SmoothCurves(curves, good, worst, first, before.s[knot], after)


def _faults(
    before: FinePoints,
    points: FinePoints,
    knot: IntArray,
    first: IntArray,
    curves: PlanView,
    step: FloatArray,
    sharpest: FloatArray,
) -> tuple[BoolArray, FloatArray]:
    """Return which curves are good, (curves,), and where they are at their worst, m.

    `step` is that of curvature at knots, and `sharpest` the largest curvature of each curve so far, 1/m.
    """
    fault = hypot(points.x - before.x, points.y - before.y) / (_SHIFT_TOO_MUCH * defaults.SMOOTH_SHIFT_MOST)
    sharp = np.zeros(len(knot))
    begin = np.delete(np.arange(len(knot)), first[1:] - 1)
    np.maximum.at(sharp, begin, np.abs(curves.curvature))
    np.maximum.at(sharp, begin + 1, np.abs(end_curvature(curves)))
    sharpest = np.maximum(sharpest, np.maximum.reduceat(np.abs(before.curvature), before.start[:-1]))
    sharp *= _RADIUS_SHARE / np.maximum(sharpest, 1.0 / GENTLE)[owners(first)]
    fault[knot] = np.maximum(fault[knot], np.maximum(sharp, np.abs(step) / _STEP_OF_CURVATURE))
    most = np.maximum.reduceat(fault, before.start[:-1])
    owner = owners(before.start)
    rows = np.flatnonzero(fault == most[owner])
    at = rows[np.searchsorted(owner[rows], np.arange(len(most)))]
    return most < 1.0, before.s[at]


def _knots(points: FinePoints, curvature: FloatArray, room: FloatArray) -> IntArray:
    """Return the points between which curvature changes evenly, within `room`, (points,), m, ends included; (knots,).

    Where curves are sharp they also stay so. Passes over all curves leave out the least important point of every
    neighbourhood, as for polylines.
    """
    end = np.zeros(len(curvature), bool)
    end[points.start[:-1]] = end[points.start[1:] - 1] = True
    sharp = defaults.SMOOTH_KNOT / _RADIUS_CHANGE / sharpest_near(points)
    knot, so_far = np.arange(len(end)), np.zeros(len(end))
    s, bend, hdg = points.s, curvature, points.hdg
    while True:
        step = np.diff(s)
        before, after = step[:-1], step[1:]
        whole = np.where(end[1:-1], 1.0, before + after)
        off = np.abs(bend[1:-1] - (bend[:-2] * after + bend[2:] * before) / whole)
        off *= np.maximum(whole**2 / _BUMP, sharp[1:-1])
        error = off + np.maximum(so_far[:-2], so_far[1:-1])
        free = (error < room[1:-1]) & ~end[1:-1] & (np.abs(hdg[2:] - hdg[:-2]) <= _MOST_TURN)
        cost = np.full(len(knot), np.inf)
        cost[1:-1][free] = error[free]
        drop = free & (cost[1:-1] < cost[:-2]) & (cost[1:-1] <= cost[2:])
        row = np.flatnonzero(drop) + 1
        if not len(row):
            return knot
        so_far[row - 1] = np.maximum(so_far[row - 1], cost[row])
        kept = np.ones(len(knot), bool)
        kept[row] = False
        knot, so_far, end, sharp, room = knot[kept], so_far[kept], end[kept], sharp[kept], room[kept]
        s, bend, hdg = s[kept], bend[kept], hdg[kept]


def spirals_through(x: FloatArray, y: FloatArray, hdg: FloatArray, first: IntArray) -> tuple[PlanView, FloatArray]:
    """Return spirals through knots, all (knots,), m and rad, and the step of curvature at each knot, (knots,), 1/m.

    Headings, continuous along each curve, hold at its ends and are first guesses at inner knots. Found there by
    Newton's method with the matrix of a cubic spline, which is that of spirals that turn little. `first` holds each
    curve's first knot, (curves + 1,).
    """
    every = _Knots.of(x, y, hdg, first)
    part, row = every, np.arange(len(x))
    for _ in range(_HEADING_ROUNDS):
        spirals = part.spirals()
        change = part.change(spirals)
        # Most curves settle in a few rounds.
        moving = np.maximum.reduceat(np.abs(spirals.step), part.first[:-1]) >= _SETTLED
        if not moving.any():
            break
        every.hdg[row] += np.clip(change, -_TURN_AT_ONCE, _TURN_AT_ONCE)
        count = np.diff(part.first)[moving]
        row = row[runs(part.first[:-1][moving], count)]
        part = _Knots.of(every.x[row], every.y[row], every.hdg[row], starts(count))
    spirals = every.spirals()
    own = first - np.arange(len(first))
    piece = every.piece
    rate = 2.0 * spirals.shape / spirals.length**2
    start = (spirals.turn - spirals.shape) / spirals.length
    s = sum_before(spirals.length, own)
    plan = PlanView(own, s, every.x[piece], every.y[piece], every.hdg[piece], spirals.length, start, rate)
    return _plain(plan, every.chord, every.towards, spirals.turn), spirals.step


@record(eq=False)
class _Spirals:
    """Spirals between knots."""

    # (spirals,) Turn, and difference of curvature over the length, rad; length, m
    turn: FloatArray
    shape: FloatArray
    length: FloatArray
    step: FloatArray  # (knots,) Of curvature, 0 at ends of curves, 1/m


@record(eq=False)
class _Knots:
    """Places that spirals lead through, and their headings."""

    # (knots,) m and rad
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    first: IntArray  # (curves + 1,) Index of each curve's first knot
    inner: BoolArray  # (knots,) Whether a spiral ends and another begins there
    # (spirals,) Knot that a spiral begins at, and length and heading of its chord, m and rad
    piece: IntArray
    chord: FloatArray
    towards: FloatArray

    @classmethod
    def of(cls, x: FloatArray, y: FloatArray, hdg: FloatArray, first: IntArray) -> _Knots:
        """Return the knots of some curves."""
        inner = np.ones(len(x), bool)
        inner[first[:-1]] = inner[first[1:] - 1] = False
        begin = np.ones(len(x), bool)
        begin[first[1:] - 1] = False
        piece = np.flatnonzero(begin)
        dx, dy = x[piece + 1] - x[piece], y[piece + 1] - y[piece]
        return cls(x, y, hdg, first, inner, piece, hypot(dx, dy), arctan2(dy, dx))

    def spirals(self) -> _Spirals:
        """Return the spirals between the headings that knots have."""
        before = wrapped(self.hdg[self.piece] - self.towards)
        turn = self.hdg[self.piece + 1] - self.hdg[self.piece]
        shape, longer = spirals_between(before, before + turn)
        length = self.chord * longer
        step = np.zeros(len(self.x))
        step[self.piece + 1] = (turn + shape) / length
        step[self.piece] -= (turn - shape) / length
        step[~self.inner] = 0.0
        return _Spirals(turn, shape, length, step)

    def change(self, spirals: _Spirals) -> FloatArray:
        """Return by how much headings change for curvature not to step, (knots,), rad."""
        stiff = np.zeros(len(self.x))
        stiff[self.piece] = 1.0 / spirals.length
        matrix = np.ones((2, len(self.x)))
        matrix[0, self.inner] = 4.0 * (stiff + np.roll(stiff, 1))[self.inner]
        matrix[1] = np.where(self.inner & np.append(self.inner[1:], False), 2.0 * stiff, 0.0)
        return solve_banded(matrix, -spirals.step)


def _plain(plan: PlanView, chord: FloatArray, towards: FloatArray, turn: FloatArray) -> PlanView:
    """Return the curves with arcs and lines for the spirals that are no different from these."""
    arc = np.abs(plan.rate) * plan.length**2 / 12.0 < _SAME_HEADING
    line = arc & (np.abs(turn) / 2.0 < _SAME_HEADING)
    half = np.where(line, 0.0, turn / 2.0)
    sinc = np.where(half == 0.0, 1.0, sine(half) / np.where(half == 0.0, 1.0, half))
    length = np.where(arc, chord / sinc, plan.length)
    hdg = np.where(arc, towards - half, plan.hdg)
    curvature = np.where(arc, 2.0 * half / length, plan.curvature)
    rate = np.where(arc, 0.0, plan.rate)
    return PlanView(plan.start, sum_before(length, plan.start), plan.x, plan.y, hdg, length, curvature, rate)
