"""Numbers, texts and speed limits as XML."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.errors import OutputError

# At most 12 significant digits: 10 nm at 1 km, 0.1 um at 99 km. Numbers that need fewer are rounded first.
NUMBER: Final = "%.12g"
# Of curvatures: an arc of 1 km ends within 0.1 um.
CURVATURE: Final = "%.10g"
# Of positions and lengths: 0.1 um.
POSITION_DECIMALS: Final = 7

# What XML 1.0 does not allow in a document (all but production 2, Char: the complement takes ten times as long to
# compile), and white space that would not survive in an attribute.
_ILLEGAL: Final = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
_SPACE: Final = re.compile(r"[\t\n\r]+")

# Written as the limit of a lane that has none on a road that has one: ``lane/speed@max`` knows no "no limit".
# A choice: beyond what road vehicles reach.
_NO_LIMIT_KMH: Final = 400

_NOT_FINITE: Final = "a number to be written is not finite; this is a defect of osm2xodr, please report it"

_KMH: Final = 3.6  # km/h per m/s
_MPH: Final = 1.0 / 0.44704  # international miles per hour per m/s

# How close to a whole number of a unit a speed must be to have been meant in it. 30 mph is 48.28 km/h; no usual limit
# in mph lies this close to a whole number of km/h.
_WHOLE_UNIT: Final = 0.005
# Doubles have these exactly, other than what functions of C and NumPy return for powers on some machines.
_POWERS_OF_TEN: Final = np.array([float(f"1e{k}") for k in range(61)])


def number(value: float) -> str:
    """Write one number as the tables do, never as ``-0``; raise an OutputError if it is not finite."""
    if not math.isfinite(value):
        raise OutputError(_NOT_FINITE)
    return NUMBER % (value + 0.0)


def numbers(pattern: str, values: list[float]) -> str:
    """Write numbers into a pattern as `number` does."""
    if not math.isfinite(sum(values)):
        raise OutputError(_NOT_FINITE)
    return pattern % tuple([value + 0.0 for value in values])


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
    unit = float(f"1e{int(f'{start:e}'.partition('e')[2]) - 11}") if start > 0 else 0.0
    while start + (end - start) > end:
        text = number(start - unit)
        start = float(text)
    return text


@lru_cache(maxsize=10_000)
def attribute(text: str) -> str:
    """Make a text fit for an attribute in double quotes: escaped, without characters that XML does not allow."""
    clean = _SPACE.sub(" ", _ILLEGAL.sub("", text))
    return clean.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


def name_attribute(name: str) -> str:
    """Return the name of a road or junction as an attribute, empty if it has none: then it may be missing."""
    return f' name="{attribute(name)}"' if name else ""


def user_data(code: str, value: str) -> str:
    """Return a ``<userData>`` element, empty if the value is."""
    return f'<userData code="{code}" value="{attribute(value)}"/>' if value else ""


def _speed(speed: float) -> str:
    """Return ``max`` and ``unit`` of a finite speed (m/s): km/h or mph, whichever makes it whole, else km/h."""
    kmh, mph = speed * _KMH, speed * _MPH
    if abs(kmh - round(kmh)) <= _WHOLE_UNIT:
        return f'max="{round(kmh)}" unit="km/h"'
    if abs(mph - round(mph)) <= _WHOLE_UNIT:
        return f'max="{round(mph)}" unit="mph"'
    return f'max="{number(round(kmh, 3))}" unit="km/h"'


def road_speed_attributes(speed: float) -> str:
    """Return the attributes of ``type/speed`` for a speed in m/s; infinity is no limit."""
    return 'max="no limit"' if math.isinf(speed) else _speed(speed)


def lane_speed_attributes(speed: float) -> str:
    """Return the attributes of ``lane/speed``, except ``sOffset``, for a speed in m/s; infinity is no limit."""
    return f'max="{_NO_LIMIT_KMH}" unit="km/h"' if math.isinf(speed) else _speed(speed)


def digits_before_point(values: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Return how many digits before the point the largest numbers have that are below some values, 0 for 1."""
    return np.searchsorted(_POWERS_OF_TEN, values)


def rounded(values: npt.NDArray[np.float64], decimals: int | npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Return values rounded to a number of decimals, without negative zeros."""
    scale = _POWERS_OF_TEN[np.asarray(decimals, np.int64)]
    nearest: npt.NDArray[np.float64] = np.rint(values * scale) / scale + 0.0
    return nearest
