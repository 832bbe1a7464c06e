"""Spirals (clothoids): curves whose curvature grows evenly along them."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.special import roots_legendre

from osm2xodr.model import FloatArray

# Series for panels that turn by no more, at the curvature of their sharper end, rad; only damaged files have spirals
# that need more than so many panels.
_PANEL_TURN: Final = 1.0
_MOST_PANELS: Final = 512
# Newton's method ends where it moves a place by less, m; the least slope that steps are divided by.
_NEWTON_ROUNDS: Final = 12
_NEWTON_TOLERANCE: Final = 1e-9
_LEAST_SLOPE: Final = 0.2
# The same for the shape of a clothoid between two headings, rad; -1/6 is its slope where it is straight.
_SHAPE_TOLERANCE: Final = 1e-13
_LEAST_SHAPE_SLOPE: Final = 2e-2
# Gauss-Legendre quadrature for whole spirals between two headings, which turn by 2.4 rad at most. Those that turn by
# less than a panel are found by series, in so many rounds.
_BETWEEN: Final = roots_legendre(12)
_SERIES_ROUNDS: Final = 4
_NO_ROWS: Final = np.zeros(0, np.int64)
_Step = tuple[FloatArray, FloatArray, FloatArray]


def arc_step(curvature: FloatArray, ds: FloatArray, rate: FloatArray | None = None) -> _Step:
    """Return u, v and the turn of a curve after ds, in the frame of its start tangent.

    The curvature is constant, or curvature + rate · s.
    """
    chord, towards, turn = chords(curvature, ds, rate)
    return chord * np.cos(towards), chord * np.sin(towards), turn


def spiral_step(curvature: FloatArray, rate: FloatArray, ds: FloatArray) -> _Step:
    """Return u, v and the turn after ds of clothoids, (n,), in the frames of their starts."""
    return arc_step(curvature, ds, rate)


def chords(curvature: FloatArray, ds: FloatArray, rate: FloatArray | None = None) -> _Step:
    """Return length, direction and turn of the chords of curves over ds, in the frames of their starts, (n,).

    The curvature is constant, or curvature + rate · s. The chord of an arc, sinc(a) · ds with half its turn a, needs
    no case of its own for lines.
    """
    half = 0.5 * ds
    towards = half * curvature
    spiral = _NO_ROWS if rate is None else np.flatnonzero(rate)
    if rate is None or not len(spiral):
        chord = _sinc(towards)
        chord *= ds
        return chord, towards, 2.0 * towards
    every = len(spiral) == len(ds)
    rates, halves = (rate, half) if every else (rate[spiral], half[spiral])
    bend = 0.5 * rates * halves * halves
    towards[spiral] += 2.0 * bend
    turn, chord = 2.0 * towards, _sinc(towards)
    mean = towards if every else towards[spiral]
    shorter, aside = _unlike_arcs(mean, bend)
    chord[spiral] += shorter
    chord *= ds
    towards[spiral] += aside - bend
    sharp = np.flatnonzero(~(np.abs(mean) + 2.0 * np.abs(bend) <= 0.5 * _PANEL_TURN))
    if len(sharp):
        row = spiral[sharp]
        chord[row], towards[row] = _in_panels(curvature[row], rate[row], ds[row])
    return chord, towards, turn


def _sinc(a: FloatArray) -> FloatArray:
    """Return sin(a) / a, (n,)."""
    # Adding 1 where it is 0 takes less time than dividing elsewhere alone.
    zero = a == 0.0
    out = np.sin(a)
    out += zero
    out /= a + zero
    return out


def _unlike_arcs(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much chords of clothoids differ from those of arcs: in length, as a share of ds, and direction.

    From the middle, with q from -1 to 1, the turn is a q + b q². These are the series in a and b of the absolute
    value, less sinc(a), and of the angle of the mean of exp(i (a q + b q²)); what is left out is below 1e-10 where
    |a| + 2 |b| is below half of `_PANEL_TURN`.
    """
    a2, b2 = a * a, b * b
    longer = b2 * (
        (-2 / 45 + a2 * (11 / 945 + a2 * (11 / 56700 + a2 * (173 / 3742200 + a2 * (175379 / 40864824000)))))
        + b2 * (2 / 2835 - a2 * (1 / 7425) - b2 * (316 / 127702575))
    )
    return longer, b * _aside(_aside_series(a2), b2)


def _aside_series(a2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factors of b and -b³ in the angle of `_unlike_arcs`, by a²."""
    straight = 1 / 3 - a2 * (2 / 45 + a2 * (4 / 945 + a2 * (2 / 4725 + a2 * (4 / 93555 + a2 * (2764 / 638512875)))))
    return straight, 8 / 2835 + a2 * (8 / 14175 - a2 * (8 / 66825))


def _aside(series: tuple[FloatArray, FloatArray], b2: FloatArray) -> FloatArray:
    """Return the angle of `_unlike_arcs` by b, of b²."""
    straight, third = series
    return straight - b2 * (third + b2 * (32 / 467775 + b2 * (2944 / 1915538625)))


def _in_panels(curvature: FloatArray, rate: FloatArray, ds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return length and direction of the chords of clothoids in as many panels as each turn needs, (n,)."""
    whole = np.fmax(np.abs(curvature), np.abs(curvature + rate * ds)) * np.abs(ds)
    panels = np.clip(np.ceil(np.nan_to_num(whole, posinf=np.inf) / _PANEL_TURN), 1, _MOST_PANELS)
    step = ds / panels
    bend = 0.125 * rate * step * step
    end = np.zeros(len(ds), complex)
    for panel in range(int(panels.max())):
        at = panel * step
        a = 0.5 * step * (curvature + rate * (at + 0.5 * step))
        longer, aside = _unlike_arcs(a, bend)
        towards = at * (curvature + 0.5 * rate * at) + a - bend + aside
        end += np.where(panel < panels, step * (_sinc(a) + longer), 0.0) * np.exp(1j * towards)
    return np.abs(end), np.angle(end)


def spirals_between(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape and length of clothoids over a chord of length 1 from heading a to b, relative to it, (n,).

    The turn after the share q of such a clothoid is (b - a - A) q + A q², with A its shape: its curvature times its
    length is b - a - A at its start and b - a + A at its end (Bertolazzi and Frego 2015, doi:10.1002/mma.3114).
    That A ends on the chord whose direction, by the series of `_unlike_arcs` with a quarter of A, is -a; Newton's
    method finds it where spirals turn by more.
    """
    turn, aim = 0.5 * (b - a), 0.5 * (a + b)
    series = _aside_series(turn * turn)
    bend = 1.5 * aim
    for _ in range(_SERIES_ROUNDS):
        bend = aim / (1.0 - _aside(series, bend * bend))
    shape, ahead = 4.0 * bend, _sinc(turn) + _unlike_arcs(turn, bend)[0]
    row = np.flatnonzero(np.abs(turn) + 2.0 * np.abs(bend) > 0.5 * _PANEL_TURN)
    if len(row):
        shape[row], ahead[row] = _between(a[row], b[row])
    return shape, 1.0 / np.maximum(ahead, _LEAST_SLOPE)


def _between(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shape of clothoids from heading a to b, and their chord by their length, (n,)."""
    turn = b - a
    shape = 3.0 * (a + b)
    for _ in range(_NEWTON_ROUNDS):
        off, slope, ahead = np.zeros(len(a)), np.zeros(len(a)), np.zeros(len(a))
        for node, weight in zip(*(item.tolist() for item in _BETWEEN), strict=True):
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
