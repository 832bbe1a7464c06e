"""The words of OpenDRIVE's enumerations, and what to write where a version lacks one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from osm2xodr.errors import OutputError
from osm2xodr.xodrWriter.options import Dialect

_ROAD_TYPES: Final = frozenset(
    {
        "unknown",
        "rural",
        "motorway",
        "town",
        "lowSpeed",
        "pedestrian",
        "bicycle",
        "townExpressway",
        "townCollector",
        "townArterial",
        "townPrivate",
        "townLocal",
        "townPlayStreet",
    }
)
_MARK_TYPES: Final = frozenset(
    {
        "none",
        "solid",
        "broken",
        "solid solid",
        "solid broken",
        "broken solid",
        "broken broken",
        "botts dots",
        "grass",
        "curb",
        "edge",
    }
)
_MARK_COLORS: Final = frozenset({"standard", "blue", "green", "red", "white", "yellow", "orange", "violet"})
_LANE_CHANGES: Final = frozenset({"increase", "decrease", "both", "none"})


class Words:
    """Puts the model's words into those of one version, and remembers which it had to replace.

    Parameters
    ----------
    dialect
        The version of OpenDRIVE.

    Attributes
    ----------
    replaced
        (word of the model, word that is written in its place).
    """

    def __init__(self, dialect: Dialect) -> None:
        self._dialect = dialect
        self.replaced: set[tuple[str, str]] = set()

    def lane_type(self, word: str) -> str:
        """Return the type of a lane; all that the model has are OpenDRIVE's."""
        return self._replaced_by(word, self._dialect.lane_types)

    def road_type(self, word: str) -> str:
        """Return the type of a road."""
        _require(word, _ROAD_TYPES, "road type")
        return self._replaced_by(word, self._dialect.road_types)

    def mark_type(self, word: str) -> str:
        """Return the type of a road mark."""
        _require(word, _MARK_TYPES, "road mark")
        return self._replaced_by(word, self._dialect.mark_types)

    def mark_color(self, word: str) -> str:
        """Return the colour of a road mark."""
        _require(word, _MARK_COLORS, "colour of road marks")
        return self._replaced_by(word, self._dialect.mark_colors)

    def lane_change(self, word: str) -> str:
        """Return what a road mark allows, the same in all versions."""
        _require(word, _LANE_CHANGES, "lane change")
        return word

    def _replaced_by(self, word: str, others: Mapping[str, str]) -> str:
        """Look a word up among those that the version lacks."""
        other = others.get(word)
        if other is None:
            return word
        self.replaced.add((word, other))
        return other


def _require(word: str, known: frozenset[str], what: str) -> None:
    """Refuse what no version knows: the file would be valid for no reader."""
    if word not in known:
        msg = f"OpenDRIVE has no {what} {word!r}; this is a defect of osm2xodr, please report it"
        raise OutputError(msg)
