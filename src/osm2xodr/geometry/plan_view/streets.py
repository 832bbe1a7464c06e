"""Streets get their curves and cross-sections, which the rest of the geometry works on.

Bends of streets become wide enough for their carriageways, which would fold over themselves otherwise.

Where a bend is tighter than half of the carriageway is wide, its inner edge runs backwards. OSM's nodes are a metre
or two off, so the line gives way: of the parts that the Dubins curve with the radius that the inner edge needs can
replace, that is replaced for which the line moves least and turns back and forth least.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    chain_curves,
    cut_curves,
    dubins_curves,
    hypot,
    lengths,
    owners,
    pose,
    replace_curves,
    sharpest_curvature,
    snap_cuts,
    sorted_unique,
    stack_plan_views,
    starts,
    unique_first,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import CORNER_RADIUS, CORNER_RADIUS_OTHER, INNER_EDGE_RADIUS, TAPER_LENGTH
from osm2xodr.geometry.lanes import CrossSection, Piece, cross_section, end_lanes
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.polyline_fit import fit_polylines
from osm2xodr.geometry.plan_view.roundabouts import FittedRings, fit_rings, move_ends
from osm2xodr.model import (
    BoolArray,
    FloatArray,
    IntArray,
    LaneSpec,
    PlanView,
    Rule,
    Street,
    StreetAttributes,
    StreetNetwork,
)
from osm2xodr.system import record

# Attributes, each with the index of the point from which on they hold.
_AttributesFrom = tuple[tuple[int, StreetAttributes], ...]
# How much before and after the tight bend is tried to be replaced with it, in radii. Choices.
_MORE: Final = np.array([0.0, 0.15, 0.3, 0.5, 0.75, 1.0, 1.4, 2.0, 2.8, 4.0])
# Bends that lie within this many radii of each other are widened as one.
_TOGETHER: Final = 1.0
# Parts of a street that are replaced in one round do not touch: those that would wait for the next round.
_ROUNDS: Final = 4
# Points along the new and the old line that are compared, and pairs of lines at a time: the processor's cache.
_POINTS: Final = 17
_LINES_AT_ONCE: Final = 4000
# Shorter records are not worth writing, m.
_SLIVER: Final = 0.02
# Rounding errors, m, and of curvature times radius.
_ROUNDING: Final = 1e-6
# How far the line may move to turn one radian less to and fro beside a bend, m: the outer edge is tight there. Choice
_COUNTER_TURN: Final = 3.0
# Parts that cost as much, within this, m, are equally good: the shortest is taken, and of equally long
# ones that which lies more on the longer side of the street, whichever way that is drawn. That counts for this share.
_EQUALLY_FAR: Final = 1e-4
_LOPSIDED: Final = 1e-3

_Pieces = tuple[tuple[Piece, ...], ...]


@record(eq=False)
class FittedStreets:
    """The streets' curves."""

    plan_view: PlanView  # One curve per street
    pieces: tuple[tuple[Piece, ...], ...]  # Of each street, in ascending s
    aside: FloatArray  # (streets,) How far left of the line of OSM each curve lies, m; 0 as fitted
    on_ring: BoolArray  # (streets,) Whether it is part of a ring that is one curve


def fit_streets(network: StreetNetwork, diagnostics: Diagnostics, *, spirals: bool = True) -> FittedStreets:
    """Fit a curve to every street and say where on it its attributes change.

    All curves are lines and arcs, but rings that are no circles if they may have `spirals`.
    """
    rings = fit_rings(network, diagnostics, spirals=spirals)
    on_ring = {street: number for number, street in enumerate(rings.streets)}
    lines = [_line(street, rings, street.id in on_ring) for street in network.streets]
    start = starts([len(points) for points, _ in lines])
    # Of several classes the least, in whatever order.
    radius = np.array(
        [min(CORNER_RADIUS.get(item.highway, CORNER_RADIUS_OTHER) for _, item in pieces) for _, pieces in lines]
    )
    closed = np.array([street.start < 0 for street in network.streets], bool)
    fitted = fit_polylines(np.concatenate([points for points, _ in lines]), start, radius, closed)
    for index in fitted.spikes.tolist():
        street = network.streets[int(np.searchsorted(start, index, side="right")) - 1]
        if street.id not in on_ring:
            text = "the line turns straight back on itself at a node, which was left out"
            diagnostics.repaired("spike", f"way/{street.pieces[0][1].osm_way_id}", text)
    station = fitted.station.copy()
    for street_id, number in on_ring.items():
        station[start[street_id] : start[street_id + 1]] = rings.stations[number]
    sections: dict[tuple[tuple[LaneSpec, ...], float], CrossSection] = {}
    pieces = tuple(
        tuple(
            (float(station[start[k] + index]), attributes, _section(attributes, network.rule, sections))
            for index, attributes in line_pieces
        )
        for k, (_, line_pieces) in enumerate(lines)
    )
    plan = fitted.plan_view
    if rings.streets:
        plan = replace_curves(plan, np.array(rings.streets), rings.plan_view, np.arange(len(rings.streets)))
    round_about = np.zeros(len(pieces), bool)
    round_about[list(rings.streets)] = True
    plan, pieces, narrow = widen_bends(plan, pieces, round_about)
    for k in narrow.tolist():
        way = pieces[k][0][1].osm_way_id
        diagnostics.note("tight-bend", f"way/{way}", "a bend is tighter than its carriageway is wide")
    return FittedStreets(plan, pieces, np.zeros(len(pieces)), round_about)


def _line(street: Street, rings: FittedRings, on_ring: bool) -> tuple[FloatArray, _AttributesFrom]:
    """Return the points that a street's curve is fitted to, and the attributes that hold from which of them on."""
    if on_ring:
        return street.points, street.pieces
    if street.start < 0:
        return _opened(street)
    return move_ends(street.points, rings.moved.get(street.start), rings.moved.get(street.end)), street.pieces


def _section(
    attributes: StreetAttributes, rule: Rule, known: dict[tuple[tuple[LaneSpec, ...], float], CrossSection]
) -> CrossSection:
    """Return the cross-section; streets whose lanes are alike share it."""
    key = attributes.lanes_ltr, attributes.middle_offset
    if key not in known:
        known[key] = cross_section(attributes, rule)
    return known[key]


def _opened(street: Street) -> tuple[FloatArray, _AttributesFrom]:
    """Cut a closed ring in the middle of its longest segment, so that its curve starts and ends on a straight."""
    points = street.points
    longest = int(hypot(*np.diff(points, axis=0).T).argmax())
    middle = (points[longest] + points[longest + 1]) / 2
    opened = np.concatenate([[middle], points[longest + 1 : -1], points[: longest + 1], [middle]])
    holding = [attributes for index, attributes in street.pieces if index <= longest][-1]
    shift = len(points) - 1 - longest
    later = [(index - longest, attributes) for index, attributes in street.pieces if index > longest]
    earlier = [(index + shift, attributes) for index, attributes in street.pieces if index <= longest]
    return opened, ((0, holding), *later, *earlier)


def outer_lanes(fitted: FittedStreets, rule: Rule, street: int, along: bool) -> tuple[float, float]:
    """Return t of the middles of a street's outermost lanes of one direction, right and left as drivers see it, m."""
    lanes = end_lanes(fitted.pieces[street][0 if along else -1][2], rule, along)
    if not lanes:
        return -np.inf, np.inf
    sign = 1.0 if along else -1.0
    return sign * lanes[-1].t, sign * lanes[0].t


@record
class _Bends:
    """Parts of curves that are too tight, (n,): curve, s where they begin and end, and the radius they need, m."""

    curve: IntArray
    begin: FloatArray
    end: FloatArray
    radius: FloatArray


def widen_bends(plan: PlanView, pieces: _Pieces, fixed: BoolArray) -> tuple[PlanView, _Pieces, IntArray]:
    """Widen the bends whose inner edge would be tighter than `INNER_EDGE_RADIUS`; `fixed` streets stay, (streets,).

    The curves keep their ends, and places of pieces move along. Also return the streets with bends that are still too
    tight, because the line would have had to move too far.
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
    return plan, pieces, sorted_unique(_tight_bends(plan, pieces, reach, fixed).curve)


def _tight_bends(plan: PlanView, pieces: _Pieces, reach: FloatArray, fixed: BoolArray) -> _Bends:
    """Return the bends that are too tight; `reach` is how far the carriageway of each street reaches at most, m."""
    owner = owners(plan.start)
    sharpest = sharpest_curvature(plan)
    bent = np.flatnonzero(np.abs(sharpest) * (reach[owner] + INNER_EDGE_RADIUS) > 1.0 + _ROUNDING)
    found: list[list[float]] = []
    for k in bent[~fixed[owner[bent]]].tolist():
        street, begin, end = int(owner[k]), float(plan.s[k]), float(plan.s[k] + plan.length[k])
        left, right = _edges(pieces[street], begin, end)
        inner = left if sharpest[k] > 0 else right
        if abs(sharpest[k]) * (inner + INNER_EDGE_RADIUS) <= 1.0 + _ROUNDING:
            continue
        radius = max(left, right) + INNER_EDGE_RADIUS
        if found and found[-1][0] == street and begin - found[-1][2] < _TOGETHER * radius:
            found[-1][2:] = end, max(radius, found[-1][3])
        else:
            found.append([street, begin, end, radius])
    columns = np.array(found).reshape(-1, 4).T
    return _Bends(columns[0].astype(np.int64), *columns[1:])


def _edges(pieces: tuple[Piece, ...], begin: float, end: float) -> tuple[float, float]:
    """Return how far the carriageway reaches to the left and to the right somewhere on a part of a street, m.

    Lanes that begin or end there taper over some length.
    """
    lo, hi = begin - TAPER_LENGTH, end + TAPER_LENGTH
    after = [piece[0] for piece in pieces[1:]] + [np.inf]
    there = [p[2] for p, until in zip(pieces, after, strict=True) if p[0] < hi and until > lo] or [pieces[0][2]]
    return max(section.left_edge for section in there), max(-section.right_edge for section in there)


def _wider(plan: PlanView, bends: _Bends) -> tuple[IntArray, FloatArray, FloatArray, PlanView, IntArray]:
    """Return which bends can be made wider, from where to where they are replaced, and by which rows of a table."""
    n = len(bends.curve)
    more = _MORE * bends.radius[:, None]
    before, after = (grid.ravel() for grid in np.meshgrid(np.arange(len(_MORE)), np.arange(len(_MORE))))
    whole = lengths(plan, bends.curve)
    which = np.repeat(np.arange(n), len(before))
    curve = bends.curve[which]
    begin = snap_cuts(plan, curve, np.maximum(bends.begin[:, None] - more[:, before], 0.0).ravel(), _SLIVER)
    end = snap_cuts(plan, curve, np.minimum(bends.end[:, None] + more[:, after], whole[:, None]).ravel(), _SLIVER)
    found = dubins_curves(*pose(plan, curve, begin), *pose(plan, curve, end), radius=bends.radius[which])
    moved = _distances(plan, curve, begin, end, found).reshape(n, -1)
    effort = moved + _COUNTER_TURN * _counter_turns(found).reshape(n, -1)
    effort[moved > defaults.BEND_SHIFT_MAX] = np.inf
    longer = np.sign(bends.begin - (whole - bends.end))[which]
    lopsided = longer * ((end - bends.end[which]) - (bends.begin[which] - begin))
    cost = (end - begin + _LOPSIDED * lopsided).reshape(n, -1)
    equal = effort <= effort.min(1, keepdims=True) + _EQUALLY_FAR
    best = np.where(equal, cost, np.inf).argmin(1)
    chosen = np.flatnonzero(moved[np.arange(n), best] <= defaults.BEND_SHIFT_MAX)
    row = best[chosen] + chosen * len(before)
    return chosen, begin[row], end[row], found, row


def _counter_turns(curves: PlanView) -> FloatArray:
    """Return by how much curves turn back and forth beyond the turn from end to end, (n,), rad, either way."""
    turn, owner, n = curves.length * curves.curvature, owners(curves.start), len(curves.start) - 1
    return np.asarray((np.bincount(owner, np.abs(turn), n) - np.abs(np.bincount(owner, turn, n))) / 2)


def _distances(plan: PlanView, curve: IntArray, begin: FloatArray, end: FloatArray, found: PlanView) -> FloatArray:
    """Return the Hausdorff distance of new curves from the parts they replace, (n,), m; infinite where unusable."""
    n = len(curve)
    length = lengths(found)
    out = np.full(n, np.inf)
    shortest = np.full(n, np.inf)
    np.minimum.at(shortest, owners(found.start), found.length)
    usable = np.flatnonzero((length > 0) & (shortest > _SLIVER))
    share = np.linspace(0.0, 1.0, _POINTS)
    for lo in range(0, len(usable), _LINES_AT_ONCE):
        row = usable[lo : lo + _LINES_AT_ONCE]
        many = np.repeat(row, _POINTS)
        new = pose(found, many, (length[row, None] * share).ravel())
        old = pose(plan, curve[many], (begin[row, None] + (end - begin)[row, None] * share).ravel())
        dx, dy = (
            one.reshape(-1, _POINTS)[:, :, None] - other.reshape(-1, _POINTS)[:, None, :]
            for one, other in zip(new[:2], old[:2], strict=True)
        )
        square = dx * dx + dy * dy
        out[row] = np.sqrt(np.maximum(square.min(1).max(1), square.min(2).max(1)))
    return out


def _put_in(
    plan: PlanView,
    pieces: _Pieces,
    street: IntArray,
    begin: FloatArray,
    end: FloatArray,
    curves: PlanView,
    row: IntArray,
) -> tuple[PlanView, _Pieces]:
    """Replace parts of streets by rows of a table of curves, and move what holds along the streets."""
    length, grown = lengths(plan), lengths(curves, row) - (end - begin)
    changed, first = unique_first(street)
    parts: list[tuple[float, float, int]] = []
    count = [0]
    out = list(pieces)
    for k, lo, hi in zip(changed.tolist(), first.tolist(), [*first[1:].tolist(), len(street)], strict=True):
        own = slice(lo, hi)
        kept_from, kept_to = [0.0, *end[own].tolist()], [*begin[own].tolist(), float(length[k])]
        for i, (a, b) in enumerate(zip(kept_from, kept_to, strict=True)):
            if b - a > _ROUNDING:
                parts.append((a, b, k))
            if i < hi - lo:
                parts.append((0.0, np.inf, len(pieces) + int(row[lo + i])))
        count.append(len(parts))
        old = np.concatenate([[0.0], np.column_stack([begin[own], end[own]]).ravel(), [length[k]]])
        shift = np.repeat(np.concatenate([[0.0], np.cumsum(grown[own])]), 2)
        at = np.interp([piece[0] for piece in pieces[k]], old, old + shift).tolist()
        out[k] = tuple((s, attributes, section) for s, (_, attributes, section) in zip(at, pieces[k], strict=True))
    part_lo, part_hi, source = zip(*parts, strict=True)
    cut = cut_curves(stack_plan_views(plan, curves), np.array(part_lo), np.array(part_hi), source)
    whole = chain_curves(cut, np.array(count, np.int64))
    return replace_curves(plan, changed, whole, np.arange(len(changed))), tuple(out)
