"""Speed limits by law, widths of lanes, colours and widths of road marks by country.

The table is `countries.json`, with the sources of each country. Where it has no entry, the numbers here hold.
`legal_speeds.json` has the limits that usually hold where no sign says another, also for countries whose law differs
from state to state: good enough for a guess, not for the meaning of a tag.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import field
from functools import lru_cache
from importlib import resources
from types import MappingProxyType
from typing import Any, Final

from osm2xodr.defaults import WALKING_SPEED_KMH
from osm2xodr.system import record

# Width of one of several lanes by OSM's highway value, m: RAL 2012 (rural roads 3.50 and 3.25) and RASt 06 (6.50 m of
# carriageway for main streets with buses, 4.75 m where a car passes a lorry slowly); within 0.2 m of the 12, 11 and
# 10 feet of AASHTO's Green Book for the same uses. 14 km of motorways were surveyed with 3.6 to 3.7 between lines,
# where RAA 2008 has 3.75; residential and unclassified streets of two lanes with 3.2 and 3.7; ``width`` of 56
# residential ones says 3.0.
LANE_WIDTH: Final = MappingProxyType(
    {
        "motorway": 3.65,
        **dict.fromkeys(("motorway_link", "trunk", "trunk_link", "primary", "primary_link"), 3.5),
        **dict.fromkeys(("secondary", "secondary_link", "tertiary", "tertiary_link", "busway"), 3.25),
        **dict.fromkeys(("unclassified", "road"), 3.25),
        "residential": 3.0,
        **dict.fromkeys(("living_street", "service", "pedestrian"), 2.5),
        "track": 2.0,
        "raceway": 5.0,
    }
)
LANE_WIDTH_OTHER: Final = 3.0
# The same in built-up areas where lanes of one direction lie beside each other, m: RASt 06, 3.00 to 3.25; streets of
# two to four lanes one way were surveyed with 2.8 to 3.4.
LANE_WIDTH_BESIDE_IN_TOWN: Final = 3.0
# Width of a carriageway of one lane for one direction, m, parked cars not counted: it has room to pass a vehicle that
# stands. Beside the parked cars of 40 residential streets in Berlin kerbs leave 4.0 to 4.4. Ramps surveyed with 5.0;
# medians of ``width``: secondary 4.7 (33 ways), tertiary 5.0 (17), residential 4.0 (79), where surveys say 4.1;
# RASt 06 has 4.75 on main streets and 3.00 to 3.50 where only cars pass.
ONE_LANE_WIDTH: Final = MappingProxyType(
    {
        **dict.fromkeys(("motorway_link", "trunk_link"), 5.0),
        **dict.fromkeys(("primary", "secondary", "tertiary"), 4.75),
        **dict.fromkeys(("trunk", "primary_link", "secondary_link", "tertiary_link"), 4.5),
        **dict.fromkeys(("unclassified", "residential", "road"), 4.0),
        "living_street": 3.5,
        "service": 3.0,
    }
)

# Usual limits where those of the country are not known, km/h: the medians over all countries of legal_speeds.json
# (urban 50, rural 90, motorways 120, living streets 20).
DEFAULT_SPEED_KMH: Final = MappingProxyType({"urban": 50, "rural": 90, "motorway": 120, "living_street": 20})

# Rank of a road by OSM's highway value where nothing is signed: traffic from a road of lower rank yields. Ramps yield
# to all roads that run on; traffic from properties, tracks and streets with walking speed yields to all others
# (StVO, sections 8, 10 and 18; Vienna Convention on Road Traffic, article 18). Residential and unclassified roads
# have equal rank.
PRIORITY_RANK: Final = MappingProxyType(
    {
        "motorway": 10,
        "trunk": 9,
        "primary": 8,
        "secondary": 7,
        "tertiary": 6,
        **dict.fromkeys(("unclassified", "residential", "road", "busway"), 4),
        **dict.fromkeys(("living_street", "pedestrian"), 2),
        "service": 1,
        "track": 0,
    }
)
PRIORITY_RANK_LINK: Final = 3
# Rank of ramps at junctions through which no street of `PRIORITY_RANK_OTHER` runs: they lead from and to main roads;
# a choice.
PRIORITY_RANK_LINK_ABOVE: Final = 5
PRIORITY_RANK_OTHER: Final = 4

# Width of narrow marks and of wide ones (motorway edges), m: German RMS 1993.
MARK_WIDTH: Final = 0.12
MARK_WIDTH_WIDE: Final = 0.15
# Width of edge lines, in general and of roads built for speed, and of lines beside lanes for buses, taxis and
# bicycles, m: narrow and wide marks of RMS 1993. Widths by country are in conventions/countries.json.
EDGE_MARK_WIDTH: Final = 0.12
EDGE_MARK_WIDTH_FAST: Final = 0.15
SPECIAL_MARK_WIDTH: Final = 0.25
SPECIAL_MARK_WIDTH_FAST: Final = 0.30

U_TURNS: Final = ("law", "all", "mapped", "none")
"""Which U-turns between carriageways are kept: as the law says at signals, all that OSM allows, mapped ones, none."""
KMH: Final = "km/h"
MPH: Final = "mph"
# Units of speed limits, m/s.
SPEED_UNITS: Final[Mapping[str, float]] = MappingProxyType({KMH: 1.0 / 3.6, MPH: 0.44704})
# OSM's values of ``maxspeed:type`` that name what `Country.default_speeds` calls otherwise.
_USUAL_NAMES: Final = MappingProxyType({"trunk": "motorroad", "nsl_single": "rural", "nsl_dual": "dual"})


@record
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


@record
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
