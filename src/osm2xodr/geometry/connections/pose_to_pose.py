"""Curves from one position and heading to another by lines and arcs, all at once, and what may be wrong with them."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    curve_ends,
    curves_of,
    dubins_curves,
    hypot,
    lengths,
    owners,
    pose,
    record_turns,
    replace_curves,
    starts,
    unique_inverse,
    wrapped,
)
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.geometry.connections.between_poses import MISSED, connections, least_distances, meetings_of_tangents
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Arcs are not made smaller where the curve would be longer by more than this share.
_LONGER_THAN_AN_ARC: Final = 0.07
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
    n = len(x0)
    out, missed = np.empty((6, n, 3)), np.empty(n, np.bool_)
    connections(x0, y0, hdg0, x1, y1, hdg1, np.broadcast_to(np.asarray(radius, np.float64), n), longest, out, missed)
    used = out[4] > 0
    s, x, y, hdg, length, curvature = out[:, used]
    plan = PlanView(starts(used.sum(1)), s, x, y, hdg, length, curvature)
    if not missed.any():
        return plan
    x0, y0, hdg0, x1, y1, hdg1 = (column[missed] for column in (x0, y0, hdg0, x1, y1, hdg1))
    shortest = dubins_curves(x0, y0, hdg0, x1, y1, hdg1, radius=CONNECTING_RADIUS)
    along = hypot(x1 - x0, y1 - y0)[:, None]
    lines = curves_of(x0, y0, arctan2(y1 - y0, x1 - x0), along, np.zeros_like(along))
    behind = np.flatnonzero(lengths(shortest) == 0)
    shortest = replace_curves(shortest, behind, lines, behind)
    return replace_curves(plan, np.flatnonzero(missed), shortest, np.arange(len(x0)))


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
    out[owner[1:][(owner[1:] == owner[:-1]) & (jump > MISSED)]] = True
    return out


def curves_apart(one: PlanView, there: IntArray, other: PlanView, back: IntArray, places: int) -> FloatArray:
    """Return how near curves of one table come to those of another one, (pairs,), m, but at their ends.

    They are compared at so many places each.
    """
    (ways, there), (others, back) = unique_inverse(there), unique_inverse(back)
    out = np.empty(len(there))
    least_distances(*_places(one, ways, places), there, *_places(other, others, places), back, out)
    return out


def _places(plan: PlanView, curve: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return so many places along curves, all but their ends, (n, count)."""
    length = lengths(plan, curve)
    lead = np.minimum(_LEAD, length / 2)
    s = lead[:, None] + (length - 2 * lead)[:, None] * np.linspace(0.0, 1.0, count)
    x, y, _ = pose(plan, np.repeat(curve, count), s.ravel())
    return x.reshape(s.shape), y.reshape(s.shape)


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
    out = np.empty((2, len(x0)))
    meetings_of_tangents(x0, y0, hdg0, x1, y1, hdg1, out)
    return out[0], out[1]
