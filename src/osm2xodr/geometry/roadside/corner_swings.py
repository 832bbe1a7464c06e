"""Sidewalks swing out round the lanes that lie in their way at corners: those of cars that turn back, or wide."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import arctan2, chain_curves, cosine, curve_ends, pose, ranks, repeated, sine, starts
from osm2xodr.geometry.connections import ConnectingRoads, Poses, connect, legs_through
from osm2xodr.geometry.roadside import defaults
from osm2xodr.model import FloatArray, IntArray, PlanView, Rule

# How far out a sidewalk swings at most, and how much farther it keeps from lanes, m. Choices.
_FARTHEST: Final = 8.0
_SLACK: Final = 0.1
# So many lanes one behind the other are looked for. A choice.
_MOST_BEHIND: Final = 6
# Shares of its way at which room is looked for.
_SHARES: Final = np.linspace(0.0, 1.0, 13)[1:-1]
# Places on lanes are so far from each other, m.
_SPACING: Final = 0.8
# It swings out and back by this slope at most. A choice.
_SLOPE: Final = 0.6
# Places through which it is drawn are about so far from each other, m, and not more of them than these. Choices.
_LEG: Final = 3.0
_MOST_LEGS: Final = 7


def swung_out(rows: ConnectingRoads, cars: ConnectingRoads, rule: Rule) -> tuple[IntArray, PlanView]:
    """Return the sidewalks, on curves of their own, that can swing out round lanes, (n,), and the curves they get.

    Whether they are clear, and as smooth as they should be, is not looked at.
    """
    # Away from the carriageway: with right-hand traffic it lies left of the sidewalk's direction.
    outwards = -1.0 if rule is Rule.RIGHT_HAND else 1.0
    room = _room_needed(rows, cars, outwards)
    chosen = np.array([row for row, out in enumerate(room) if out is not None], np.int64)
    if not len(chosen):
        return chosen, rows.plan_view
    passed, count = _places(rows, chosen, [out for out in room if out is not None], outwards)
    begin, end = curve_ends(rows.plan_view, chosen)
    one, other, first = legs_through(begin, passed, end, count)
    return chosen, chain_curves(connect(*one, *other), first)


def _room_needed(rows: ConnectingRoads, cars: ConnectingRoads, outwards: float) -> list[FloatArray | None]:
    """Return how far out each sidewalk is clear of lanes at `_SHARES` of its way, m; None if it is so, or nowhere."""
    at = rows.length[:, None] * _SHARES
    places = pose(rows.plan_view, np.repeat(np.arange(len(at)), len(_SHARES)), at.ravel())
    x, y, hdg = (np.reshape(column, at.shape) for column in places)
    half = np.maximum(rows.entry_width, rows.exit_width) / 2
    half -= np.minimum(defaults.CORNER_ONTO_LANE, half / 2)
    # Places on the lanes of these junctions, one junction after the other.
    lanes = np.flatnonzero(np.isin(cars.junction, rows.junction))
    lanes = lanes[np.argsort(cars.junction[lanes], kind="stable")]
    count = (cars.length[lanes] / _SPACING).astype(np.int64) + 2
    of, share = np.repeat(lanes, count), ranks(count) / np.repeat(count - 1, count)
    cx, cy, _ = pose(cars.plan_view, of, share * cars.length[of])
    wide = np.minimum(cars.entry_width, cars.exit_width)[of] / 2
    first, last = (np.searchsorted(cars.junction[of], rows.junction, side).tolist() for side in ("left", "right"))
    out = []
    for row, near in enumerate(map(slice, first, last)):
        dx, dy = cx[near] - x[row, :, None], cy[near] - y[row, :, None]
        sin, cos = sine(hdg[row])[:, None], cosine(hdg[row])[:, None]
        middle, along = outwards * (dy * cos - dx * sin), dx * cos + dy * sin
        out.append(_beyond_lanes(middle, along, half[row] + wide[near], at[row]))
    return out


def _beyond_lanes(middle: FloatArray, along: FloatArray, reach: FloatArray, s: FloatArray) -> FloatArray | None:
    """Return how far out from places s along a sidewalk, (m,), it is clear of lanes, m; None if it is so, or nowhere.

    Places on lanes, as seen from there, are `middle` outwards and `along` the sidewalk, (m, n), and keep it off by
    `reach`, (n,), m.
    """
    # Each place on a lane covers so much of the lines that lead outwards from the sidewalk.
    depth = np.sqrt(np.maximum(reach**2 - along**2, 0.0))
    begin, end = middle - depth, np.where(depth > 0.0, middle + depth, -np.inf)
    need = np.zeros(len(s))
    for _ in range(_MOST_BEHIND):
        need = np.where(begin <= need[:, None], end, 0.0).max(axis=1, initial=0.0).clip(need)
    if not need.any() or need.max() > _FARTHEST:
        return None
    need[need > 0.0] += _SLACK
    return np.asarray((need[None, :] - _SLOPE * np.abs(s[:, None] - s[None, :])).max(axis=1).clip(0.0))


def _places(
    rows: ConnectingRoads, chosen: IntArray, out: Sequence[FloatArray], outwards: float
) -> tuple[Poses, IntArray]:
    """Return poses that far beside some sidewalks' curves, `out` at `_SHARES` of each, m, and how many on each."""
    length = rows.length[chosen]
    many = np.clip(length / _LEG, 1, _MOST_LEGS).astype(np.int64)
    of = repeated(many)
    s, step = (ranks(many) + 0.5) * length[of] / many[of], (length / (4 * many))[of]
    at, t = np.stack([s - step, s, s + step]), np.empty((3, len(of)))
    for k, (first, last) in enumerate(pairwise(starts(many).tolist())):
        known = np.concatenate([[0.0], _SHARES * length[k], [length[k]]])
        t[:, first:last] = outwards * np.interp(at[:, first:last], known, np.concatenate([[0.0], out[k], [0.0]]))
    places = pose(rows.plan_view, np.tile(chosen[of], 3), at.ravel())
    x, y, hdg = (np.reshape(column, at.shape) for column in places)
    x, y = x - t * sine(hdg), y + t * cosine(hdg)
    return (x[1], y[1], arctan2(y[2] - y[0], x[2] - x[0])), many
