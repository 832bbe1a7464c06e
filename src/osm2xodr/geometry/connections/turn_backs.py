"""Connecting roads that turn back: the way with the least tarmac of its own is taken.

A car that turns back keeps to what is paved for others: it turns round the nose between the arms, and where their
lanes are closer than its turning circle it swings out before the turn, after it, or both. Ways of one kind are laid
out at places along and across the arms, each costs what it needs of ground that no other way paves, and the cheapest
wins. What a way costs also counts its length, how sharp it is, and whether it meets the way back.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    advance,
    chain_curves,
    chosen_curves,
    curve_ends,
    curves_of,
    dubins_without_slivers,
    heading_change,
    lengths,
    owners,
    pose,
    ranks,
    record_turns,
    repeated,
    replace_curves,
    smallest_radius,
    sorted_unique,
    stack_plan_views,
    starts,
    wrapped,
)
from osm2xodr.defaults import CONNECTING_RADIUS, LEAST_TURN_BACK, MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.defaults import CAR_WIDTH, U_TURN_RADIUS, U_TURN_RADIUS_MAX
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Places that are tried: the middle of the turning circle lies ahead of both ends by up to this, m, at this spacing,
# and at so many places across, from a swing before the turn alone to one after it alone. Choices.
_FARTHEST: Final = 18.0
_SPACING: Final = 1.5
_ACROSS: Final = 5
# Ways are compared with the ground at so many places along them and across their lanes, and pavement is known by
# squares of this size, m.
_ALONG: Final = 24
_OFFSETS: Final = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
_CELL: Final = 0.5
# What ways cost, m² of tarmac: each m² of their own beyond `_OWN` once more so much; each metre of length, and beyond
# that of a balloon; each rad that they swing out and back; each metre that oncoming cars lack; each metre that
# the turn is sharper than `U_TURN_RADIUS`.
# Choices: nobody drives 20 m farther to spare 2 m² of tarmac.
_PER_OWN_BEYOND: Final = 2.0
_PER_LENGTH: Final = 0.25
_LONGEST: Final = 36.0
_PER_LENGTH_BEYOND: Final = 4.0
_PER_SWING: Final = 1.5
_PER_MEETING: Final = 35.0
_PER_SHARPNESS: Final = 24.0
# Radii that are tried, m: of a car that others turn round, of most, and of one with care.
_RADII: Final = (7.5, U_TURN_RADIUS_MAX, 5.0, U_TURN_RADIUS, 3.5, CONNECTING_RADIUS)
# An arc across the whole distance of two lanes is left this share of it for lanes that are not quite parallel.
_SHARE_OF_HALF: Final = 0.96
# Ways there and back do not meet in this share of their lengths at both ends, and keep this more apart, m.
_MEET: Final = 0.06
_MARGIN: Final = 0.1
_ROUNDS: Final = 3
# So many ways are looked at together.
_AT_ONCE: Final = 32
# Ways back are balloons if they are longer than this, m, and turn forth and back by more than this, rad. Choices.
_BALLOON: Final = 40.0
_SWINGS: Final = 0.1
# A way needs tarmac of its own if it is more than this, m². A choice: the corner of a lane.
_OWN: Final = 10.0


_Pose = tuple[float, float, float]
"""x, y, m, and heading, rad."""


def turn_back_rows(connecting: ConnectingRoads) -> IntArray:
    """Return the roads of cars that end in about the opposite of their first heading, but for loops, (k,)."""
    turn = np.abs(heading_change(connecting.plan_view, np.arange(len(connecting.length))))
    found = (turn >= LEAST_TURN_BACK) & connecting.for_vehicles() & (connecting.entry != connecting.exit)
    return np.flatnonzero(found)


def lanes_apart(begin: Poses, end: Poses) -> FloatArray:
    """Return how far the ends of turns back are apart across the axis between their headings, (n,), m."""
    axis = begin[2] + wrapped(end[2] - begin[2] - np.pi) / 2
    return np.asarray(np.abs((end[1] - begin[1]) * np.cos(axis) - (end[0] - begin[0]) * np.sin(axis)))


def draw_turns_back(connecting: ConnectingRoads) -> ConnectingRoads:
    """Return the roads with those that turn back drawn so that they need the least tarmac of their own."""
    rows = turn_back_rows(connecting)
    if not len(rows):
        return connecting
    ground = _Ground(connecting, rows)
    plan = connecting.plan_view
    partner = np.full(len(connecting.length), -1)
    for one, other in zip(*connecting.there_and_back(), strict=True):
        partner[one], partner[other] = other, one
    begin, end = curve_ends(plan, rows)
    first, length, curvature = _pieces(begin, end)
    ways = {}
    for k, row in enumerate(rows.tolist()):
        part = slice(int(first[k]), int(first[k + 1]))
        now, start = (
            chosen_curves(plan, rows[k : k + 1]),
            (float(begin[0][k]), float(begin[1][k]), float(begin[2][k])),
        )
        ways[row] = _Ways(ground, row, now, start, length[part], curvature[part])
    # Two that turn round the same nose are chosen in turns, the inner one first.
    drawn: dict[int, PlanView] = {}
    for _ in range(_ROUNDS):
        for row in rows[np.lexsort((rows, lanes_apart(begin, end)))].tolist():
            beside = drawn.get(int(partner[row]))
            if row not in drawn or beside is not None:
                drawn[row] = ways[row].cheapest(beside)
    new = stack_plan_views(*(drawn[row] for row in rows.tolist()))
    plan = replace_curves(plan, rows, new, np.arange(len(rows)))
    return replace(connecting, plan_view=plan, length=lengths(plan))


def _swing(plan: PlanView) -> FloatArray:
    """Return how far curves turn forth and back again, (curves,), rad."""
    turn, owner, n = record_turns(plan), owners(plan.start), len(plan.start) - 1
    return np.asarray(np.bincount(owner, np.abs(turn), n) - np.abs(np.bincount(owner, turn, n)))


def balloons(connecting: ConnectingRoads) -> BoolArray:
    """Say which roads swing out to turn back, and are longer than nearly all that cars drive, (n,)."""
    out = np.zeros(len(connecting.length), bool)
    out[turn_back_rows(connecting)] = True
    return out & (connecting.length > _BALLOON) & (_swing(connecting.plan_view) > _SWINGS)


def needs_own_tarmac(connecting: ConnectingRoads) -> BoolArray:
    """Say which roads turn back over ground that no other way through their junction paves, (n,)."""
    rows = turn_back_rows(connecting)
    out = np.zeros(len(connecting.length), bool)
    if len(rows):
        ground = _Ground(connecting, rows)
        for row in rows.tolist():
            own = ground.own_tarmac(row, chosen_curves(connecting.plan_view, np.array([row])))
            out[row] = own[0] > _OWN
    return out


class _Ground:
    """The squares that the ways through junctions pave, but those that turn back."""

    def __init__(self, connecting: ConnectingRoads, back: IntArray) -> None:
        self._connecting = connecting
        there = np.isin(connecting.junction, connecting.junction[back]) & ~connecting.beside_cars()
        there[back] = False
        rows = np.flatnonzero(there)
        length = lengths(connecting.plan_view, rows)
        count = np.maximum((length / (0.9 * _CELL)).astype(np.int64), 1) + 1
        of = repeated(count)
        share = ranks(count) / (count - 1)[of]
        x, y, hdg = pose(connecting.plan_view, rows[of], share * length[of])
        width = connecting.entry_width[rows][of] * (1 - share) + connecting.exit_width[rows][of] * share
        steps = np.linspace(-0.5, 0.5, 1 + int(np.ceil(width.max(initial=1.0) / (0.9 * _CELL))))
        t = width[:, None] * steps
        self._cells = sorted_unique(
            self._keys(
                np.repeat(connecting.junction[rows][of], len(steps)),
                (x[:, None] - t * np.sin(hdg)[:, None]).ravel(),
                (y[:, None] + t * np.cos(hdg)[:, None]).ravel(),
            )
        )

    @staticmethod
    def _keys(junction: IntArray, x: FloatArray, y: FloatArray) -> IntArray:
        """Return a number for each square of a junction; areas are up to 250 km wide."""
        column, line = (np.floor(v / _CELL).astype(np.int64) + 2**19 for v in (x, y))
        return np.asarray((junction << 40) | (column << 20) | line)

    def own_tarmac(self, row: int, ways: PlanView) -> FloatArray:
        """Return how much ground ways need in the place of a road that nothing else paves, (ways,), m²."""
        item, n = self._connecting, len(ways.start) - 1
        length, share = lengths(ways), (np.arange(_ALONG) + 0.5) / _ALONG
        x, y, hdg = pose(ways, np.repeat(np.arange(n), _ALONG), (length[:, None] * share).ravel())
        width = np.tile(item.entry_width[row] * (1 - share) + item.exit_width[row] * share, n)
        t = 0.5 * width[:, None] * _OFFSETS
        keys = self._keys(
            np.full(t.size, item.junction[row]),
            (x[:, None] - t * np.sin(hdg)[:, None]).ravel(),
            (y[:, None] + t * np.cos(hdg)[:, None]).ravel(),
        )
        place = np.minimum(np.searchsorted(self._cells, keys), max(len(self._cells) - 1, 0))
        paved = self._cells[place] == keys if len(self._cells) else np.zeros(len(keys), bool)
        bare = (~paved).reshape(n, _ALONG, -1).mean(axis=2) * width.reshape(n, -1)
        return np.asarray(bare.mean(axis=1) * length)


def _places(plan: PlanView, count: int) -> tuple[FloatArray, FloatArray]:
    """Return x and y of so many places along curves, but near their ends, (curves, count), m."""
    n, share = len(plan.start) - 1, np.linspace(_MEET, 1.0 - _MEET, count)
    x, y, _ = pose(plan, np.repeat(np.arange(n), count), (lengths(plan)[:, None] * share).ravel())
    return x.reshape(n, count), y.reshape(n, count)


def _meeting(x: FloatArray, y: FloatArray, other_x: FloatArray, other_y: FloatArray) -> FloatArray:
    """Return what the distance of places on ways, (ways, k), to those on another one lacks of a car's width, m."""
    square = (x[..., None] - other_x) ** 2 + (y[..., None] - other_y) ** 2
    return np.asarray(np.maximum(CAR_WIDTH + _MARGIN - np.sqrt(square.min(axis=(1, 2))), 0.0))


class _Ways:
    """The ways that may take the place of a road that turns back, the cheapest but for tarmac and meetings first."""

    def __init__(
        self, ground: _Ground, row: int, now: PlanView, begin: _Pose, length: FloatArray, curvature: FloatArray
    ) -> None:
        self._ground, self._row, self._begin = ground, row, begin
        cost = _cost(
            length.sum(axis=1),
            1.0 / np.abs(np.where(length > 0.0, curvature, 0.0)).max(axis=1, initial=1e-9),
            np.abs(length * curvature).sum(axis=1) - np.abs((length * curvature).sum(axis=1)),
        )
        order = np.argsort(np.round(cost, 6), kind="stable")
        self._length, self._curvature, self._bounds = length[order], curvature[order], cost[order]
        # What has been looked at: curves, and what they cost but for meetings.
        self._plans, self._places = [now], [_places(now, _ALONG)]
        self._costs = [_cost(lengths(now), smallest_radius(now), _swing(now)) + self._of_ground(now)]
        self._next = 0

    def cheapest(self, beside: PlanView | None) -> PlanView:
        """Return the way that costs least, with the way back `beside` it."""
        best, found = math.inf, self._plans[0]
        others = (np.zeros((1, 0)),) * 2 if beside is None else _places(beside, 2 * _ALONG)
        for k in itertools.count():
            if k == len(self._plans):
                if self._next == len(self._bounds) or self._bounds[self._next] >= best:
                    return found
                self._look_at_more()
            some = np.flatnonzero(np.round(self._costs[k], 3) < best)
            if not len(some):
                continue
            cost = self._costs[k][some]
            if beside is not None:
                x, y = self._places[k]
                cost = cost + _PER_MEETING * _meeting(x[some], y[some], *others)
            place = int(np.argmin(np.round(cost, 3)))
            if round(float(cost[place]), 3) < best:
                best, found = round(float(cost[place]), 3), chosen_curves(self._plans[k], some[place : place + 1])
        raise AssertionError

    def _look_at_more(self) -> None:
        part = slice(self._next, self._next + _AT_ONCE)
        length, curvature = self._length[part], self._curvature[part]
        x, y, hdg = (np.full(len(length), v) for v in self._begin)
        # Lines that go on as lines become one record: checkers call two redundant.
        curves = curves_of(x, y, hdg, length, curvature)
        plan = chain_curves(curves, np.arange(len(curves.start)))
        self._plans.append(plan)
        self._places.append(_places(plan, _ALONG))
        self._costs.append(self._bounds[part] + self._of_ground(plan))
        self._next = min(part.stop, len(self._bounds))

    def _of_ground(self, plan: PlanView) -> FloatArray:
        own = self._ground.own_tarmac(self._row, plan)
        return np.asarray(own + _PER_OWN_BEYOND * np.maximum(own - _OWN, 0.0))


def _cost(length: FloatArray, radius: FloatArray, swing: FloatArray) -> FloatArray:
    """Return what ways cost by their length, smallest radius, m, and swing, rad, (ways,)."""
    cost = _PER_LENGTH * length + _PER_SWING * swing
    cost += _PER_LENGTH_BEYOND * np.maximum(length - _LONGEST, 0.0)
    return np.asarray(cost + _PER_SHARPNESS * np.maximum(U_TURN_RADIUS - radius, 0.0))


def _pieces(begin: Poses, end: Poses) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return lengths and curvatures, (ways, 5), of ways that turn back from poses to others, and each one's first."""
    # Seen from the start, with the end on the left.
    x, y = _seen_along(begin[2], end[0] - begin[0], end[1] - begin[1])
    side = np.where(y > 0, 1.0, -1.0)
    back = np.asarray(wrapped(side * (end[2] - begin[2]) - np.pi))
    row, length, curvature = _swinging(x, np.abs(y), back)
    others = _straight_on(x, np.abs(y), begin, end)
    row = np.concatenate([row, others[0]])
    length = np.concatenate([length, others[1]])
    curvature = np.concatenate([curvature * side[row[: len(curvature)], None], others[2]])
    order = np.argsort(row, kind="stable")
    return starts(np.bincount(row, minlength=len(x))), length[order], curvature[order]


def _swinging(x: FloatArray, y: FloatArray, back: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return ways to the left that go straight on, swing out, turn, swing in again, and go straight on to the end.

    The ends are ahead of the starts by `x` and beside them by `y`, m, with the opposite heading but for `back`, rad,
    all (n,). Also which of these each way is for.
    """
    row, radius, ahead = np.meshgrid(np.arange(len(x)), _RADII, np.arange(0.0, _FARTHEST, _SPACING), indexing="ij")
    cx = np.maximum(x, 0.0)[row] + ahead
    # Where the circle of the turn touches the line through the end, and where that through the start.
    low = y[row] + np.tan(back)[row] * (cx - x[row]) - radius / np.cos(back)[row]
    some = low <= radius
    row, cx, r, low = (np.repeat(column[some], _ACROSS) for column in (row, cx, radius, low))
    cy = low + (r - low) * np.tile(np.linspace(0.0, 1.0, _ACROSS), int(some.sum()))
    along, beside = _seen_along(back[row], cx - x[row], cy - y[row])
    out, into = (np.arccos(np.clip((v + r) / (2 * r), -1.0, 1.0)) for v in (cy, -beside))
    before, after = cx - 2 * r * np.sin(out), along - 2 * r * np.sin(into)
    good = (before >= 0.0) & (after >= 0.0) & (out + into < MOST_SWING_BACK / 2)
    length = np.column_stack([before, r * out, r * (np.pi + back[row] + out + into), r * into, after])[good]
    return row[good], length, np.array([0.0, -1.0, 1.0, -1.0, 0.0]) / r[good][:, None]


def _seen_along(hdg: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return coordinates in frames with these headings."""
    return x * np.cos(hdg) + y * np.sin(hdg), y * np.cos(hdg) - x * np.sin(hdg)


def _straight_on(x: FloatArray, y: FloatArray, begin: Poses, end: Poses) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return ways that go straight on, turn by the shortest curve, and go straight on to the end, as `_swinging`."""
    half = np.clip(_SHARE_OF_HALF * y / 2, U_TURN_RADIUS, U_TURN_RADIUS_MAX)
    radii = np.column_stack([half, *(np.full(len(y), r) for r in _RADII)])
    tried = (radii >= U_TURN_RADIUS) & (radii < half[:, None])
    tried[:, 0] = True
    of, kind = np.nonzero(tried)
    ahead = np.arange(0.0, _FARTHEST, _SPACING)
    row, radius = np.repeat(of, len(ahead)), np.repeat(radii[of, kind], len(ahead))
    before = np.maximum(x, 0.0)[row] + np.tile(ahead, len(of))
    n, after = len(before), before - x[row]
    (x0, y0, hdg0), (x1, y1, hdg1) = ([column[row] for column in poses] for poses in (begin, end))
    start = (*advance(x0, y0, hdg0, np.zeros(n), before)[:2], hdg0)
    stop = (*advance(x1, y1, hdg1, np.zeros(n), -after)[:2], hdg1)
    turn = dubins_without_slivers(*start, *stop, radius=radius, most_swing=MOST_SWING_BACK)
    pieces, curvature = np.zeros((n, 5)), np.zeros((n, 5))
    pieces[:, 0], pieces[:, 4] = before, after
    count = np.diff(turn.start)
    owner = repeated(count)
    place = 1 + np.arange(len(owner)) - turn.start[owner]
    pieces[owner, place], curvature[owner, place] = turn.length, turn.curvature
    return row[count > 0], pieces[count > 0], curvature[count > 0]
