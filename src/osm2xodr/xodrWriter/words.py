"""The words of OpenDRIVE's enumerations, and their replacements where a version lacks one."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Final

from osm2xodr.errors import OutputError
from osm2xodr.xodrWriter.options import Dialect

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
