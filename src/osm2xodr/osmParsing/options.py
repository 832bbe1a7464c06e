"""Options of reading OSM. Imports nothing heavy, as the command line needs it first."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from osm2xodr.model import Corrections, LocalFrame, Rule
from osm2xodr.osmParsing.defaults import LANE_WIDTH_MAX, LANE_WIDTH_MIN

_MAJOR: Final = frozenset(
    f"{name}{link}" for name in ("motorway", "trunk", "primary", "secondary", "tertiary") for link in ("", "_link")
)
_DRIVABLE: Final = _MAJOR | {"unclassified", "residential", "living_street", "service", "road"}
_ALL: Final = _DRIVABLE | {"track", "busway", "raceway"}

# All values of ``highway`` that can be asked for: roads wide enough for cars.
HIGHWAYS: Final = _ALL | {"pedestrian"}


@dataclass(frozen=True, slots=True)
class WaySelection:
    """Which ways become streets."""

    highways: frozenset[str]  # Values of ``highway`` that become streets
    services_out: frozenset[str] = frozenset()  # Values of ``service`` that are left out nevertheless


DRIVABLE: Final = WaySelection(
    _DRIVABLE, frozenset({"driveway", "parking_aisle", "drive-through", "emergency_access"})
)
PRESETS: Final[Mapping[str, WaySelection]] = MappingProxyType(
    {"major": WaySelection(_MAJOR), "drivable": DRIVABLE, "all": WaySelection(_ALL)}
)


@dataclass(frozen=True, slots=True)
class ParseOptions:
    """What is read of an OSM file; ValueError if the lane width is not that of a lane."""

    ways: WaySelection = DRIVABLE  # Which ways become streets
    include_private: bool = False  # Whether to carry ways that are closed to the public
    rule: Rule | None = None  # The driving side; None takes it from OSM or the country
    # Width of lanes without a tagged width, m; None takes one by the class of the road
    default_lane_width: float | None = None
    furniture: bool = True  # Whether to read footways, barriers, stops, tram tracks, signs beside streets
    extra_objects: frozenset[str] = frozenset()  # Things read beside streets on request: ``lamps``, ``trees``
    default_speeds: bool = True  # Whether streets without a limit get the usual one of the country, place and class
    guessed_sidewalks: bool = True  # Whether streets in towns get sidewalks where no tag says anything of any
    guessed_shoulders: bool = True  # Likewise hard shoulders beside motorways
    frame: LocalFrame | None = None  # The local frame; None makes one in the middle of the streets
    allow_partial: bool = False  # Whether a map may be read of which its server says that it is not whole
    corrections: Corrections = field(default_factory=Corrections)  # What the user knows better than OSM

    def __post_init__(self) -> None:
        width = self.default_lane_width
        if width is not None and not (math.isfinite(width) and LANE_WIDTH_MIN <= width <= LANE_WIDTH_MAX):
            raise ValueError(
                f"a lane cannot be {width:g} m wide, give a width from {LANE_WIDTH_MIN:g} to {LANE_WIDTH_MAX:g} m"
            )


def parse_ways_option(text: str) -> WaySelection:
    """Read ``--ways``: presets and values of ``highway``, separated by commas; ValueError for others or none.

    ``service`` named by itself means service roads of every kind.
    """
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = [name for name in names if name not in PRESETS and name not in HIGHWAYS]
    if unknown or not names:
        problem = f"{unknown[0]!r} is not a kind of way that cars drive on" if unknown else "no kind of way is given"
        raise ValueError(f"{problem}; choose from {', '.join(PRESETS)} or a list of {', '.join(sorted(HIGHWAYS))}")
    highways: frozenset[str] = frozenset()
    services_out: frozenset[str] = frozenset()
    every_service = False
    for name in names:
        chosen = PRESETS.get(name, WaySelection(frozenset({name})))
        highways |= chosen.highways
        services_out |= chosen.services_out
        every_service |= "service" in chosen.highways and not chosen.services_out
    return WaySelection(highways, frozenset() if every_service else services_out)
