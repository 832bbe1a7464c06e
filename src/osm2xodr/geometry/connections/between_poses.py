"""Lines and arcs between poses, and how near they come to each other, one by one."""

from __future__ import annotations

import math
from typing import Final

from osm2xodr.curves import spirals, trigonometry
from osm2xodr.defaults import CONNECTING_RADIUS, LEAST_TURN_BACK
from osm2xodr.model import BoolArray, FloatArray, IntArray

# A line and an arc are used where both tangents are longer than this, m, and the turn is larger than this, rad, but
# no turn back, and where the line is either no shorter than this, m, or absent, that is shorter than this, m.
_SHORTEST_TANGENT: Final = 0.05
_LEAST_TURN: Final = 1e-3
_SHORTEST_LINE_BEFORE_ARC: Final = 0.01
_NO_LINE_BELOW: Final = 1e-9
# An arc is not made smaller where that would leave lines no longer than this, m.
_SHORTEST_LINE_BESIDE_ARC: Final = 0.5
# An arc that turns less than this, rad, is written as its chord: readers with single precision cannot place its far
# centre. Curves that are drawn again begin and end as they did, so that what chords leave out adds up.
_STRAIGHT_BELOW: Final = 5e-5
# Two arcs that would be longer than this, m, or their tangents, do not meet: to a pose behind in almost the same
# heading they are circles of many kilometres, whose end is off by what rounding leaves of it.
_LONGEST_TANGENT: Final = 1e4
# Shorter records are left out, m.
_SHORTEST_RECORD: Final = 1e-7
# A curve whose heading at its end, or between two of its records, is off by more has missed it, rad.
MISSED: Final = 1e-3
_MISSED: Final = MISSED
# So has one that ends beside its pose by more than this, m.
_MISSED_BY: Final = 1e-3
# Turns below this, rad, count as straight.
_NO_ANGLE: Final = 1e-9

_TURN_BACK: Final = LEAST_TURN_BACK
_DRIVEN_RADIUS: Final = CONNECTING_RADIUS
_HALF_TURN: Final = math.pi
_INFINITE: Final = math.inf


def connections(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    radius: FloatArray,
    longest: float,
    out: FloatArray,
    missed: BoolArray,
) -> None:
    """Write s, x, y, heading, length and curvature of three records of each curve, (6, n, 3); some have no length.

    Curves that do not reach their second pose are marked in `missed`, (n,).
    """
    for k in range(len(x0)):
        ax, ay, leaving = float(x0[k]), float(y0[k]), float(hdg0[k])
        bx, by, arriving = float(x1[k]), float(y1[k]), float(hdg1[k])
        sharpest = _two_arcs(ax, ay, leaving, bx, by, arriving, k, out)
        simple = _line_and_arc(ax, ay, leaving, bx, by, arriving, float(radius[k]), longest, sharpest, k, out)
        missed[k] = _misses(ax, ay, leaving, bx, by, arriving, simple, k, out)


def _two_arcs(x0: float, y0: float, hdg0: float, x1: float, y1: float, hdg1: float, k: int, out: FloatArray) -> float:
    """Write lengths and curvatures of two arcs, and of a third record without length; return the larger curvature."""
    vx, vy = x1 - x0, y1 - y0
    ty0, tx0 = trigonometry.sine_cosine(hdg0)
    ty1, tx1 = trigonometry.sine_cosine(hdg1)
    square = vx * vx + vy * vy
    # 1 - t0·t1, written so that it does not cancel for almost equal headings.
    half = trigonometry.sine_cosine((hdg1 - hdg0) / 2.0)[0]
    apart = 2.0 * (half * half)
    along = vx * (tx0 + tx1) + vy * (ty0 + ty1)
    root = math.sqrt(along * along + 2.0 * apart * square)
    # The stable form of (-along + root) / (2 apart) for either sign of `along`.
    tangent = square / max(along + root, 1e-12) if along > 0.0 else (root - along) / max(2.0 * apart, 1e-12)
    # A pose straight behind in the same heading is out of reach of two arcs.
    tangent = min(tangent, _LONGEST_TANGENT)
    jx = (x0 + tangent * tx0 + x1 - tangent * tx1) / 2.0
    jy = (y0 + tangent * ty0 + y1 - tangent * ty1) / 2.0
    ax, ay, bx, by = jx - x0, jy - y0, x1 - jx, y1 - jy
    out[4, k, 0], out[5, k, 0] = _arc(ax, ay, tx0 * ay - ty0 * ax, tx0 * ax + ty0 * ay)
    out[4, k, 1], out[5, k, 1] = _arc(bx, by, bx * ty1 - by * tx1, bx * tx1 + by * ty1)
    out[4, k, 2], out[5, k, 2] = 0.0, 0.0
    return max(abs(float(out[5, k, 0])), abs(float(out[5, k, 1])))


def _arc(wx: float, wy: float, cross: float, dot: float) -> tuple[float, float]:
    """Return length and curvature of the arc over a chord, by its products with the direction at one end."""
    square = max(wx * wx + wy * wy, 1e-18)
    turn, curvature = 2.0 * trigonometry.arctangent(cross, dot), 2.0 * cross / square
    if abs(turn) > _NO_ANGLE and curvature != 0.0:
        return turn / curvature, curvature
    return math.sqrt(square), 0.0


def _line_and_arc(
    x0: float,
    y0: float,
    hdg0: float,
    x1: float,
    y1: float,
    hdg1: float,
    most: float,
    longest: float,
    sharpest: float,
    k: int,
    out: FloatArray,
) -> bool:
    """Write lengths and curvatures of line, arc, line if they connect the poses; say whether they do.

    The arc touches both tangents at the distance of the shorter one from where they meet, or nearer if its radius
    would be above `most`, as long as they are at most `longest` times as long; the rest of both is lines. It may be
    sharper than cars drive only where it is no sharper than `sharpest`.
    """
    turn = _wrapped(hdg1 - hdg0)
    size = abs(turn)
    before, after = _tangents(x0, y0, hdg0, x1, y1, hdg1)
    shorter, unequal = min(before, after), abs(before - after)
    if not (shorter > _SHORTEST_TANGENT and _LEAST_TURN < size < _TURN_BACK):
        return False
    sine, cosine = trigonometry.sine_cosine(min(max(size, 1e-6), 3.1) / 2.0)
    half = sine / cosine
    # The detour by the tangents, as a share of the largest arc.
    detour = max(2.0 * half / max(size, 1e-6) - 1.0, 1e-6)
    touch = max(most * half, shorter * (1.0 - (longest - 1.0) / detour))
    if not shorter - touch > _SHORTEST_LINE_BESIDE_ARC:
        touch = shorter
        if not (unequal > _SHORTEST_LINE_BEFORE_ARC or unequal < _NO_LINE_BELOW):
            return False
    touch = max(touch, 1e-9)
    radius = touch / half
    sharp = 1.0 / radius
    if not (sharp * _DRIVEN_RADIUS <= 1.0 or sharp <= sharpest):
        return False
    out[4, k, 0], out[4, k, 1], out[4, k, 2] = max(before - touch, 0.0), radius * size, max(after - touch, 0.0)
    out[5, k, 0], out[5, k, 1], out[5, k, 2] = 0.0, -sharp if turn < 0.0 else sharp, 0.0
    return True


def _misses(
    x0: float, y0: float, hdg0: float, x1: float, y1: float, hdg1: float, simple: bool, k: int, out: FloatArray
) -> bool:
    """Write where the three records of a curve begin, given their lengths and curvatures; say if it misses its pose.

    Those that hardly turn become their chords, and so do two arcs, which are not `simple`, if neither turns.
    """
    missed, bent, turned, gone_x, gone_y = False, False, 0.0, 0.0, 0.0
    for i in range(3):
        length, curvature = float(out[4, k, i]), float(out[5, k, i])
        hdg = hdg0 + turned
        u, v, _ = spirals.end(0.0, 0.0, 0.0, curvature, 0.0, length)
        sine, cosine = trigonometry.sine_cosine(hdg)
        dx, dy = cosine * u - sine * v, sine * u + cosine * v
        out[1, k, i], out[2, k, i], out[3, k, i] = x0 + gone_x, y0 + gone_y, hdg
        turned, gone_x, gone_y = turned + length * curvature, gone_x + dx, gone_y + dy
        missed = missed or length > _LONGEST_TANGENT
        if abs(curvature * length) < _STRAIGHT_BELOW:
            out[3, k, i], out[4, k, i], out[5, k, i] = trigonometry.arctangent(dy, dx), _size(dx, dy), 0.0
        else:
            bent = bent or i < 2
    missed = missed or _size(x0 + gone_x - x1, y0 + gone_y - y1) > _MISSED_BY
    if not (bent or simple):
        out[3, k, 0], out[4, k, 0], out[4, k, 1] = (
            trigonometry.arctangent(y1 - y0, x1 - x0),
            _size(x1 - x0, y1 - y0),
            0.0,
        )
    s, turned = 0.0, 0.0
    for i in range(3):
        if not out[4, k, i] > _SHORTEST_RECORD:
            out[4, k, i] = 0.0
        length = float(out[4, k, i])
        s += length
        out[0, k, i] = s - length
        turned += length * float(out[5, k, i])
    return missed or abs(_wrapped(hdg0 + turned - hdg1)) > _MISSED


def _size(x: float, y: float) -> float:
    """Return the length of a vector."""
    return math.sqrt(x * x + y * y)


def _wrapped(angle: float) -> float:
    """Return an angle as a turn from -pi up to pi, rad, rounded as `wrapped` does."""
    rest = math.fmod(angle + _HALF_TURN, 2.0 * _HALF_TURN)
    return (rest + 2.0 * _HALF_TURN if rest < 0.0 else rest) - _HALF_TURN


def meetings_of_tangents(
    x0: FloatArray,
    y0: FloatArray,
    hdg0: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    hdg1: FloatArray,
    out: FloatArray,
) -> None:
    """Write what `tangents` returns, (2, n)."""
    for k in range(len(x0)):
        out[0, k], out[1, k] = _tangents(
            float(x0[k]), float(y0[k]), float(hdg0[k]), float(x1[k]), float(y1[k]), float(hdg1[k])
        )


def _tangents(x0: float, y0: float, hdg0: float, x1: float, y1: float, hdg1: float) -> tuple[float, float]:
    vx, vy = x1 - x0, y1 - y0
    sine0, cosine0 = trigonometry.sine_cosine(hdg0)
    sine1, cosine1 = trigonometry.sine_cosine(hdg1)
    sine = trigonometry.sine_cosine(_wrapped(hdg1 - hdg0))[0]
    if abs(sine) < _NO_ANGLE:
        sine = 1.0
    return (vx * sine1 - vy * cosine1) / sine, (cosine0 * vy - sine0 * vx) / sine


def least_distances(
    ax: FloatArray, ay: FloatArray, row: IntArray, bx: FloatArray, by: FloatArray, other: IntArray, out: FloatArray
) -> None:
    """Write how near places in some rows come to those in rows of another table, (n,), m."""
    for k in range(len(row)):
        least = _INFINITE
        for i in range(ax.shape[1]):
            for j in range(bx.shape[1]):
                dx = float(bx[other[k], j]) - float(ax[row[k], i])
                dy = float(by[other[k], j]) - float(ay[row[k], i])
                least = min(least, dx * dx + dy * dy)
        out[k] = math.sqrt(least)
