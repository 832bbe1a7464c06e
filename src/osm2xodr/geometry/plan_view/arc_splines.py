"""Arc splines: smooth curves of many arcs through points, for lines that are neither straight nor circles.

A spline is a row of arcs of equal length, each of which begins in the heading in which the one before it ends. Least
squares make it pass the points with as little change of curvature as possible (a discrete minimum variation curve
after Moreton and Séquin 1992, doi:10.1145/142920.134035): a circle where a circle fits, an oval for an oval.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import advance, arc_step, arctan2, cosine, hypot, running_lengths, sine, solve_dense, wrapped
from osm2xodr.defaults import CONNECTING_RADIUS
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# Arcs of a spline: enough for an oval, few enough to solve quickly. Choices.
_FEWEST_ARCS: Final = 20
_MOST_ARCS: Final = 60
# Weights of the change of curvature against the distance from the points; the largest that fits is taken.
_STIFFNESS: Final = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
# How many steps of stiffness a spline gives up to have no counter-bends; a choice.
_STEPS_LOOSER: Final = 3
# How much more than the line a spline may turn forth and back, rad, and by how much the turn of a ring may differ
# from a full circle before it is fitted, rad. Choices.
_SWING: Final = 0.1
_RING_TURN_ERROR: Final = 0.1
# Gauss-Newton: iterations; change of a turn in one of them at most, rad; it has converged where a step is smaller
# than this, m and rad, and a ring all but closes, m. Then the ring is closed to the last, m.
_ITERATIONS: Final = 25
_TURN_STEP_MAX: Final = 0.3
_CONVERGED_STEP: Final = 2e-3
_CONVERGED_GAP: Final = 1e-3
_CLOSED_GAP: Final = 1e-9


@record(eq=False)
class _Spline:
    """A row of arcs, and where the points lie on it."""

    start: FloatArray  # (3,) x, y and heading of its start
    turn: FloatArray  # (arcs,) Turn of each arc, rad
    step: float  # Length of each arc, m
    s: FloatArray  # (points,) Where each point is projected to, m; the first stays at 0

    def borders(self) -> FloatArray:
        """Return x, y and heading where the arcs start and where the last ends, (arcs + 1, 3)."""
        hdg = self.start[2] + np.concatenate([[0.0], np.cumsum(self.turn)])
        u, v, _ = arc_step(self.turn / self.step, np.full(len(self.turn), self.step))
        cos, sin = cosine(hdg[:-1]), sine(hdg[:-1])
        x = self.start[0] + np.concatenate([[0.0], np.cumsum(cos * u - sin * v)])
        y = self.start[1] + np.concatenate([[0.0], np.cumsum(sin * u + cos * v)])
        return np.column_stack([x, y, hdg])


def fit_arcs(points: FloatArray, closed: bool) -> tuple[PlanView, FloatArray] | None:
    """Return the smoothest spline that passes points (n, 2) in their order, and s of each, m.

    None where no spline comes close enough (`RING_TOLERANCE`, `RING_CURVE_RMS`) without bends that the line does not
    have. Where bends to one side are enough, there are no others. A closed line goes on from its last point to its
    first, once around.
    """
    guess = _first_guess(points, closed)
    if closed and abs(abs(guess.turn.sum()) - 2 * np.pi) > _RING_TURN_ERROR:
        return None
    free = np.ones(len(guess.turn), bool)
    best: _Spline | None = None
    low, high = -1, len(_STIFFNESS)
    while high - low > 1:
        middle = (low + high) // 2
        found = _solved(best or guess, points, closed, _STIFFNESS[middle], free)
        if found is None:
            high = middle
        else:
            best, low = found, middle
    if best is None:
        return None
    for number in range(low, max(low - _STEPS_LOOSER, -1), -1):
        one_sided = _to_one_side(best, points, closed, _STIFFNESS[number])
        if one_sided is not None:
            return _plan(one_sided), one_sided.s
    # A spline that swings about sharp corners is no better than the corners.
    swings = np.abs(best.turn).sum() - np.abs(turns_of(points, closed)).sum()
    return None if swings > _SWING else (_plan(best), best.s)


def turns_of(points: FloatArray, closed: bool) -> FloatArray:
    """Return the turns of a polyline at its points (at its inner points unless it is closed), rad."""
    line = np.concatenate([points, points[:2]]) if closed else points
    step = np.diff(line, axis=0)
    return wrapped(np.diff(arctan2(step[:, 1], step[:, 0])))


def _first_guess(points: FloatArray, closed: bool) -> _Spline:
    """Return arcs along the polyline, whose corners they round somewhat."""
    line = np.concatenate([points, points[:1]]) if closed else points
    chainage = running_lengths(line)
    arcs = int(np.clip(np.ceil(chainage[-1] / defaults.RING_ARC), _FEWEST_ARCS, _MOST_ARCS))
    at = np.linspace(0.0, chainage[-1], arcs + 1)
    x, y = np.interp(at, chainage, line[:, 0]), np.interp(at, chainage, line[:, 1])
    chord = arctan2(np.diff(y), np.diff(x))
    change = wrapped(np.diff(chord, append=chord[0]))
    if not closed:
        change[-1] = 0.0
    turn = (np.roll(change, 1) + change) / 2
    if closed:
        turn = (np.roll(turn, 1) + 2 * turn + np.roll(turn, -1)) / 4
    start = np.array([x[0], y[0], chord[0] - change[-1] / 2])
    return _Spline(start, turn, float(chainage[-1] / arcs), chainage[: len(points)])


def _to_one_side(spline: _Spline, points: FloatArray, closed: bool, stiffness: float) -> _Spline | None:
    """Return the spline with its counter-bends made straight; None where that is too far from the points."""
    side = np.sign(spline.turn.sum())
    free = np.ones(len(spline.turn), bool)
    found: _Spline | None = spline
    while found is not None:
        bent_back = side * found.turn < 0
        if not bent_back.any():
            return found
        free &= ~bent_back
        found = _solved(found, points, closed, stiffness, free)
    return None


def _solved(spline: _Spline, points: FloatArray, closed: bool, stiffness: float, free: BoolArray) -> _Spline | None:
    """Return the spline after least squares (Gauss-Newton), or None if it does not converge close to the points.

    Unknowns are start, turns and step; arcs that are not free are straight. Lagrange multipliers make a closed spline
    end exactly in the pose in which it starts.
    """
    columns = np.concatenate([[0, 1, 2], 3 + np.flatnonzero(free), [3 + len(free)]])
    spline = replace(spline, turn=np.where(free, spline.turn, 0.0))
    around = 2 * np.pi * np.sign(spline.turn.sum())
    smooth = _smoothness(spline, closed, stiffness * len(points))
    for _ in range(_ITERATIONS):
        spline = replace(spline, s=_projected(spline, points, closed))
        error, jacobian = _errors(spline, points, closed)
        gap, closing = _gap(spline, around) if closed else (np.zeros(0), np.zeros((0, len(free) + 4)))
        size = len(columns)
        system = np.zeros((size + len(gap), size + len(gap)))
        normal = np.einsum("ki,kj->ij", jacobian, jacobian) + np.einsum("ki,kj->ij", smooth, smooth)
        system[:size, :size] = normal[np.ix_(columns, columns)]
        system[size:, :size] = closing[:, columns]
        system[:size, size:] = closing[:, columns].T
        rough = np.einsum("ki,i->k", smooth, np.concatenate([np.zeros(3), spline.turn, [0.0]]))
        slope = (np.einsum("ki,k->i", jacobian, error) + np.einsum("ki,k->i", smooth, rough))[columns]
        change = np.zeros(len(free) + 4)
        change[columns] = solve_dense(system, -np.concatenate([slope, gap])[:, None])[:size, 0]
        # Far from here the derivatives are not valid.
        change *= min(1.0, _TURN_STEP_MAX / float(np.abs(change[2:-1]).max()))
        spline = _changed(spline, change)
        if spline.step <= 0.0:
            return None
        if np.abs(change).max() < _CONVERGED_STEP and np.abs(gap).max(initial=0.0) < _CONVERGED_GAP:
            spline = _closed_up(spline, around, columns) if closed else spline
            return spline if _comes_close(spline, points) else None
    return None


def _closed_up(spline: _Spline, around: float, columns: IntArray) -> _Spline:
    """Close a spline that all but closes: the least change of its unknowns that does."""
    for _ in range(_ITERATIONS):
        gap, closing = _gap(spline, around)
        change = np.zeros(closing.shape[1])
        by = closing[:, columns]
        change[columns] = -np.einsum("ki,k->i", by, solve_dense(np.einsum("ik,jk->ij", by, by), gap[:, None])[:, 0])
        spline = _changed(spline, change)
        if np.abs(gap).max() < _CLOSED_GAP:
            break
    return spline


def _changed(spline: _Spline, change: FloatArray) -> _Spline:
    """Return the spline with its unknowns changed; points stay at the same share of it."""
    step = spline.step + float(change[-1])
    return _Spline(spline.start + change[:3], spline.turn + change[3:-1], step, spline.s * (step / spline.step))


def _comes_close(spline: _Spline, points: FloatArray) -> bool:
    """Whether a spline passes the points in their order and near enough, without a bend too sharp for cars."""
    x, y, _ = _at(spline).T
    distance = hypot(points[:, 0] - x, points[:, 1] - y)
    ordered = (np.diff(spline.s) > 0).all() and spline.s[-1] <= spline.step * len(spline.turn) + 1e-6
    rms = np.sqrt((distance**2).mean())
    drivable = np.abs(spline.turn).max() * CONNECTING_RADIUS <= spline.step
    return bool(ordered and drivable and distance.max() <= defaults.RING_TOLERANCE and rms <= defaults.RING_CURVE_RMS)


def _at(spline: _Spline) -> FloatArray:
    """Return x, y and heading at s of each point, (points, 3)."""
    arc = np.clip((spline.s / spline.step).astype(np.int64), 0, len(spline.turn) - 1)
    x, y, hdg = spline.borders()[arc].T
    return np.column_stack(advance(x, y, hdg, spline.turn[arc] / spline.step, spline.s - arc * spline.step))


def _projected(spline: _Spline, points: FloatArray, closed: bool) -> FloatArray:
    """Return s of the points, moved towards where their perpendiculars meet the spline."""
    x, y, hdg = _at(spline).T
    ahead = (points[:, 0] - x) * cosine(hdg) + (points[:, 1] - y) * sine(hdg)
    s: FloatArray = spline.s + np.clip(ahead, -spline.step, spline.step)
    s[0] = 0.0
    if not closed:
        s[-1] = spline.step * len(spline.turn)
    return s


def _errors(spline: _Spline, points: FloatArray, closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return how far left of the points the spline lies, and how far ahead of its ends, m, and the Jacobian."""
    x, y, hdg = _at(spline).T
    by_x, by_y = _derivatives(spline, np.column_stack([x, y]), spline.s)
    dx, dy = x - points[:, 0], y - points[:, 1]
    sin, cos = sine(hdg), cosine(hdg)
    held = [0] if closed else [0, -1]
    error = np.concatenate([dy * cos - dx * sin, (dx * cos + dy * sin)[held]])
    left = by_y * cos[:, None] - by_x * sin[:, None]
    ahead = by_x[held] * cos[held, None] + by_y[held] * sin[held, None]
    return error, np.concatenate([left, ahead])


def _gap(spline: _Spline, around: float) -> tuple[FloatArray, FloatArray]:
    """Return by how much a spline does not close, x, y and heading, and the derivatives, (3, unknowns)."""
    borders = spline.borders()
    end = borders[-1:, :2]
    by_x, by_y = _derivatives(spline, end, np.array([len(spline.turn) * spline.step]))
    by_x[0, 0] -= 1.0
    by_y[0, 1] -= 1.0
    by_hdg = np.concatenate([np.zeros(3), np.ones(len(spline.turn)), [0.0]])
    gap = np.append(end[0] - borders[0, :2], spline.turn.sum() - around)
    return gap, np.stack([by_x[0], by_y[0], by_hdg])


def _derivatives(spline: _Spline, place: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of x and of y of places on the spline by all unknowns, both (places, unknowns).

    A turn swings everything beyond its arc about the arc's end, and places within the arc by their share of the turn.
    There the tangent at two thirds of the way stands for the mean tangent weighted by s: exact for a line, and near
    enough for the iteration to end at the same solution.
    """
    borders = spline.borders()
    arcs = len(spline.turn)
    number = np.arange(arcs)
    within = np.clip(s[:, None] - number * spline.step, 0.0, spline.step)
    mean_hdg = borders[:-1, 2] + spline.turn / spline.step * within * (2 / 3)
    swung = within**2 / (2 * spline.step)
    beyond = s[:, None] > (number + 1) * spline.step
    lever_x = np.where(beyond, place[:, :1] - borders[1:, 0], 0.0) + swung * cosine(mean_hdg)
    lever_y = np.where(beyond, place[:, 1:] - borders[1:, 1], 0.0) + swung * sine(mean_hdg)
    from_start = place - spline.start[:2]
    ones, zeros = np.ones((len(s), 1)), np.zeros((len(s), 1))
    by_x = np.concatenate([ones, zeros, -from_start[:, 1:], -lever_y, from_start[:, :1] / spline.step], axis=1)
    by_y = np.concatenate([zeros, ones, from_start[:, :1], lever_x, from_start[:, 1:] / spline.step], axis=1)
    return by_x, by_y


def _smoothness(spline: _Spline, closed: bool, weight: float) -> FloatArray:
    """Return rows, (changes, unknowns), whose squares sum up to the weighted change of curvature along the spline.

    That is the integral of (dκ/ds)², made a length squared by the fifth power of the mean radius.
    """
    arcs = len(spline.turn)
    radius = arcs * spline.step / max(abs(float(spline.turn.sum())), 0.1)
    change = np.roll(np.eye(arcs), 1, axis=1) - np.eye(arcs)
    if not closed:
        change = change[:-1]
    out = np.zeros((len(change), arcs + 4))
    steps = radius / spline.step
    out[:, 3:-1] = change * (steps * steps * spline.step * math.sqrt(weight * steps))
    return out


def _plan(spline: _Spline) -> PlanView:
    """Return the spline as a table of one curve."""
    x, y, hdg = np.ascontiguousarray(spline.borders()[:-1].T)
    arcs = len(spline.turn)
    step = np.full(arcs, spline.step)
    return PlanView(np.array([0, arcs]), np.arange(arcs) * spline.step, x, y, hdg, step, spline.turn / spline.step)
