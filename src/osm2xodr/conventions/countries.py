"""Speed limits by law, widths of lanes, colours and widths of road marks by country.

The table is `countries.json`, with the sources of each country. Where it has no entry, `conventions.defaults` holds.
`legal_speeds.json` has the limits that usually hold where no sign says another, also for countries whose law differs
from state to state: good enough for a guess, not for the meaning of a tag.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import resources
from types import MappingProxyType
from typing import Any, Final

from osm2xodr.conventions.defaults import (
    DEFAULT_SPEED_KMH,
    EDGE_MARK_WIDTH,
    EDGE_MARK_WIDTH_FAST,
    LANE_WIDTH,
    LANE_WIDTH_BESIDE_IN_TOWN,
    LANE_WIDTH_OTHER,
    MARK_WIDTH,
    MARK_WIDTH_WIDE,
    ONE_LANE_WIDTH,
    SPECIAL_MARK_WIDTH,
    SPECIAL_MARK_WIDTH_FAST,
)
from osm2xodr.defaults import WALKING_SPEED_KMH

U_TURNS: Final = ("law", "all", "mapped", "none")
"""Which U-turns between carriageways are kept: as the law says at signals, all that OSM allows, mapped ones, none."""
KMH: Final = "km/h"
MPH: Final = "mph"
# Units of speed limits, m/s.
SPEED_UNITS: Final[Mapping[str, float]] = MappingProxyType({KMH: 1.0 / 3.6, MPH: 0.44704})
# OSM's values of ``maxspeed:type`` that name what `Country.default_speeds` calls otherwise.
_USUAL_NAMES: Final = MappingProxyType({"trunk": "motorroad", "nsl_single": "rural", "nsl_dual": "dual"})


@dataclass(frozen=True, slots=True)
class MarkStyle:
    """Road marks of a country; colours in OpenDRIVE's words, where ``standard`` is white."""

    # Colour of centre lines (between opposite directions) where they are broken, and where any of them is solid
    centre: str = "standard"
    centre_solid: str = "standard"
    # Colour of solid centre lines on roads of two lanes that forbid overtaking; empty if it is `centre_solid`
    no_overtaking: str = ""
    no_change: str = "standard"  # Colour of solid lines between lanes of one direction
    # Colour of edge lines; the second on the side of a one-way carriageway where oncoming traffic would be
    outer_edge: str = "standard"
    median_edge: str = "standard"
    double_from: int = 0  # Least number of lanes for cars with a double centre line; 0 for none
    # Whether centre lines on roads of two lanes are double where nobody may overtake
    double_no_overtaking: bool = False
    # Width of a line, or of each line of a double one, m; the second on `FAST_HIGHWAYS`
    width: float = MARK_WIDTH
    width_fast: float = MARK_WIDTH_WIDE
    # Width of edge lines, m
    edge_width: float = EDGE_MARK_WIDTH
    edge_width_fast: float = EDGE_MARK_WIDTH_FAST
    # Width of lines beside lanes for buses, taxis or bicycles, m
    special_width: float = SPECIAL_MARK_WIDTH
    special_width_fast: float = SPECIAL_MARK_WIDTH_FAST
    # Whether lines of a road that goes first run on past a side street. Past accesses of properties they always do.
    past_side_streets: bool = True


@dataclass(frozen=True, slots=True)
class Country:
    """Laws and usual designs in a country, or in a part of one."""

    code: str = ""  # ISO 3166-1 alpha-2 or ISO 3166-2; empty for `GENERIC`
    speed_unit: str = KMH  # Unit of its speed limit signs: `KMH` or `MPH`
    # Legal limits, m/s, by OSM's values of ``maxspeed:type`` (``urban``, ``rural``, ``motorway``, ``trunk``,
    # ``living_street`` …); ``residential`` where such streets have a limit of their own. Infinity where there is
    # none; absent where the law differs within the country.
    speeds: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    # Usual limits where nothing says another, m/s: ``urban``, ``rural``, ``motorway`` and ``living_street``; where
    # they differ, also ``residential`` streets and ``service`` roads, and outside of built-up areas ``dual``
    # carriageways and roads for motor vehicles only (``motorroad``). Infinity where there is none.
    default_speeds: Mapping[str, float] = field(default_factory=lambda: _default_speeds("", {}), hash=False)
    # Width of one of several lanes, m, by highway value, where it differs from `LANE_WIDTH`
    lane_widths: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    # The largest of those of one direction beside each other in built-up areas, m, where it differs from most
    lane_width_beside: float | None = None
    marks: MarkStyle = MarkStyle()
    u_turns_at_signals: bool = True  # Whether cars may turn back at signals where no sign says that they may not
    sources: tuple[str, ...] = ()  # Titles of the laws and guides

    def lane_width(self, highway: str, *, alone: bool = False, beside_in_town: bool = False) -> float:
        """Return the usual width of a lane for cars, m, by highway value.

        It may be `alone` on the carriageway, or lie `beside` others of its direction in a built-up area.
        """
        width = self.lane_widths.get(highway, LANE_WIDTH.get(highway, LANE_WIDTH_OTHER))
        if alone:
            return max(width, ONE_LANE_WIDTH.get(highway, width))
        if not beside_in_town:
            return width
        return min(width, LANE_WIDTH_BESIDE_IN_TOWN if self.lane_width_beside is None else self.lane_width_beside)


def find_country(code: str) -> Country:
    """Return the country with an ISO 3166-1 alpha-2 (or 3166-2) code; `GENERIC` if it is not in the tables."""
    return countries().get(code) or _lesser_known(code)


@lru_cache(maxsize=64)
def _lesser_known(code: str) -> Country:
    """Return a country of which at most the usual limits are known."""
    return Country(code, default_speeds=_default_speeds(code, {})) if code in _legal_speeds() else GENERIC


@lru_cache(maxsize=1)
def countries() -> Mapping[str, Country]:
    """Return all countries of the table by their codes."""
    table = _table("countries.json")
    titles = table["sources"]
    return MappingProxyType({code: _country(code, entry, titles) for code, entry in table["countries"].items()})


def _table(name: str) -> Mapping[str, Any]:
    text = resources.files("osm2xodr.conventions").joinpath(name).read_text(encoding="utf-8")
    table: Mapping[str, Any] = json.loads(text)
    return table


@lru_cache(maxsize=1)
def _legal_speeds() -> Mapping[str, Mapping[str, Any]]:
    found: Mapping[str, Mapping[str, Any]] = _table("legal_speeds.json")["countries"]
    return found


def _in_si(limits: Mapping[str, Any], unit: str) -> dict[str, float]:
    """Return limits in m/s; words stand for no limit and for walking speed."""
    words = {"none": math.inf, "walk": WALKING_SPEED_KMH * SPEED_UNITS[KMH]}
    return {kind: words[limit] if limit in words else limit * SPEED_UNITS[unit] for kind, limit in limits.items()}


def _default_speeds(code: str, known: Mapping[str, float]) -> Mapping[str, float]:
    """Return the usual limits of a country, m/s: those that are known for sure, else of the table, else of most."""
    entry = dict(_legal_speeds().get(code, {}))
    speeds = _in_si(entry, str(entry.pop("unit", KMH)))
    speeds |= {_USUAL_NAMES.get(kind, kind): speed for kind, speed in known.items()}
    out = _in_si(DEFAULT_SPEED_KMH, KMH) | speeds
    # Nowhere is the limit of built-up areas above that outside of them.
    if "rural" in speeds and "urban" not in speeds:
        out["urban"] = min(out["urban"], speeds["rural"])
    return MappingProxyType(out)


def _country(code: str, entry: Mapping[str, Any], titles: Mapping[str, str]) -> Country:
    unit = entry.get("unit", KMH)
    speeds = _in_si(entry.get("speeds", {}), unit)
    return Country(
        code=code,
        speed_unit=unit,
        speeds=MappingProxyType(speeds),
        default_speeds=_default_speeds(code, speeds),
        lane_widths=MappingProxyType(dict(entry.get("lane_widths", {}))),
        lane_width_beside=entry.get("lane_width_beside"),
        marks=MarkStyle(**entry.get("marks", {})),
        u_turns_at_signals=entry.get("u_turns_at_signals", True),
        sources=tuple(titles[source] for source in entry["sources"]),
    )


GENERIC: Final = Country()
