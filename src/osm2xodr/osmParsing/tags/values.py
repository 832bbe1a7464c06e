"""What the values of OSM's tags mean, as numbers in SI units. Nothing here knows about ways."""

from __future__ import annotations

import math
import re
from typing import Final

from osm2xodr.conventions import MPH, find_country
from osm2xodr.defaults import WALKING_SPEED_KMH
from osm2xodr.osmParsing.defaults import LAYER_PLAUSIBLE_MAX, SPEED_PLAUSIBLE_MAX_KMH

# Steeper than the steepest streets (0.35 to 0.38) and tracks; a larger ``incline`` is a mistake, rise per metre.
_GRADE_PLAUSIBLE_MAX: Final = 0.45

KMH: Final = 1.0 / 3.6
_FOOT: Final = 0.3048
_INCH: Final = 0.0254
_MILE_PER_HOUR: Final = 0.44704
_KNOT: Final = 1852.0 / 3600.0

_LENGTH_UNITS: Final = {
    "": 1.0,
    "m": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "km": 1000.0,
    "ft": _FOOT,
    "feet": _FOOT,
    "foot": _FOOT,
    "in": _INCH,
    "mi": 1609.344,
    "yd": 0.9144,
}
_SPEED_UNITS: Final = {
    "": KMH,
    "km/h": KMH,
    "kmh": KMH,
    "kph": KMH,
    "mph": _MILE_PER_HOUR,
    "knots": _KNOT,
    "knot": _KNOT,
    "kn": _KNOT,
}
_NUMBER: Final = r"\d+(?:[.,]\d+)?|[.,]\d+"
_QUANTITY: Final = re.compile(rf"({_NUMBER})\s*([a-z/]*)\.?", re.ASCII)
_FEET_INCHES: Final = re.compile(rf"({_NUMBER})\s*(?:'|ft)(?:\s*({_NUMBER})\s*(?:\"|''|in))?", re.ASCII)
# Longer rows of digits are no number of anything, and the longest are none that fits.
_DIGITS_MAX: Final = 9
_INTEGER: Final = re.compile(rf"[-+]?\d{{1,{_DIGITS_MAX}}}(?:\.\d*)?", re.ASCII)
_GRADE: Final = re.compile(rf"([-+]?)\s*({_NUMBER})\s*(%|°|deg)?", re.ASCII)
_ZONE: Final = re.compile(r"(?:zone:?)?(\d{1,3})", re.ASCII)
# OSM's other name of a country.
_ALIASES: Final = {"UK": "GB"}


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def parse_length(text: str) -> float | None:
    """Read a length such as ``3.5``, ``3,5 m``, ``11 ft`` or ``3'6"``, m; None where it is none.

    Metres unless a unit is given (OSM wiki, Map features/Units).
    """
    text = text.strip().lower()
    found = _FEET_INCHES.fullmatch(text)
    if found:
        return _number(found[1]) * _FOOT + (_number(found[2]) * _INCH if found[2] else 0.0)
    found = _QUANTITY.fullmatch(text)
    if not found or found[2] not in _LENGTH_UNITS:
        return None
    return _number(found[1]) * _LENGTH_UNITS[found[2]]


def plausible_length(text: str, most: float) -> float | None:
    """Read a length as `parse_length` does; None also where it is 0 or above the largest that is plausible, m."""
    length = parse_length(text)
    return length if length is not None and 0.0 < length <= most else None


def parse_count(text: str) -> tuple[int | None, bool]:
    """Read a number of lanes; fractions lose what is beyond the point, of several numbers the smallest counts.

    Returns
    -------
    int or None
        A number of at least 1; None where there is none.
    bool
        Whether the value was just that number.
    """
    if text.isascii() and text.isdigit() and text[0] != "0" and len(text) <= _DIGITS_MAX:
        return int(text), True
    parts = [part.strip() for part in re.split(r"[;|,]", text)]
    numbers = [int(float(part)) for part in parts if _INTEGER.fullmatch(part)]
    numbers = [number for number in numbers if number > 0]
    return (min(numbers) if numbers else None), False


def parse_speed(text: str) -> float | None:
    """Read a speed limit, m/s; infinity where there is none, None where the value says nothing for sure.

    Numbers are km/h unless a unit is given. ``DE:urban`` and the like are looked up in the table of countries.
    """
    text = text.strip()
    lower = text.lower()
    if lower == "none":
        return math.inf
    if lower == "walk":
        return WALKING_SPEED_KMH * KMH
    found = _QUANTITY.fullmatch(lower)
    if found and found[2] in _SPEED_UNITS:
        speed = _number(found[1]) * _SPEED_UNITS[found[2]]
        return speed if 0.0 < speed <= SPEED_PLAUSIBLE_MAX_KMH * KMH else None
    if ":" in text:
        return _implicit_speed(text)
    return None


def _implicit_speed(text: str) -> float | None:
    """Read ``XX:context``: what a country's law says, or the number of a zone such as ``DE:zone:30``."""
    country, _, context = text.partition(":")
    country, context = country.strip().upper(), context.strip().lower()
    if context == "walk":
        return WALKING_SPEED_KMH * KMH
    speed = find_country(country).speeds.get(context)
    if speed is not None:
        return speed
    found = _ZONE.fullmatch(context)
    if not found or int(found[1]) == 0:
        return None
    miles = find_country(_ALIASES.get(country, country)).speed_unit == MPH
    return int(found[1]) * (_MILE_PER_HOUR if miles else KMH)


def parse_grade(text: str) -> float | None:
    """Read ``incline``, rise per metre along the way; None for ``up``, ``down`` and what is no number.

    Numbers without a unit are percent, which is the unit that the OSM wiki asks for.
    """
    found = _GRADE.fullmatch(text.strip().lower())
    if not found:
        return None
    value = _number(found[2]) * (-1.0 if found[1] == "-" else 1.0)
    grade = math.tan(math.radians(value)) if found[3] in ("°", "deg") and abs(value) < 90.0 else value / 100.0
    return grade if abs(grade) <= _GRADE_PLAUSIBLE_MAX else None


def parse_layer(text: str) -> int | None:
    """Read ``layer``; of several numbers the one farthest from the ground counts, None where there is none."""
    parts = [part.strip() for part in text.split(";")]
    numbers = [int(float(part)) for part in parts if _INTEGER.fullmatch(part)]
    layer = max(numbers, key=abs, default=None)
    return layer if layer is not None and abs(layer) <= LAYER_PLAUSIBLE_MAX else None
