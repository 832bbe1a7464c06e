"""Parking along a road: ``parking:right=lane`` and the older ``parking:lane:right=parallel``.

The new way of writing goes before the old one, keys with a side before those for both (OSM wiki, Street parking).
What is mapped as an area of its own (``separate``) is not made here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.osmParsing.defaults import PARKING_WIDTH
from osm2xodr.osmParsing.tags.lane_lists import Findings
from osm2xodr.osmParsing.tags.sides import Tags, width_of_side

_OLD: Final = "parking:lane"
_NEW: Final = "parking"
_SIDES: Final = ("left", "right", "both")
# How cars stand, by OSM's value; the last two are older still.
_ORIENTATIONS: Final = {
    "parallel": "parallel",
    "diagonal": "diagonal",
    "perpendicular": "perpendicular",
    "inline": "parallel",
    "orthogonal": "perpendicular",
}
# Values of the old key that give parking without saying how cars stand.
_SOMEHOW: Final = frozenset({"marked", "yes"})
PARKING_TAGS: Final = tuple(
    key
    for side in _SIDES
    for key in (
        *(f"{_NEW}:{side}{ending}" for ending in ("", ":orientation", ":width")),
        *(f"{_OLD}:{side}{ending}" for ending in ("", ":width")),
        *(f"{_OLD}:{side}:{value}" for value in (*_ORIENTATIONS, *sorted(_SOMEHOW))),
    )
)

LANE: Final = "lane"
HALF_ON_KERB: Final = "half_on_kerb"
ON_KERB: Final = "on_kerb"
STREET_SIDE: Final = "street_side"
SHOULDER: Final = "shoulder"
# Where cars stand, by the value of either way of writing.
_PLACES: Final = {
    "lane": LANE,
    "on_street": LANE,
    "painted_area_only": LANE,
    "half_on_kerb": HALF_ON_KERB,
    "on_kerb": ON_KERB,
    "street_side": STREET_SIDE,
    "lay_by": STREET_SIDE,
    "shoulder": SHOULDER,
}
# No parking, or none that is made from the tags of the road.
_NONE: Final = frozenset(
    {"no", "none", "separate", "no_parking", "no_stopping", "no_standing", "fire_lane", "not_applicable"}
)
_CODE: Final = "parking"


@dataclass(frozen=True, slots=True)
class Parking:
    """Parking on one side of a way."""

    place: str  # `LANE`, `HALF_ON_KERB`, `ON_KERB`, `STREET_SIDE` or `SHOULDER`
    width: float  # Of the strip, m
    given: bool  # Whether OSM gives the width

    @property
    def on_carriageway(self) -> float:
        """How much of the strip is part of the carriageway that ``width`` measures, m."""
        return self.width * {LANE: 1.0, HALF_ON_KERB: 0.5}.get(self.place, 0.0)


def read_parking(tags: Tags, side: str, findings: Findings) -> Parking | None:
    """Return the parking on a side of a way; None where there is none to be made.

    Parameters
    ----------
    tags
        Of the way.
    side
        ``left`` or ``right``, seen along it.
    findings
        What is guessed, not known or contradicts itself is added, once for both sides.
    """
    new = _new(tags, side, findings)
    old = _old(tags, side, findings)
    if new is None and old is None:
        return None
    if new is not None and old is not None and (new[0] == "") != (old[0] == ""):
        _say(findings, Kind.REPAIRED, "parking:lane contradicts the newer tags of parking, which are taken")
    place, orientation = new or old or ("", "")
    if not place:
        return None
    if new and not orientation and old:
        orientation = old[1]
    if not orientation:
        _say(findings, Kind.GUESSED, "no orientation of parking given, parallel assumed")
    keys = [f"{key}:{name}:width" for key in (_NEW, _OLD) for name in (side, "both")]
    width = width_of_side(tags, keys, _CODE, findings)
    return Parking(place, width or PARKING_WIDTH[orientation or "parallel"], width is not None)


def _new(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation as the new way of writing has them, "" for none; None where it is not used."""
    for name in (f"{_NEW}:{side}", f"{_NEW}:both"):
        value = _first(tags, name, (*_PLACES, *_NONE, "yes"), findings)
        if value is None:
            continue
        if value in _NONE:
            return "", ""
        if value == "yes":
            _say(findings, Kind.GUESSED, f"{name}=yes does not say where cars stand, on the carriageway assumed")
        names = (f"{_NEW}:{side}:orientation", f"{_NEW}:both:orientation")
        orientation = next((found for key in names if (found := _first(tags, key, _ORIENTATIONS, findings))), "")
        return _PLACES.get(value, LANE), _ORIENTATIONS.get(orientation, "")
    return None


def _old(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation as the old way of writing has them, "" for none; None where it is not used."""
    for name in (f"{_OLD}:{side}", f"{_OLD}:both"):
        value = _first(tags, name, (*_ORIENTATIONS, *_NONE, *_SOMEHOW), findings)
        if value is None:
            continue
        if value in _NONE:
            return "", ""
        names = (f"{_OLD}:{side}:{value}", f"{_OLD}:both:{value}")
        place = next((found for key in names if (found := _first(tags, key, _PLACES, findings))), "lane")
        return _PLACES[place], _ORIENTATIONS.get(value, "")
    return None


def _first(tags: Tags, name: str, known: Sequence[str] | dict[str, str], findings: Findings) -> str | None:
    """Return the value of a tag, the first that is known of several; None where there is none."""
    text = tags.get(name)
    if text is None:
        return None
    value = next((part.strip() for part in text.split(";") if part.strip() in known), None)
    if value is None:
        _say(findings, Kind.DROPPED, f"{name}={text} is not known and is ignored")
    elif value != text:
        _say(findings, Kind.GUESSED, f"{name}={text} taken for {value}")
    return value


def _say(findings: Findings, kind: Kind, words: str) -> None:
    if (kind, _CODE, words) not in findings:
        findings.append((kind, _CODE, words))
