"""Polylines of OSM become smooth curves of lines and arcs, all streets at once (docs/method/plan_view.md).

Every vertex of a simplified polyline gets a fillet. A fillet alone lies inside its corner, so vertices first move
outwards by half of what the fillet cuts off: the curve then passes the vertices on the inside by as much as it passes
the segments on the outside.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    cosine,
    hypot,
    owners,
    running_lengths,
    slope_of,
    starts,
)
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# Nodes closer than this give no direction of their own, m: it would be that of their errors.
_SHORTEST_SEGMENT: Final = 0.5
# Larger radii cannot be told from a line, m, and cost readers with single precision their exactness.
_LARGEST_RADIUS: Final = 2000.0
# A polyline that turns by more at a node goes back on itself, rad: no street does.
_SPIKE_TURN: Final = np.deg2rad(170.0)
# From this turn on a corner is meant as one: its fillet gets the radius wished for where the cut allows, rad. Choice.
_CORNER_TURN: Final = np.deg2rad(25.0)
# Turns between which the largest cut grows from a corner's to a hairpin's, rad. Choices.
_HAIRPIN_TURNS: Final = np.deg2rad([90.0, 150.0])
# At its ends a street stays straight for this length, m, or this share of a short segment, so that the heading of its
# ends is that of its line. Choices; above 0.1 m, since netconvert drops the end of shorter lines and warns.
_STRAIGHT_END: Final = 0.12
_STRAIGHT_END_SHARE: Final = 0.2
# Between two arcs lies no line, or one at least this long, m: some readers round to centimetres.
_SHORTEST_LINE: Final = 0.02
# Lengths up to this are rounding errors, m.
_ROUNDING: Final = 1e-9
# Length of the line that stands for a polyline which has shrunk to a point, m.
_LENGTH_OF_POINT: Final = 1e-6
# Smaller turns are left out, rad: even with the largest radius their arcs would be shorter than a centimetre.
_SMALLEST_TURN: Final = 5e-6
# Rounds in which moved vertices and fillets, and the fillets of neighbours, settle: more change nothing that matters.
_FILLET_ROUNDS: Final = 4
_SHARE_ROUNDS: Final = 3


@record(eq=False)
class FittedPolylines:
    """Curves through many polylines."""

    plan_view: PlanView  # One curve per polyline
    station: FloatArray  # (points,) s of every point of the polylines on its curve, m
    spikes: IntArray  # (spikes,) Indices of points that were left out because the polyline goes back on itself there


def fit_polylines(
    points: FloatArray,
    start: IntArray,
    corner_radius: FloatArray,
    closed: BoolArray | None = None,
    fixed: BoolArray | None = None,
) -> FittedPolylines:
    """Fit a curve of lines and arcs with continuous heading to each polyline.

    `points` (n, 2) are those of all polylines in a row, local x, y, m, no two in a row at the same place; `start`
    (polylines + 1,) has each polyline's first point, of two at least; `corner_radius` (polylines,) is wished for at
    corners, m. `closed` (polylines,) have ends that meet on a straight, so that heading continues from end to start;
    `fixed` points (n,) are neither left out nor moved.
    """
    polyline = owners(start)
    keep, spikes = _simplify(points, polyline, np.zeros(len(points), bool) if fixed is None else fixed)
    kept = np.flatnonzero(keep)
    owner = polyline[kept]
    interior = np.zeros(len(kept), bool)
    interior[1:-1] = (owner[1:-1] == owner[:-2]) & (owner[1:-1] == owner[2:])
    anchored = np.zeros(len(kept), bool) if fixed is None else fixed[kept]
    if closed is not None:
        first = np.concatenate([[True], owner[1:] != owner[:-1]])
        last = np.concatenate([owner[1:] != owner[:-1], [True]])
        anchored[1:] |= first[:-1] & closed[owner[1:]]
        anchored[:-1] |= last[1:] & closed[owner[:-1]]
    moved, tangent, turn = _displaced_fillets(points[kept], interior, anchored, corner_radius[owner])
    plan, kept_station = _records(moved, tangent, turn, owner, len(start) - 1)
    chainage = running_lengths(points)
    station = np.interp(chainage, chainage[kept], kept_station)
    # Where an end of one polyline and the start of the next coincide, interpolation cannot tell them apart.
    station[kept] = kept_station
    return FittedPolylines(plan, station, spikes)


# ---------------------------------------------------------------- which points count


def _simplify(points: FloatArray, polyline: IntArray, fixed: BoolArray) -> tuple[BoolArray, IntArray]:
    """Say which points are needed to stay within `SIMPLIFY_TOLERANCE`, and which were spikes.

    Each pass takes out the least important point of each neighbourhood. The error that a segment has made already
    adds to that of leaving out its ends, so the tolerance holds.
    """
    ends = np.flatnonzero(np.diff(polyline, prepend=-1)), np.flatnonzero(np.diff(polyline, append=-1))
    # A loop needs two points besides the one that it begins and ends at.
    comes_back = hypot(*(points[ends[0]] - points[ends[1]]).T) < _SHORTEST_SEGMENT
    keep = np.ones(len(points), bool)
    error_so_far = np.zeros(len(points))
    spikes: list[IntArray] = []
    while True:
        k = np.flatnonzero(keep)
        if len(k) < 3:
            break
        before, here, after = k[:-2], k[1:-1], k[2:]
        interior = (polyline[before] == polyline[here]) & (polyline[here] == polyline[after]) & ~fixed[here]
        interior &= ~comes_back[polyline[here]] | (np.bincount(polyline[k])[polyline[here]] > 4)
        shorter, turn, off = _corners(points[k])
        error = off + np.maximum(error_so_far[before], error_so_far[here])
        spike = turn > _SPIKE_TURN
        wanted = interior & (spike | (shorter < _SHORTEST_SEGMENT) | (error <= defaults.SIMPLIFY_TOLERANCE))
        cost = np.where(wanted, np.where(spike, -1.0, off), np.inf)
        left = np.concatenate([[np.inf], cost[:-1]])
        right = np.concatenate([cost[1:], [np.inf]])
        drop = wanted & (cost < left) & (cost <= right)
        if not drop.any():
            break
        spikes.append(here[drop & spike])
        error_so_far[before[drop]] = error[drop]
        keep[here[drop]] = False
    return keep, np.sort(np.concatenate(spikes)) if spikes else np.zeros(0, np.int64)


def _corners(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return of inner points the shorter segment, m, the size of the turn, rad, the distance from the chord, m."""
    first, second, chord = points[1:-1] - points[:-2], points[2:] - points[1:-1], points[2:] - points[:-2]
    shorter = np.minimum(hypot(*first.T), hypot(*second.T))
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    turn = np.abs(arctan2(cross, (first * second).sum(1)))
    along = (first * chord).sum(1) / np.maximum((chord * chord).sum(1), 1e-12)
    off = hypot(*(first - np.clip(along, 0, 1)[:, None] * chord).T)
    return shorter, turn, off


# ---------------------------------------------------------------- fillets


def _displaced_fillets(
    original: FloatArray, interior: BoolArray, anchored: BoolArray, corner_radius: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return moved vertices (n, 2), tangent lengths of their fillets (n,), m, and their turns (n,), rad."""
    moved = original.copy()
    for _ in range(_FILLET_ROUNDS):
        vertex = moved
        step = np.diff(vertex, axis=0)
        length = hypot(*step.T)
        unit = step / np.maximum(length, 1e-12)[:, None]
        turn = _turns(unit, interior)
        size = np.abs(turn)
        quarter = slope_of(size / 4)
        wish = np.minimum(
            _corner_cut(size, corner_radius) / np.maximum(quarter, 1e-9),
            _LARGEST_RADIUS * slope_of(np.minimum(size, 3.1) / 2),
        )
        tangent = _share_segments(np.where(interior, wish, 0.0), length, interior)
        bisector = np.zeros_like(vertex)
        bisector[1:-1] = unit[:-1] - unit[1:]
        bisector /= np.maximum(hypot(*bisector.T), 1e-12)[:, None]
        out = np.where(interior & ~anchored, np.minimum(0.5 * tangent * quarter, 0.5 * defaults.CORNER_CUT_MAX), 0.0)
        moved = original + out[:, None] * bisector
    # The last tangents belong to the vertices that they were computed for.
    return vertex, _without_slivers(tangent, length), turn


def _turns(unit: FloatArray, interior: BoolArray) -> FloatArray:
    """Return the signed turn at each vertex, rad, 0 at ends."""
    turn = np.zeros(len(interior))
    cross = unit[:-1, 0] * unit[1:, 1] - unit[:-1, 1] * unit[1:, 0]
    turn[1:-1] = arctan2(cross, (unit[:-1] * unit[1:]).sum(1))
    turn[~interior | (np.abs(turn) < _SMALLEST_TURN)] = 0.0
    return turn


def _corner_cut(turn: FloatArray, corner_radius: FloatArray) -> FloatArray:
    """Return how far the curve may cut each corner, m, by the size of its turn, rad."""
    wish = corner_radius * (1.0 / np.maximum(cosine(turn / 2), 0.05) - 1.0)
    most = np.interp(turn, _HAIRPIN_TURNS, [defaults.CORNER_CUT_MAX, defaults.CORNER_CUT_HAIRPIN])
    cut: FloatArray = np.where(turn > _CORNER_TURN, np.clip(wish, defaults.CORNER_CUT, most), defaults.CORNER_CUT)
    return cut


def _share_segments(wish: FloatArray, length: FloatArray, interior: BoolArray) -> FloatArray:
    """Return tangent lengths, (n,), m: as much of its segments as each vertex wishes and its neighbours leave."""
    # Arcs may follow one another, but a street's end stays straight for a little.
    at_end = ~(interior[:-1] & interior[1:])
    room = length - np.where(at_end, np.minimum(_STRAIGHT_END, _STRAIGHT_END_SHARE * length), 0.0)
    before = np.concatenate([[0.0], room])
    after = np.concatenate([room, [0.0]])
    free_before = np.concatenate([[True], ~interior[:-1]])
    free_after = np.concatenate([~interior[1:], [True]])
    tangent = np.minimum(
        wish, np.minimum(np.where(free_before, before, before / 2), np.where(free_after, after, after / 2))
    )
    for _ in range(_SHARE_ROUNDS):
        left = np.concatenate([[0.0], tangent[:-1]])
        right = np.concatenate([tangent[1:], [0.0]])
        grown = np.minimum(wish, np.minimum(before - left, after - right))
        grown = np.where(interior, np.maximum(grown, tangent), 0.0)
        over = np.minimum(1.0, room / np.maximum(grown[:-1] + grown[1:], 1e-12))
        scale = np.minimum(np.concatenate([[1.0], over]), np.concatenate([over, [1.0]]))
        tangent = grown * scale
    return np.asarray(np.where(interior, tangent, 0.0))


def _without_slivers(tangent: FloatArray, length: FloatArray) -> FloatArray:
    """Return tangents some of which are a little shorter, so that no line between two arcs is too short to write."""
    # The longer of the two gives way, which leaves a line that is long enough on its other side, too.
    left = length - tangent[:-1] - tangent[1:]
    short = np.flatnonzero((left > _ROUNDING) & (left < _SHORTEST_LINE))
    longer = np.where(tangent[short] >= tangent[short + 1], short, short + 1)
    out = tangent.copy()
    out[longer] = np.maximum(out[longer] - _SHORTEST_LINE, 0.5 * out[longer])
    return out


# ---------------------------------------------------------------- lines and arcs


def _records(
    vertex: FloatArray, tangent: FloatArray, turn: FloatArray, owner: IntArray, curves: int
) -> tuple[PlanView, FloatArray]:
    """Return the lines and arcs of vertices with fillets, and s of each vertex (of the middle of its arc)."""
    step = np.diff(vertex, axis=0)
    distance = hypot(*step.T)
    same = owner[1:] == owner[:-1]
    unit = step / np.maximum(distance, 1e-12)[:, None]
    n = len(vertex)
    # Two slots per vertex: the line that leads to it from the one before, then its arc.
    place, hdg, length, curvature = np.zeros((n, 2, 2)), np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2))
    place[1:, 0] = vertex[:-1] + tangent[:-1, None] * unit
    place[1:, 1] = vertex[1:] - tangent[1:, None] * unit
    hdg[1:] = arctan2(unit[:, 1], unit[:, 0])[:, None]
    length[1:, 0] = np.where(same, distance - tangent[:-1] - tangent[1:], 0.0)
    bend = turn != 0.0
    radius = tangent / slope_of(np.where(bend, np.abs(turn), 1.0) / 2)
    length[:, 1] = np.where(bend, radius * np.abs(turn), 0.0)
    curvature[:, 1] = np.where(bend, np.sign(turn) / np.maximum(radius, 1e-9), 0.0)
    # A polyline that shrinks to a point keeps place and heading; roads made of it are dropped for their length.
    last = np.flatnonzero(np.concatenate([~same, [True]]))
    point = last[np.bincount(np.repeat(owner, 2), (length > _ROUNDING).ravel(), curves)[owner[last]] == 0]
    place[point, 0], length[point, 0] = vertex[point], _LENGTH_OF_POINT
    return _table(place.reshape(-1, 2), hdg.ravel(), length.ravel(), curvature.ravel(), np.repeat(owner, 2), curves)


def _table(
    place: FloatArray, hdg: FloatArray, length: FloatArray, curvature: FloatArray, owner: IntArray, curves: int
) -> tuple[PlanView, FloatArray]:
    """Return a table of the slots that have a length, and s of the middle of every second slot."""
    end = np.cumsum(length)
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    base = np.repeat((end - length)[first], np.diff(np.append(first, len(owner))))
    s = end - length - base
    used = length > _ROUNDING
    curve = owner[used]
    start = starts(np.bincount(curve, minlength=curves))
    # Sums over all curves leave rounding errors: each curve starts at 0 all the same.
    record_s = np.where(np.diff(curve, prepend=-1) > 0, 0.0, s[used])
    x, y = place[used].T.copy()
    return PlanView(start, record_s, x, y, hdg[used], length[used], curvature[used]), s[1::2] + 0.5 * length[1::2]
