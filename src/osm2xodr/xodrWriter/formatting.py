"""Numbers, texts and speed limits as XML, and the words of OpenDRIVE's enumerations in each of its versions."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.errors import OutputError
from osm2xodr.xodrWriter.options import Dialect

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

_ROAD_TYPES: Final = (
    *("unknown", "rural", "motorway", "town", "lowSpeed", "pedestrian", "bicycle", "townExpressway"),
    *("townCollector", "townArterial", "townPrivate", "townLocal", "townPlayStreet"),
)
# Types of lanes that are words for who may drive on them, too.
_LANES_OF_USERS: Final = frozenset({"bus", "taxi"})
_MARK_TYPES: Final = (
    *("none", "solid", "broken", "solid solid", "solid broken", "broken solid", "broken broken"),
    *("botts dots", "grass", "curb", "edge"),
)
_MARK_COLORS: Final = frozenset({"standard", "blue", "green", "red", "white", "yellow", "orange", "violet"})
_LANE_CHANGES: Final = frozenset({"increase", "decrease", "both", "none"})
# Replacements, by word and side, for readers that take `increase` and `decrease` for changes to one side and the
# other as drivers see them. They cannot be told that only one direction may cross the centre line.
_AS_DRIVEN: Final = {
    ("increase", -1): "decrease",
    ("decrease", -1): "increase",
    ("increase", 0): "none",
    ("decrease", 0): "none",
}
# Towards higher and lower ids, where these are negated.
_NEGATED: Final = {"increase": "decrease", "decrease": "increase"}
# Those of 1.6 to 1.8 that do not move; 1.4 leaves the choice to the writer.
_OBJECT_TYPES: Final = (
    *("none", "obstacle", "pole", "tree", "vegetation", "barrier", "building", "parkingSpace", "patch"),
    *("railing", "trafficIsland", "crosswalk", "streetLamp", "gantry", "soundBarrier", "roadMark", "roadSurface"),
)
_ORIENTATIONS: Final = frozenset({"+", "-", "none"})
_UNITS: Final = frozenset({"m", "km", "ft", "mile", "m/s", "mph", "km/h", "kg", "t", "%", ""})
# ISO 3166-1 alpha-2, or OpenDRIVE's own catalogue of signals.
_COUNTRY: Final = re.compile("[A-Z]{2}|OpenDRIVE|")


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


class Words:
    """Translate the model's words into those of one version, and record the replacements.

    `lane_types` are types that the reader misunderstands, and their replacements; those of the version go first.
    `changes_as_driven` names lane changes as drivers see them, `negated` turns lane ids to the other side. See
    `osm2xodr.conventions.Target`.
    """

    def __init__(
        self,
        dialect: Dialect,
        lane_types: tuple[tuple[str, str], ...] = (),
        *,
        changes_as_driven: bool = False,
        negated: bool = False,
    ) -> None:
        self._dialect = dialect
        self._sign = -1 if negated else 1
        self._changes_as_driven = changes_as_driven
        self._lane_types = {**dict(lane_types), **dialect.lane_types}
        self.replaced: set[tuple[str, str]] = set()  # (word of the model, word that is written in its place)

    @property
    def has_boundary(self) -> bool:
        """Whether the version knows boundaries of junctions."""
        return self._dialect.has_boundary

    def lane_id(self, number: int) -> int:
        """Return the id of a lane."""
        return self._sign * number

    def lane_range(self, first: int, last: int) -> tuple[int, int]:
        """Return the ids of the first and the last of several lanes, in ascending order as they were."""
        return (first, last) if self._sign > 0 else (-last, -first)

    def lane_type(self, word: str) -> str:
        """Return the type of a lane; the model uses OpenDRIVE's."""
        return self._replaced_by(word, self._lane_types)

    def lane_users(self, word: str) -> tuple[str, ...]:
        """Return who alone may drive on a lane of the model's type that is written as one for all; else none."""
        return (word,) if word in _LANES_OF_USERS and self._lane_types.get(word) == "driving" else ()

    def lane_direction(self, word: str) -> str:
        """Return the direction of a lane of the model's type; empty for that of its side of the road."""
        return "both" if self._dialect.has_direction and word == "bidirectional" else ""

    def access(self, word: str) -> tuple[str, ...]:
        """Return who alone may drive on a lane of the model's access; none where all may, or no word says who."""
        others = self._dialect.access.get(word, (word,) if word else ())
        if others != (word,) and word:
            self.replaced.add((word, " ".join(others) or "driving"))
        return others

    def road_type(self, word: str) -> str:
        """Return the type of a road."""
        return self._replaced_by(_required(word, _ROAD_TYPES, "road type"), self._dialect.road_types)

    def mark_type(self, word: str) -> str:
        """Return the type of a road mark."""
        return self._replaced_by(_required(word, _MARK_TYPES, "road mark"), self._dialect.mark_types)

    def mark_color(self, word: str) -> str:
        """Return the colour of a road mark."""
        return self._replaced_by(_required(word, _MARK_COLORS, "colour of road marks"), self._dialect.mark_colors)

    def lane_change(self, word: str, side: int = 0) -> str:
        """Return the lane changes of a mark; `side` is 1 left of the centre line, -1 right of it, 0 for that line."""
        known = _required(word, _LANE_CHANGES, "lane change")
        known = known if self._sign > 0 else _NEGATED.get(known, known)
        return _AS_DRIVEN.get((known, side), known) if self._changes_as_driven else known

    def object_type(self, word: str) -> str:
        """Return the type of an object."""
        return self._replaced_by(_required(word, _OBJECT_TYPES, "object type"), self._dialect.object_types)

    def orientation(self, word: str) -> str:
        """Return the direction that a thing is for, the same in all versions."""
        return _required(word, _ORIENTATIONS, "orientation")

    def unit(self, word: str) -> str:
        """Return the unit of a sign's value, the same in all versions; empty for none."""
        return _required(word, _UNITS, "unit")

    def country(self, word: str) -> str:
        """Return the country of a sign's code, the same in all versions; empty for none."""
        return _required(word, {word} if _COUNTRY.fullmatch(word) else (), "country")

    def _replaced_by(self, word: str, others: Mapping[str, str]) -> str:
        """Return a word, or its replacement where the version lacks it."""
        other = others.get(word, word)
        if other != word:
            self.replaced.add((word, other))
        return other


def _required(word: str, known: Collection[str], what: str) -> str:
    """Return a word, or raise an OutputError where no version knows it: no reader would accept the file."""
    if word not in known:
        msg = f"OpenDRIVE has no {what} {word!r}; this is a defect of osm2xodr, please report it"
        raise OutputError(msg)
    return word
