"""Curves of lines and arcs, and piecewise cubics, evaluated over whole networks at once."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from osm2xodr.curves.ragged import ranks, runs
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView


def wrapped(angle: FloatArray) -> FloatArray:
    """Return angles as turns: from -pi up to pi, rad."""
    out: FloatArray = (angle + np.pi) % (2 * np.pi) - np.pi
    return out


def arc_step(curvature: FloatArray, ds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return u, v and the turn of a curve of constant curvature after ds, in the frame of its start tangent.

    The chord is written with sinc, so that lines need no case of their own:
    u + iv = ds · sinc(k·ds/2) · exp(i·k·ds/2).
    """
    turn = curvature * ds
    half = 0.5 * turn
    chord = ds * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half), turn


def lengths(plan: PlanView) -> FloatArray:
    """Return the length of each curve, (curves,), m."""
    last = np.maximum(plan.start[1:] - 1, 0)
    has = plan.start[1:] > plan.start[:-1]
    out: FloatArray = np.where(has, plan.s[last] + plan.length[last], 0.0) if len(plan.s) else np.zeros(len(has))
    return out


def smallest_radius(plan: PlanView) -> FloatArray:
    """Return the smallest radius of each curve, (curves,), m; infinity for lines."""
    out = np.full(len(plan.start) - 1, np.inf)
    owner = np.repeat(np.arange(len(out)), np.diff(plan.start))
    bent = plan.curvature != 0
    np.minimum.at(out, owner[bent], 1 / np.abs(plan.curvature[bent]))
    return out


# Lines whose headings differ by less are one, rad.
_SAME_HEADING = 1e-8
# Shorter pieces of curves are none, m.
SHORTEST_PIECE = 1e-7
# So few queries are sooner answered one by one.
_FEW = 16


def find_record(start: IntArray, record_s: FloatArray, curve: IntArray, s: FloatArray) -> IntArray:
    """Return the index of the record that holds at s of a curve, both (n,).

    Positions before a curve's first record belong to the first, those beyond its end to the last.
    """
    if len(curve) <= _FEW:
        pairs = zip(start[curve].tolist(), start[curve + 1].tolist(), s.tolist(), strict=True)
        return np.array([max(bisect_right(record_s, at, lo, hi) - 1, lo) for lo, hi, at in pairs], np.int64)
    out = start[curve].astype(np.int64)
    hi = start[curve + 1].astype(np.int64) - 1
    # A bisection over all queries at once, each for as long as more than one record is left of its curve.
    todo = np.flatnonzero(out < hi)
    lo, hi, at = out[todo], hi[todo], s[todo]
    while len(todo):
        mid = (lo + hi + 1) >> 1
        right = record_s[mid] <= at
        lo = np.where(right, mid, lo)
        hi = np.where(right, hi, mid - 1)
        out[todo] = lo
        more = np.flatnonzero(lo < hi)
        todo, lo, hi, at = todo[more], lo[more], hi[more], at[more]
    return out


def pose(plan: PlanView, curve: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and heading at s of curves, all (n,), m and rad. The heading is not wrapped."""
    k = find_record(plan.start, plan.s, curve, s)
    u, v, turn = arc_step(plan.curvature[k], s - plan.s[k])
    cos, sin = np.cos(plan.hdg[k]), np.sin(plan.hdg[k])
    return plan.x[k] + cos * u - sin * v, plan.y[k] + sin * u + cos * v, plan.hdg[k] + turn


def places_along(plan: PlanView, spacing: float, curves: IntArray | None = None) -> tuple[IntArray, FloatArray]:
    """Return evenly spread places along curves, from end to end: index of the curve and s, both (n,).

    Parameters
    ----------
    plan
        The curves.
    spacing
        How far apart the places on a curve may be, m; each curve has two at least.
    curves
        Indices of those that count; all if not given.
    """
    chosen = np.arange(len(plan.start) - 1) if curves is None else curves
    length = lengths(plan)[chosen]
    count = np.maximum(np.ceil(length / spacing).astype(np.int64), 1) + 1
    s = np.multiply(np.repeat(length / (count - 1), count), ranks(count), dtype=np.float64)
    return np.repeat(chosen, count), s


def joined_plan_views(first: PlanView, second: PlanView) -> PlanView:
    """Return the curves of both tables in one, the second's after the first's."""
    return PlanView(
        np.concatenate([first.start, second.start[1:] + first.start[-1]]),
        *(
            np.concatenate([getattr(first, name), getattr(second, name)])
            for name in ("s", "x", "y", "hdg", "length", "curvature")
        ),
    )


def curves_of(x: FloatArray, y: FloatArray, hdg: FloatArray, length: FloatArray, curvature: FloatArray) -> PlanView:
    """Return curves of several lines and arcs each, (n, pieces), that start in poses (n,); no piece of length 0."""
    places = []
    for k in range(length.shape[1]):
        places.append((x, y, hdg))
        u, v, turn = arc_step(curvature[:, k], length[:, k])
        x, y = x + np.cos(hdg) * u - np.sin(hdg) * v, y + np.sin(hdg) * u + np.cos(hdg) * v
        hdg = hdg + turn
    used = length > SHORTEST_PIECE
    start = np.concatenate([[0], np.cumsum(used.sum(1))]).astype(np.int64)
    xs, ys, hdgs = (np.column_stack([place[k] for place in places])[used] for k in range(3))
    s = (np.cumsum(length * used, axis=1) - length * used)[used]
    return PlanView(start, s, xs, ys, hdgs, length[used], curvature[used])


def joined_curves(plan: PlanView, first: IntArray) -> PlanView:
    """Return the curves of a table joined to longer ones.

    Parameters
    ----------
    plan
        Curves each of which goes on where the one before it in its group ends.
    first : (groups + 1,)
        Index of each group's first curve.
    """
    length = lengths(plan)
    end = np.cumsum(length)
    begin = end - length
    group = np.repeat(np.arange(len(first) - 1), np.diff(first))
    before = begin - begin[np.minimum(first[:-1], max(len(begin) - 1, 0))][group]
    curve = np.repeat(np.arange(len(length)), np.diff(plan.start))
    owner = group[curve]
    # A line that goes on as a line is one.
    turn = np.abs(wrapped(np.diff(plan.hdg)))
    lines = (plan.curvature[1:] == 0) & (plan.curvature[:-1] == 0)
    goes_on = (owner[1:] == owner[:-1]) & lines & (turn < _SAME_HEADING)
    kept = np.flatnonzero(np.concatenate([[True], ~goes_on])[: len(owner)])
    return PlanView(
        np.searchsorted(owner[kept], np.arange(len(first))).astype(np.int64),
        (plan.s + before[curve])[kept],
        plan.x[kept],
        plan.y[kept],
        plan.hdg[kept],
        np.add.reduceat(plan.length, kept) if len(kept) else plan.length,
        plan.curvature[kept],
    )


def turned_round(plan: PlanView, turned: BoolArray) -> PlanView:
    """Return the curves of a table, some of them, (curves,), from their end to their start."""
    owner = np.repeat(np.arange(len(turned)), np.diff(plan.start))
    back = turned[owner]
    every = np.arange(len(owner))
    source = np.where(back, (plan.start[:-1] + plan.start[1:] - 1)[owner] - every, every)
    u, v, turn = arc_step(plan.curvature, plan.length)
    cos, sin = np.cos(plan.hdg), np.sin(plan.hdg)
    end = (
        lengths(plan)[owner] - (plan.s + plan.length),
        plan.x + cos * u - sin * v,
        plan.y + sin * u + cos * v,
        wrapped(plan.hdg + turn + np.pi),
        plan.length,
        -plan.curvature,
    )
    start = plan.s, plan.x, plan.y, plan.hdg, plan.length, plan.curvature
    return PlanView(
        plan.start, *(np.where(back, after[source], before) for before, after in zip(start, end, strict=True))
    )


def cut_curves(plan: PlanView, lo: FloatArray, hi: FloatArray, curve: Sequence[int] | IntArray) -> PlanView:
    """Return the part from s = lo to s = hi of curves; all (parts,). The same curve may be cut several times.

    The parts' s starts at 0. A cut closer than 1 cm to the border of two records is moved there by `snap_cuts`
    beforehand if slivers are to be avoided.
    """
    which = np.asarray(curve, np.int64)
    count = plan.start[which + 1] - plan.start[which]
    part = np.repeat(np.arange(len(which)), count)
    k = runs(plan.start[which], count)
    begin = np.maximum(plan.s[k], lo[part])
    end = np.minimum(plan.s[k] + plan.length[k], hi[part])
    used = end - begin > 1e-9
    # What is cut off as too short to count must not leave the first record with an s above 0.
    k, part, begin, end = k[used], part[used], begin[used], end[used]
    u, v, turn = arc_step(plan.curvature[k], begin - plan.s[k])
    cos, sin = np.cos(plan.hdg[k]), np.sin(plan.hdg[k])
    start = np.concatenate([[0], np.cumsum(np.bincount(part, minlength=len(which)))]).astype(np.int64)
    return PlanView(
        start,
        np.where(np.diff(part, prepend=-1) > 0, 0.0, begin - lo[part]),
        plan.x[k] + cos * u - sin * v,
        plan.y[k] + sin * u + cos * v,
        plan.hdg[k] + turn,
        end - begin,
        plan.curvature[k].copy(),
    )


def replaced(plan: PlanView, rows: IntArray, other: PlanView, other_rows: IntArray) -> PlanView:
    """Return the table with some of its curves replaced by those of another table."""
    curves = len(plan.start) - 1
    source = np.arange(curves)
    source[rows] = curves + other_rows
    both = joined_plan_views(plan, other)
    return cut_curves(both, np.zeros(curves), lengths(both)[source], source)


def snap_cuts(plan: PlanView, curve: IntArray, s: FloatArray, within: float = 0.01) -> FloatArray:
    """Move positions closer than `within` to the border of two records onto it, so that cuts leave no slivers."""
    k = find_record(plan.start, plan.s, curve, s)
    lower, upper = plan.s[k], plan.s[k] + plan.length[k]
    snapped = np.where(s - lower < within, lower, s)
    out: FloatArray = np.where(upper - s < within, upper, snapped)
    return out
