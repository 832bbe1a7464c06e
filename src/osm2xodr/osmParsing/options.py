"""Options of reading OSM. Imports nothing heavy, as the command line needs it first."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from osm2xodr.conventions import Group, flag, option, same_option
from osm2xodr.osmParsing.defaults import LANE_WIDTH_MAX, LANE_WIDTH_MIN
from osm2xodr.system import record

if TYPE_CHECKING:
    from osm2xodr.model import Corrections, LocalFrame, Rule

_MAJOR: Final = frozenset(
    f"{name}{link}" for name in ("motorway", "trunk", "primary", "secondary", "tertiary") for link in ("", "_link")
)
_DRIVABLE: Final = _MAJOR | {"unclassified", "residential", "living_street", "service", "road"}
_ALL: Final = _DRIVABLE | {"track", "busway", "raceway"}

# All values of ``highway`` that can be asked for: roads wide enough for cars.
HIGHWAYS: Final = _ALL | {"pedestrian"}


@record
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


def _check_width(width: float) -> float:
    """Return the width of a lane, m; ValueError if no lane has it."""
    if not (math.isfinite(width) and LANE_WIDTH_MIN <= width <= LANE_WIDTH_MAX):
        raise ValueError(
            f"a lane cannot be {width:g} m wide, give a width from {LANE_WIDTH_MIN:g} to {LANE_WIDTH_MAX:g} m"
        )
    return width


def _side(left: bool) -> Rule:
    from osm2xodr.model import Rule

    return Rule.LEFT_HAND if left else Rule.RIGHT_HAND


def _no_corrections() -> Corrections:
    from osm2xodr.model import Corrections

    return Corrections()


@record
class ParseOptions:
    """What is read of an OSM file; ValueError if the lane width is not that of a lane."""

    ways: WaySelection = option(
        "ways",
        Group.WHAT,
        "Which ways: major, drivable, all, or values of OSM's highway, separated by commas.",
        default="drivable",
        metavar="LIST",
        parse=parse_ways_option,
        stage=DRIVABLE,
    )
    include_private: bool = flag("include_private", Group.WHAT, "Keep ways that are closed to the public.")
    # The driving side; None takes it from OSM or the country
    rule: Rule | None = option(
        "left_hand", Group.LANES, "Traffic drives on the left.  [default: as in the country]", bool, parse=_side
    )
    default_lane_width: float | None = option(
        "default_lane_width",
        Group.LANES,
        "Width of lanes where OSM gives none.  [default: by class of road]",
        float,
        metavar="METRES",
        parse=_check_width,
    )
    # Whether to read footways, barriers, stops, tram tracks, signs beside streets
    furniture: bool = same_option("no_furniture", True)
    # Things read beside streets on request: ``lamps``, ``trees``
    extra_objects: frozenset[str] = same_option("objects", frozenset())
    default_speeds: bool = flag(
        "no_default_speeds",
        Group.LANES,
        "Write only the speed limits that OSM gives, none that is usual in the country.",
        negates="default_speeds",
    )
    guessed_parking: bool = flag(
        "no_guessed_parking",
        Group.LANES,
        "Write only the parking that OSM gives, none that streets in towns usually have.",
        negates="guessed_parking",
    )
    guessed_sidewalks: bool = flag(
        "no_guessed_sidewalks",
        Group.LANES,
        "Write only the sidewalks that OSM gives, none that streets in towns usually have.",
        negates="guessed_sidewalks",
    )
    guessed_shoulders: bool = flag(
        "no_guessed_shoulders",
        Group.LANES,
        "Write only the shoulders that OSM gives, none that motorways usually have.",
        negates="guessed_shoulders",
    )
    frame: LocalFrame | None = None  # The local frame; None makes one in the middle of the streets
    # Whether a map may be read of which its server says that it is not whole
    allow_partial: bool = same_option("allow_partial", False)
    corrections: Corrections = field(default_factory=_no_corrections)  # What the user knows better than OSM

    def __post_init__(self) -> None:
        if self.default_lane_width is not None:
            _check_width(self.default_lane_width)
