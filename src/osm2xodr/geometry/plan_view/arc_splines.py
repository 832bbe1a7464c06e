"""Smooth curves of many arcs through points, for lines that are neither straight nor circles.

A curve is a row of arcs of one length that go on in each other's heading. Least squares make it pass the points
with as little change of curvature as possible (a discrete minimum variation curve after Moreton and Séquin 1992,
doi:10.1145/142920.134035): a circle where a circle fits, an oval for an oval.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from osm2xodr.curves import arc_step, wrapped
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

_FEWEST_ARCS, _MOST_ARCS = 20, 60
_ITERATIONS = 25
# A step of the iteration below this, m and rad, is the last if what a ring misses to close is below the second, m;
# then it is closed to the third, m.
_LAST_STEP, _LAST_GAP, _CLOSED = 2e-3, 1e-3, 1e-9
# Change of a turn in one step of the iteration at most, rad.
_FARTHEST_TURN = 0.3
# How much more than the line a curve may turn to and fro, rad.
_SWING = 0.1
# How many steps of stiffness a curve gives up to have no counter-bends.
_LOOSER = 3
_STIFFNESS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    """A row of arcs and where the points lie on it."""

    start: FloatArray  # (3,) x, y and heading of its start
    turn: FloatArray  # (arcs,) Of each arc, rad
    step: float  # Length of each arc, m
    s: FloatArray  # (points,) Where each point is projected to, m; the first stays at 0

    def borders(self) -> FloatArray:
        """Return x, y and heading where the arcs start and the last ends, (arcs + 1, 3)."""
        hdg = self.start[2] + np.concatenate([[0.0], np.cumsum(self.turn)])
        u, v, _ = arc_step(self.turn / self.step, np.full(len(self.turn), self.step))
        cos, sin = np.cos(hdg[:-1]), np.sin(hdg[:-1])
        x = self.start[0] + np.concatenate([[0.0], np.cumsum(cos * u - sin * v)])
        y = self.start[1] + np.concatenate([[0.0], np.cumsum(sin * u + cos * v)])
        return np.column_stack([x, y, hdg])


def fit_arcs(points: FloatArray, closed: bool) -> tuple[PlanView, FloatArray] | None:
    """Return the smoothest curve that passes points in their order, and s of each.

    None where none comes close enough (`RING_TOLERANCE`, `RING_CURVE_RMS`) without bends that the line does not
    have. A curve that can do with bends to one side has no others.

    Parameters
    ----------
    points : (n, 2)
        Local x, y, m. The first of a closed line is not repeated.
    closed
        Whether the line goes on from its last point to the first, once around.
    """
    row = _first_guess(points, closed)
    if closed and abs(abs(row.turn.sum()) - 2 * np.pi) > 0.1:
        return None
    free = np.ones(len(row.turn), bool)
    best: _Row | None = None
    low, high = -1, len(_STIFFNESS)
    while high - low > 1:
        middle = (low + high) // 2
        found = _solved(best or row, points, closed, _STIFFNESS[middle], free)
        if found is None:
            high = middle
        else:
            best, low = found, middle
    if best is None:
        return None
    for number in range(low, max(low - _LOOSER, -1), -1):
        one_sided = _to_one_side(best, points, closed, _STIFFNESS[number])
        if one_sided is not None:
            return _plan(one_sided), one_sided.s
    # A curve that swings about sharp corners is no better than the corners.
    swings = np.abs(best.turn).sum() - np.abs(turns_of(points, closed)).sum()
    return None if swings > _SWING else (_plan(best), best.s)


def turns_of(points: FloatArray, closed: bool) -> FloatArray:
    """Return the turns of a polyline at its points, rad."""
    line = np.concatenate([points, points[:2]]) if closed else points
    step = np.diff(line, axis=0)
    return wrapped(np.diff(np.arctan2(step[:, 1], step[:, 0])))


def _first_guess(points: FloatArray, closed: bool) -> _Row:
    """Return arcs along the polyline, its corners somewhat rounded."""
    line = np.concatenate([points, points[:1]]) if closed else points
    chainage = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    arcs = int(np.clip(np.ceil(chainage[-1] / defaults.RING_ARC), _FEWEST_ARCS, _MOST_ARCS))
    at = np.linspace(0.0, chainage[-1], arcs + 1)
    x, y = np.interp(at, chainage, line[:, 0]), np.interp(at, chainage, line[:, 1])
    chord = np.arctan2(np.diff(y), np.diff(x))
    change = wrapped(np.diff(chord, append=chord[0]))
    if not closed:
        change[-1] = 0.0
    turn = (np.roll(change, 1) + change) / 2
    if closed:
        turn = (np.roll(turn, 1) + 2 * turn + np.roll(turn, -1)) / 4
    start = np.array([x[0], y[0], chord[0] - change[-1] / 2])
    return _Row(start, turn, float(chainage[-1] / arcs), chainage[: len(points)])


def _to_one_side(row: _Row, points: FloatArray, closed: bool, stiffness: float) -> _Row | None:
    """Return the row with its counter-bends made straight, None where that is too far from the points."""
    side = np.sign(row.turn.sum())
    free = np.ones(len(row.turn), bool)
    found: _Row | None = row
    while found is not None:
        bent_back = side * found.turn < 0
        if not bent_back.any():
            return found
        free &= ~bent_back
        found = _solved(found, points, closed, stiffness, free)
    return None


def _solved(row: _Row, points: FloatArray, closed: bool, stiffness: float, free: BoolArray) -> _Row | None:
    """Return the row after least squares (Gauss-Newton), or None if it does not settle close to the points.

    Arcs that are not free are straight. Unknowns are start, turns and step. A closed row ends exactly where and as
    it started (Lagrange multipliers).
    """
    columns = np.concatenate([[0, 1, 2], 3 + np.flatnonzero(free), [3 + len(free)]])
    row = replace(row, turn=np.where(free, row.turn, 0.0))
    around = 2 * np.pi * np.sign(row.turn.sum())
    smooth = _smoothness(row, closed, stiffness * len(points))
    for _ in range(_ITERATIONS):
        row = replace(row, s=_projected(row, points, closed))
        error, jacobian = _errors(row, points, closed)
        gap, closing = _gap(row, around) if closed else (np.zeros(0), np.zeros((0, len(free) + 4)))
        size = len(columns)
        system = np.zeros((size + len(gap), size + len(gap)))
        system[:size, :size] = (jacobian.T @ jacobian + smooth.T @ smooth)[np.ix_(columns, columns)]
        system[size:, :size] = closing[:, columns]
        system[:size, size:] = closing[:, columns].T
        rough = smooth @ np.concatenate([np.zeros(3), row.turn, [0.0]])
        slope = (jacobian.T @ error + smooth.T @ rough)[columns]
        change = np.zeros(len(free) + 4)
        change[columns] = np.linalg.solve(system, -np.concatenate([slope, gap]))[:size]
        # A far step would follow the tangent to where it is none.
        change *= min(1.0, _FARTHEST_TURN / float(np.abs(change[2:-1]).max()))
        row = _changed(row, change)
        if row.step <= 0.0:
            return None
        if np.abs(change).max() < _LAST_STEP and np.abs(gap).max(initial=0.0) < _LAST_GAP:
            row = _joined_up(row, around, columns) if closed else row
            return row if _comes_close(row, points) else None
    return None


def _joined_up(row: _Row, around: float, columns: IntArray) -> _Row:
    """Return a row that all but closes with what is missing spread over all its unknowns."""
    for _ in range(_ITERATIONS):
        gap, closing = _gap(row, around)
        change = np.zeros(closing.shape[1])
        change[columns] = -np.linalg.lstsq(closing[:, columns], gap, rcond=None)[0]
        row = _changed(row, change)
        if np.abs(gap).max() < _CLOSED:
            break
    return row


def _changed(row: _Row, change: FloatArray) -> _Row:
    """Return the row with its unknowns changed; points stay at the same share of it."""
    step = row.step + float(change[-1])
    return _Row(row.start + change[:3], row.turn + change[3:-1], step, row.s * (step / row.step))


def _comes_close(row: _Row, points: FloatArray) -> bool:
    """Whether a row passes the points in their order and near enough, without a bend too sharp for cars."""
    x, y, _ = _at(row).T
    distance = np.hypot(points[:, 0] - x, points[:, 1] - y)
    ordered = (np.diff(row.s) > 0).all() and row.s[-1] <= row.step * len(row.turn) + 1e-6
    rms = np.sqrt((distance**2).mean())
    drivable = np.abs(row.turn).max() * CONNECTING_RADIUS <= row.step
    return bool(ordered and drivable and distance.max() <= defaults.RING_TOLERANCE and rms <= defaults.RING_CURVE_RMS)


def _arc_of(row: _Row) -> IntArray:
    """Return the arc that each point is projected to."""
    out: IntArray = np.clip((row.s / row.step).astype(np.int64), 0, len(row.turn) - 1)
    return out


def _at(row: _Row) -> FloatArray:
    """Return x, y and heading at s of each point, (points, 3)."""
    arc = _arc_of(row)
    x, y, hdg = row.borders()[arc].T
    u, v, turn = arc_step(row.turn[arc] / row.step, row.s - arc * row.step)
    return np.column_stack([x + np.cos(hdg) * u - np.sin(hdg) * v, y + np.sin(hdg) * u + np.cos(hdg) * v, hdg + turn])


def _projected(row: _Row, points: FloatArray, closed: bool) -> FloatArray:
    """Return s of the points moved towards where their perpendiculars meet the curve."""
    x, y, hdg = _at(row).T
    ahead = (points[:, 0] - x) * np.cos(hdg) + (points[:, 1] - y) * np.sin(hdg)
    s: FloatArray = row.s + np.clip(ahead, -row.step, row.step)
    s[0] = 0.0
    if not closed:
        s[-1] = row.step * len(row.turn)
    return s


def _errors(row: _Row, points: FloatArray, closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return how far left of the points the curve lies, then how far ahead of its ends; and the Jacobian."""
    x, y, hdg = _at(row).T
    by_x, by_y = _derivatives(row, np.column_stack([x, y]), row.s)
    dx, dy = x - points[:, 0], y - points[:, 1]
    sin, cos = np.sin(hdg), np.cos(hdg)
    held = [0] if closed else [0, -1]
    error = np.concatenate([dy * cos - dx * sin, (dx * cos + dy * sin)[held]])
    left = by_y * cos[:, None] - by_x * sin[:, None]
    ahead = by_x[held] * cos[held, None] + by_y[held] * sin[held, None]
    return error, np.concatenate([left, ahead])


def _gap(row: _Row, around: float) -> tuple[FloatArray, FloatArray]:
    """Return by how much a row does not close, x, y and heading, and its derivatives, (3, unknowns)."""
    borders = row.borders()
    end = borders[-1:, :2]
    by_x, by_y = _derivatives(row, end, np.array([len(row.turn) * row.step]))
    by_x[0, 0] -= 1.0
    by_y[0, 1] -= 1.0
    by_hdg = np.concatenate([np.zeros(3), np.ones(len(row.turn)), [0.0]])
    gap = np.append(end[0] - borders[0, :2], row.turn.sum() - around)
    return gap, np.stack([by_x[0], by_y[0], by_hdg])


def _derivatives(row: _Row, place: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of x and of y of places on the curve by all unknowns, both (places, unknowns).

    A turn swings what lies beyond its arc about the arc's end, and what lies within the arc by the mean of the turn
    so far. The tangent at two thirds stands for that of the part of an arc weighted by its s, which is exact for a
    line and leaves the solution as it is.
    """
    borders = row.borders()
    arcs = len(row.turn)
    number = np.arange(arcs)
    within = np.clip(s[:, None] - number * row.step, 0.0, row.step)
    mean_hdg = borders[:-1, 2] + row.turn / row.step * within * (2 / 3)
    swung = within**2 / (2 * row.step)
    beyond = s[:, None] > (number + 1) * row.step
    lever_x = np.where(beyond, place[:, :1] - borders[1:, 0], 0.0) + swung * np.cos(mean_hdg)
    lever_y = np.where(beyond, place[:, 1:] - borders[1:, 1], 0.0) + swung * np.sin(mean_hdg)
    from_start = place - row.start[:2]
    ones, zeros = np.ones((len(s), 1)), np.zeros((len(s), 1))
    by_x = np.concatenate([ones, zeros, -from_start[:, 1:], -lever_y, from_start[:, :1] / row.step], axis=1)
    by_y = np.concatenate([zeros, ones, from_start[:, :1], lever_x, from_start[:, 1:] / row.step], axis=1)
    return by_x, by_y


def _smoothness(row: _Row, closed: bool, weight: float) -> FloatArray:
    """Return rows whose squares sum up to the change of curvature along the row, (changes, unknowns).

    It is the integral of (dκ/ds)², made a length squared by the fifth power of the mean radius.
    """
    arcs = len(row.turn)
    radius = arcs * row.step / max(abs(float(row.turn.sum())), 0.1)
    change = np.roll(np.eye(arcs), 1, axis=1) - np.eye(arcs)
    if not closed:
        change = change[:-1]
    out = np.zeros((len(change), arcs + 4))
    out[:, 3:-1] = change * np.sqrt(weight * (radius / row.step) ** 5 * row.step**2)
    return out


def _plan(row: _Row) -> PlanView:
    x, y, hdg = np.ascontiguousarray(row.borders()[:-1].T)
    arcs = len(row.turn)
    step = np.full(arcs, row.step)
    return PlanView(np.array([0, arcs]), np.arange(arcs) * row.step, x, y, hdg, step, row.turn / row.step)
