"""Numbers and words as XML text."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.errors import OutputError

# At most 12 significant digits: 10 nm at 1 km, 0.1 um at 99 km. Whoever needs fewer rounds before.
NUMBER: Final = "%.12g"
# Of curvatures: an arc of 1 km ends within 0.1 um.
CURVATURE: Final = "%.10g"
# Of positions and lengths: 0.1 um.
POSITION_DECIMALS: Final = 7

# What XML 1.0 does not allow in a document (production 2, Char), and white space that would not survive in an
# attribute.
_ILLEGAL: Final = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_SPACE: Final = re.compile(r"[\t\n\r]+")


def number(value: float) -> str:
    """Write one number as the tables do; never as ``-0``.

    Raises
    ------
    OutputError
        If it is not finite.
    """
    if not math.isfinite(value):
        msg = "a lane or speed limit has a number that is not finite; this is a defect of osm2xodr, please report it"
        raise OutputError(msg)
    return NUMBER % (value + 0.0)


def position(value: float) -> str:
    """Write a length or a place along a road, as `number` does."""
    return number(round(value, POSITION_DECIMALS))


def start_of_last(s: float, length: float) -> str:
    """Write where the last lane section of a road starts, so that readers find its end on the road.

    CARLA computes s + (length - s) in doubles and refuses a file where rounding makes that more than the length. The
    start then moves back by a unit in its last digit written.
    """
    text, end = position(s), float(position(length))
    start = float(text)
    unit = 10.0 ** (math.floor(math.log10(start)) - 11) if start > 0 else 0.0
    while start + (end - start) > end:
        text = number(start - unit)
        start = float(text)
    return text


@lru_cache(maxsize=10_000)
def attribute(text: str) -> str:
    """Make a text fit for an attribute in double quotes: escaped, and without what XML does not allow."""
    clean = _SPACE.sub(" ", _ILLEGAL.sub("", text))
    return clean.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


def rounded(values: npt.NDArray[np.float64], decimals: int | npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return values with so many decimals, without negative zeros."""
    scale = np.power(10.0, decimals)
    nearest: npt.NDArray[np.float64] = np.rint(values * scale) / scale + 0.0
    return nearest
