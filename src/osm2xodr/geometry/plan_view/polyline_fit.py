"""Polylines of OSM become smooth curves of lines and arcs: all streets at once.

Every vertex of a simplified polyline gets a fillet. A fillet alone lies inside of every corner, so vertices are
first moved outwards by half of what the fillet cuts off: the curve then runs as far outside of the vertices as
inside of the segments, as the road that the nodes were set on does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Nodes closer than this carry no direction of their own.
_SHORTEST_SEGMENT: Final = 0.5
# Radius above which a curve is no longer told from a line; also keeps single-precision readers exact.
_LARGEST_RADIUS: Final = 2000.0

_SPIKE = np.deg2rad(170.0)
_LEFTOVER_LINE = 0.1
# Between two arcs lies a line at least so long, or none, m: some readers round to centimetres.
_SHORTEST_LINE = 0.02
_NO_LINE = 1e-9
_POINT = 1e-6
# A smaller turn is none, rad: its arc would be shorter than a centimetre even with the largest radius.
_NO_TURN = 5e-6


@dataclass(frozen=True, slots=True, eq=False)
class FittedPolylines:
    """Curves through many polylines."""

    plan_view: PlanView  # One curve per polyline
    station: FloatArray  # (points,) s of every point of the polylines on its curve, m
    spikes: IntArray  # (spikes,) Indices of points that were left out because the polyline turns back on itself there


def fit_polylines(
    points: FloatArray,
    start: IntArray,
    corner_radius: FloatArray,
    closed: BoolArray | None = None,
    fixed: BoolArray | None = None,
) -> FittedPolylines:
    """Fit a curve of lines and arcs with continuous heading to each polyline.

    Parameters
    ----------
    points : (points, 2)
        Local x, y of all polylines in a row, m; no two in a row at the same place.
    start : (polylines + 1,)
        Index of each polyline's first point; each has at least two.
    corner_radius : (polylines,)
        Radius wished for at corners, m.
    closed : (polylines,)
        Polylines whose ends meet on a straight, so that heading continues from end to start.
    fixed : (points,)
        Points that are neither left out nor moved.
    """
    polyline = np.repeat(np.arange(len(start) - 1), np.diff(start))
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
    chainage = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    station = np.interp(chainage, chainage[kept], kept_station)
    # An end of one polyline and the start of the next have chainages of their own, but may coincide in place.
    station[kept] = kept_station
    return FittedPolylines(plan, station, spikes)


def _simplify(points: FloatArray, polyline: IntArray, fixed: BoolArray) -> tuple[BoolArray, IntArray]:
    """Say which points are needed to stay within the tolerance, and which were spikes.

    Passes over all polylines take out the least important point of each neighbourhood. What a segment already
    passed over counts towards what it may still pass over, so the tolerance holds.
    """
    ends = np.flatnonzero(np.diff(polyline, prepend=-1)), np.flatnonzero(np.diff(polyline, append=-1))
    # A loop needs two points besides the one that it begins and ends at.
    comes_back = np.hypot(*(points[ends[0]] - points[ends[1]]).T) < _SHORTEST_SEGMENT
    keep = np.ones(len(points), bool)
    passed_over = np.zeros(len(points))
    spikes: list[IntArray] = []
    while True:
        k = np.flatnonzero(keep)
        if len(k) < 3:
            break
        before, here, after = k[:-2], k[1:-1], k[2:]
        interior = (polyline[before] == polyline[here]) & (polyline[here] == polyline[after]) & ~fixed[here]
        interior &= ~comes_back[polyline[here]] | (np.bincount(polyline[k])[polyline[here]] > 4)
        a, b, c = points[before], points[here], points[after]
        first, second, chord = b - a, c - b, c - a
        len_first, len_second = np.hypot(*first.T), np.hypot(*second.T)
        cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        dot = (first * second).sum(1)
        turn = np.abs(np.arctan2(cross, dot))
        along = (first * chord).sum(1) / np.maximum((chord * chord).sum(1), 1e-12)
        off = np.hypot(*(first - np.clip(along, 0, 1)[:, None] * chord).T)
        error = off + np.maximum(passed_over[before], passed_over[here])
        spike = turn > _SPIKE
        crowded = np.minimum(len_first, len_second) < _SHORTEST_SEGMENT
        wanted = interior & (spike | crowded | (error <= defaults.SIMPLIFY_TOLERANCE))
        cost = np.where(wanted, np.where(spike, -1.0, off), np.inf)
        left = np.concatenate([[np.inf], cost[:-1]])
        right = np.concatenate([cost[1:], [np.inf]])
        drop = wanted & (cost < left) & (cost <= right)
        if not drop.any():
            break
        spikes.append(here[drop & spike])
        passed_over[before[drop]] = error[drop]
        keep[here[drop]] = False
    return keep, np.sort(np.concatenate(spikes)) if spikes else np.zeros(0, np.int64)


def _corner_cut(turn: FloatArray, corner_radius: FloatArray) -> FloatArray:
    """Return how far the curve may cut each corner, m."""
    wish = corner_radius * (1.0 / np.maximum(np.cos(turn / 2), 0.05) - 1.0)
    most = np.interp(turn, np.deg2rad([90.0, 150.0]), [defaults.CORNER_CUT_MAX, defaults.CORNER_CUT_HAIRPIN])
    cut: FloatArray = np.where(turn > np.deg2rad(25.0), np.clip(wish, defaults.CORNER_CUT, most), defaults.CORNER_CUT)
    return cut


def _displaced_fillets(
    original: FloatArray, interior: BoolArray, anchored: BoolArray, corner_radius: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return moved vertices (n, 2), tangent lengths of their fillets (n,), m, and their turns (n,), rad."""
    moved = original.copy()
    tangent = np.zeros(len(original))
    turn = np.zeros(len(original))
    for _ in range(4):
        step = np.diff(moved, axis=0)
        length = np.hypot(*step.T)
        unit = step / np.maximum(length, 1e-12)[:, None]
        turn = _turns(unit, interior)
        size = np.abs(turn)
        quarter = np.tan(size / 4)
        wish = np.minimum(
            _corner_cut(size, corner_radius) / np.maximum(quarter, 1e-9),
            _LARGEST_RADIUS * np.tan(np.minimum(size, 3.1) / 2),
        )
        tangent = _share(np.where(interior, wish, 0.0), length, interior)
        bisector = np.zeros_like(moved)
        bisector[1:-1] = unit[:-1] - unit[1:]
        bisector /= np.maximum(np.hypot(*bisector.T), 1e-12)[:, None]
        out = np.where(interior & ~anchored, np.minimum(0.5 * tangent * quarter, 0.5 * defaults.CORNER_CUT_MAX), 0.0)
        last_moved = moved
        moved = original + out[:, None] * bisector
    # The last tangents belong to the vertices that they were computed for.
    return last_moved, _without_slivers(tangent, length), turn


def _without_slivers(tangent: FloatArray, length: FloatArray) -> FloatArray:
    """Return tangents some of which are a little shorter, so that no line between two arcs is too short to count.

    Either of the two may give way, and on its other side, too, a line long enough is left then.
    """
    left = length - tangent[:-1] - tangent[1:]
    short = np.flatnonzero((left > _NO_LINE) & (left < _SHORTEST_LINE))
    longer = np.where(tangent[short] >= tangent[short + 1], short, short + 1)
    out = tangent.copy()
    out[longer] = np.maximum(out[longer] - _SHORTEST_LINE, 0.5 * out[longer])
    return out


def _turns(unit: FloatArray, interior: BoolArray) -> FloatArray:
    """Return the signed turn at each vertex, rad, 0 at ends."""
    turn = np.zeros(len(interior))
    cross = unit[:-1, 0] * unit[1:, 1] - unit[:-1, 1] * unit[1:, 0]
    turn[1:-1] = np.arctan2(cross, (unit[:-1] * unit[1:]).sum(1))
    turn[~interior | (np.abs(turn) < _NO_TURN)] = 0.0
    return turn


def _share(wish: FloatArray, length: FloatArray, interior: BoolArray) -> FloatArray:
    """Give each vertex as much of its two segments as it wishes and its neighbours leave."""
    # Arcs may follow one another, but a street's end stays straight for a little.
    at_end = ~(interior[:-1] & interior[1:])
    room = length - np.where(at_end, np.minimum(_LEFTOVER_LINE, 0.2 * length), 0.0)
    before = np.concatenate([[0.0], room])
    after = np.concatenate([room, [0.0]])
    free_before = np.concatenate([[True], ~interior[:-1]])
    free_after = np.concatenate([~interior[1:], [True]])
    tangent = np.minimum(
        wish, np.minimum(np.where(free_before, before, before / 2), np.where(free_after, after, after / 2))
    )
    for _ in range(3):
        left = np.concatenate([[0.0], tangent[:-1]])
        right = np.concatenate([tangent[1:], [0.0]])
        grown = np.minimum(wish, np.minimum(before - left, after - right))
        grown = np.where(interior, np.maximum(grown, tangent), 0.0)
        over = np.minimum(1.0, room / np.maximum(grown[:-1] + grown[1:], 1e-12))
        scale = np.minimum(np.concatenate([[1.0], over]), np.concatenate([over, [1.0]]))
        tangent = grown * scale
    out: FloatArray = np.where(interior, tangent, 0.0)
    return out


def _records(
    vertex: FloatArray, tangent: FloatArray, turn: FloatArray, owner: IntArray, curves: int
) -> tuple[PlanView, FloatArray]:
    """Write out lines and arcs; also return s of each vertex (of its arc's middle)."""
    step = np.diff(vertex, axis=0)
    length = np.hypot(*step.T)
    same = owner[1:] == owner[:-1]
    unit = step / np.maximum(length, 1e-12)[:, None]
    hdg = np.arctan2(unit[:, 1], unit[:, 0])
    n = len(vertex)
    # Two slots per vertex: the line that leads to it from the one before, then its arc.
    shape = (n, 2)
    rx, ry, rh, rl, rk = (np.zeros(shape) for _ in range(5))
    line_start = vertex[:-1] + tangent[:-1, None] * unit
    rx[1:, 0], ry[1:, 0], rh[1:, 0] = line_start[:, 0], line_start[:, 1], hdg
    rl[1:, 0] = np.where(same, length - tangent[:-1] - tangent[1:], 0.0)
    bend = np.abs(turn) > 1e-9
    radius = tangent / np.tan(np.where(bend, np.abs(turn), 1.0) / 2)
    arc_start = vertex[1:] - tangent[1:, None] * unit
    rx[1:, 1], ry[1:, 1], rh[1:, 1] = arc_start[:, 0], arc_start[:, 1], hdg
    rl[:, 1] = np.where(bend, radius * np.abs(turn), 0.0)
    rk[:, 1] = np.where(bend, np.sign(turn) / np.maximum(radius, 1e-9), 0.0)
    # A polyline that comes to a point keeps a heading: what is made of it is dropped for its length.
    last = np.flatnonzero(np.concatenate([~same, [True]]))
    point = np.bincount(np.repeat(owner, 2), (rl > _NO_LINE).ravel(), curves)[owner[last]] == 0
    rx[last[point], 0], ry[last[point], 0] = vertex[last[point], 0], vertex[last[point], 1]
    rl[last[point], 0] = _POINT
    flat_length = rl.ravel()
    end_s = np.cumsum(flat_length)
    first_of = np.concatenate([[True], ~same])
    base = np.repeat((end_s[0::2] - flat_length[0::2])[first_of], np.diff(np.append(np.flatnonzero(first_of), n)))
    s = end_s - flat_length - np.repeat(base, 2)
    station = s[1::2] + 0.5 * flat_length[1::2]
    used = flat_length > _NO_LINE
    curve = np.repeat(owner, 2)[used]
    per_curve = np.bincount(curve, minlength=curves)
    start = np.concatenate([[0], np.cumsum(per_curve)]).astype(np.int64)
    # Sums over all curves leave rounding errors: each curve starts at 0 all the same.
    record_s = np.where(np.diff(curve, prepend=-1) > 0, 0.0, s[used])
    plan = PlanView(
        start, record_s, rx.ravel()[used], ry.ravel()[used], rh.ravel()[used], flat_length[used], rk.ravel()[used]
    )
    return plan, station
