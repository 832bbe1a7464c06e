"""Curves from one position and heading to another by lines and arcs, all at once, and what may be wrong with them."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    arc_step,
    arctan2,
    cosine,
    curve_ends,
    curves_of,
    dubins_curves,
    hypot,
    lengths,
    owners,
    pose,
    record_turns,
    replace_curves,
    sine,
    slope_of,
    starts,
    wrapped,
)
from osm2xodr.defaults import CONNECTING_RADIUS, LEAST_TURN_BACK
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# A line and an arc are used where both tangents are longer than this, m, and the turn is larger than this, rad, but
# no turn back, and where the line is either no shorter than this, m, or absent, that is shorter than this, m.
_SHORTEST_TANGENT: Final = 0.05
_LEAST_TURN: Final = 1e-3
_SHORTEST_LINE_BEFORE_ARC: Final = 0.01
_NO_LINE_BELOW: Final = 1e-9
# An arc is not made smaller where that would leave lines no longer than this, m.
_SHORTEST_LINE_BESIDE_ARC: Final = 0.5
# Nor where the curve would be longer by more than this share.
_LONGER_THAN_AN_ARC: Final = 0.07
# An arc that turns less than this, rad, is written as its chord: readers with single precision cannot place its far
# centre. Curves that are drawn again begin and end as they did, so that what chords leave out adds up.
_STRAIGHT_BELOW: Final = 5e-5
# Two arcs that would be longer than this, m, or their tangents, do not meet: to a pose behind in almost the same
# heading they are circles of many kilometres, whose end is off by what rounding leaves of it.
_LONGEST_TANGENT: Final = 1e4
# Shorter records are left out, m.
_SHORTEST_RECORD: Final = 1e-7
# A curve whose heading at its end, or between two of its records, is off by more has missed it, rad.
_MISSED: Final = 1e-3
# So has one that ends beside its pose by more than this, m.
_MISSED_BY: Final = 1e-3
# A connecting road shorter than this, m, that turns by more than this, rad, is a point: no car turns on one.
_SHORTEST_TURN: Final = 0.1
_TURN_OF_A_POINT: Final = 0.5
# A connecting road that is longer than this many times the distance it bridges, and this much more, m, is a detour:
# its arms lie on each other.
_DETOUR: Final = 4.0
_DETOUR_MORE: Final = 60.0
# Two arcs that turn by more than this in all, rad (40 degrees), swing out if they turn forth and back by more than
# this, rad (20 degrees).
_TURN_THAT_MAY_SWING: Final = 0.7
_SWING_BACK_AND_FORTH: Final = 0.35

# Curves are compared from this far behind their start to this far before their end, m.
_LEAD: Final = 2.0
# Turns below this, rad, count as straight.
_NO_ANGLE: Final = 1e-9


def connect(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    *,
    radius: float | FloatArray = np.inf,
    longest: float = 1.0 + _LONGER_THAN_AN_ARC,
) -> PlanView:
    """Return a curve from each pose 0 to pose 1, (n,), m and rad, that starts and ends in their headings.

    Lines and an arc where the tangents meet ahead of the first and behind the second pose and leave room for a turn
    that cars drive, the arc no larger than `radius`, m, unless the curve would become `longest` times as long as the
    largest arc by that; else two arcs with tangents of equal length (biarc, Bolton 1975,
    doi:10.1016/0010-4485(75)90086-X), if their radius is larger; Dubins' shortest curve where two arcs do not reach
    the second pose, because it looks back from straight ahead. A pose straight behind, which only a full circle
    reaches, has a line, driven backwards.
    """
    length, curvature = _biarc(x0, y0, hdg0, x1, y1, hdg1)
    simple, simple_length, simple_curvature = _line_and_arc(x0, y0, hdg0, x1, y1, hdg1, radius, longest)
    sharp = np.abs(simple_curvature[:, 1])
    simple &= (sharp * CONNECTING_RADIUS <= 1.0) | (sharp <= np.abs(curvature).max(axis=1))
    length = np.where(simple[:, None], simple_length, length)
    curvature = np.where(simple[:, None], simple_curvature, curvature)
    x, y, hdg, dx, dy = _starts(x0, y0, hdg0, length, curvature)
    missed = hypot(x0 + dx.sum(axis=1) - x1, y0 + dy.sum(axis=1) - y1) > _MISSED_BY
    missed |= length.max(axis=1) > _LONGEST_TANGENT
    straight = np.abs(curvature * length) < _STRAIGHT_BELOW
    hdg = np.where(straight, arctan2(dy, dx), hdg)
    length = np.where(straight, hypot(dx, dy), length)
    curvature = np.where(straight, 0.0, curvature)
    line = straight[:, :2].all(axis=1) & ~simple
    hdg[line, 0] = arctan2(y1 - y0, x1 - x0)[line]
    length[line, 0], length[line, 1] = hypot(x1 - x0, y1 - y0)[line], 0.0
    length = np.where(length > _SHORTEST_RECORD, length, 0.0)
    used = length > 0
    s = np.cumsum(length, axis=1) - length
    start = starts(used.sum(1))
    plan = PlanView(start, s[used], x[used], y[used], hdg[used], length[used], curvature[used])
    missed |= np.abs(wrapped(hdg0 + (length * curvature).sum(axis=1) - hdg1)) > _MISSED
    if not missed.any():
        return plan
    x0, y0, hdg0, x1, y1, hdg1 = (column[missed] for column in (x0, y0, hdg0, x1, y1, hdg1))
    other = dubins_curves(x0, y0, hdg0, x1, y1, hdg1, radius=CONNECTING_RADIUS)
    along = hypot(x1 - x0, y1 - y0)[:, None]
    lines = curves_of(x0, y0, arctan2(y1 - y0, x1 - x0), along, np.zeros_like(along))
    behind = np.flatnonzero(lengths(other) == 0)
    other = replace_curves(other, behind, lines, behind)
    return replace_curves(plan, np.flatnonzero(missed), other, np.arange(len(x0)))


def _starts(
    x0: FloatArray, y0: FloatArray, hdg0: FloatArray, length: FloatArray, curvature: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return x, y and heading where each record starts, and the steps to its end in x and y, all (n, 3)."""
    zero = np.zeros((len(x0), 1))
    hdg = hdg0[:, None] + np.concatenate([zero, np.cumsum(length * curvature, axis=1)[:, :-1]], axis=1)
    u, v, _ = arc_step(curvature, length)
    dx = cosine(hdg) * u - sine(hdg) * v
    dy = sine(hdg) * u + cosine(hdg) * v
    x = x0[:, None] + np.concatenate([zero, np.cumsum(dx, axis=1)[:, :-1]], axis=1)
    y = y0[:, None] + np.concatenate([zero, np.cumsum(dy, axis=1)[:, :-1]], axis=1)
    return x, y, hdg, dx, dy


def legs_through(begin: Poses, passed: Poses, end: Poses, count: IntArray) -> tuple[Poses, Poses, IntArray]:
    """Return the poses that the legs of curves lead from and to, (legs,), and the first leg of each, (n + 1,).

    `begin` and `end` are those of the curves, (n,), and `passed` those that they pass on their way, curve after
    curve, of which each has `count`, (n,).
    """
    start = starts(count + 2)
    inside = np.ones(start[-1], bool)
    inside[start[:-1]] = inside[start[1:] - 1] = False
    leave = np.delete(np.arange(start[-1]), start[1:] - 1)
    both = []
    for one, middle, other in zip(begin, passed, end, strict=True):
        column = np.zeros(start[-1])
        column[start[:-1]], column[inside], column[start[1:] - 1] = one, middle, other
        both.append((column[leave], column[leave + 1]))
    (x0, x1), (y0, y1), (hdg0, hdg1) = both
    return (x0, y0, hdg0), (x1, y1, hdg1), start - np.arange(len(start))


def detours(plan: PlanView) -> BoolArray:
    """Say which curves are far longer than what they bridge, (curves,)."""
    (x0, y0, _), (x1, y1, _) = curve_ends(plan)
    return lengths(plan) > _DETOUR * hypot(x1 - x0, y1 - y0) + _DETOUR_MORE


def has_kinks(plan: PlanView) -> BoolArray:
    """Say which curves change their heading at once between two of their records, (curves,)."""
    owner = owners(plan.start)
    jump = np.abs(wrapped(plan.hdg[1:] - (plan.hdg + record_turns(plan))[:-1]))
    out = np.zeros(len(plan.start) - 1, bool)
    out[owner[1:][(owner[1:] == owner[:-1]) & (jump > _MISSED)]] = True
    return out


def curves_apart(one: PlanView, there: IntArray, other: PlanView, back: IntArray, places: int) -> FloatArray:
    """Return how near curves of one table come to those of another one, (pairs,), m, but at their ends.

    They are compared at so many places each.
    """
    (ax, ay), (bx, by) = _places(one, there, places), _places(other, back, places)
    least = np.full(len(there), np.inf)
    # One place of the ways there after the other, so that no large table of all places arises.
    for x, y in zip(ax, ay, strict=True):
        square, across = bx - x, by - y
        square *= square
        across *= across
        square += across
        np.minimum(least, square.min(axis=0), out=least)
    return np.asarray(np.sqrt(least))


def _places(plan: PlanView, curve: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return so many places along curves, all but their ends, (count, n)."""
    length = lengths(plan, curve)
    lead = np.minimum(_LEAD, length / 2)
    s = lead[:, None] + (length - 2 * lead)[:, None] * np.linspace(0.0, 1.0, count)
    x, y, _ = pose(plan, np.repeat(curve, count), s.ravel())
    # Faster than one curve after the other: least distances are looked for along the first axis.
    return np.ascontiguousarray(x.reshape(s.shape).T), np.ascontiguousarray(y.reshape(s.shape).T)


def turns_on_the_spot(plan: PlanView) -> BoolArray:
    """Say which curves turn at a point, (curves,)."""
    return (lengths(plan) < _SHORTEST_TURN) & (_turns(plan)[1] > _TURN_OF_A_POINT)


def swings_out(plan: PlanView) -> BoolArray:
    """Say which pairs of arcs turn to the other side before they turn or after it, (curves,)."""
    net, whole = _turns(plan)
    # Curves of more records keep to streets.
    out: BoolArray = (np.diff(plan.start) == 2) & (net > _TURN_THAT_MAY_SWING) & (whole - net > _SWING_BACK_AND_FORTH)
    return out


def _turns(plan: PlanView) -> tuple[FloatArray, FloatArray]:
    """Return by how much curves change their heading, and by how much they turn in all, (curves,), rad."""
    n, owner = len(plan.start) - 1, owners(plan.start)
    turn = record_turns(plan)
    return np.abs(np.bincount(owner, turn, n)), np.bincount(owner, np.abs(turn), n).astype(np.float64)


def tangents(
    x0: FloatArray, y0: FloatArray, hdg0: FloatArray, x1: FloatArray, y1: FloatArray, hdg1: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far ahead of poses 0, and behind poses 1, their tangents meet, (n,), m; negative: beyond."""
    vx, vy = x1 - x0, y1 - y0
    sin = sine(wrapped(hdg1 - hdg0))
    safe = np.where(np.abs(sin) < _NO_ANGLE, 1.0, sin)
    before = (vx * sine(hdg1) - vy * cosine(hdg1)) / safe
    after = (cosine(hdg0) * vy - sine(hdg0) * vx) / safe
    return before, after


def _line_and_arc(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    most: float | FloatArray,
    longest: float,
) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return where lines and an arc connect the poses, (n,), and lengths and curvatures of line, arc, line, (n, 3).

    The arc touches both tangents at the distance of the shorter one from where they meet, or nearer if its radius
    would be above `most`, as long as they are at most `longest` times as long; the rest of both is lines.
    """
    turn = wrapped(hdg1 - hdg0)
    before, after = tangents(x0, y0, hdg0, x1, y1, hdg1)
    shorter = np.minimum(before, after)
    size = np.abs(turn)
    unequal = np.abs(before - after)
    found = (shorter > _SHORTEST_TANGENT) & (size > _LEAST_TURN) & (size < LEAST_TURN_BACK)
    half = slope_of(np.clip(size, 1e-6, 3.1) / 2)
    # The detour by the tangents, as a share of the largest arc.
    detour = np.maximum(2 * half / np.maximum(size, 1e-6) - 1, 1e-6)
    touch = np.maximum(most * half, shorter * (1 - (longest - 1) / detour))
    between_lines = shorter - touch > _SHORTEST_LINE_BESIDE_ARC
    touch = np.maximum(np.where(between_lines, touch, shorter), 1e-9)
    found &= between_lines | (unequal > _SHORTEST_LINE_BEFORE_ARC) | (unequal < _NO_LINE_BELOW)
    radius = touch / half
    length = np.stack([np.maximum(before - touch, 0), radius * size, np.maximum(after - touch, 0)], axis=1)
    curvature = np.zeros_like(length)
    curvature[:, 1] = np.sign(turn) / radius
    return found, length, curvature


def _biarc(
    x0: FloatArray, y0: FloatArray, hdg0: FloatArray, x1: FloatArray, y1: FloatArray, hdg1: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return lengths and curvatures (n, 3) of two arcs; the third record is empty."""
    vx, vy = x1 - x0, y1 - y0
    tx0, ty0, tx1, ty1 = cosine(hdg0), sine(hdg0), cosine(hdg1), sine(hdg1)
    square = vx * vx + vy * vy
    # 1 - t0·t1, written so that it does not cancel for almost equal headings.
    apart = 2.0 * sine((hdg1 - hdg0) / 2) ** 2
    along = vx * (tx0 + tx1) + vy * (ty0 + ty1)
    root = np.sqrt(along * along + 2 * apart * square)
    # The stable form of (-along + root) / (2 apart) for either sign of `along`.
    tangent = np.where(
        along > 0, square / np.maximum(along + root, 1e-12), (root - along) / np.maximum(2 * apart, 1e-12)
    )
    # A pose straight behind in the same heading is out of reach of two arcs.
    tangent = np.minimum(tangent, _LONGEST_TANGENT)
    jx = (x0 + tangent * tx0 + x1 - tangent * tx1) / 2
    jy = (y0 + tangent * ty0 + y1 - tangent * ty1) / 2
    length = np.zeros((len(x0), 3))
    curvature = np.zeros((len(x0), 3))
    for k, (wx, wy, cross, dot) in enumerate(
        (
            (jx - x0, jy - y0, tx0 * (jy - y0) - ty0 * (jx - x0), tx0 * (jx - x0) + ty0 * (jy - y0)),
            (x1 - jx, y1 - jy, (x1 - jx) * ty1 - (y1 - jy) * tx1, (x1 - jx) * tx1 + (y1 - jy) * ty1),
        )
    ):
        chord2 = np.maximum(wx * wx + wy * wy, 1e-18)
        turn = 2 * arctan2(cross, dot)
        curvature[:, k] = 2 * cross / chord2
        bent = (np.abs(turn) > _NO_ANGLE) & (curvature[:, k] != 0)
        length[:, k] = np.where(bent, turn / np.where(bent, curvature[:, k], 1.0), np.sqrt(chord2))
        curvature[:, k] = np.where(bent, curvature[:, k], 0.0)
    return length, curvature
