"""Lines, arcs and spirals (clothoids, whose curvature grows evenly along them): places along one record."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import trigonometry
from osm2xodr.model import FloatArray

# Series for panels that turn by no more, at the curvature of their sharper end, rad; only damaged files have spirals
# that need more than so many panels.
_PANEL_TURN: Final = 1.0
_MOST_PANELS: Final = 512.0
# Newton's method ends where it moves a place by less, m; the least slope that steps are divided by.
_NEWTON_ROUNDS: Final = 12
_NEWTON_TOLERANCE: Final = 1e-9
_LEAST_SLOPE: Final = 0.2
# The same for the shape of a clothoid between two headings, rad; -1/6 is its slope where it is straight.
_SHAPE_TOLERANCE: Final = 1e-13
_LEAST_SHAPE_SLOPE: Final = 2e-2
# Gauss-Legendre quadrature of 12 nodes (Abramowitz and Stegun 1964, table 25.4: those above 0) for whole spirals
# between two headings, which turn by 2.4 rad at most. Those that turn by less than a panel are found by series, in so
# many rounds.
_NODES: Final = (
    0.125233408511468915,
    0.367831498998180194,
    0.587317954286617447,
    0.769902674194304687,
    0.904117256370474857,
    0.981560634246719251,
)
_WEIGHTS: Final = (
    0.249147045813402785,
    0.233492536538354809,
    0.203167426723065922,
    0.160078328543346226,
    0.106939325995318431,
    0.0471753363865118272,
)
_SERIES_ROUNDS: Final = 4
_Pose = tuple[FloatArray, FloatArray, FloatArray]


def advance(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    hdg: npt.ArrayLike,
    curvature: npt.ArrayLike,
    ds: npt.ArrayLike,
    rate: npt.ArrayLike = 0.0,
) -> _Pose:
    """Return x, y and heading ds farther on, m and rad, where the curvature is curvature + rate · s.

    All may have any shapes that fit each other.
    """
    given = np.broadcast_arrays(*(np.asarray(values, np.float64) for values in (x, y, hdg, curvature, rate, ds)))
    out = np.empty((3, *given[0].shape))
    x, y, hdg, curvature, rate, ds = (values.ravel() for values in given)
    ends(x, y, hdg, curvature, rate, ds, out.reshape(3, -1))
    return out[0, ...], out[1, ...], out[2, ...]


def arc_step(curvature: npt.ArrayLike, ds: npt.ArrayLike, rate: npt.ArrayLike = 0.0) -> _Pose:
    """Return u, v and the turn of curves after ds, in the frames of their start tangents."""
    return advance(0.0, 0.0, 0.0, curvature, ds, rate)


def ends(
    x: FloatArray,
    y: FloatArray,
    hdg: FloatArray,
    curvature: FloatArray,
    rate: FloatArray,
    ds: FloatArray,
    out: FloatArray,
) -> None:
    """Write where curves lead from poses to: x, y and heading, (3, n)."""
    for k in range(len(ds)):
        out[0, k], out[1, k], out[2, k] = end(
            float(x[k]), float(y[k]), float(hdg[k]), float(curvature[k]), float(rate[k]), float(ds[k])
        )


def end(x: float, y: float, hdg: float, curvature: float, rate: float, ds: float) -> tuple[float, float, float]:
    """Return x, y and heading ds farther on than a pose, m and rad."""
    length, towards, turn = chord(curvature, rate, ds)
    sine, cosine = trigonometry.sine_cosine(towards + hdg)
    return cosine * length + x, sine * length + y, turn + hdg


def chord(curvature: float, rate: float, ds: float) -> tuple[float, float, float]:
    """Return length, direction and turn of the chord of a curve over ds, in the frame of its start.

    The chord of an arc, sinc(a) · ds with half its turn a, needs no case of its own for lines.
    """
    half = 0.5 * ds
    bend = 0.5 * rate * half * half
    mean = half * curvature + 2.0 * bend
    if rate == 0.0:
        return _sinc(mean) * ds, mean, 2.0 * mean
    if abs(mean) + 2.0 * abs(bend) <= 0.5 * _PANEL_TURN:
        longer, aside = _unlike_arc(mean, bend)
        return (_sinc(mean) + longer) * ds, mean + (aside - bend), 2.0 * mean
    length, towards = _in_panels(curvature, rate, ds)
    return length, towards, 2.0 * mean


def _sinc(a: float) -> float:
    """Return sin(a) / a."""
    return trigonometry.sine_cosine(a)[0] / a if a != 0.0 else 1.0


def _unlike_arc(a: float, b: float) -> tuple[float, float]:
    """Return by how much chords of clothoids differ from those of arcs: in length, as a share of ds, and direction.

    From the middle, with q from -1 to 1, the turn is a q + b q². These are the series in a and b of the absolute
    value, less sinc(a), and of the angle of the mean of exp(i (a q + b q²)); what is left out is below 1e-10 where
    |a| + 2 |b| is below half of `_PANEL_TURN`.
    """
    a2, b2 = a * a, b * b
    sixth = 11.0 / 56700.0 + a2 * (173.0 / 3742200.0 + a2 * (175379.0 / 40864824000.0))
    longer = b2 * (
        (-2.0 / 45.0 + a2 * (11.0 / 945.0 + a2 * sixth))
        + b2 * (2.0 / 2835.0 - a2 * (1.0 / 7425.0) - b2 * (316.0 / 127702575.0))
    )
    return longer, b * _aside(a2, b2)


def _aside(a2: float, b2: float) -> float:
    """Return the angle of `_unlike_arc` by b, of a² and b²."""
    sixth = 2.0 / 4725.0 + a2 * (4.0 / 93555.0 + a2 * (2764.0 / 638512875.0))
    straight = 1.0 / 3.0 - a2 * (2.0 / 45.0 + a2 * (4.0 / 945.0 + a2 * sixth))
    third = 8.0 / 2835.0 + a2 * (8.0 / 14175.0 - a2 * (8.0 / 66825.0))
    return straight - b2 * (third + b2 * (32.0 / 467775.0 + b2 * (2944.0 / 1915538625.0)))


def _in_panels(curvature: float, rate: float, ds: float) -> tuple[float, float]:
    """Return length and direction of the chord of a clothoid in as many panels as its turn needs."""
    whole = max(abs(curvature), abs(curvature + rate * ds)) * abs(ds)
    panels = min(max(whole / _PANEL_TURN, 1.0), _MOST_PANELS) if whole >= 0.0 else 1.0
    count = int(panels)
    count += count < panels
    step = ds / count
    bend = 0.125 * rate * step * step
    u = v = 0.0
    for panel in range(count):
        at = panel * step
        a = 0.5 * step * (curvature + rate * (at + 0.5 * step))
        longer, aside = _unlike_arc(a, bend)
        length = step * (_sinc(a) + longer)
        sine, cosine = trigonometry.sine_cosine(at * (curvature + 0.5 * rate * at) + a - bend + aside)
        u += length * cosine
        v += length * sine
    return math.sqrt(u * u + v * v), trigonometry.arctangent(v, u)


def spirals_between(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape and length of clothoids over a chord of length 1 from heading a to b, relative to it, (n,).

    The turn after the share q of such a clothoid is (b - a - A) q + A q², with A its shape: its curvature times its
    length is b - a - A at its start and b - a + A at its end (Bertolazzi and Frego 2015, doi:10.1002/mma.3114).
    That A ends on the chord whose direction, by the series of `_unlike_arc` with a quarter of A, is -a; Newton's
    method finds it where spirals turn by more.
    """
    shape, length = np.empty((2, len(a)))
    nodes, weights = (np.array(values) for values in (_NODES, _WEIGHTS))
    shapes_between(a, b, np.append(-nodes, nodes), np.append(weights, weights), shape, length)
    return shape, length


def shapes_between(
    a: FloatArray, b: FloatArray, nodes: FloatArray, weights: FloatArray, shape: FloatArray, length: FloatArray
) -> None:
    """Write shape and length of clothoids between headings, with nodes and weights of the quadrature."""
    for k in range(len(a)):
        turn, aim = 0.5 * (float(b[k]) - float(a[k])), 0.5 * (float(a[k]) + float(b[k]))
        bend = 1.5 * aim
        for _ in range(_SERIES_ROUNDS):
            bend = aim / (1.0 - _aside(turn * turn, bend * bend))
        if abs(turn) + 2.0 * abs(bend) <= 0.5 * _PANEL_TURN:
            shape[k] = 4.0 * bend
            ahead = _sinc(turn) + _unlike_arc(turn, bend)[0]
        else:
            shape[k], ahead = _between(float(a[k]), float(b[k]), nodes, weights)
        length[k] = 1.0 / max(ahead, _LEAST_SLOPE)


def _between(a: float, b: float, nodes: FloatArray, weights: FloatArray) -> tuple[float, float]:
    """Return the shape of a clothoid from heading a to b, and its chord by its length."""
    turn, shape, ahead = b - a, 3.0 * (a + b), 0.0
    for _ in range(_NEWTON_ROUNDS):
        off = slope = ahead = 0.0
        for k in range(len(nodes)):
            q = 0.5 * (1.0 + float(nodes[k]))
            sine, cosine = trigonometry.sine_cosine(a + q * (turn - shape + shape * q))
            off += float(weights[k]) * sine
            slope += (q * q - q) * (float(weights[k]) * cosine)
            ahead += float(weights[k]) * cosine
        step = off / (slope if slope < -_LEAST_SHAPE_SLOPE else -1.0 / 3.0)
        if abs(step) < _SHAPE_TOLERANCE:
            break
        shape -= step
    return shape, 0.5 * ahead


def nearest_on_spiral(curvature: float, rate: float, length: float, u: float, v: float, guess: float) -> float:
    """Return how far along a spiral the place nearest to the point (u, v), in the frame of its start, lies, m.

    Newton's method on the distance along the tangent, from a guess; steps are short near the centre of the bend.
    """
    s = min(max(guess, 0.0), length)
    for _ in range(_NEWTON_ROUNDS):
        x, y, hdg = end(0.0, 0.0, 0.0, curvature, rate, s)
        sine, cosine = trigonometry.sine_cosine(hdg)
        ahead, aside = (u - x) * cosine + (v - y) * sine, (v - y) * cosine - (u - x) * sine
        slope = max(1.0 - (curvature + rate * s) * aside, _LEAST_SLOPE)
        before, s = s, min(max(s + ahead / slope, 0.0), length)
        if abs(s - before) < _NEWTON_TOLERANCE:
            break
    return s
