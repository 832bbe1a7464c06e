"""Ways from one arm to another and back again: where they would meet, they are drawn beside one common axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    arctan2,
    chain_curves,
    chosen_curves,
    cosine,
    curve_ends,
    heading_change,
    lengths,
    repeated,
    replace_curves,
    reverse_curves,
    sine,
    smallest_radius,
    smooth_step,
    stack_plan_views,
    unique_all,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections import defaults
from osm2xodr.geometry.connections.carriageways import ROUNDED, Carriageways, along_the_way
from osm2xodr.geometry.connections.pose_to_pose import connect, curves_apart, has_kinks, legs_through
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# Curves are compared at this many places.
_PLACES: Final = 32
# The last axis that is tried runs between the middle of their way over the streets and the direct curve: as in
# `ROUNDED`. A choice.
_BETWEEN: Final = (12.0, 16.0, 0.6)
# One-way carriageways are the two halves of one arm where lanes of both end within this of each other, m, and their
# headings are opposite within 30 degrees. Choices: a median, and half a lane on either side.
_ONE_ARM: Final = 8.0
_OPPOSITE: Final = -0.866
# Less than this decides nothing, m: alike junctions shall look alike, and coordinates are rounded.
_ROUNDING: Final = 1e-3


@record(eq=False)
class _Pairs(Table):
    """Ways there and back between the same two arms, (pairs,): indices of their curves."""

    there: IntArray
    back: IntArray


def draw_side_by_side(
    plan: PlanView,
    entry: IntArray,
    exit_: IntArray,
    width: FloatArray,
    shared: BoolArray,
    streets: Carriageways | None = None,
) -> PlanView:
    """Redraw curves from arm to arm and back that come too near to each other, if that sets them apart.

    `entry` and `exit_` are the arms that the curves join (`joined_arms`), `width` is that of their lanes, m, and
    `shared` says which have a lane for both directions, all (n,); `streets` are those inside the junctions. Both
    curves of a pair are drawn beside the curve from the middle between their ends on one arm to that on the other;
    or, if that does not help, one of them is drawn beside the other; or both beside the middle of their way over the
    streets.
    """
    pairs = _pairs(entry, exit_, shared)
    axes_of: tuple[Callable[[PlanView, _Pairs], PlanView], ...] = (_middles, _ways_there, _ways_back)
    if streets is not None:
        axes_of += tuple(partial(_along_streets, streets=streets, rounding=item) for item in (ROUNDED, _BETWEEN))
    for axes in axes_of:
        pairs, apart = _too_near(plan, pairs, width, 0.0, LEAST_TURN_BACK)
        if not len(apart):
            break
        plan = _redrawn(plan, pairs, apart, axes(plan, pairs), defaults.TURNING_RADIUS_ACUTE, streets=streets)
    return plan


def joined_arms(
    plan: PlanView, junction: IntArray, entry: IntArray, exit_: IntArray, one_way: BoolArray
) -> tuple[IntArray, IntArray]:
    """Return numbers of the arms that curves lead from and to, (n,): those of road ends, of both halves of arms once.

    `one_way`, (ends,), says which road ends are those of one-way carriageways.
    """
    begin, end = (np.column_stack(poses).tolist() for poses in curve_ends(plan))
    into: dict[int, dict[int, list[float]]] = {}
    for k in np.flatnonzero(one_way[entry]).tolist():
        into.setdefault(int(junction[k]), {})[int(entry[k])] = begin[k]
    near: dict[tuple[int, int], float] = {}
    for k in np.flatnonzero(one_way[exit_]).tolist():
        x, y, hdg = end[k]
        for arm, (x0, y0, hdg0) in into.get(int(junction[k]), {}).items():
            apart = float(np.hypot(x - x0, y - y0))
            if apart < _ONE_ARM and float(cosine(np.array(hdg - hdg0))) < _OPPOSITE:
                pair = arm, int(exit_[k])
                near[pair] = min(apart, near.get(pair, np.inf))
    number = np.arange(len(one_way))
    taken: set[int] = set()
    for arm, other in sorted(near, key=lambda pair: (round(near[pair], 3), pair)):
        if not taken & {arm, other}:
            number[arm] = number[other] = min(arm, other)
            taken |= {arm, other}
    return number[entry], number[exit_]


def _too_near(
    plan: PlanView, pairs: _Pairs, width: FloatArray, least_turn: float, most_turn: float
) -> tuple[_Pairs, FloatArray]:
    """Return the pairs that come too near to each other, and how near, m, of those that turn from `least_turn` on.

    Those that turn by `most_turn`, rad, and more are left out.
    """
    turn = np.abs(heading_change(plan, pairs.there))
    pairs = pairs.chosen((turn >= least_turn) & (turn < most_turn))
    apart = _apart(plan, pairs)
    near = apart < defaults.OPPOSING_CLEARANCE * (width[pairs.there] + width[pairs.back]) / 2
    return pairs.chosen(near), apart[near]


def _redrawn(
    plan: PlanView,
    pairs: _Pairs,
    apart: FloatArray,
    axis: PlanView,
    radius: float,
    longest: float = np.inf,
    streets: Carriageways | None = None,
) -> PlanView:
    """Return the plan with those pairs drawn beside their axes that get farther apart by it than they are, m.

    `radius` is the least that curves get if they had more, `longest` what they get at most unless they were longer,
    m. With `streets`, they leave these no more than before, or than curves may.
    """
    drawn = stack_plan_views(_beside(plan, pairs.there, axis, back=False), _beside(plan, pairs.back, axis, back=True))
    both, rows = _Pairs(*np.arange(2 * len(apart)).reshape(2, -1)), np.concatenate([pairs.there, pairs.back])
    good = smallest_radius(drawn) > np.minimum(smallest_radius(plan)[rows], radius) - 1e-6
    good &= lengths(drawn) <= np.maximum(lengths(plan, rows), longest)
    good &= ~has_kinks(drawn)
    better = _apart(drawn, both) > apart + _ROUNDING
    chosen = np.tile(np.flatnonzero(better & good[both.there] & good[both.back]), (2, 1))
    chosen[1] += len(apart)
    if streets is not None:
        curve, row = chosen.ravel(), rows[chosen.ravel()]
        most = np.maximum(streets.beyond(plan, row, row), defaults.OFF_CARRIAGEWAY) + _ROUNDING
        kept = streets.beyond(drawn, curve, row, most) <= most
        chosen = chosen[:, kept.reshape(chosen.shape).all(axis=0)]
    return replace_curves(plan, rows[chosen.ravel()], drawn, chosen.ravel())


def _middles(plan: PlanView, pairs: _Pairs) -> PlanView:
    """Return the curves from the middle between both lanes on the first arms to that on the second."""
    start, end = _axis_ends(plan, pairs)
    return connect(*start, *end)


def _along_streets(
    plan: PlanView, pairs: _Pairs, streets: Carriageways, rounding: tuple[float, float, float]
) -> PlanView:
    """Return the curves that run from one middle to the other along the streets, whose corners are rounded."""
    lanes = streets.lanes
    there, back = lanes.chosen(pairs.there), lanes.chosen(pairs.back)
    # No lane of an inner street is their own.
    free = np.full(len(lanes.paths.length), np.inf)
    middle = replace(
        there,
        paths=replace(lanes.paths, inner_right=-free, inner_left=free),
        t_in=(there.t_in - back.t_out) / 2,
        t_out=(there.t_out - back.t_in) / 2,
    )
    return along_the_way(_middles(plan, pairs), middle, rounding)


def _ways_there(plan: PlanView, pairs: _Pairs) -> PlanView:
    """Return the ways there."""
    return chosen_curves(plan, pairs.there)


def _ways_back(plan: PlanView, pairs: _Pairs) -> PlanView:
    """Return the ways back, the other way round."""
    return reverse_curves(chosen_curves(plan, pairs.back), np.ones(len(pairs.back), bool))


def _pairs(entry: IntArray, exit_: IntArray, shared: BoolArray) -> _Pairs:
    """Return the ways there and back between the same two arms that have one lane each."""
    rows, many = np.flatnonzero(~shared), int(max(entry.max(initial=0), exit_.max(initial=0))) + 1
    arms, first, _, count = unique_all(entry[rows] * many + exit_[rows])
    alone, row = arms[count == 1], rows[first[count == 1]]
    one, two = alone // many, alone % many
    at = np.minimum(np.searchsorted(alone, two * many + one), len(alone) - 1)
    found = np.flatnonzero((one < two) & (alone[at] == two * many + one))
    found = found[np.argsort(row[found])]
    return _Pairs(row[found], row[at[found]])


def _apart(plan: PlanView, pairs: _Pairs) -> FloatArray:
    """Return how near the ways there come to the ways back, (pairs,), m."""
    return curves_apart(plan, pairs.there, plan, pairs.back, _PLACES)


def _axis_ends(plan: PlanView, pairs: _Pairs) -> tuple[Poses, Poses]:
    """Return the poses in the middle between the curves of each pair, on the first arm and on the second."""
    begin, end = curve_ends(plan, pairs.there)
    other_begin, other_end = curve_ends(plan, pairs.back)
    return (
        ((begin[0] + other_end[0]) / 2, (begin[1] + other_end[1]) / 2, begin[2]),
        ((end[0] + other_begin[0]) / 2, (end[1] + other_begin[1]) / 2, end[2]),
    )


def _beside(plan: PlanView, row: IntArray, axis: PlanView, *, back: bool) -> PlanView:
    """Return curves with the ends of those in the rows that run beside the axes, or beside these the other way."""
    (x0, y0, h0), (x1, y1, h1) = reversed(curve_ends(plan, row)) if back else curve_ends(plan, row)
    if back:
        h0, h1 = h0 + np.pi, h1 + np.pi
    total = lengths(axis)
    (ax, ay, _), (bx, by, _) = curve_ends(axis)
    t0 = (y0 - ay) * cosine(h0) - (x0 - ax) * sine(h0)
    t1 = (y1 - by) * cosine(h1) - (x1 - bx) * sine(h1)
    # Where one record of an axis meets the next, its curves pass, too.
    count = np.diff(axis.start) - 1
    owner = repeated(count)
    inner = np.ones(len(axis.s), bool)
    inner[axis.start[:-1]] = False
    share = axis.s[inner] / total[owner]
    t = t0[owner] + (t1 - t0)[owner] * smooth_step(share)
    slope = (t1 - t0)[owner] * 6 * share * (1 - share) / total[owner]
    hdg = axis.hdg[inner]
    middle = axis.x[inner] - t * sine(hdg), axis.y[inner] + t * cosine(hdg), hdg + arctan2(slope, 1.0)
    here, there, first = legs_through((x0, y0, h0), middle, (x1, y1, h1), count)
    pieces = connect(*here, *there)
    if back:
        pieces = reverse_curves(pieces, np.ones(len(here[0]), bool))
        order = np.concatenate([np.arange(hi - 1, lo - 1, -1) for lo, hi in pairwise(first.tolist())])
        pieces = chosen_curves(pieces, order)
    return chain_curves(pieces, first)
