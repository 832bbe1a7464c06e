"""Connecting roads that turn back: the way with the least tarmac of its own is taken.

A car that turns back keeps to what is paved for others: it turns round the nose between the arms, and where their
lanes are closer than its turning circle it swings out before the turn, after it, or both. Ways of one kind are laid
out at places along and across the arms, each costs what it needs of ground that no other way paves, and the cheapest
wins. What a way costs also counts its length, how sharp it is, and whether it meets the way back.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    advance,
    arccosine,
    chain_curves,
    chosen_curves,
    cosine,
    cosine_sine,
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
    sine,
    slope_of,
    smallest_radius,
    sorted_unique,
    starts,
    wrapped,
)
from osm2xodr.defaults import CONNECTING_RADIUS, LEAST_TURN_BACK, MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import NEAR_ENDS, OWN_TARMAC, PAVEMENT_CELL
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.turn_back_ways import (
    SQUARE_BITS,
    cheapest_way,
    cost_of_ground,
    cost_of_meeting,
    own_tarmac,
    places_on_way,
    rounded,
    squares_across,
)
from osm2xodr.geometry.defaults import U_TURN_RADIUS, U_TURN_RADIUS_MAX
from osm2xodr.geometry.junctions import JunctionLayout
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Places that are tried: the middle of the turning circle lies ahead of both ends by up to this, m, at this spacing,
# and at so many places across, from a swing before the turn alone to one after it alone. Choices.
_FARTHEST: Final = 18.0
_SPACING: Final = 1.5
_ACROSS: Final = 5
# Ways are compared with the ground at so many places along them.
_ALONG: Final = 24
# What ways cost, m² of tarmac, beside what `turn_back_ways` says: each metre of length, and beyond that of a balloon;
# each rad that they swing out and back; each metre that the turn is sharper than `U_TURN_RADIUS`.
# Choices: nobody drives 20 m farther to spare 2 m² of tarmac.
_PER_LENGTH: Final = 0.25
_LONGEST: Final = 38.0
_PER_LENGTH_BEYOND: Final = 30.0
_PER_SWING: Final = 1.5
_PER_SHARPNESS: Final = 48.0
# Radii that are tried, m: of a car that others turn round, of most, and of one with care.
_RADII: Final = (7.5, U_TURN_RADIUS_MAX, 5.0, U_TURN_RADIUS, 3.5, CONNECTING_RADIUS)
# An arc across the whole distance of two lanes is left this share of it for lanes that are not quite parallel.
_SHARE_OF_HALF: Final = 0.96
_ROUNDS: Final = 3
# Ways back are balloons if they are longer than this, m, and turn forth and back by more than this, rad. Choices.
_BALLOON: Final = 40.0
_SWINGS: Final = 0.1


def turn_back_rows(connecting: ConnectingRoads) -> IntArray:
    """Return the roads of cars that end in about the opposite of their first heading, but for loops, (k,)."""
    turn = np.abs(heading_change(connecting.plan_view, np.arange(len(connecting.length))))
    found = (turn >= LEAST_TURN_BACK) & connecting.for_vehicles() & (connecting.entry != connecting.exit)
    return np.flatnonzero(found)


def lanes_apart(begin: Poses, end: Poses) -> FloatArray:
    """Return how far the ends of turns back are apart across the axis between their headings, (n,), m."""
    axis = begin[2] + wrapped(end[2] - begin[2] - np.pi) / 2
    return np.asarray(np.abs((end[1] - begin[1]) * cosine(axis) - (end[0] - begin[0]) * sine(axis)))


def draw_turns_back(connecting: ConnectingRoads, ends: StreetEnds, layout: JunctionLayout) -> ConnectingRoads:
    """Return the roads with those that turn back drawn so that they need the least tarmac of their own."""
    rows = turn_back_rows(connecting)
    if not len(rows):
        return connecting
    ground, plan = _Ground(connecting, rows, ends, layout), connecting.plan_view
    turns, number = chosen_curves(plan, rows), {row: k for k, row in enumerate(rows.tolist())}
    partner = {}
    for one, other in zip(*(side.tolist() for side in connecting.there_and_back()), strict=True):
        partner[one], partner[other] = other, one
    begin, end = curve_ends(plan, rows)
    start = np.column_stack(begin)
    first, length, curvature = _pieces(begin, end)
    turn = length * curvature
    sharpest = np.abs(np.where(length > 0.0, curvature, 0.0)).max(axis=1, initial=1e-9)
    bounds = _cost(length.sum(axis=1), 1.0 / sharpest, np.abs(turn).sum(axis=1) - np.abs(turn.sum(axis=1)))
    order = np.lexsort((np.round(bounds, 6), owners(first)))
    length, curvature, bounds = length[order], curvature[order], bounds[order]
    known, scratch = np.full(len(bounds), -1.0), np.empty((3, _ALONG))
    # Those that are there already, and where they run, but near their ends.
    own = ground.own_tarmac(turns, rows)
    costs = _cost(lengths(turns), smallest_radius(turns), _swing(turns)) + np.array([cost_of_ground(v) for v in own])
    drawn, now = _places(turns, 2 * _ALONG, NEAR_ENDS), _places(turns, _ALONG, NEAR_ENDS)
    # What comes back without turning back stays.
    others = np.array([partner[row] for row in number if row in partner and partner[row] not in number], np.int64)
    stays = dict(zip(others.tolist(), _places(plan, 2 * _ALONG, NEAR_ENDS, others)[:, :2], strict=True))
    nothing = np.zeros((2, 0))
    # Two that turn round the same nose are chosen in turns, the inner one first.
    chosen: dict[int, int] = {}
    for _ in range(_ROUNDS):
        for k in np.lexsort((rows, lanes_apart(begin, end))).tolist():
            back = partner.get(int(rows[k]), -1)
            other = number.get(back, -1)
            if k in chosen and other not in chosen:
                continue
            beside = drawn[other, :2] if other in chosen else stays.get(back, nothing)
            best = rounded(costs[k] + (cost_of_meeting(now[k], beside) if beside.size else 0.0))
            part = slice(int(first[k]), int(first[k + 1]))
            some = length[part], curvature[part]
            given = *some, bounds[part], known[part], *ground.of(int(rows[k])), beside, scratch
            way = cheapest_way(best, start[k], *given)
            if way >= 0:
                places_on_way(start[k], *some, way, NEAR_ENDS, drawn[k])
            elif chosen.get(k, -1) >= 0:
                drawn[k] = _places(turns, 2 * _ALONG, NEAR_ENDS, np.array([k]))[0]
            chosen[k] = way + part.start if way >= 0 else -1
    ways = np.array([chosen[k] for k in range(len(rows))], np.int64)
    moved = np.flatnonzero(ways >= 0)
    # Lines that go on as lines become one record: checkers call two redundant.
    x, y, hdg = (column[moved] for column in begin)
    curves = curves_of(x, y, hdg, length[ways[moved]], curvature[ways[moved]])
    new = chain_curves(curves, np.arange(len(curves.start)))
    plan = replace_curves(plan, rows[moved], new, np.arange(len(moved)))
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


def needs_own_tarmac(connecting: ConnectingRoads, ends: StreetEnds, layout: JunctionLayout) -> BoolArray:
    """Say which roads turn back over ground that no street or other way through their junction paves, (n,)."""
    rows = turn_back_rows(connecting)
    out = np.zeros(len(connecting.length), bool)
    if len(rows):
        ground = _Ground(connecting, rows, ends, layout)
        out[rows] = ground.own_tarmac(chosen_curves(connecting.plan_view, rows), rows) > OWN_TARMAC
    return out


class _Ground:
    """The squares that streets within junctions pave, and the ways through these, but those that turn back."""

    def __init__(self, connecting: ConnectingRoads, back: IntArray, ends: StreetEnds, layout: JunctionLayout) -> None:
        self._connecting = connecting
        there = np.isin(connecting.junction, connecting.junction[back]) & ~connecting.beside_cars()
        there[back] = False
        rows = np.flatnonzero(there)
        length = lengths(connecting.plan_view, rows)
        count = np.maximum((length / (0.9 * PAVEMENT_CELL)).astype(np.int64), 1) + 1
        of = repeated(count)
        share = ranks(count) / (count - 1)[of]
        places = np.stack(pose(connecting.plan_view, rows[of], share * length[of]))
        width = connecting.entry_width[rows][of] * (1 - share) + connecting.exit_width[rows][of] * share
        lanes = _squares(connecting.junction[rows][of], places, width)
        streets = _squares(*_carriageways(sorted_unique(connecting.junction[back]), ends, layout))
        self._paved = sorted_unique(np.concatenate([lanes, streets]))
        # Those of each junction.
        junctions = np.arange(connecting.junction.max(initial=-1) + 2)
        self._first = np.searchsorted(self._paved, junctions << SQUARE_BITS).tolist()

    def of(self, row: int) -> tuple[float, float, int, IntArray]:
        """Return widths at the start and the end of a road, m, its junction, and the squares that are paved."""
        item, junction = self._connecting, int(self._connecting.junction[row])
        paved = self._paved[self._first[junction] : self._first[junction + 1]]
        return float(item.entry_width[row]), float(item.exit_width[row]), junction, paved

    def own_tarmac(self, plan: PlanView, rows: IntArray) -> FloatArray:
        """Return how much ground the curves of some roads need that nothing else paves, (n,), m²."""
        places, length = _places(plan, _ALONG, 0.5 / _ALONG), lengths(plan).tolist()
        return np.array([own_tarmac(places[k], length[k], *self.of(row)) for k, row in enumerate(rows.tolist())])


def _squares(junction: IntArray, places: FloatArray, width: FloatArray) -> IntArray:
    """Return the squares of junctions that lanes of a width, m, pave across some poses, (n,), (3, n) and (n,)."""
    steps = np.linspace(-0.5, 0.5, 1 + int(np.ceil(width.max(initial=1.0) / (0.9 * PAVEMENT_CELL))))
    out = np.empty((len(junction), len(steps)), np.int64)
    squares_across(junction, places, width, steps, out)
    return out.ravel()


def _carriageways(
    junctions: IntArray, ends: StreetEnds, layout: JunctionLayout
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return places along the carriageways of all streets in junctions: the junction, pose and width, m, of each."""
    of_node = [(node, junction) for junction in junctions.tolist() for node in layout.nodes[junction]]
    junction = np.full(ends.node.max(initial=0) + 2, -1)  # By node; the last one stands for none
    junction[[node for node, _ in of_node]] = [number for _, number in of_node]
    end = np.flatnonzero(junction[ends.node] >= 0)
    reach = np.where(layout.inner[end // 2], ends.length[end], layout.trim[end])
    count = (reach / (0.9 * PAVEMENT_CELL)).astype(np.int64) + 2
    of = repeated(count)
    u = (ranks(count) / (count - 1)[of]) * reach[of]
    end, at_end = end[of], end[of] % 2 == 1
    x, y, hdg = pose(ends.plan_view, end // 2, np.where(at_end, ends.length[end] - u, u))
    hdg = hdg + np.where(at_end, np.pi, 0.0)
    middle = (ends.left + ends.right)[end] / 2
    places = np.stack([x - middle * sine(hdg), y + middle * cosine(hdg), hdg])
    return junction[ends.node[end]], places, (ends.left - ends.right)[end]


def _places(plan: PlanView, count: int, margin: float, curves: IntArray | None = None) -> FloatArray:
    """Return poses at even steps along curves, but for a share at their ends, (curves, 3, count)."""
    curves = np.arange(len(plan.start) - 1) if curves is None else curves
    s = lengths(plan, curves)[:, None] * np.linspace(margin, 1.0 - margin, count)
    return np.stack(pose(plan, np.repeat(curves, count), s.ravel())).reshape(3, -1, count).transpose(1, 0, 2).copy()


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
    low = y[row] + slope_of(back)[row] * (cx - x[row]) - radius / cosine(back)[row]
    some = low <= radius
    row, cx, r, low = (np.repeat(column[some], _ACROSS) for column in (row, cx, radius, low))
    cy = low + (r - low) * np.tile(np.linspace(0.0, 1.0, _ACROSS), int(some.sum()))
    along, beside = _seen_along(back[row], cx - x[row], cy - y[row])
    out, into = (arccosine(np.clip((v + r) / (2 * r), -1.0, 1.0)) for v in (cy, -beside))
    before, after = cx - 2 * r * sine(out), along - 2 * r * sine(into)
    good = (before >= 0.0) & (after >= 0.0) & (out + into < MOST_SWING_BACK / 2)
    length = np.column_stack([before, r * out, r * (np.pi + back[row] + out + into), r * into, after])[good]
    return row[good], length, np.array([0.0, -1.0, 1.0, -1.0, 0.0]) / r[good][:, None]


def _seen_along(hdg: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return coordinates in frames with these headings."""
    cos, sin = cosine_sine(hdg)
    return x * cos + y * sin, y * cos - x * sin


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
