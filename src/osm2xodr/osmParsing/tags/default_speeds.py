"""Guessed speed limits, where neither OSM nor a law that is sure to hold gives one.

Outside and inside built-up areas, and by class, most countries have a limit that holds where no sign says another
(`Country.default_speeds`). What has to be guessed is whether the area is built up.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from osm2xodr.conventions import KMH, SPEED_UNITS, Country
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import BUILT_UP_DENSITY, LINK_SPEED_KMH, SERVICE_SPEED_KMH
from osm2xodr.osmParsing.tags.legal_speeds import EVIDENCE_TAGS, is_built_up, limit_words
from osm2xodr.osmParsing.tags.values import Tags

# Tags whose values, such as ``DE:urban``, say where a way is, the surest first (OSM wiki, Key:source:maxspeed).
_PLACE_TAGS: Final = ("zone:traffic", "maxspeed:type", "source:maxspeed", "zone:maxspeed", "maxspeed")
_URBAN: Final = re.compile(r"[A-Z-]+:\s*(urban|nsl_restricted|(zone:?)?\d+$|living_street)|zone", re.IGNORECASE)
_RURAL: Final = re.compile(r"[A-Z-]+:\s*(rural|trunk|motorway|motorroad|nsl_single|nsl_dual)", re.IGNORECASE)
# Classes by what decides about their limit, besides the place.
_OWN_LIMIT: Final = {"motorway": "motorway", "living_street": "living_street", "pedestrian": "living_street"}
_SLOW: Final = frozenset({"service", "track"})
_DUAL: Final = frozenset({"trunk", "primary", "secondary"})
DEFAULT_SPEED_TAGS: Final = (*_PLACE_TAGS, *EVIDENCE_TAGS, "motorroad")


def with_default_speeds(
    streets: Sequence[Street],
    tags: Mapping[int, Tags],
    density: FloatArray,
    country: Country,
    diagnostics: Diagnostics,
) -> tuple[Street, ...]:
    """Give a guessed limit to every piece of street without one.

    `tags` are those of ways by id; `density` (streets,) is that of residential streets around each street, m per
    hectare. The diagnostics get each way that is given a limit.
    """
    said: dict[int, str] = {}
    out: list[Street] = []
    for street, dense in zip(streets, (density >= BUILT_UP_DENSITY).tolist(), strict=True):
        known = [_is_known(piece) for _, piece in street.pieces]
        if all(known):
            out.append(street)
            continue
        pieces = []
        for (first, piece), has_limit in zip(street.pieces, known, strict=True):
            guessed = piece
            if not has_limit:
                speed, said[piece.osm_way_id] = _guess(piece, tags[piece.osm_way_id], dense, country)
                guessed = replace(piece, default_speed=speed)
            pieces.append((first, guessed))
        out.append(replace(street, pieces=tuple(pieces)))
    for way, words in sorted(said.items()):
        diagnostics.guessed("speed", f"way/{way}", words)
    return tuple(out)


def _is_known(piece: StreetAttributes) -> bool:
    """Whether the limit of each direction of cars is known."""
    if piece.speed_forward is not None and piece.speed_backward is not None:
        return True
    return all(piece.speed_along(direction) is not None for direction in piece.car_directions())


def _guess(piece: StreetAttributes, tags: Tags, dense: bool, country: Country) -> tuple[float, str]:
    """Return the limit of a piece of street, m/s, and in words what it follows from."""
    for known in (piece.speed_forward, piece.speed_backward):
        if known is not None:
            return known, f"no limit given for one direction, taken from the other one: {limit_words(known, country)}"
    speed, where = _usual(piece, tags, dense, country)
    return speed, f"no limit given, {limit_words(speed, country)} is usual {where}"


def _usual(piece: StreetAttributes, tags: Tags, dense: bool, country: Country) -> tuple[float, str]:
    """Return the usual limit on a piece of street, m/s, and in words where."""
    highway, speeds = piece.highway, country.default_speeds
    where = f"in {country.code}" if country.code else "in most countries"
    if highway in _SLOW:
        speed = speeds.get("service", SERVICE_SPEED_KMH * SPEED_UNITS[KMH])
        return speed, "on roads to single properties and fields"
    if highway in _OWN_LIMIT:
        return speeds[_OWN_LIMIT[highway]], f"on roads of its class {where}"
    if highway == "motorway_link":
        return min(speeds["motorway"], LINK_SPEED_KMH * SPEED_UNITS[KMH]), "on ramps"
    if highway == "residential" or _in_town(tags, dense):
        urban = speeds["urban"]
        speed = speeds.get("residential", urban) if highway == "residential" else urban
        return speed, f"in built-up areas {where}"
    kind = "rural"
    apart = len(piece.car_directions()) == 1 and not piece.roundabout and highway in _DUAL
    if tags.get("motorroad") == "yes" or (highway == "trunk" and apart):
        kind = next((name for name in ("motorroad", "dual") if name in speeds), kind)
    elif apart and "dual" in speeds:
        kind = "dual"
    speed = speeds[kind]
    if highway.endswith("_link"):
        return min(speed, LINK_SPEED_KMH * SPEED_UNITS[KMH]), "on ramps"
    return speed, f"outside built-up areas {where}"


def _in_town(tags: Tags, dense: bool) -> bool:
    """Whether a way lies in a built-up area: as tagged, else where there are lamps, sidewalks or dwellings."""
    for key in _PLACE_TAGS:
        if key in tags and (_URBAN.match(tags[key]) or _RURAL.match(tags[key])):
            return bool(_URBAN.match(tags[key]))
    if tags.get("motorroad") == "yes":
        return False
    return is_built_up(tags) or dense
