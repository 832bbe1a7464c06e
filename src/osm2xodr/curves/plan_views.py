"""Curves of lines, arcs and spirals: evaluated, made, stacked, chained, reversed and cut, whole networks at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves.ragged import owners, ranks, repeated, runs, starts
from osm2xodr.curves.records import find_record
from osm2xodr.curves.spirals import advance
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Pieces of curves that are not longer than this are left out, m: rounding errors.
SHORTEST_PIECE: Final = 1e-7
# Lines that follow each other and whose headings differ by less are one, rad: ASAM's checker calls them redundant.
_SAME_HEADING: Final = 1e-6
# Cuts leave out pieces that are not longer than this, m.
_SHORTEST_CUT: Final = 1e-9

_COLUMNS: Final = ("s", "x", "y", "hdg", "length", "curvature", "rate")
_Pose = tuple[FloatArray, FloatArray, FloatArray]


def wrapped(angle: FloatArray) -> FloatArray:
    """Return angles as turns: from -pi up to pi, rad."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def lengths(plan: PlanView, curves: slice | IntArray = slice(None)) -> FloatArray:
    """Return the length of each curve, or of those of given indices, (curves,), m."""
    first, end = plan.start[:-1][curves], plan.start[1:][curves]
    last = np.maximum(end - 1, 0)
    has = end > first
    return np.where(has, plan.s[last] + plan.length[last], 0.0) if len(plan.s) else np.zeros(len(has))


def smallest_radius(plan: PlanView) -> FloatArray:
    """Return the smallest radius of each curve, (curves,), m; infinity for lines."""
    out = np.full(len(plan.start) - 1, np.inf)
    owner, sharpest = owners(plan.start), np.abs(sharpest_curvature(plan))
    bent = sharpest != 0
    np.minimum.at(out, owner[bent], 1 / sharpest[bent])
    return out


def sharpest_curvature(plan: PlanView) -> FloatArray:
    """Return the curvature of each record at its end where it is larger, (records,), 1/m."""
    end = end_curvature(plan)
    return np.where(np.abs(end) > np.abs(plan.curvature), end, plan.curvature)


def end_curvature(plan: PlanView, records: slice | IntArray = slice(None)) -> FloatArray:
    """Return the curvature at the end of records, of all if none are named, (records,), 1/m."""
    return np.asarray(plan.curvature[records] + plan.rate[records] * plan.length[records])


def record_ends(plan: PlanView) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the curve, s, m, and curvature, 1/m, where each record begins, and then where each ends, all (2 n,).

    Curvature is largest, and the centre of the bend nearest, at one of these places.
    """
    owner = owners(plan.start)
    s = np.concatenate([plan.s, plan.s + plan.length])
    return np.concatenate([owner, owner]), s, np.concatenate([plan.curvature, end_curvature(plan)])


def record_turns(plan: PlanView) -> FloatArray:
    """Return by how much each record turns, (records,), rad."""
    return np.asarray((plan.curvature + 0.5 * plan.rate * plan.length) * plan.length)


def curve_ends(plan: PlanView, curve: IntArray | None = None) -> tuple[_Pose, _Pose]:
    """Return what `pose` does at the start and at the end of curves, of all if none are named, all (n,)."""
    curve = np.arange(len(plan.start) - 1) if curve is None else curve
    first = plan.start[curve]
    last = np.maximum(plan.start[curve + 1] - 1, first)
    start = plan.x[last], plan.y[last], plan.hdg[last], plan.curvature[last]
    end = advance(*start, lengths(plan, curve) - plan.s[last], plan.rate[last])
    return (plan.x[first], plan.y[first], plan.hdg[first]), end


def heading_at(plan: PlanView, curve: IntArray, s: FloatArray) -> FloatArray:
    """Return the heading at s of curves, (n,), rad: that of `pose`, to the last bit, in less time. Not wrapped."""
    k = find_record(plan.start, plan.s, curve, s)
    return _turned(plan, k, s - plan.s[k]) + plan.hdg[k]


def _turned(plan: PlanView, record: IntArray, ds: FloatArray) -> FloatArray:
    """Return by how much records have turned after ds, (n,), rad, in the same steps as `advance`."""
    half = 0.5 * ds
    return np.asarray(2.0 * (half * plan.curvature[record] + plan.rate[record] * half * half))


def heading_change(plan: PlanView, curve: IntArray) -> FloatArray:
    """Return by how much the heading at the end of curves differs from that at their start, (n,), rad, -pi to pi."""
    first, last = plan.start[curve], plan.start[curve + 1] - 1
    return wrapped(_turned(plan, last, lengths(plan, curve) - plan.s[last]) + plan.hdg[last] - plan.hdg[first])


def curvature_at(plan: PlanView, curve: IntArray, s: FloatArray) -> FloatArray:
    """Return the curvature at s of curves, (n,), 1/m."""
    k = find_record(plan.start, plan.s, curve, s)
    return np.asarray(plan.curvature[k] + plan.rate[k] * (s - plan.s[k]))


def places_along(
    plan: PlanView, spacing: float | FloatArray, curves: IntArray | None = None
) -> tuple[IntArray, FloatArray]:
    """Return places along all curves, or along those of given indices: index of the curve and s, both (n,).

    They are evenly spread from end to end, at most `spacing` apart, m, or that of each of these curves; each has two
    at least.
    """
    chosen = np.arange(len(plan.start) - 1) if curves is None else curves
    length = lengths(plan, chosen)
    count = np.maximum(np.ceil(length / spacing).astype(np.int64), 1) + 1
    s = np.multiply(np.repeat(length / (count - 1), count), ranks(count), dtype=np.float64)
    return np.repeat(chosen, count), s


def stack_plan_views(*plans: PlanView) -> PlanView:
    """Return the curves of several tables in one, table after table."""
    first = starts([len(plan.s) for plan in plans])
    start = [plan.start[:-1] + begin for plan, begin in zip(plans, first.tolist(), strict=False)]
    columns = ([np.zeros(0), *(getattr(plan, name) for plan in plans)] for name in _COLUMNS)
    return PlanView(np.concatenate([*start, first[-1:]]), *map(np.concatenate, columns))


def curves_of(x: FloatArray, y: FloatArray, hdg: FloatArray, length: FloatArray, curvature: FloatArray) -> PlanView:
    """Return curves of several lines and arcs each, (n, pieces), that start in poses (n,); no piece of length 0."""
    places = []
    for k in range(length.shape[1]):
        places.append((x, y, hdg))
        x, y, hdg = advance(x, y, hdg, curvature[:, k], length[:, k])
    used = length > SHORTEST_PIECE
    start = starts(used.sum(1))
    xs, ys, hdgs = (np.column_stack([place[k] for place in places])[used] for k in range(3))
    s = (np.cumsum(length * used, axis=1) - length * used)[used]
    return PlanView(start, s, xs, ys, hdgs, length[used], curvature[used])


def lines_that_go_on(plan: PlanView, owner: IntArray, most: float) -> BoolArray:
    """Say which records but the first are lines that go on as the lines before them, (records - 1,).

    Both have the same `owner`, (records,), and headings that differ by less than `most`, rad.
    """
    straight = (plan.curvature == 0.0) & (plan.rate == 0.0)
    on: BoolArray = straight[1:] & straight[:-1] & (owner[1:] == owner[:-1])
    return on & (np.abs(wrapped(np.diff(plan.hdg))) < most)


def chain_curves(plan: PlanView, first: IntArray) -> PlanView:
    """Return one curve for each group of curves, each of which goes on where the one before it in its group ends.

    `first` holds the index of each group's first curve, (groups + 1,). Lines that go on as lines become one record.
    """
    length = lengths(plan)
    end = np.cumsum(length)
    begin = end - length
    group = owners(first)
    before = begin - begin[np.minimum(first[:-1], max(len(begin) - 1, 0))][group]
    curve = owners(plan.start)
    owner = group[curve]
    goes_on = lines_that_go_on(plan, owner, _SAME_HEADING)
    kept = np.flatnonzero(np.concatenate([[True], ~goes_on])[: len(owner)])
    return PlanView(
        np.searchsorted(owner[kept], np.arange(len(first))).astype(np.int64),
        (plan.s + before[curve])[kept],
        plan.x[kept],
        plan.y[kept],
        plan.hdg[kept],
        np.add.reduceat(plan.length, kept) if len(kept) else plan.length,
        plan.curvature[kept],
        plan.rate[kept],
    )


def reverse_curves(plan: PlanView, which: BoolArray, *, wrap: bool = True) -> PlanView:
    """Return the curves of a table, some of them, (curves,), from their end to their start, with wrapped headings."""
    owner = owners(plan.start)
    back = which[owner]
    every = np.arange(len(owner))
    source = np.where(back, (plan.start[:-1] + plan.start[1:] - 1)[owner] - every, every)
    x, y, hdg = advance(plan.x, plan.y, plan.hdg, plan.curvature, plan.length, plan.rate)
    s = lengths(plan, owner) - (plan.s + plan.length)
    backwards = s, x, y, wrapped(hdg + np.pi) if wrap else hdg + np.pi, plan.length, -end_curvature(plan), plan.rate
    columns = [(getattr(plan, name), after) for name, after in zip(_COLUMNS, backwards, strict=True)]
    return PlanView(plan.start, *(np.where(back, after[source], before) for before, after in columns))


def cut_curves(plan: PlanView, lo: FloatArray, hi: FloatArray, curve: Sequence[int] | IntArray) -> PlanView:
    """Return the parts from s = lo to s = hi of curves, all (parts,). The same curve may be cut several times.

    The parts' s starts at 0. `snap_cuts` moves cuts beforehand so that they leave no slivers.
    """
    which = np.asarray(curve, np.int64)
    count = plan.start[which + 1] - plan.start[which]
    part = repeated(count)
    k = runs(plan.start[which], count)
    begin = np.maximum(plan.s[k], lo[part])
    end = np.minimum(plan.s[k] + plan.length[k], hi[part])
    used = end - begin > _SHORTEST_CUT
    k, part, begin, end = k[used], part[used], begin[used], end[used]
    x, y, hdg, curvature = plan.x[k], plan.y[k], plan.hdg[k], plan.curvature[k]
    # Few parts begin within a record.
    cut = np.flatnonzero(begin > plan.s[k])
    within = k[cut]
    ds, rate = begin[cut] - plan.s[within], plan.rate[within]
    x[cut], y[cut], hdg[cut] = advance(x[cut], y[cut], hdg[cut], curvature[cut], ds, rate)
    curvature[cut] += rate * ds
    start = starts(np.bincount(part, minlength=len(which)))
    # A piece that was left out must not leave the first record with an s above 0.
    s = np.where(np.diff(part, prepend=-1) > 0, 0.0, begin - lo[part])
    return PlanView(start, s, x, y, hdg, end - begin, curvature, plan.rate[k])


def chosen_curves(plan: PlanView, rows: IntArray) -> PlanView:
    """Return the curves of some rows, in their order; the same one may come several times."""
    count = plan.start[rows + 1] - plan.start[rows]
    k = runs(plan.start[rows], count)
    s = plan.s[k]
    # As `cut_curves` finds it.
    length = s + plan.length[k] - s
    used = length > _SHORTEST_CUT
    if not used.all():
        return cut_curves(plan, np.zeros(len(rows)), lengths(plan, rows), rows)
    return PlanView(starts(count), s, plan.x[k], plan.y[k], plan.hdg[k], length, plan.curvature[k], plan.rate[k])


def replace_curves(plan: PlanView, rows: IntArray, other: PlanView, other_rows: IntArray) -> PlanView:
    """Return the table with its curves `rows` replaced by the curves `other_rows` of another table."""
    curves = len(plan.start) - 1
    source = np.arange(curves)
    source[rows] = curves + other_rows
    return chosen_curves(stack_plan_views(plan, other), source)


def snap_cuts(plan: PlanView, curve: IntArray, s: FloatArray, within: float = 0.01) -> FloatArray:
    """Move positions closer than `within` to the border of two records onto it, so that cuts leave no slivers."""
    k = find_record(plan.start, plan.s, curve, s)
    lower, upper = plan.s[k], plan.s[k] + plan.length[k]
    snapped = np.where(s - lower < within, lower, s)
    return np.where(upper - s < within, upper, snapped)


def cut_records(plan: PlanView, row: IntArray, ds: FloatArray) -> PlanView:
    """Cut records, by their indices, ds behind their starts, m; a record may be cut several times."""
    count = len(plan.s)
    row, ds = np.concatenate([np.arange(count), row]), np.concatenate([np.zeros(count), ds])
    order = np.lexsort((ds, row))
    row, ds = row[order], ds[order]
    pieces = np.bincount(row, minlength=count)
    end = np.append(ds[1:], 0.0)
    end[np.cumsum(pieces) - 1] = plan.length
    pose = plan.x[row], plan.y[row], plan.hdg[row], plan.curvature[row]
    x, y, hdg = advance(*pose, ds, plan.rate[row])
    curvature = plan.curvature[row] + plan.rate[row] * ds
    return PlanView(starts(pieces)[plan.start], plan.s[row] + ds, x, y, hdg, end - ds, curvature, plan.rate[row])
