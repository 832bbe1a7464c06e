"""Parking along a road: ``parking:right=lane`` and the older ``parking:lane:right=parallel``.

The newer tagging scheme takes precedence over the older one, keys for one side over those for both (OSM wiki, Street
parking). Parking mapped as an area of its own (``separate``) is not part of the road.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.osmParsing.defaults import PARKING_WIDTH
from osm2xodr.osmParsing.tags.sides import width_of_side
from osm2xodr.osmParsing.tags.values import Findings, Tags, add_once

_OLD: Final = "parking:lane"
_NEW: Final = "parking"
_SIDES: Final = ("left", "right", "both")
# Orientation of parked cars by OSM's value; the last two are older still.
_ORIENTATIONS: Final = {
    **{value: value for value in ("parallel", "diagonal", "perpendicular")},
    "inline": "parallel",
    "orthogonal": "perpendicular",
}
# Values of the older key for parking of unknown orientation.
_UNORIENTED: Final = frozenset({"marked", "yes"})
PARKING_TAGS: Final = tuple(
    key
    for side in _SIDES
    for key in (
        *(f"{_NEW}:{side}{ending}" for ending in ("", ":orientation", ":width")),
        *(f"{_OLD}:{side}{ending}" for ending in ("", ":width")),
        *(f"{_OLD}:{side}:{value}" for value in (*_ORIENTATIONS, *sorted(_UNORIENTED))),
    )
)

LANE: Final = "lane"
HALF_ON_KERB: Final = "half_on_kerb"
ON_KERB: Final = "on_kerb"
STREET_SIDE: Final = "street_side"
SHOULDER: Final = "shoulder"
# Where cars stand, by the value in either scheme.
_PLACES: Final = {
    **{place: place for place in (LANE, HALF_ON_KERB, ON_KERB, STREET_SIDE, SHOULDER)},
    **dict.fromkeys(("on_street", "painted_area_only"), LANE),
    "lay_by": STREET_SIDE,
}
# No parking, or none that is part of the road.
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
    """Return the parking on a side (``left`` or ``right``) of a way; None if there is none.

    Findings that concern both sides are added once.
    """
    new = _newer(tags, side, findings)
    old = _older(tags, side, findings)
    if new is None and old is None:
        return None
    if new is not None and old is not None and (new[0] == "") != (old[0] == ""):
        words = "parking:lane contradicts the newer tags of parking, which are taken"
        add_once(findings, Kind.REPAIRED, _CODE, words)
    place, orientation = new or old or ("", "")
    if not place:
        return None
    if new and not orientation and old:
        orientation = old[1]
    if not orientation:
        add_once(findings, Kind.GUESSED, _CODE, "no orientation of parking given, parallel assumed")
    keys = [f"{key}:{name}:width" for key in (_NEW, _OLD) for name in (side, "both")]
    width = width_of_side(tags, keys, _CODE, findings)
    return Parking(place, width or PARKING_WIDTH[orientation or "parallel"], width is not None)


def _newer(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation in the newer scheme, "" for none; None where it is not used."""
    for name in (f"{_NEW}:{side}", f"{_NEW}:both"):
        value = _first(tags, name, (*_PLACES, *_NONE, "yes"), findings)
        if value is None:
            continue
        if value in _NONE:
            return "", ""
        if value == "yes":
            words = f"{name}=yes does not say where cars stand, on the carriageway assumed"
            add_once(findings, Kind.GUESSED, _CODE, words)
        names = (f"{_NEW}:{side}:orientation", f"{_NEW}:both:orientation")
        orientation = next((found for key in names if (found := _first(tags, key, _ORIENTATIONS, findings))), "")
        return _PLACES.get(value, LANE), _ORIENTATIONS.get(orientation, "")
    return None


def _older(tags: Tags, side: str, findings: Findings) -> tuple[str, str] | None:
    """Return place and orientation in the older scheme, "" for none; None where it is not used."""
    for name in (f"{_OLD}:{side}", f"{_OLD}:both"):
        value = _first(tags, name, (*_ORIENTATIONS, *_NONE, *_UNORIENTED), findings)
        if value is None:
            continue
        if value in _NONE:
            return "", ""
        names = (f"{_OLD}:{side}:{value}", f"{_OLD}:both:{value}")
        place = next((found for key in names if (found := _first(tags, key, _PLACES, findings))), "lane")
        return _PLACES[place], _ORIENTATIONS.get(value, "")
    return None


def _first(tags: Tags, name: str, known: Sequence[str] | dict[str, str], findings: Findings) -> str | None:
    """Return the value of a tag, of several the first known one; None if there is none."""
    text = tags.get(name)
    if text is None:
        return None
    value = next((part.strip() for part in text.split(";") if part.strip() in known), None)
    if value is None:
        add_once(findings, Kind.DROPPED, _CODE, f"{name}={text} is not known and is ignored")
    elif value != text:
        add_once(findings, Kind.GUESSED, _CODE, f"{name}={text} taken for {value}")
    return value
