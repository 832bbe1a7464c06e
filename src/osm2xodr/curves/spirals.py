"""Spirals (clothoids): curves whose curvature grows evenly along them."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.special import roots_legendre

from osm2xodr.model import FloatArray

# Gauss-Legendre quadrature: this many points integrate a panel that turns by so much, rad, to the last digit, and so
# few do where it turns by less; only damaged files have spirals that need more than so many panels.
_POINTS: Final = 7
_PANEL_TURN: Final = 0.8
_SHORT_POINTS: Final = 5
_SHORT_PANEL_TURN: Final = 0.2
_MOST_PANELS: Final = 512
# Newton's method ends where it moves a place by less, m; the least slope that steps are divided by.
_NEWTON_ROUNDS: Final = 12
_NEWTON_TOLERANCE: Final = 1e-9
_LEAST_SLOPE: Final = 0.2
# The same for the shape of a clothoid between two headings, rad; -1/6 is its slope where it is straight.
_SHAPE_TOLERANCE: Final = 1e-13
_LEAST_SHAPE_SLOPE: Final = 2e-2
# The weight of the middle of a panel, and the node and twice the weight of each pair of points about it.
_Rule = tuple[float, tuple[tuple[float, float], ...]]


def _rule(points: int) -> _Rule:
    """Return the rule of an odd number of points."""
    nodes, weights = roots_legendre(points)
    half = points // 2
    return float(weights[half]), tuple(
        zip(nodes[half + 1 :].tolist(), (2 * weights[half + 1 :]).tolist(), strict=True)
    )


_RULE: Final = _rule(_POINTS)
_SHORT_RULE: Final = _rule(_SHORT_POINTS)
# The same for whole spirals between two headings, which turn by 2.4 rad at most, and for those whose headings both
# differ by less than so many rad from that of the chord.
_BETWEEN: Final = roots_legendre(12)
_BETWEEN_SMALL: Final = roots_legendre(7)
_SMALL: Final = 0.25

_Step = tuple[FloatArray, FloatArray, FloatArray]


def arc_step(curvature: FloatArray, ds: FloatArray, rate: FloatArray | None = None) -> _Step:
    """Return u, v and the turn of a curve after ds, in the frame of its start tangent.

    The curvature is constant, or curvature + rate · s. The chord of an arc is written with sinc, so that lines need
    no case of their own: u + iv = ds · sinc(k·ds/2) · exp(i·k·ds/2).
    """
    if rate is None:
        return _arc(curvature, ds)
    spiral = rate != 0.0
    if spiral.all():
        return spiral_step(curvature, rate, ds)
    if not spiral.any():
        return _arc(curvature, ds)
    out = np.empty((3, len(ds)))
    for row, found in (
        (k := np.flatnonzero(~spiral), _arc(curvature[k], ds[k])),
        (k := np.flatnonzero(spiral), spiral_step(curvature[k], rate[k], ds[k])),
    ):
        out[:, row] = found
    return out[0], out[1], out[2]


def _arc(curvature: FloatArray, ds: FloatArray) -> _Step:
    """Return u, v and the turn of an arc after ds."""
    turn = curvature * ds
    half = 0.5 * turn
    chord = ds * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half), turn


def spiral_step(curvature: FloatArray, rate: FloatArray, ds: FloatArray) -> _Step:
    """Return u, v and the turn after ds of clothoids, (n,), in the frames of their starts.

    The curvature is curvature + rate · s. Gauss-Legendre quadrature integrates cos and sin of the turn, in as many
    panels as each turn needs.
    """
    whole = np.fmax(np.abs(curvature), np.abs(curvature + rate * ds)) * np.abs(ds)
    turn = ds * (curvature + 0.5 * rate * ds)
    short = whole < _SHORT_PANEL_TURN
    if short.all():
        return *_panel(curvature, rate, ds, _SHORT_RULE), turn
    u, v = np.empty(len(ds)), np.empty(len(ds))
    row = np.flatnonzero(short)
    u[row], v[row] = _panel(curvature[row], rate[row], ds[row], _SHORT_RULE)
    panels = np.clip(np.ceil(np.nan_to_num(whole, posinf=np.inf) / _PANEL_TURN), 1, _MOST_PANELS).astype(np.int64)
    panels[short] = 0
    for count in np.unique(panels[~short]).tolist():
        row = np.flatnonzero(panels == count)
        first, change, step = curvature[row], rate[row], ds[row] / count
        x, y = _panel(first, change, step, _RULE)
        for panel in range(1, count):
            at = panel * step
            towards = at * (first + 0.5 * change * at)
            ahead, aside = _panel(first + change * at, change, step, _RULE)
            cos, sin = np.cos(towards), np.sin(towards)
            x, y = x + cos * ahead - sin * aside, y + sin * ahead + cos * aside
        u[row], v[row] = x, y
    return u, v, turn


def _panel(curvature: FloatArray, rate: FloatArray, ds: FloatArray, rule: _Rule) -> tuple[FloatArray, FloatArray]:
    """Return u and v after ds of clothoids, (n,), that turn little.

    From the middle, with q from -1 to 1, the turn is a q + b q²: what is odd in q cancels out.
    """
    half = 0.5 * ds
    b = 0.5 * rate * half * half
    a = half * (curvature + rate * half)
    ahead, aside = np.full(len(ds), rule[0]), np.zeros(len(ds))
    for node, weight in rule[1]:
        even, bend = weight * np.cos(node * a), node * node * b
        ahead += even * np.cos(bend)
        aside += even * np.sin(bend)
    cos, sin = np.cos(a - b), np.sin(a - b)
    return half * (cos * ahead - sin * aside), half * (sin * ahead + cos * aside)


def spirals_between(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape and length of clothoids over a chord of length 1 from heading a to b, relative to it, (n,).

    The turn after the share q of such a clothoid is (b - a - A) q + A q², with A its shape: its curvature times its
    length is b - a - A at its start and b - a + A at its end (Bertolazzi and Frego 2015, doi:10.1002/mma.3114).
    Newton's method finds the A that ends on the chord.
    """
    shape, ahead = np.empty(len(a)), np.empty(len(a))
    small = np.maximum(np.abs(a), np.abs(b)) < _SMALL
    for row, rule in ((np.flatnonzero(small), _BETWEEN_SMALL), (np.flatnonzero(~small), _BETWEEN)):
        if len(row):
            shape[row], ahead[row] = _between(a[row], b[row], *rule)
    return shape, 1.0 / np.maximum(ahead, _LEAST_SLOPE)


def _between(a: FloatArray, b: FloatArray, nodes: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shape of clothoids from heading a to b, and their chord by their length, (n,)."""
    turn = b - a
    shape = 3.0 * (a + b)
    for _ in range(_NEWTON_ROUNDS):
        off, slope, ahead = np.zeros(len(a)), np.zeros(len(a)), np.zeros(len(a))
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            q = 0.5 * (1.0 + node)
            heading = a + q * (turn - shape + shape * q)
            cos = weight * np.cos(heading)
            off += weight * np.sin(heading)
            slope += (q * q - q) * cos
            ahead += cos
        step = off / np.where(slope < -_LEAST_SHAPE_SLOPE, slope, -1.0 / 3.0)
        if float(np.abs(step).max(initial=0.0)) < _SHAPE_TOLERANCE:
            break
        shape = shape - step
    return shape, 0.5 * ahead


def nearest_on_spirals(
    curvature: FloatArray, rate: FloatArray, length: FloatArray, u: FloatArray, v: FloatArray, guess: FloatArray
) -> FloatArray:
    """Return how far along spirals the places nearest to points u, v (in the frames of their starts) lie, (n,), m.

    Newton's method on the distance along the tangent, from a guess; steps are short near the centre of the bend.
    """
    s = np.clip(guess, 0.0, length)
    row = np.arange(len(s))
    for _ in range(_NEWTON_ROUNDS):
        k, change, at = curvature[row], rate[row], s[row]
        x, y, hdg = spiral_step(k, change, at)
        dx, dy = u[row] - x, v[row] - y
        cos, sin = np.cos(hdg), np.sin(hdg)
        ahead, aside = dx * cos + dy * sin, dy * cos - dx * sin
        slope = np.maximum(1.0 - (k + change * at) * aside, _LEAST_SLOPE)
        s[row] = after = np.clip(at + ahead / slope, 0.0, length[row])
        row = row[np.abs(after - at) >= _NEWTON_TOLERANCE]
        if not len(row):
            break
    return s
