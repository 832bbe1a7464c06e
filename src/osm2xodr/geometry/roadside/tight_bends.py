"""Strips inside tight bends end where those of both legs meet, as at the inner corner of a sidewalk."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from osm2xodr.curves import cosine, owners, pose, ranks, repeated, sharpest_curvature, sine
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strips import Margins, Notch
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Bends of larger radii have room inside for any strips, m.
_GENTLE_RADIUS: Final = 60.0
# Strips may be wider than their room by this, m: the step in which widths are cut.
_ROOM_TOLERANCE: Final = 0.01
# How far before and behind a bend its strips may meet those of the other leg, m, and the step in which this is looked
# at, m: a strip of 3 m in a bend of 120 degrees needs 5 m.
_LEG_REACH: Final = 8.0
_LEG_STEP: Final = 0.25
# Slopes of the outer edge where a strip gets narrower: a flatter one takes too long, none is steeper. Choices.
_FLATTEST: Final = 0.2
_STEEPEST: Final = 4.0
# How much more room than the least strips may have where they are as narrow as that, m, tried one after the other.
_ABOVE_NARROWEST: Final = (0.05, 0.1, 0.2, 0.4)
# Records closer to each other make one bend, m.
_ONE_BEND: Final = 1.0
# What stays as it is at the ends of roads, m: there strips meet those of junctions.
_CLEAR_OF_ENDS: Final = 0.5


class TightBend(NamedTuple):
    """A record of a plan view that bends so much that strips inside of it may fold over themselves."""

    road: int
    # s on the road, m
    start: float
    end: float
    side: int  # The inside: 1 left, -1 right
    edge: float  # How far the carriageway's edge is from the reference line there, m
    room: float  # How far strips may reach beyond it, m


def tight_bends(
    parts: RoadParts, first: IntArray, left: FloatArray, right: FloatArray, with_any: BoolArray
) -> list[TightBend]:
    """Return the bends inside which strips might fold over themselves.

    `left` and `right` are t of the carriageway's edges in all stretches, m; those of a road begin at its `first`
    (roads + 1,). Only roads `with_any` strips count.
    """
    plan = parts.plan_view
    owner = owners(plan.start)
    sharpest = sharpest_curvature(plan)
    bent = np.flatnonzero((np.abs(sharpest) > 1.0 / _GENTLE_RADIUS) & with_any[owner])
    inside = np.sign(sharpest[bent])
    # Lanes of neighbouring stretches reach into a bend with their tapers.
    every = [first[owner[bent]], first[owner[bent] + 1]]
    edge = np.where(inside > 0, _widest(left, *every), _widest(-right, *every))
    room = 1.0 / np.abs(sharpest[bent]) - defaults.CORNER_EDGE_RADIUS - edge
    end = plan.s[bent] + plan.length[bent]
    columns = (owner[bent], plan.s[bent], end, inside.astype(np.int64), edge, room)
    return [TightBend(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def _widest(edge: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return the largest of the edges from each index `first` up to `last`, excluded, (n,)."""
    if not len(first):
        return np.zeros(0)
    return np.asarray(np.maximum.reduceat(np.append(edge, -np.inf), np.column_stack([first, last]).ravel())[0::2])


def notches_in(
    parts: RoadParts, bends: Sequence[TightBend], margins: Sequence[Margins]
) -> tuple[dict[int, list[Notch]], list[TightBend]]:
    """Return the notches that bends leave in the strips inside of them, by road, and the bends that need more.

    These are so tight that even the carriageway's edge folds, or too close to a road's end.
    """
    narrow = _joined([bend for bend in bends if _width(margins[bend.road], bend) > bend.room + _ROOM_TOLERANCE])
    notches: dict[int, list[Notch]] = {}
    others: list[TightBend] = []
    for bend, (s, reach) in zip(narrow, _reaches(parts, narrow), strict=True):
        width = _width(margins[bend.road], bend)
        notch = _notch(bend, width, s, reach)
        before, after = (0.0, 0.0) if notch is None else notch.extent(width)
        if notch is None or before < _CLEAR_OF_ENDS or after > float(parts.length[bend.road]) - _CLEAR_OF_ENDS:
            others.append(bend)
        else:
            notches.setdefault(bend.road, []).append(notch)
    return notches, others


def _joined(bends: Sequence[TightBend]) -> list[TightBend]:
    """Join records that follow each other to bends as tight as the tightest of them."""
    out: list[TightBend] = []
    for item in bends:
        if out and (out[-1].road, out[-1].side) == (item.road, item.side) and item.start - out[-1].end < _ONE_BEND:
            item = item._replace(start=out[-1].start, room=min(out[-1].room, item.room))
            out.pop()
        out.append(item)
    return out


def _width(beside: Margins, bend: TightBend) -> float:
    """Return how far strips reach beyond the carriageway's edge inside a bend and around it, m."""
    lo, hi = bend.start - _LEG_REACH, bend.end + _LEG_REACH
    return max((item.width(bend.side) for item in beside if item.start < hi and item.end > lo), default=0.0)


def _notch(bend: TightBend, width: float, s: FloatArray, reach: FloatArray) -> Notch | None:
    """Return the notch of a bend; None if its legs leave too little room for longer than strips may be narrow."""
    if bend.room < -defaults.CORNER_EDGE_RADIUS:
        return None
    room, inside = max(bend.room, 0.0), (s >= bend.start) & (s <= bend.end)
    found = [Notch(bend.side, bend.start, bend.end, room, *_slopes(s, reach, width, bend.start, bend.end, room))]
    # Where the curvature grows, the narrowest place is shorter than the bend.
    for more in _ABOVE_NARROWEST if inside.any() else ():
        places = s[inside & (reach <= np.min(reach[inside]) + more)]
        # It may reach as far as the next places: an arc of less than a metre has few of them.
        step = float(s[1] - s[0])
        start, end = max(float(places[0]) - step, bend.start), min(float(places[-1]) + step, bend.end)
        found.append(Notch(bend.side, start, end, room, *_slopes(s, reach, width, start, end, room)))
    good = [item for item in found if min(item.before, item.after) >= _FLATTEST]
    return min(good, key=lambda item: _lost(item, width), default=None)


def _slopes(
    s: FloatArray, reach: FloatArray, width: float, start: float, end: float, room: float
) -> tuple[float, float]:
    """Return how steeply strips may get wider from a room that they have from start to end, before and behind it."""
    tight = reach < width
    slopes = []
    for away in (start - s, s - end):
        near = tight & (away > 0.0)
        slopes.append(float(np.min((reach[near] - room) / away[near], initial=_STEEPEST)))
    return slopes[0], slopes[1]


def _lost(notch: Notch, width: float) -> float:
    """Return the area that strips of a width lose in a notch, m2."""
    begin, end = notch.extent(width)
    return 0.5 * (width - notch.room) * (end - begin + notch.end - notch.start)


def _reaches(parts: RoadParts, bends: Sequence[TightBend]) -> list[tuple[FloatArray, FloatArray]]:
    """Return places in and around bends, s, m, and how far strips there may reach beyond the carriageway's edge, m.

    That is the radius of the largest circle that touches the edge there from outside and has no other place of the
    edge inside, without the radius that edges of strips keep.
    """
    if not bends:
        return []
    road, start, end, side, edge, _ = (np.array(column) for column in zip(*bends, strict=True))
    lo = np.maximum(start - _LEG_REACH, 0.0)
    hi = np.minimum(end + _LEG_REACH, parts.length[road])
    count = np.ceil((hi - lo) / _LEG_STEP).astype(np.int64) + 1
    bend = repeated(count)
    s = lo[bend] + ranks(count) * ((hi - lo) / (count - 1))[bend]
    x, y, hdg = pose(parts.plan_view, road[bend], s)
    normal = side[bend, None] * np.column_stack([-sine(hdg), cosine(hdg)])
    places = np.column_stack([x, y]) + edge[bend, None] * normal
    borders = np.cumsum(count)[:-1]
    parted = zip(*(np.split(array, borders) for array in (s, places, normal)), strict=True)
    return [(own, _empty_radius(at, inwards) - defaults.CORNER_EDGE_RADIUS) for own, at, inwards in parted]


def _empty_radius(places: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the radius of the largest circle on the normal through each place with no other place in it, (n,), m."""
    away = places[None, :, :] - places[:, None, :]
    ahead = np.einsum("ijk,ik->ij", away, normal)
    # |c - p| = r and |c - q| >= r, with c = p + r n.
    radius = np.where(
        ahead > defaults.SAME_PLACE, (away**2).sum(2) / np.maximum(2.0 * ahead, defaults.SAME_PLACE), np.inf
    )
    return np.asarray(radius.min(axis=1))
