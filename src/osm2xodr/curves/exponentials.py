"""Exponentials, logarithms, powers and cube roots that have the same last digit on every machine.

As `trigonometry` does they use only + - * / and roots, and the binary exponents of numbers, which are exact.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray

# The natural logarithm of 2 in two parts (Cody and Waite 1980): the first has 31 bits, so that whole multiples of it
# that are exponents of doubles are exact.
_LN_2: Final = 0.6931471805599453
_LN_2_HIGH: Final = float.fromhex("0x1.62e42feep-1")
_LN_2_LOW: Final = float.fromhex("0x1.a39ef35793c76p-33")
_ROOT_OF_HALF: Final = 0.7071067811865476
# Beyond these exponents there is nothing but infinity and 0.
_FARTHEST: Final = 800.0


def exp(x: npt.ArrayLike) -> FloatArray:
    """Return e to the powers of numbers of any shape, wrong by less than 1 unit in the last place."""
    given = np.clip(np.asarray(x, np.float64), -_FARTHEST, _FARTHEST)
    doublings = np.rint(given / _LN_2)
    high, low = given - doublings * _LN_2_HIGH, doublings * _LN_2_LOW
    r = high - low
    # Taylor's series for up to ln 2 / 2, by Horner's rule: what it leaves out is below 2**-58.
    series = np.zeros_like(r)
    for k in range(14, 2, -1):
        series = (series + 1.0) * r / k
    shape = 1.0 + (r + (0.5 * r * r * (1.0 + series) + ((high - r) - low)))
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return np.asarray(np.ldexp(shape, doublings.astype(np.int32)))


def log(x: npt.ArrayLike) -> FloatArray:
    """Return the natural logarithms of positive numbers of any shape, wrong by less than 1 unit in the last place."""
    given = np.asarray(x, np.float64)
    share, exponent = np.frexp(np.where(given > 0.0, given, 1.0))
    less = share < _ROOT_OF_HALF
    f = np.where(less, 2.0 * share, share) - 1.0
    doublings = np.subtract(exponent, less, dtype=np.float64)
    # ln((1 + s) / (1 - s)), s at most 0.172: what its series leaves out is below 2**-60.
    s = f / (2.0 + f)
    z = s * s
    series = np.zeros_like(z)
    for k in range(23, 1, -2):
        series = z * (2.0 / k + series)
    half = 0.5 * f * f
    out = doublings * _LN_2_HIGH - ((half - (s * (half + series) + doublings * _LN_2_LOW)) - f)
    return np.asarray(np.where(given > 0.0, out, np.where(given == 0.0, -np.inf, np.nan)))


def power(x: npt.ArrayLike, exponent: npt.ArrayLike) -> FloatArray:
    """Return powers of positive numbers, both of any shape, as exponentials of their logarithms."""
    return exp(np.asarray(exponent, np.float64) * log(x))


def cube_root(x: npt.ArrayLike) -> FloatArray:
    """Return the cube roots of numbers of any shape, none below 0, wrong by less than 2 units in the last place."""
    given = np.asarray(x, np.float64)
    some = np.where(given > 0.0, given, 1.0)
    root = exp(log(some) / 3.0)
    return np.asarray(np.where(given > 0.0, root - (root * root * root - some) / (3.0 * root * root), 0.0))
