"""Values of OSM's tags as numbers in SI units, and tags about the sides of a way.

These are ``key=both``, ``key:left=yes``, ``key:both:width=2`` and the like. A key that names a side takes precedence
over ``key:both``, and that over the key alone.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from osm2xodr.conventions import KMH, MPH, SPEED_UNITS, find_country
from osm2xodr.curves import slope_of
from osm2xodr.defaults import WALKING_SPEED_KMH
from osm2xodr.diagnostics import Kind
from osm2xodr.osmParsing.defaults import MARGIN_WIDTH_MAX, MARGIN_WIDTH_MIN

# Steeper than the steepest streets (0.35 to 0.38) and tracks; a larger ``incline`` is a mistake, rise per metre.
_GRADE_PLAUSIBLE_MAX: Final = 0.45

# Faster than any signed limit; a larger ``maxspeed`` is a mistake, km/h.
_SPEED_PLAUSIBLE_MAX_KMH: Final = 250.0
# Layers beyond these are mistakes (OSM wiki, Key:layer: -5 to 5; stacked interchanges keep within 8).
_LAYER_PLAUSIBLE_MAX: Final = 10

FOOT: Final = 0.3048
_INCH: Final = 0.0254

_LENGTH_UNITS: Final = {
    **dict.fromkeys(("", "m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("ft", "feet", "foot"), FOOT),
    "cm": 0.01,
    "mm": 0.001,
    "km": 1000.0,
    "in": _INCH,
    "yd": 0.9144,
    "mi": 1609.344,
}
_SPEED_UNITS: Final = {
    **dict.fromkeys(("", "km/h", "kmh", "kph"), SPEED_UNITS[KMH]),
    **dict.fromkeys(("knots", "knot", "kn"), 1852.0 / 3600.0),
    "mph": SPEED_UNITS[MPH],
}
_NUMBER: Final = r"\d+(?:[.,]\d+)?|[.,]\d+"
_QUANTITY: Final = re.compile(rf"({_NUMBER})\s*([a-z/]*)\.?", re.ASCII)
_FEET_INCHES: Final = re.compile(rf"({_NUMBER})\s*(?:'|ft)(?:\s*({_NUMBER})\s*(?:\"|''|in))?", re.ASCII)
# More digits than any real value has; longer numbers might overflow.
_DIGITS_MAX: Final = 9
_INTEGER: Final = re.compile(rf"[-+]?\d{{1,{_DIGITS_MAX}}}(?:\.\d*)?", re.ASCII)
_GRADE: Final = re.compile(rf"([-+]?)\s*({_NUMBER})\s*(%|°|deg)?", re.ASCII)
_ZONE: Final = re.compile(r"(?:zone:?)?(\d{1,3})", re.ASCII)
# OSM's other name of a country.
_ALIASES: Final = {"UK": "GB"}

# Tags of a way or node.
Tags = Mapping[str, str]
# Diagnostics about a way's tags without its id: kind, code, words.
Findings = list[tuple[Kind, str, str]]

LEFT_RIGHT: Final = ("left", "right")
SIDE_KEYS: Final = ("", ":both", ":left", ":right")

# What a side can have; ``APART`` is mapped as a way or an area of its own.
YES: Final = "yes"
NO: Final = "no"
APART: Final = "separate"
# OSM's words for them.
_WORDS: Final = {"yes": YES, "no": NO, "none": NO, "separate": APART}


def add_once(findings: Findings, kind: Kind, code: str, words: str) -> None:
    """Add a finding that both sides of a way may have."""
    if (kind, code, words) not in findings:
        findings.append((kind, code, words))


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def parse_length(text: str) -> float | None:
    """Read a length such as ``3.5``, ``3,5 m``, ``11 ft`` or ``3'6"``, m; None if it is not one.

    Metres unless a unit is given (OSM wiki, Map features/Units).
    """
    text = text.strip().lower()
    found = _FEET_INCHES.fullmatch(text)
    if found:
        return _number(found[1]) * FOOT + (_number(found[2]) * _INCH if found[2] else 0.0)
    found = _QUANTITY.fullmatch(text)
    if not found or found[2] not in _LENGTH_UNITS:
        return None
    return _number(found[1]) * _LENGTH_UNITS[found[2]]


def plausible_length(text: str, most: float) -> float | None:
    """Read a length as `parse_length` does; None also where it is 0 or above the largest that is plausible, m."""
    length = parse_length(text)
    return length if length is not None and 0.0 < length <= most else None


def first_width(
    tags: Tags,
    keys: Iterable[str],
    limits: tuple[float, float],
    code: str,
    noun: str,
    findings: Findings,
) -> float | None:
    """Return the width from the first of some keys with one within limits, m; None if none has one.

    Other values become findings: they are not the width of such a thing (the noun).
    """
    for key in keys:
        if key in tags:
            width = parse_length(tags[key])
            if width is not None and limits[0] <= width <= limits[1]:
                return width
            add_once(findings, Kind.DROPPED, code, f"{key}={tags[key]} is not the width of {noun} and is ignored")
    return None


def parse_count(text: str) -> tuple[int | None, bool]:
    """Read a number of lanes: at least 1, or None; and whether the value was exactly that number.

    Fractions are rounded down, of several numbers the smallest is taken.
    """
    if text.isascii() and text.isdigit() and text[0] != "0" and len(text) <= _DIGITS_MAX:
        return int(text), True
    parts = [part.strip() for part in re.split(r"[;|,]", text)]
    numbers = [int(float(part)) for part in parts if _INTEGER.fullmatch(part)]
    numbers = [number for number in numbers if number > 0]
    return (min(numbers) if numbers else None), False


def parse_speed(text: str) -> float | None:
    """Read a speed limit, m/s; infinity for ``none``, None where the value gives no definite limit.

    Numbers are km/h unless a unit is given. ``DE:urban`` and the like are looked up in the table of countries.
    """
    text = text.strip()
    lower = text.lower()
    if lower == "none":
        return math.inf
    if lower == "walk":
        return WALKING_SPEED_KMH * SPEED_UNITS[KMH]
    found = _QUANTITY.fullmatch(lower)
    if found and found[2] in _SPEED_UNITS:
        speed = _number(found[1]) * _SPEED_UNITS[found[2]]
        return speed if 0.0 < speed <= _SPEED_PLAUSIBLE_MAX_KMH * SPEED_UNITS[KMH] else None
    if ":" in text:
        return _implicit_speed(text)
    return None


def lowest_speed(text: str) -> tuple[float | None, bool]:
    """Read a speed limit as `parse_speed` does, of several the lowest; and whether there is only one."""
    parts = [part for part in re.split(r"[;|]", text) if part.strip()]
    if len(parts) < 2:
        return parse_speed(text), True
    speeds = [speed for part in parts if (speed := parse_speed(part)) is not None]
    return min(speeds, default=None), False


def _implicit_speed(text: str) -> float | None:
    """Read ``XX:context``: the limit in a country's law, or that of a zone such as ``DE:zone:30``."""
    country, _, context = text.partition(":")
    country, context = country.strip().upper(), context.strip().lower()
    if context == "walk":
        return WALKING_SPEED_KMH * SPEED_UNITS[KMH]
    speed = find_country(country).speeds.get(context)
    if speed is not None:
        return speed
    found = _ZONE.fullmatch(context)
    if not found or int(found[1]) == 0:
        return None
    return int(found[1]) * SPEED_UNITS[find_country(_ALIASES.get(country, country)).speed_unit]


def parse_grade(text: str) -> float | None:
    """Read ``incline``, rise per metre along the way; None for ``up``, ``down`` and anything that is not a number.

    Numbers without a unit are percent (OSM wiki, Key:incline).
    """
    found = _GRADE.fullmatch(text.strip().lower())
    if not found:
        return None
    value = _number(found[2]) * (-1.0 if found[1] == "-" else 1.0)
    grade = float(slope_of(math.radians(value))) if found[3] in ("°", "deg") and abs(value) < 90.0 else value / 100.0
    return grade if abs(grade) <= _GRADE_PLAUSIBLE_MAX else None


def parse_layer(text: str) -> int | None:
    """Read ``layer``, of several numbers the one farthest from the ground; None if there is none."""
    parts = [part.strip() for part in text.split(";")]
    numbers = [int(float(part)) for part in parts if _INTEGER.fullmatch(part)]
    layer = max(numbers, key=abs, default=None)
    return layer if layer is not None and abs(layer) <= _LAYER_PLAUSIBLE_MAX else None


def keys_of_sides(key: str, *endings: str) -> tuple[str, ...]:
    """Return a key with each of its sides and each ending (``""`` for none)."""
    return tuple(f"{key}{side}{ending}" for side in SIDE_KEYS for ending in endings)


def names_of_side(key: str, side: str, ending: str = "") -> tuple[str, str, str]:
    """Return the keys that apply to one side, the most specific first."""
    return f"{key}:{side}{ending}", f"{key}:both{ending}", f"{key}{ending}"


def sides_of(tags: Tags, key: str, code: str, findings: Findings, yes: Sequence[str] = LEFT_RIGHT) -> dict[str, str]:
    """Read what the sides of a way have: `YES`, `NO` or `APART` for ``left`` and ``right``, if a tag mentions it.

    `key` has no side (``sidewalk``); `yes` are the sides that its value ``yes`` means. Values that are not known or
    contradict each other are added to `findings` with `code`.
    """
    stated: dict[str, list[str]] = {side: [] for side in LEFT_RIGHT}
    for end, about in ((":left", ("left",)), (":right", ("right",)), (":both", LEFT_RIGHT), ("", LEFT_RIGHT)):
        name = f"{key}{end}"
        value = tags.get(name)
        if value is None:
            continue
        read = _read(value, about, yes if not end else about)
        if read is None:
            findings.append((Kind.DROPPED, code, f"{name}={value} is not known or contradicts itself and is ignored"))
            continue
        if not end and value == "yes":
            where = "both sides" if len(yes) > 1 else f"the {yes[0]}"
            findings.append((Kind.GUESSED, code, f"{name}=yes names no side, taken to mean {where}"))
        for side, state in read.items():
            stated[side].append(state)
    if any({YES, NO} <= set(states) for states in stated.values()):
        words = f"tags of {key} contradict each other, the most specific one is taken"
        findings.append((Kind.REPAIRED, code, words))
    return {side: states[0] for side, states in stated.items() if states}


def _read(value: str, about: Sequence[str], yes: Sequence[str]) -> dict[str, str] | None:
    """Return what one value says about the sides that its key applies to; None if it is not known."""
    rest = NO
    named: set[str] = set()
    for part in value.split(";"):
        word = part.strip().lower()
        if word in {"yes", "both"} and (word == "both" or len(about) == 1 or set(yes) == set(about)):
            named.update(about)
        elif word == "yes":
            named.update(yes)
        elif word in about:
            named.add(word)
        elif word in _WORDS:
            rest = _WORDS[word]
        else:
            return None
    if named and rest is NO and any(part.strip().lower() in {"no", "none"} for part in value.split(";")):
        return None
    return {side: YES if side in named else rest for side in about}


def width_of_side(tags: Tags, keys: Sequence[str], code: str, findings: Findings) -> float | None:
    """Return the width of a strip beside a road from the first of some keys with a valid one, m; None if none has."""
    return first_width(tags, keys, (MARGIN_WIDTH_MIN, MARGIN_WIDTH_MAX), code, "a strip beside a road", findings)
