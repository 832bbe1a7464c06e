"""The country of a place, from a table of borders in the package, and what holds there where OSM says nothing.

That is the side of the road that it drives on, and speed limits where no law is sure to hold. Outside and inside
built-up areas, and by class, most countries have a limit that holds where no sign says another
(`Country.default_speeds`). What has to be guessed is whether the area is built up.
"""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from functools import lru_cache
from importlib import resources
from typing import Final

import numpy as np

from osm2xodr.conventions import KMH, SPEED_UNITS, Country
from osm2xodr.curves import cosine, hypot
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import FloatArray, IntArray, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import LINK_SPEED_KMH, SERVICE_SPEED_KMH
from osm2xodr.osmParsing.tags import Tags, in_town, limit_words
from osm2xodr.system import record

# How far out at sea the driving side is that of the nearest country, m; a choice.
_COUNTRY_REACH: Final = 200e3

_METRES_PER_DEGREE: Final = 111_195.0  # of latitude, on a sphere of 6371 km

# Classes by what decides about their limit, besides the place.
_OWN_LIMIT: Final = {"motorway": "motorway", "living_street": "living_street", "pedestrian": "living_street"}
_SLOW: Final = frozenset({"service", "track"})
_DUAL: Final = frozenset({"trunk", "primary", "secondary"})


@record
class Place:
    """A place on Earth."""

    country: str  # ISO 3166-1 alpha-2; empty outside of all countries
    drives_left: bool | None  # Whether traffic drives on the left; None where no country is near


@record(eq=False)
class _Borders:
    """Outlines of countries: ends x1, y1 and x2, y2 of each edge, degrees, and the index of its country."""

    codes: tuple[str, ...]
    drives_left: tuple[bool, ...]
    x1: FloatArray
    y1: FloatArray
    x2: FloatArray
    y2: FloatArray
    place: IntArray


@lru_cache(maxsize=1)
def _borders() -> _Borders:
    packed = resources.files("osm2xodr.osmParsing.network").joinpath("data/countries.json.gz").read_bytes()
    table = json.loads(gzip.decompress(packed))
    unit = float(table["unit_deg"])
    owned = [(number, ring) for number, place in enumerate(table["places"]) for ring in place["rings"]]
    rings = [np.cumsum(np.asarray(ring, np.float64).reshape(-1, 2), axis=0) * unit for _, ring in owned]
    x1, y1 = np.concatenate([ring[:-1] for ring in rings]).T
    x2, y2 = np.concatenate([ring[1:] for ring in rings]).T
    edges = np.array([len(ring) - 1 for ring in rings])
    codes, drives_left = (tuple(place[key] for place in table["places"]) for key in ("code", "left"))
    return _Borders(codes, drives_left, x1, y1, x2, y2, np.repeat([number for number, _ in owned], edges))


def find_place(lat_deg: float, lon_deg: float) -> Place:
    """Return the country at a place (degrees, WGS 84) and its driving side.

    Out at sea the driving side is that of the nearest country within 200 km, but no country is named.
    """
    borders = _borders()
    places = len(borders.codes)
    crossed = (borders.y1 > lat_deg) != (borders.y2 > lat_deg)
    x1, y1, x2, y2 = (column[crossed] for column in (borders.x1, borders.y1, borders.x2, borders.y2))
    east_of_it = x1 + (lat_deg - y1) / (y2 - y1) * (x2 - x1) > lon_deg
    inside = np.flatnonzero(np.bincount(borders.place[crossed][east_of_it], minlength=places) % 2)
    if len(inside):
        # Of nested countries the smallest.
        area = np.abs(np.bincount(borders.place, borders.x1 * borders.y2 - borders.x2 * borders.y1, places))
        found = int(inside[np.argmin(area[inside])])
        return Place(borders.codes[found], borders.drives_left[found])
    east = (borders.x1 - lon_deg + 180.0) % 360.0 - 180.0
    distance = hypot(east * cosine(math.radians(lat_deg)), borders.y1 - lat_deg)
    nearest = int(np.argmin(distance))
    if distance[nearest] * _METRES_PER_DEGREE > _COUNTRY_REACH:
        return Place("", None)
    return Place("", borders.drives_left[int(borders.place[nearest])])


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
