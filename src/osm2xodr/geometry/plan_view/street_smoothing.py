"""Curves of streets become those of continuous curvature, in chains through intersections (docs/method/plan_view.md).

Corners that cannot become smooth stay lines and arcs; what lies on both sides of them becomes smooth.

Streets that go on straight through intersections become smooth as one curve.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    arctan2,
    chain_curves,
    chosen_curves,
    cosine,
    cut_curves,
    find_record,
    join_tables,
    lengths,
    owners,
    pose,
    repeated,
    replace_curves,
    reverse_curves,
    runs,
    sine,
    smallest_radius,
    snap_cuts,
    stack_plan_views,
    sum_before,
    wrapped,
)
from osm2xodr.geometry.plan_view.smooth_curves import NOWHERE, OnCurves, SmoothCurves, smooth_curves
from osm2xodr.geometry.plan_view.streets import FittedStreets
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, PlanView, StreetNetwork
from osm2xodr.system import record

# Shorter curves stay lines and arcs, m. A choice.
_SHORTEST_CURVE: Final = 8.0
# Rounds in which corners that cannot become smooth are left out, and how far such a corner reaches to both sides, m,
# at least; if it begins or ends in an arc no longer than twice that, as far as this. Choices.
_CORNER_ROUNDS: Final = 5
_CORNER_REACH: Final = 8.0
# A corner does not end as near as this to an intersection, where headings may step, m.
_OFF_NODES: Final = 0.3
# Rounds in which the place nearest to an intersection is found, in steps of at most this, m. Numerics.
_FOOT_ROUNDS: Final = 3
_FOOT_STEP: Final = 2.0

# Places on an old and the new curve, m, by the index of the curve.
Places = dict[int, tuple[FloatArray, FloatArray]]
# A street goes on in another if it bends by less there, rad (30 degrees), from and to the places that lie this far
# from the intersection, m. Choices.
_LEAST_CORNER: Final = 0.52
_LEAD: Final = 10.0
# So much bend, rad, outweighs that names or classes differ. A choice.
_OTHER_ROAD: Final = 0.2
# Branches whose bends differ by less are alike, rad (1 degree). A choice.
_ALIKE: Final = 0.02


@record(eq=False)
class Parts(Table):
    """Parts of curves, curve after curve from start to end."""

    curve: IntArray  # (parts,) Index of the curve
    # (parts,) Where on it they begin and end, m
    lo: FloatArray
    hi: FloatArray
    held: BoolArray  # (parts, 2) Whether its ends keep their heading
    tried: BoolArray  # (parts,) Whether it became too sharp once, with few knots

    @classmethod
    def whole(cls, plan: PlanView, held: BoolArray) -> Parts:
        """Return the whole curves of a plan, whose ends keep their heading or not, (curves, 2)."""
        n = len(held)
        return cls(np.arange(n), np.zeros(n), lengths(plan), held, np.zeros(n, bool))


def smooth_streets(
    network: StreetNetwork, fitted: FittedStreets, *, chained: bool = True, jobs: int = 1
) -> FittedStreets:
    """Return the streets with curves of continuous curvature; straight ones and rings that are one curve stay.

    Streets that go on straight through intersections become smooth as one if they are `chained`; else each is the
    same whatever lies beyond its ends. So many processes work at once.
    """
    closed = np.array([street.start < 0 for street in network.streets], bool)
    chains = chain_streets(network, fitted.plan_view, ~fitted.on_ring, chained=chained)
    plan = chains.curves(fitted.plan_view)
    bends = np.isfinite(smallest_radius(plan)) | (np.diff(chains.first) > 1)
    rows = np.flatnonzero(bends & (lengths(plan) > _SHORTEST_CURVE))
    if not len(rows):
        return fitted
    begin, owner = chains.place_of(fitted.plan_view), owners(chains.first)
    place = np.full(len(plan.start) - 1, -1, np.int64)
    place[rows] = np.arange(len(rows))
    inner = np.flatnonzero((begin > 0.0) & (place[owner] >= 0))
    held = np.repeat(closed[chains.street[chains.first[rows]]], 2).reshape(-1, 2)
    old = chosen_curves(plan, rows)
    new, places = smooth_parts(old, Parts.whole(old, held), (place[owner[inner]], begin[inner]), jobs)
    streets = np.flatnonzero(place[owner] >= 0)
    return _cut_into_streets(fitted, chains, streets, place[owner[streets]], new, places)


def smooth_parts(plan: PlanView, parts: Parts, nodes: OnCurves, jobs: int = 1) -> tuple[PlanView, Places]:
    """Return curves that are smooth but for corners that cannot be, and places on the old and the new ones."""
    finished: list[tuple[Parts, PlanView]] = []
    ways: dict[tuple[int, float], tuple[FloatArray, FloatArray]] = {}
    todo, corners = parts, NOWHERE
    for number in range(_CORNER_ROUNDS + 1):
        short = (todo.hi - todo.lo <= _SHORTEST_CURVE) | (number == _CORNER_ROUNDS)
        kept, todo = todo.chosen(short), todo.chosen(~short)
        finished.append((kept, cut_curves(plan, kept.lo, kept.hi, kept.curve)))
        if not len(todo.curve):
            break
        arcs = cut_curves(plan, todo.lo, todo.hi, todo.curve)
        found = smooth_curves(arcs, todo.held, _within(todo, nodes), _within(todo, corners), jobs)
        good = np.flatnonzero(found.good)
        finished.append((todo.chosen(good), chosen_curves(found.plan_view, good)))
        _note_places(todo, found, good, ways)
        bad, worst = todo.chosen(~found.good), found.worst[~found.good]
        corners = np.concatenate([corners[0], bad.curve]), np.concatenate([corners[1], bad.lo + worst])
        corner, rest = _without_corners(plan, bad.chosen(bad.tried), worst[bad.tried], nodes)
        finished.append((corner, cut_curves(plan, corner.lo, corner.hi, corner.curve)))
        todo = replace(bad, tried=np.ones(len(worst), bool)).chosen(~bad.tried).joined(rest)
        todo = todo.chosen(np.lexsort((todo.lo, todo.curve)))
    every = join_tables(item for item, _ in finished)
    order = np.lexsort((every.lo, every.curve))
    every = every.chosen(order)
    table = chosen_curves(stack_plan_views(*(item for _, item in finished)), order)
    first = np.searchsorted(every.curve, np.arange(len(plan.start)))
    return chain_curves(table, first), _places(every, lengths(table), first, ways)


def _within(parts: Parts, nodes: OnCurves) -> OnCurves:
    """Return the part that places on curves lie in, and where along it, m; without those that lie in none."""
    curve, s = nodes
    row = np.searchsorted(parts.curve, np.arange(int(max(curve.max(initial=-1), parts.curve.max(initial=-1))) + 2))
    count = np.diff(row)[curve]
    node = repeated(count)
    part = runs(row[curve], count)
    inside = (parts.lo[part] < s[node]) & (s[node] < parts.hi[part])
    return part[inside], s[node[inside]] - parts.lo[part[inside]]


def _note_places(
    parts: Parts, found: SmoothCurves, good: IntArray, ways: dict[tuple[int, float], tuple[FloatArray, FloatArray]]
) -> None:
    """Note the places of parts that are smooth now."""
    for k in good.tolist():
        row = slice(int(found.first[k]), int(found.first[k + 1]))
        ways[int(parts.curve[k]), float(parts.lo[k])] = found.before[row], found.after[row]


def _without_corners(plan: PlanView, parts: Parts, worst: FloatArray, nodes: OnCurves) -> tuple[Parts, Parts]:
    """Return the corner of each part that cannot become smooth, and what lies on both sides of it."""
    middle = parts.lo + worst
    ends = []
    for sign in (-1.0, 1.0):
        end = middle + sign * _CORNER_REACH
        record = find_record(plan.start, plan.s, parts.curve, end)
        of_record = plan.s[record] + (plan.length[record] if sign > 0 else 0.0)
        bent = (plan.curvature[record] != 0.0) & (np.abs(of_record - middle) <= 2 * _CORNER_REACH)
        end = np.where(bent, of_record, end)
        ends.append(_off_nodes(parts.curve, end, nodes, sign))
    a = np.where(ends[0] - parts.lo > _SHORTEST_CURVE, ends[0], parts.lo)
    b = np.where(parts.hi - ends[1] > _SHORTEST_CURVE, ends[1], parts.hi)
    held = np.ones((len(a), 2), bool)
    before = replace(parts, hi=a, held=np.column_stack([parts.held[:, 0], held[:, 1]]))
    after = replace(parts, lo=b, held=np.column_stack([held[:, 0], parts.held[:, 1]]))
    rest = before.joined(after)
    return replace(parts, lo=a, hi=b), rest.chosen(np.flatnonzero(rest.hi > rest.lo))


def _off_nodes(curve: IntArray, s: FloatArray, nodes: OnCurves, sign: float) -> FloatArray:
    """Return places on curves, (n,), m; those too near to one of the nodes, in order, are moved on or back."""
    out = s.copy()
    begin, end = np.searchsorted(nodes[0], curve), np.searchsorted(nodes[0], curve, side="right")
    for k, (first, last) in enumerate(zip(begin.tolist(), end.tolist(), strict=True)):
        at = nodes[1][first:last]
        near = at[np.abs(at - s[k]) < _OFF_NODES]
        if len(near):
            out[k] = near[0] + sign * _OFF_NODES
    return out


def _places(
    parts: Parts, length: FloatArray, first: IntArray, ways: dict[tuple[int, float], tuple[FloatArray, FloatArray]]
) -> Places:
    """Return places on old and new curves, which consist of parts of some `length`, (parts,), m."""
    begin = sum_before(length, first).tolist()
    rows: dict[int, list[tuple[FloatArray, FloatArray]]] = {}
    for k, (curve, lo, hi) in enumerate(zip(parts.curve.tolist(), parts.lo.tolist(), parts.hi.tolist(), strict=True)):
        found = ways.get((curve, lo))
        before, after = (np.array([0.0, hi - lo]),) * 2 if found is None else found
        rows.setdefault(curve, []).append((before + lo, after + begin[k]))
    # Where two parts meet, rounding must not lead back.
    return {
        curve: (
            np.maximum.accumulate(np.concatenate([a for a, _ in items])),
            np.maximum.accumulate(np.concatenate([b for _, b in items])),
        )
        for curve, items in rows.items()
    }


def _cut_into_streets(
    fitted: FittedStreets, chains: StreetChains, rows: IntArray, curve: IntArray, new: PlanView, places: Places
) -> FittedStreets:
    """Return the streets with parts of the new curves of their chains, cut nearest to their intersections.

    `rows` are those of streets in chains that have changed, all of them, and `curve` (rows,) their new curve.
    """
    plan = fitted.plan_view
    street, back, begin = chains.street[rows], chains.back[rows], chains.place_of(plan)[rows]
    length = lengths(plan)[street]
    first = np.diff(curve, prepend=-1) > 0
    lo = np.zeros(len(rows))
    cut = np.flatnonzero(~first)
    x, y, _ = pose(plan, street[cut], np.where(back[cut], length[cut], 0.0))
    s = np.array([np.interp(begin[k], *places[int(curve[k])]) for k in cut.tolist()])
    for _ in range(_FOOT_ROUNDS):
        # Curves may cross themselves: the nearest place of all may be elsewhere.
        x0, y0, hdg = pose(new, curve[cut], s)
        s = s + np.clip((x - x0) * cosine(hdg) + (y - y0) * sine(hdg), -_FOOT_STEP, _FOOT_STEP)
    lo[cut] = snap_cuts(new, curve[cut], s)
    hi = np.where(np.append(first[1:], True), lengths(new)[curve], np.append(lo[1:], 0.0))
    parts = reverse_curves(cut_curves(new, lo, hi, curve), back, wrap=False)
    pieces = list(fitted.pieces)
    for k, row in enumerate(street.tolist()):
        if len(pieces[row]) == 1:
            continue
        s = np.array([piece[0] for piece in pieces[row]])
        along = begin[k] + (length[k] - s if back[k] else s)
        at = np.interp(along, *places[int(curve[k])]) - lo[k]
        at = np.clip(hi[k] - lo[k] - at if back[k] else at, 0.0, hi[k] - lo[k])
        at[s == 0.0] = 0.0
        pieces[row] = tuple((s, *piece[1:]) for s, piece in zip(at.tolist(), pieces[row], strict=True))
    plan = replace_curves(plan, street, parts, np.arange(len(rows)))
    return replace(fitted, plan_view=plan, pieces=tuple(pieces))


@record(eq=False)
class StreetChains:
    """Rows of streets that go on in each other."""

    first: IntArray  # (chains + 1,) Index of each chain's first street; the last entry is the number of streets
    # (streets of all chains,) Chain after chain
    street: IntArray  # Its id
    back: BoolArray  # Whether the chain runs against it

    def curves(self, plan: PlanView) -> PlanView:
        """Return the curves of chains, by those of streets."""
        return chain_curves(reverse_curves(chosen_curves(plan, self.street), self.back, wrap=False), self.first)

    def place_of(self, plan: PlanView) -> FloatArray:
        """Return how far along its chain each street begins, (streets of all chains,), m."""
        return sum_before(lengths(plan, self.street), self.first)


def chain_streets(network: StreetNetwork, plan: PlanView, which: BoolArray, *, chained: bool = True) -> StreetChains:
    """Return the chains that streets form, of those of `which`, (streets,), alone; else each is one of its own."""
    partner = _partners(network, plan, which) if chained else np.full(2 * len(which), -1, np.int64)
    street: list[int] = []
    first: list[int] = []
    used = ~which
    # From loose ends first; what is left are circles, which begin anywhere.
    ends = np.flatnonzero(np.repeat(which, 2))
    for end in [*ends[partner[ends] < 0].tolist(), *ends[(partner[ends] >= 0) & (ends % 2 == 0)].tolist()]:
        if used[end // 2]:
            continue
        first.append(len(street))
        here = end
        while here >= 0 and not used[here // 2]:
            used[here // 2] = True
            street.append(here)
            here = int(partner[here ^ 1])
    number = np.array(street, np.int64)
    return StreetChains(np.array([*first, len(street)], np.int64), number // 2, number % 2 == 1)


def _partners(network: StreetNetwork, plan: PlanView, which: BoolArray) -> IntArray:
    """Return for each street end that which it goes on in, -1 if it does in none, (ends,).

    Both bend least, of all at their intersection, where they go on in each other.
    """
    streets = network.streets
    end = np.arange(2 * len(streets))
    partner = np.full(len(end), -1, np.int64)
    node = np.array([number for street in streets for number in (street.start, street.end)], np.int64)
    chosen = np.flatnonzero(np.repeat(which, 2) & (node >= 0))
    if not len(chosen):
        return partner
    attributes = [street.attributes_at_end(k) for street in streets for k in (0, 1)]
    roads: dict[tuple[str, str], int] = {}
    road = np.array([roads.setdefault((item.road, item.highway), len(roads)) for item in attributes])
    ways: list[frozenset[Direction]] = []
    for k, item in enumerate(attributes):
        ways.append(ways[-1] if k and item is attributes[k - 1] else item.car_directions())
    along = np.array([Direction.BACKWARD not in item for item in ways], bool)
    against = np.array([Direction.FORWARD not in item for item in ways], bool)
    one_way = along | against
    enters = np.where(end % 2 == 1, ~against, ~along)
    hdg = _headings(plan, end)
    # All pairs of ends at an intersection.
    order = chosen[np.argsort(node[chosen], kind="stable")]
    group = np.flatnonzero(np.diff(node[order], prepend=-1))
    size = np.diff(np.append(group, len(order)))
    one = np.repeat(order, np.repeat(size, size))
    other = order[runs(np.repeat(group, size), np.repeat(size, size))]
    bend = np.abs(wrapped(hdg[one] + np.pi - hdg[other]))
    fits = (bend < _LEAST_CORNER) & (one // 2 != other // 2) & (one_way[one] == one_way[other])
    fits &= ~one_way[one] | (enters[one] != enters[other])
    one, other, cost = one[fits], other[fits], (bend + _OTHER_ROAD * (road[one] != road[other]))[fits]
    ranked = np.lexsort((other, cost, one))
    first = np.diff(one[ranked], prepend=-1) != 0
    # Of two branches that are alike none is the street itself.
    rival = np.append(~first[1:] & (np.diff(cost[ranked]) < _ALIKE), False)
    best = ranked[first & ~rival]
    partner[one[best]] = other[best]
    mutual = partner[partner] == end
    return np.where((partner >= 0) & mutual, partner, -1)


def _headings(plan: PlanView, end: IntArray) -> FloatArray:
    """Return the direction from street ends to places a little along their streets, (n,), rad."""
    length = lengths(plan)[end // 2]
    away = np.minimum(_LEAD, length / 2)
    at_end = end % 2 == 1
    x0, y0, _ = pose(plan, end // 2, np.where(at_end, length, 0.0))
    x1, y1, _ = pose(plan, end // 2, np.where(at_end, length - away, away))
    return np.asarray(arctan2(y1 - y0, x1 - x0))
