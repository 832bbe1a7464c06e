"""Where one carriageway passes over another: by their areas, and by bridges, tunnels and layers."""

from __future__ import annotations

from dataclasses import fields
from typing import Final

import numpy as np

from osm2xodr.curves import (
    blocks,
    cosine,
    hypot,
    lengths,
    overlap_depths,
    overlapping_pairs,
    pose,
    ranks,
    segments_cross,
    sine,
    stack_plan_views,
)
from osm2xodr.geometry.defaults import PARALLEL_SINE
from osm2xodr.geometry.heights.problem import (
    ProfileProblem,
    curve_spans,
    level_numbers,
    span_sides,
    structures_at,
    wanted_clearances,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, Structure
from osm2xodr.system import record

# Longest piece of a carriageway along its road, m: about the width of a lane.
_PIECE: Final = 4.0
# Roads that meet at a node do not cross there, however their layers are tagged: within this distance of it, m.
_NEAR_NODE: Final = 25.0
# Carriageways that reach less into each other lie side by side, m: less than the error of widths.
_SHARED_WIDTH: Final = 0.2
# Pieces of one place follow each other within this distance, m. A long place is held once in so many metres.
_PLACE_GAP: Final = 10.0
_PLACE_STEP: Final = 12.0
# Share of their length by which the middles of pieces are made longer at both ends where crossings are looked for.
_BEYOND: Final = 0.01


@record(eq=False)
class Carriageways:
    """Pieces of the carriageways of R roads and, behind them, of C connecting roads.

    A curve is a road, or R plus the number of a connecting road.
    """

    # (n,) Curve, and where along it the piece's middle is, m
    curve: IntArray
    s: FloatArray
    corners: FloatArray  # (n, 4, 2) m: right and left where it begins, left and right where it ends
    width: FloatArray  # (n,) m
    # (n,) Structure and layer
    structure: IntArray
    layer: IntArray
    level: IntArray  # (n,) Number of the level: the higher one passes over the lower one
    far_level: IntArray  # (n,) The same of connecting roads by that of their arms which is farther from the ground


def lay_out_carriageways(problem: ProfileProblem) -> Carriageways:
    """Cut the carriageways of all roads and connecting roads into pieces."""
    connectors = problem.connectors
    plan = problem.plan_view if connectors is None else stack_plan_views(problem.plan_view, connectors.plan_view)
    length = lengths(plan)
    count = np.maximum(1, np.ceil(length / _PIECE)).astype(np.int64)
    curve = np.repeat(np.arange(len(length), dtype=np.int64), count)
    step = length / count
    s = (ranks(count) + 0.5) * step[curve]
    half, middle = _across(problem, curve, curve_spans(problem, curve, s))
    corners = _corners(plan, curve, count, step, middle - half, middle + half)
    structure, layer = structures_at(problem, curve, s)
    far = curve_spans(problem, curve, s, far=True)
    far_level = level_numbers(problem.span_structure[far], problem.span_layer[far])
    return Carriageways(curve, s, corners, 2 * half, structure, layer, level_numbers(structure, layer), far_level)


def _corners(
    plan: PlanView, curve: IntArray, count: IntArray, step: FloatArray, right: FloatArray, left: FloatArray
) -> FloatArray:
    """Return the corners of pieces of curves from t `right` to `left`, both (n,), m; (n, 4, 2), m.

    Each of the curves has `count` pieces, which are `step` long, m.
    """
    # Pieces end where the next ones begin.
    border = np.repeat(np.arange(len(count), dtype=np.int64), count + 1)
    border_s = ranks(count + 1) * step[border]
    first, out = np.arange(len(curve)) + curve, np.empty((len(curve), 4, 2))
    for rows in blocks(len(curve)):
        own = slice(first[rows][0], first[rows][-1] + 2)
        x, y, hdg = pose(plan, border[own], border_s[own])
        begin = first[rows] - own.start
        across, ahead = sine(hdg), cosine(hdg)
        for k, (at, t) in enumerate(((begin, right), (begin, left), (begin + 1, left), (begin + 1, right))):
            out[rows, k, 0] = x[at] - t[rows] * across[at]
            out[rows, k, 1] = y[at] + t[rows] * ahead[at]
    return out


def _across(problem: ProfileProblem, curve: IntArray, span: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return half the carriageway's width and t of its middle, (n,), m, of pieces on a span of a curve."""
    connectors = problem.connectors
    half, middle = (side[span] for side in span_sides(problem))
    if connectors is not None:
        inside = curve >= len(problem.end_junction)
        half[inside], middle[inside] = connectors.half_width[curve[inside] - len(problem.end_junction)], 0.0
    return half, middle


@record(eq=False)
class Crossings:
    """Places where one carriageway passes over another without meeting it.

    Curves are roads, and behind them connecting roads, as in `Carriageways`.
    """

    # (n,) Curves, and where along them, m
    upper: IntArray
    upper_s: FloatArray
    lower: IntArray
    lower_s: FloatArray
    clearance: FloatArray  # (n,) Height wanted from road to road, by class or `maxheight` of the lower one, m
    place: IntArray  # (n,) Number of the place that each belongs to: several hold the corners of one
    xy: FloatArray  # (n, 2) Where, local, m
    known_by: IntArray | None = None  # (n,) OSM way whose correction gives the clearance, 0 where none does


@record(eq=False)
class _Pairs:
    """Pieces that lie over each other, sorted by curves and along the upper one."""

    upper: IntArray  # (m,) Pieces
    lower: IntArray
    depth: FloatArray  # (m,) How far they reach into each other, m
    crossing: BoolArray  # (m,) Whether their middles cross
    place: IntArray  # (m,) Place of each

    def chosen(self, rows: IntArray) -> _Pairs:
        """Return some of them."""
        return _Pairs(*(getattr(self, item.name)[rows] for item in fields(_Pairs)))


def find_crossings(problem: ProfileProblem, end_node: IntArray) -> tuple[Crossings, Crossings]:
    """Find where one carriageway passes over another, by their areas, layers and structures.

    `end_node`, (2 R,), is the node that each road end lies at; junction j is node j. The second result are the places
    where carriageways of different layers are level: right beside a node that they share.
    """
    ways = lay_out_carriageways(problem)
    pairs = _places(ways, _overlaps(ways))
    near, related = _meetings(problem, end_node, ways, pairs)
    crosses = np.bincount(pairs.place, pairs.crossing & ~near) > 0
    crosses = crosses[pairs.place] if len(pairs.place) else pairs.crossing
    above = _on_top_of_each_other(ways, pairs) & ~related
    passing = (crosses & ~near) | above
    # On both sides of the same curve there is nothing to be level with.
    half = pairs.depth >= 0.5 * np.minimum(ways.width[pairs.upper], ways.width[pairs.lower])
    apart = ways.level[pairs.upper] != ways.level[pairs.lower]
    meeting = near & apart & (pairs.crossing | half) & ~passing & (ways.curve[pairs.upper] != ways.curve[pairs.lower])
    chosen = (pairs.chosen(np.flatnonzero(rows)) for rows in (passing, meeting))
    found, meets = (_as_crossings(problem, ways, _thinned(problem, ways, rows)) for rows in chosen)
    return found, meets


def _as_crossings(problem: ProfileProblem, ways: Carriageways, pairs: _Pairs) -> Crossings:
    upper, lower = ways.curve[pairs.upper], ways.curve[pairs.lower]
    upper_s, lower_s = ways.s[pairs.upper], ways.s[pairs.lower]
    spans = curve_spans(problem, upper, upper_s), curve_spans(problem, lower, lower_s)
    clearance, known_by = wanted_clearances(problem, *spans)
    xy = 0.5 * (ways.corners[pairs.upper].mean(axis=1) + ways.corners[pairs.lower].mean(axis=1))
    place = np.unique(pairs.place, return_inverse=True)[1].astype(np.int64)
    return Crossings(upper, upper_s, lower, lower_s, clearance, place, xy, known_by)


def _overlaps(ways: Carriageways) -> _Pairs:
    """Return all pairs of pieces on different levels that lie over each other, and of structures of one that cross.

    Where a connecting road and what it lies over are both on the ground, its other arm decides.
    """
    level, far = ways.level, ways.far_level
    a, b = overlapping_pairs(ways.corners, (level != 0) | (far != 0))
    height = np.where(level[a] == level[b], far[a] - far[b], level[a] - level[b])
    same = height == 0
    apart = ~same | ((ways.structure[a] != Structure.GROUND) & (ways.curve[a] != ways.curve[b]))
    a, b, height = a[apart], b[apart], height[apart]
    depth = overlap_depths(ways.corners[a], ways.corners[b])
    deep = depth > _SHARED_WIDTH
    a, b, depth, height = a[deep], b[deep], depth[deep], height[deep]
    over = (height > 0) | ((height == 0) & (ways.curve[a] > ways.curve[b]))
    upper, lower = np.where(over, a, b), np.where(over, b, a)
    crossing = _middles_cross(ways, upper, lower)
    # Side by side on one layer, none of them is above the other.
    used = np.flatnonzero((height != 0) | crossing)
    return _Pairs(upper[used], lower[used], depth[used], crossing[used], np.zeros(len(used), np.int64))


def _middles_cross(ways: Carriageways, one: IntArray, other: IntArray) -> BoolArray:
    """Return whether the middles of pieces, both (n,), cross each other."""
    return segments_cross(*_longer_middles(ways, one), *_longer_middles(ways, other))


def _longer_middles(ways: Carriageways, pieces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return where middles of pieces begin and end, (n, 2), m, a little longer: two may cross where pieces meet."""
    begin, end = np.empty((2, len(pieces), 2))
    for rows in blocks(len(pieces)):
        corners = ways.corners[pieces[rows]]
        first, last = 0.5 * (corners[:, 0] + corners[:, 1]), 0.5 * (corners[:, 2] + corners[:, 3])
        more = _BEYOND * (last - first)
        begin[rows], end[rows] = first - more, last + more
    return begin, end


def _places(ways: Carriageways, pairs: _Pairs) -> _Pairs:
    """Sort pairs by curves and along the upper one, and number the places that they belong to."""
    upper, lower, s = ways.curve[pairs.upper], ways.curve[pairs.lower], ways.s[pairs.upper]
    order = np.lexsort((ways.s[pairs.lower], s, lower, upper))
    upper, lower, s = upper[order], lower[order], s[order]
    new = (np.diff(upper, prepend=-1) != 0) | (np.diff(lower, prepend=-1) != 0) | (np.diff(s, prepend=0) > _PLACE_GAP)
    out = pairs.chosen(order)
    return _Pairs(out.upper, out.lower, out.depth, out.crossing, np.cumsum(new) - 1)


def _on_top_of_each_other(ways: Carriageways, pairs: _Pairs) -> BoolArray:
    """Say for pairs of pieces whether they run one above the other (double decks).

    Away from its ends a structure may also lie over a part only of what runs along it; near them that might follow
    from guessed widths alone.
    """
    a, b = pairs.upper, pairs.lower
    u, v = (end - begin for begin, end in (_longer_middles(ways, pieces) for pieces in (a, b)))
    size = np.maximum(hypot(*u.T) * hypot(*v.T), 1e-9)
    parallel = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / size < PARALLEL_SINE
    on = ways.structure != Structure.GROUND
    inner = _within_structure(ways)
    half = pairs.depth >= 0.5 * np.minimum(ways.width[a], ways.width[b])
    out: BoolArray = (on[a] | on[b]) & (inner[a] | inner[b] | half) & (parallel | inner[a] | inner[b])
    return out


def _within_structure(ways: Carriageways) -> BoolArray:
    """Return which pieces lie on a structure and farther than `_NEAR_NODE` from where it or its curve ends."""
    curve, s, structure = ways.curve, ways.s, ways.structure
    border = np.r_[True, (curve[1:] != curve[:-1]) | (structure[1:] != structure[:-1]), True]
    first = np.flatnonzero(border[:-1])
    run = np.cumsum(border[:-1]) - 1
    last = np.r_[first[1:], len(curve)] - 1
    on = structure != Structure.GROUND
    out: BoolArray = on & (s - s[first][run] > _NEAR_NODE) & (s[last][run] - s > _NEAR_NODE)
    return out


def _meetings(
    problem: ProfileProblem, end_node: IntArray, ways: Carriageways, pairs: _Pairs
) -> tuple[BoolArray, BoolArray]:
    """Return whether the curves of pairs share a node near both pieces, and whether they share one at all.

    A connecting road is at its junction's node all along. Places of one curve near each other count as both.
    """
    connectors, roads = problem.connectors, len(problem.end_junction)
    length = lengths(problem.plan_view)
    inside = np.zeros(0, np.int64) if connectors is None else connectors.junction
    node = np.vstack([end_node.reshape(-1, 2), np.column_stack([inside, inside])])

    def to_node(piece: IntArray, end: int) -> FloatArray:
        curve, s = ways.curve[piece], ways.s[piece]
        plain = np.minimum(curve, roads - 1)
        return np.where(curve >= roads, 0.0, length[plain] - s if end else s)

    a, b = pairs.upper, pairs.lower
    related = ways.curve[a] == ways.curve[b]
    near: BoolArray = related & (np.abs(ways.s[a] - ways.s[b]) < 2 * _NEAR_NODE)
    related = near.copy()
    for i in (0, 1):
        for j in (0, 1):
            shared = node[ways.curve[a], i] == node[ways.curve[b], j]
            related |= shared
            near |= shared & (to_node(a, i) < _NEAR_NODE) & (to_node(b, j) < _NEAR_NODE)
    return near, related


def _thinned(problem: ProfileProblem, ways: Carriageways, pairs: _Pairs) -> _Pairs:
    """Leave of each place, and of each `_PLACE_STEP` of a long one, the corners and where the overlap is deepest.

    The connecting roads of a junction lie on one plane: for these, their places under or over one road are one.
    """
    if not len(pairs.place):
        return pairs
    one, other = (_surfaces(problem, ways.curve[piece]) for piece in (pairs.upper, pairs.lower))
    us = ways.s[pairs.upper]
    part = np.where(one < 0, 0, np.floor(us / _PLACE_STEP).astype(np.int64))
    keys = np.column_stack([one, other, np.where((one < 0) | (other < 0), 0, pairs.place)])
    place = np.unique(keys, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
    pairs = _Pairs(pairs.upper, pairs.lower, pairs.depth, pairs.crossing, place)
    x, y = ways.corners[pairs.upper].mean(axis=1).T + ways.corners[pairs.lower].mean(axis=1).T
    kept = []
    for value in (x + y, x - y, -x - y, y - x, pairs.depth):
        order = np.lexsort((-value, part, place))
        new = (np.diff(place[order], prepend=-1) != 0) | (np.diff(part[order], prepend=-1) != 0)
        kept.append(order[new])
    return pairs.chosen(np.unique(np.concatenate(kept)))


def _surfaces(problem: ProfileProblem, curve: IntArray) -> IntArray:
    """Return a number for the surface of each curve, (n,): its own, or one below 0 for that of its junction."""
    roads, out = len(problem.end_junction), curve.copy()
    if problem.connectors is not None:
        inside = curve >= roads
        out[inside] = -1 - problem.connectors.junction[curve[inside] - roads]
    return out
