"""Connecting roads that turn back: one tight turn, as near to the ends of their arms as the way across allows.

A car that turns back goes round the nose of the median, or of the corner between two arms at an acute angle: its turn
reaches as far as the street across the median, if this is near, and begins at the ends of the arms if it is not.
Where the two lanes are closer than a car's turning circle, it swings out before and after the turn.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    advance,
    chain_curves,
    curve_ends,
    curves_of,
    dubins_without_slivers,
    heading_change,
    lengths,
    owners,
    record_turns,
    repeated,
    replace_curves,
    smallest_radius,
    wrapped,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections.defaults import LEAST_REDRAWN_RADIUS, SMOOTH_CORNER
from osm2xodr.geometry.connections.street_paths import LanePaths, Poses
from osm2xodr.geometry.defaults import U_TURN_RADIUS, U_TURN_RADIUS_MAX
from osm2xodr.geometry.plan_view import StreetEnds, outward_pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# An arc across the whole distance of two lanes is left this share of it for lanes that are not quite parallel.
SHARE_OF_HALF: Final = 0.96
# A curve swings out if it turns forth and back by more than this, rad (6 degrees). A choice.
_SWING: Final = 0.1
# Where the two lanes are at least this far apart, m, a car swings out before its turn alone; else also after it. A
# choice: by at most 2 m.
_APART_FOR_ONE_SWING: Final = 6.0
# A turn begins at most this far beyond the ends of both arms, m: farther on, other streets meet. A choice.
_FARTHEST: Final = 6.0


def turns_back(plan: PlanView) -> BoolArray:
    """Say which curves end in about the opposite of the heading that they start with, (curves,)."""
    return np.asarray(np.abs(heading_change(plan, np.arange(len(plan.start) - 1))) >= LEAST_TURN_BACK)


def swings_back(plan: PlanView) -> BoolArray:
    """Say which curves turn back and swing out for it, (curves,): their lanes are close."""
    turn, owner, n = record_turns(plan), owners(plan.start), len(plan.start) - 1
    forth_and_back = np.bincount(owner, np.abs(turn), n) - np.abs(np.bincount(owner, turn, n))
    return np.asarray(turns_back(plan) & (forth_and_back > _SWING))


def draw_turn_backs(plan: PlanView, lanes: LanePaths, ends: StreetEnds, entry: IntArray, exit_: IntArray) -> PlanView:
    """Replace those of the curves, (n,), that turn back by tight turns.

    `entry` and `exit_` (n,) are the street ends that they lead from and to. Curves that follow a smooth street, or a
    roundabout, stay.
    """
    paths = lanes.paths
    bends = (paths.sharpest[lanes.path] >= SMOOTH_CORNER) & ~paths.on_ring[lanes.path]
    row = np.flatnonzero(turns_back(plan) & bends & (entry != exit_))
    # Where two thirds of the turn are bends of the arms' streets, cars follow these if they can.
    follows = paths.cornered[lanes.path[row]] < LEAST_TURN_BACK / 3
    row = row[~follows | (smallest_radius(plan)[row] < LEAST_REDRAWN_RADIUS)]
    if not len(row):
        return plan
    begin, end = curve_ends(plan, row)
    turned = turned_back(begin, end, _way_across(begin, end, ends, entry[row], exit_[row]))
    found = np.flatnonzero((lengths(turned) > 0) & (smallest_radius(turned) >= U_TURN_RADIUS * (1 - 1e-9)))
    return replace_curves(plan, row[found], turned, found)


def _axis(begin: Poses, end: Poses) -> FloatArray:
    """Return the heading between that of the start and the opposite of that of the end, (n,), rad."""
    return begin[2] + wrapped(end[2] - begin[2] - np.pi) / 2


def lanes_apart(begin: Poses, end: Poses) -> FloatArray:
    """Return how far the ends of turns back are apart across the axis between their headings, (n,), m."""
    axis = _axis(begin, end)
    return np.asarray(np.abs((end[1] - begin[1]) * np.cos(axis) - (end[0] - begin[0]) * np.sin(axis)))


def _way_across(begin: Poses, end: Poses, ends: StreetEnds, entry: IntArray, exit_: IntArray) -> FloatArray:
    """Return how far ahead of the start the first nodes of the junction lie on either arm, (n,), m.

    Arms that meet at one node lie on each other there: they have none.
    """
    axis = _axis(begin, end)
    ahead = np.full(len(entry), -np.inf)
    for arm in (entry, exit_):
        x, y, _ = outward_pose(ends, arm, np.zeros(len(arm)))
        ahead = np.maximum(ahead, (x - begin[0]) * np.cos(axis) + (y - begin[1]) * np.sin(axis))
    return np.where(ends.node[entry] == ends.node[exit_], -np.inf, ahead)


def turned_back(
    begin: Poses,
    end: Poses,
    across: FloatArray,
    least: float | FloatArray = U_TURN_RADIUS,
    swing: FloatArray | None = None,
) -> PlanView:
    """Return curves that go on to where both poses are abreast, turn there, and go back; none where they cannot.

    `across` is how far ahead of the start, m, the way across lies (-inf: there is none), `least` the smallest radius,
    m, both (n,). With `swing`, (n,), m, they have that radius where they swing out, on both sides.
    """
    (x0, y0, h0), (x1, y1, h1) = begin, end
    axis = _axis(begin, end)
    stagger = (x1 - x0) * np.cos(axis) + (y1 - y0) * np.sin(axis)
    apart = lanes_apart(begin, end)
    abreast = np.maximum(stagger, 0.0)
    room = np.clip(across - abreast, 0.0, U_TURN_RADIUS_MAX + _FARTHEST)
    radius = np.minimum(SHARE_OF_HALF * apart / 2, np.maximum(room, least))
    radius = np.maximum(np.minimum(radius, U_TURN_RADIUS_MAX), least)
    before = abreast + np.clip(room - radius, 0.0, _FARTHEST)
    after = before - stagger
    straight = np.zeros(len(before))
    begin = (*advance(x0, y0, h0, straight, before)[:2], h0)
    end = (*advance(x1, y1, h1, straight, -after)[:2], h1)
    pieces, curvature = np.zeros((len(before), 5)), np.zeros((len(before), 5))
    pieces[:, 0], pieces[:, 4] = before, after
    turn = dubins_without_slivers(*begin, *end, radius=radius)
    count = np.diff(turn.start)
    owner = repeated(count)
    place = 1 + np.arange(len(owner)) - turn.start[owner]
    pieces[owner, place], curvature[owner, place] = turn.length, turn.curvature
    if swing is not None:
        pieces[:, 1:4], curvature[:, 1:4] = _swing_on_both_sides(begin, end, radius, swing)
        pieces[~np.isfinite(pieces).all(axis=1)] = 0.0
        return chain_curves(curves_of(x0, y0, h0, pieces, curvature), np.arange(len(before) + 1))
    close = np.flatnonzero((SHARE_OF_HALF * apart / 2 < radius) & (apart >= _APART_FOR_ONE_SWING))
    arcs, bends = _swing_before(_chosen(begin, close), _chosen(end, close), radius[close])
    driven = np.isfinite(arcs).all(axis=1)
    pieces[close[driven], 1:4], curvature[close[driven], 1:4] = arcs[driven], bends[driven]
    pieces[~pieces[:, 1:4].any(axis=1)] = 0.0
    # A turn that ends in a line goes on in that after it: checkers call two records redundant.
    plan = curves_of(x0, y0, h0, pieces, curvature)
    return chain_curves(plan, np.arange(len(before) + 1))


def _chosen(poses: Poses, row: IntArray) -> Poses:
    x, y, hdg = poses
    return x[row], y[row], hdg[row]


def _side(begin: Poses, end: Poses) -> FloatArray:
    """Return 1 where the end lies to the left of the start, else -1."""
    (x0, y0, h0), (x1, y1, _) = begin, end
    return np.where((y1 - y0) * np.cos(h0) - (x1 - x0) * np.sin(h0) > 0, 1.0, -1.0)


def _swing_on_both_sides(
    begin: Poses, end: Poses, radius: FloatArray, swing: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return lengths and curvatures, (n, 3), of curves that swing out, turn back, and swing in again.

    Lengths are not finite where there is none.
    """
    (x0, y0, h0), (x1, y1, h1) = begin, end
    side, axis = _side(begin, end), _axis(begin, end)
    # The circle of the turn touches those of both swings, and lies ahead of them.
    ax, ay = x0 + side * swing * np.sin(h0), y0 - side * swing * np.cos(h0)
    bx, by = x1 + side * swing * np.sin(h1), y1 - side * swing * np.cos(h1)
    dx, dy = (bx - ax) / 2, (by - ay) / 2
    half = np.hypot(dx, dy)
    with np.errstate(invalid="ignore", divide="ignore"):
        ahead = np.sqrt((radius + swing) ** 2 - half**2) / half
    ahead *= np.where(dx * np.sin(axis) > dy * np.cos(axis), 1.0, -1.0)
    x, y = ax + dx - ahead * dy, ay + dy + ahead * dx
    first, last = (np.arctan2(y - cy, x - cx) - side * np.pi / 2 for cx, cy in ((ax, ay), (bx, by)))
    out, back = wrapped(side * (h0 - first)), wrapped(side * (last - h1))
    length = np.column_stack([swing * out, radius * ((side * (last - first)) % (2 * np.pi)), swing * back])
    length[(out < 0) | (back < 0)] = np.nan
    return length, np.column_stack([-side / swing, side / radius, -side / swing])


def _swing_before(begin: Poses, end: Poses, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lengths and curvatures, (n, 3), of curves that swing out, turn back, and run straight to their end.

    Lengths are not finite where there is none.
    """
    (x0, y0, h0), (x1, y1, h1) = begin, end
    side = _side(begin, end)
    # The circle of the turn touches the lane at the end and the circle of the swing, which is about 0. It is about x,
    # y before it is moved back by the straight piece.
    x = x1 - x0 - side * radius * (np.sin(h1) + np.sin(h0))
    y = y1 - y0 + side * radius * (np.cos(h1) + np.cos(h0))
    along = x * np.cos(h1) + y * np.sin(h1)
    with np.errstate(invalid="ignore"):
        straight = along + np.sqrt(along**2 - x**2 - y**2 + 4 * radius**2)
    bearing = np.arctan2(y - straight * np.sin(h1), x - straight * np.cos(h1))
    touching = bearing - side * np.pi / 2
    swing = wrapped(side * (h0 - touching))
    turn = (side * (h1 - touching)) % (2 * np.pi)
    length = np.column_stack([radius * swing, radius * turn, straight])
    length[(swing < 0) | (straight < 0)] = np.nan
    return length, np.column_stack([-side / radius, side / radius, np.zeros(len(side))])
