"""Guessed speed limits, where neither OSM nor a law that is sure to hold gives one.

Outside and inside built-up areas, and by class, most countries have a limit that holds where no sign says another
(`Country.default_speeds`). What has to be guessed is whether the area is built up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from typing import Final

from osm2xodr.conventions import KMH, SPEED_UNITS, Country
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Street, StreetAttributes
from osm2xodr.osmParsing.defaults import LINK_SPEED_KMH, SERVICE_SPEED_KMH
from osm2xodr.osmParsing.tags import Tags, in_town, limit_words

# Classes by what decides about their limit, besides the place.
_OWN_LIMIT: Final = {"motorway": "motorway", "living_street": "living_street", "pedestrian": "living_street"}
_SLOW: Final = frozenset({"service", "track"})
_DUAL: Final = frozenset({"trunk", "primary", "secondary"})


def with_default_speeds(
    streets: Sequence[Street],
    tags: Mapping[int, Tags],
    dense: Set[int],
    country: Country,
    diagnostics: Diagnostics,
) -> tuple[Street, ...]:
    """Give a guessed limit to every piece of street without one.

    `tags` are those of ways by id; `dense` are the ids of the ways among residential streets. The diagnostics get
    each way that is given a limit.
    """
    stated: dict[int, str] = {}
    # By identity: the pieces of a way share their attributes.
    guessed: dict[int, StreetAttributes] = {}
    out: list[Street] = []
    for street in streets:
        for _, piece in street.pieces:
            if id(piece) not in guessed and not _is_known(piece):
                way = piece.osm_way_id
                speed, stated[way] = _guess(piece, tags[way], way in dense, country)
                guessed[id(piece)] = replace(piece, default_speed=speed)
        if any(id(piece) in guessed for _, piece in street.pieces):
            pieces = tuple((first, guessed.get(id(piece), piece)) for first, piece in street.pieces)
            street = replace(street, pieces=pieces)
        out.append(street)
    for way, words in sorted(stated.items()):
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
    if highway == "residential" or in_town(tags, dense):
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
