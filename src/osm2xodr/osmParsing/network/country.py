"""The country of a place and the side of the road that it drives on, from a table of borders in the package."""

from __future__ import annotations

import gzip
import json
import math
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Final

import numpy as np

from osm2xodr.curves import cosine, hypot
from osm2xodr.model import FloatArray, IntArray

# How far out at sea the driving side is that of the nearest country, m; a choice.
_COUNTRY_REACH: Final = 200e3

_METRES_PER_DEGREE: Final = 111_195.0  # of latitude, on a sphere of 6371 km


@dataclass(frozen=True, slots=True)
class Place:
    """A place on Earth."""

    country: str  # ISO 3166-1 alpha-2; empty outside of all countries
    drives_left: bool | None  # Whether traffic drives on the left; None where no country is near


@dataclass(frozen=True, slots=True, eq=False)
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
