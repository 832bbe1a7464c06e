"""Sine, cosine and arctangent that have the same last digit on every machine, which those of C libraries have not.

Only + - * / and roots are used, whose rounding IEEE 754 fixes. Sines and cosines are wrong by less than 1 unit in the
last place, arctangents by less than 2.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray

# Added to a number and taken away again this leaves the nearest integer (1.5 · 2**52).
_ROUNDER: Final = 6755399441055744.0
_PER_QUARTER: Final = 2.0 / math.pi
# A quarter turn in three parts (Cody and Waite 1980): the first two have 33 bits each, so that up to 2**20 of them
# are exact, and the last what is left. Angles beyond, rad, are first taken modulo a turn as a float has it.
_QUARTER_1: Final = float.fromhex("0x1.921fb544p+0")
_QUARTER_2: Final = float.fromhex("0x1.0b4611a6p-34")
_QUARTER_3: Final = float.fromhex("0x1.3198a2e037073p-69")
_LARGEST: Final = 1.6e6
_TURN: Final = 2.0 * math.pi
# Half a turn, a quarter, an eighth and the arctangent of 1/2, rad, and what rounding took away from them.
_PI: Final = math.pi
_PI_REST: Final = float.fromhex("0x1.1a62633145c07p-53")
_QUARTER: Final = 0.5 * math.pi
_QUARTER_REST: Final = 0.5 * _PI_REST
_EIGHTH: Final = 0.25 * math.pi
_EIGHTH_REST: Final = 0.25 * _PI_REST
_OF_HALF: Final = float.fromhex("0x1.dac670561bb4fp-2")
_OF_HALF_REST: Final = float.fromhex("0x1.a2b7f222f65e2p-56")


def _within_a_turn(x: float) -> float:
    """Return an angle that is very large, or no number, modulo a turn, rad."""
    return x - x if x - x != 0.0 else math.fmod(x, _TURN)


def sine_cosine(x: float) -> tuple[float, float]:
    """Return sine and cosine of an angle, rad."""
    if not abs(x) <= _LARGEST:
        x = _within_a_turn(x)
    quarters = (x * _PER_QUARTER + _ROUNDER) - _ROUNDER
    first = x - quarters * _QUARTER_1
    second = quarters * _QUARTER_2
    rough = first - second
    third = quarters * _QUARTER_3 - ((first - rough) - second)
    r = rough - third
    rest = (rough - r) - third
    # Taylor's series for up to an eighth of a turn: what they leave out is below 2**-60.
    z = r * r
    w = z * z
    odd = (
        -1.0 / 6.0
        + z * (1.0 / 120.0)
        + w * (-1.0 / 5040.0 + z * (1.0 / 362880.0) + w * (-1.0 / 39916800.0 + z * (1.0 / 6227020800.0)))
    )
    odd += w * w * w * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0))
    even = (
        1.0 / 24.0
        + z * (-1.0 / 720.0)
        + w * (1.0 / 40320.0 + z * (-1.0 / 3628800.0) + w * (1.0 / 479001600.0 + z * (-1.0 / 87178291200.0)))
    )
    even += w * w * w * (1.0 / 20922789888000.0 + z * (-1.0 / 6402373705728000.0))
    sine = r + (rest * (1.0 - 0.5 * z) + r * z * odd)
    about = 1.0 - 0.5 * z
    cosine = about + ((1.0 - about - 0.5 * z) + (w * even - r * rest))
    # Which quarter of a turn, from -2 to 2.
    quarter = quarters - 4.0 * ((quarters * 0.25 + _ROUNDER) - _ROUNDER)
    if quarter == 0.0:
        return sine, cosine
    if quarter == 1.0:
        return cosine, -sine
    if quarter == -1.0:
        return -cosine, sine
    return -sine, -cosine


def arctangent(y: float, x: float) -> float:
    """Return the angle of the vector (x, y), from -pi to pi, rad; zeros have no sign, and (0, 0) has the angle 0."""
    across, along = abs(y), abs(x)
    small, large = min(across, along), max(across, along)
    if large == 0.0:
        return 0.0
    # About a ratio of 0, 1/2 or 1: the arctangent of (t - c) / (1 + c t), which is at most 1/4, is left.
    if 4.0 * small < large:
        u, base, rest = small / large, 0.0, 0.0
    elif 4.0 * small < 3.0 * large:
        u, base, rest = (small - 0.5 * large) / (large + 0.5 * small), _OF_HALF, _OF_HALF_REST
    else:
        u, base, rest = (small - large) / (large + small), _EIGHTH, _EIGHTH_REST
    z = u * u
    w = z * z
    series = (
        -1.0 / 3.0
        + z * (1.0 / 5.0)
        + w
        * (-1.0 / 7.0 + z * (1.0 / 9.0) + w * (-1.0 / 11.0 + z * (1.0 / 13.0) + w * (-1.0 / 15.0 + z * (1.0 / 17.0))))
    )
    series += w * w * w * w * (-1.0 / 19.0 + z * (1.0 / 21.0) + w * (-1.0 / 23.0 + z * (1.0 / 25.0)))
    more = u * z * series + rest
    if across > along:
        base, u, more = _QUARTER - base, -u, _QUARTER_REST - more
    if x < 0.0:
        base, u, more = _PI - base, -u, _PI_REST - more
    angle = base + (u + more)
    return -angle if y < 0.0 else angle


def wrap(angle: float) -> float:
    """Return an angle as a turn from -pi to pi, rad."""
    return angle - _TURN * ((angle / _TURN + _ROUNDER) - _ROUNDER)


def sines(x: FloatArray, out: FloatArray) -> None:
    """Write the sines of angles, (n,), rad."""
    for k in range(len(x)):
        out[k] = sine_cosine(float(x[k]))[0]


def cosines(x: FloatArray, out: FloatArray) -> None:
    """Write the cosines of angles, (n,), rad."""
    for k in range(len(x)):
        out[k] = sine_cosine(float(x[k]))[1]


def directions(x: FloatArray, along: FloatArray, across: FloatArray) -> None:
    """Write the cosines and the sines of angles, (n,), rad."""
    for k in range(len(x)):
        across[k], along[k] = sine_cosine(float(x[k]))


def arctangents(y: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """Write the angles of vectors, (n,), rad."""
    for k in range(len(x)):
        out[k] = arctangent(float(y[k]), float(x[k]))


def sine(x: npt.ArrayLike) -> FloatArray:
    """Return the sines of angles of any shape, rad."""
    given = np.asarray(x, np.float64)
    out = np.empty(given.shape)
    sines(given.ravel(), out.reshape(-1))
    return out


def cosine(x: npt.ArrayLike) -> FloatArray:
    """Return the cosines of angles of any shape, rad."""
    given = np.asarray(x, np.float64)
    out = np.empty(given.shape)
    cosines(given.ravel(), out.reshape(-1))
    return out


def cosine_sine(x: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the cosines and the sines of angles of any shape, rad, in half of the time of both."""
    given = np.asarray(x, np.float64)
    out = np.empty((2, *given.shape))
    directions(given.ravel(), out[0].reshape(-1), out[1].reshape(-1))
    return out[0, ...], out[1, ...]


def arctan2(y: npt.ArrayLike, x: npt.ArrayLike) -> FloatArray:
    """Return the angles of vectors of any shape, from -pi to pi, rad; zeros have no sign."""
    one, other = np.broadcast_arrays(np.asarray(y, np.float64), np.asarray(x, np.float64))
    out = np.empty(one.shape)
    arctangents(one.ravel(), other.ravel(), out.reshape(-1))
    return out


def slope_of(x: npt.ArrayLike) -> FloatArray:
    """Return the slopes of angles of any shape, rad: their tangents."""
    return np.asarray(sine(x) / cosine(x))


def arcsine(x: npt.ArrayLike) -> FloatArray:
    """Return the angles whose sines are given, any shape, from -pi / 2 to pi / 2, rad."""
    given = np.asarray(x, np.float64)
    return arctan2(given, np.sqrt((1.0 - given) * (1.0 + given)))


def arccosine(x: npt.ArrayLike) -> FloatArray:
    """Return the angles whose cosines are given, any shape, from 0 to pi, rad."""
    given = np.asarray(x, np.float64)
    return arctan2(np.sqrt((1.0 - given) * (1.0 + given)), given)


def hypot(x: npt.ArrayLike, y: npt.ArrayLike) -> FloatArray:
    """Return the lengths of vectors of any shape; infinite where their squares are."""
    one, other = np.asarray(x, np.float64), np.asarray(y, np.float64)
    with np.errstate(over="ignore"):
        return np.asarray(np.sqrt(one * one + other * other))
