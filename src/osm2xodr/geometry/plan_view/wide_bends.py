"""Bends of streets become wide enough for their carriageways, which would fold over themselves else.

Where a bend is tighter than half of the carriageway is wide, its inner edge runs backwards. OSM's nodes are a metre
or two off, and seldom give the bends of steep lanes more room than that, so the line gives way: a part of it is
replaced by the shortest curve with a radius that leaves the inner edge one of its own. Of the parts that will do, the
one is taken for which the line moves the least.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import (
    chain_curves,
    cut_curves,
    dubins_curves,
    find_record,
    lengths,
    pose,
    replace_curves,
    stack_plan_views,
)
from osm2xodr.geometry import defaults
from osm2xodr.geometry.lanes import Piece
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# By how much more than the tight bend itself is replaced before it and after it, in radii.
_MORE = np.array([0.0, 0.15, 0.3, 0.5, 0.75, 1.0, 1.4, 2.0, 2.8, 4.0])
# Bends that lie within this many radii of each other are widened as one.
_TOGETHER = 1.0
# A part that is replaced may touch another one of the same street only in the next round.
_ROUNDS = 4
# Places along the new and the old line that are compared.
_PLACES = 17
_AT_ONCE = 4000
# Shorter records are none that one would want to write, m.
_SLIVER = 0.02
_SHORT = 1e-6
# Parts whose curves move the line by as much, up to this, m, are as good: the shortest is taken, and of two alike the
# one that lies more on the longer side of the street, whichever way that is drawn. That counts for this share.
_AS_GOOD = 1e-4
_LOPSIDED = 1e-3


@dataclass(frozen=True, slots=True)
class _Bends:
    """Parts of curves that are too tight, (n,): curve, s where they begin and end, and the least radius, m."""

    curve: IntArray
    begin: FloatArray
    end: FloatArray
    radius: FloatArray


def with_wide_bends(
    plan: PlanView, pieces: tuple[tuple[Piece, ...], ...], fixed: BoolArray
) -> tuple[PlanView, tuple[tuple[Piece, ...], ...], IntArray]:
    """Widen the bends whose inner edge would be tighter than `INNER_EDGE_RADIUS`.

    Parameters
    ----------
    plan, pieces
        The streets' curves, and what lies along them.
    fixed : (streets,)
        Streets that stay as they are.

    Returns
    -------
    plan, pieces
        With the same ends, and the pieces' places moved along.
    narrow
        Streets with bends that are still too tight: the line would have had to move too far.
    """
    reach = np.array([max(max(p[2].left_edge, -p[2].right_edge) for p in street) for street in pieces] or [0.0])
    for _ in range(_ROUNDS):
        bends = _tight_bends(plan, pieces, reach, fixed)
        if not len(bends.curve):
            return plan, pieces, np.zeros(0, np.int64)
        chosen, begin, end, curves, row = _wider(plan, bends)
        if not len(chosen):
            break
        street = bends.curve[chosen]
        # Bends stand in the order of their streets; the first of those that meet goes first.
        free = np.concatenate([[True], (street[1:] != street[:-1]) | (begin[1:] > end[:-1])])
        plan, pieces = _put_in(plan, pieces, street[free], begin[free], end[free], curves, row[free])
    return plan, pieces, np.unique(_tight_bends(plan, pieces, reach, fixed).curve)


def _tight_bends(
    plan: PlanView, pieces: tuple[tuple[Piece, ...], ...], reach: FloatArray, fixed: BoolArray
) -> _Bends:
    """Return the bends that are too tight."""
    owner = np.repeat(np.arange(len(plan.start) - 1), np.diff(plan.start))
    bent = np.flatnonzero(np.abs(plan.curvature) * (reach[owner] + defaults.INNER_EDGE_RADIUS) > 1.0 + _SHORT)
    bent = bent[~fixed[owner[bent]]]
    found: list[list[float]] = []
    for k in bent.tolist():
        street, begin, end = int(owner[k]), float(plan.s[k]), float(plan.s[k] + plan.length[k])
        left, right = _edges(pieces[street], begin, end)
        inner = left if plan.curvature[k] > 0 else right
        if abs(plan.curvature[k]) * (inner + defaults.INNER_EDGE_RADIUS) <= 1.0 + _SHORT:
            continue
        radius = max(left, right) + defaults.INNER_EDGE_RADIUS
        if found and found[-1][0] == street and begin - found[-1][2] < _TOGETHER * radius:
            found[-1][2:] = end, max(radius, found[-1][3])
        else:
            found.append([street, begin, end, radius])
    columns = np.array(found).reshape(-1, 4).T
    return _Bends(columns[0].astype(np.int64), *columns[1:])


def _edges(pieces: tuple[Piece, ...], begin: float, end: float) -> tuple[float, float]:
    """Return how far the carriageway reaches to the left and to the right somewhere on a part of a street, m.

    Lanes that begin or end there do so over some length.
    """
    lo, hi = begin - defaults.TAPER_LENGTH, end + defaults.TAPER_LENGTH
    after = [piece[0] for piece in pieces[1:]] + [np.inf]
    there = [p[2] for p, until in zip(pieces, after, strict=True) if p[0] < hi and until > lo] or [pieces[0][2]]
    return max(section.left_edge for section in there), max(-section.right_edge for section in there)


def _wider(plan: PlanView, bends: _Bends) -> tuple[IntArray, FloatArray, FloatArray, PlanView, IntArray]:
    """Return which bends can be made wider, what of their curves is replaced, and by which curves of a table."""
    n = len(bends.curve)
    more = _MORE * bends.radius[:, None]
    before, after = (grid.ravel() for grid in np.meshgrid(np.arange(len(_MORE)), np.arange(len(_MORE))))
    whole = lengths(plan)[bends.curve]
    begin = np.maximum(bends.begin[:, None] - more[:, before], 0.0)
    end = np.minimum(bends.end[:, None] + more[:, after], whole[:, None])
    which = np.repeat(np.arange(n), len(before))
    begin, end = _on_records(plan, bends.curve[which], begin.ravel(), end.ravel())
    radius, curve = bends.radius[which], bends.curve[which]
    x0, y0, hdg0 = pose(plan, curve, begin)
    x1, y1, hdg1 = pose(plan, curve, end)
    found = dubins_curves(x0, y0, hdg0, x1, y1, hdg1, radius=radius)
    aside = _moved(plan, curve, begin, end, found)
    longer = np.sign(bends.begin - (whole - bends.end))[which]
    lopsided = longer * ((end - bends.end[which]) - (bends.begin[which] - begin))
    cost = (end - begin + _LOPSIDED * lopsided).reshape(n, -1)
    least = aside.reshape(n, -1).min(1, keepdims=True)
    best = np.where(aside.reshape(n, -1) <= least + _AS_GOOD, cost, np.inf).argmin(1) + np.arange(n) * len(before)
    chosen = np.flatnonzero(aside[best] <= defaults.BEND_ASIDE)
    row = best[chosen]
    return chosen, begin[row], end[row], found, row


def _on_records(plan: PlanView, curve: IntArray, begin: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Move places to the border of two records if that is near, so that nothing short is left of a record."""
    out = []
    for s in (begin, end):
        k = find_record(plan.start, plan.s, curve, s)
        lower, upper = plan.s[k], plan.s[k] + plan.length[k]
        near = np.where(s - lower < _SLIVER, lower, s)
        out.append(np.where(upper - s < _SLIVER, upper, near))
    return out[0], out[1]


def _moved(plan: PlanView, curve: IntArray, begin: FloatArray, end: FloatArray, found: PlanView) -> FloatArray:
    """Return how far curves are from what they replace, (n,), m; infinite where they are no use."""
    n = len(curve)
    length = lengths(found)
    out = np.full(n, np.inf)
    owner = np.repeat(np.arange(n), np.diff(found.start))
    shortest = np.full(n, np.inf)
    np.minimum.at(shortest, owner, found.length)
    usable = np.flatnonzero((length > 0) & (shortest > _SLIVER))
    share = np.linspace(0.0, 1.0, _PLACES)
    for lo in range(0, len(usable), _AT_ONCE):
        row = usable[lo : lo + _AT_ONCE]
        many = np.repeat(row, _PLACES)
        new = pose(found, many, (length[row, None] * share).ravel())
        old = pose(plan, curve[many], (begin[row, None] + (end - begin)[row, None] * share).ravel())
        dx, dy = (
            one.reshape(-1, _PLACES)[:, :, None] - other.reshape(-1, _PLACES)[:, None, :]
            for one, other in zip(new[:2], old[:2], strict=True)
        )
        apart = dx * dx + dy * dy
        out[row] = np.sqrt(np.maximum(apart.min(1).max(1), apart.min(2).max(1)))
    return out


def _put_in(
    plan: PlanView,
    pieces: tuple[tuple[Piece, ...], ...],
    street: IntArray,
    begin: FloatArray,
    end: FloatArray,
    curves: PlanView,
    row: IntArray,
) -> tuple[PlanView, tuple[tuple[Piece, ...], ...]]:
    """Replace parts of streets by curves, those of given rows, and move what lies along the streets."""
    length, grown = lengths(plan), lengths(curves)[row] - (end - begin)
    changed, first = np.unique(street, return_index=True)
    part_lo, part_hi, source, count = [], [], [], []
    out = list(pieces)
    offset = len(plan.start) - 1
    for k, lo, hi in zip(changed.tolist(), first.tolist(), [*first[1:].tolist(), len(street)], strict=True):
        own = slice(lo, hi)
        kept = np.concatenate([[0.0], end[own]]), np.concatenate([begin[own], [length[k]]])
        for i in range(hi - lo + 1):
            if kept[1][i] - kept[0][i] > _SHORT:
                part_lo.append(kept[0][i])
                part_hi.append(kept[1][i])
                source.append(k)
            if i < hi - lo:
                part_lo.append(0.0)
                part_hi.append(np.inf)
                source.append(offset + int(row[lo + i]))
        count.append(len(source))
        old = np.concatenate([[0.0], np.column_stack([begin[own], end[own]]).ravel(), [length[k]]])
        shift = np.repeat(np.concatenate([[0.0], np.cumsum(grown[own])]), 2)
        at = np.interp([piece[0] for piece in pieces[k]], old, old + shift).tolist()
        out[k] = tuple((s, attributes, section) for s, (_, attributes, section) in zip(at, pieces[k], strict=True))
    parts = cut_curves(stack_plan_views(plan, curves), np.array(part_lo), np.array(part_hi), source)
    whole = chain_curves(parts, np.concatenate([[0], count]).astype(np.int64))
    return replace_curves(plan, changed, whole, np.arange(len(changed))), tuple(out)
