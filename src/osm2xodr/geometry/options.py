"""What the user may choose about roads and their heights. Imports nothing heavy: the command line reads it first."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from osm2xodr.conventions import PLANS, SUPERELEVATION, U_TURNS, Group, flag, option
from osm2xodr.defaults import GRADE_LIMIT
from osm2xodr.errors import InputError
from osm2xodr.geometry.defaults import GRADE_MAX
from osm2xodr.system import record

# Classes that the defaults leave to the value for all others.
_OTHER_CLASSES: Final = ("busway", "pedestrian", "raceway", "road")
# Least grade limit that a user may set: RAL and RASt want 0.5 to 0.7 % at least for the water to run off.
_GRADE_LIMIT_MIN: Final = 0.005
# Beyond this factor nothing is left of the terrain: a choice.
_SMOOTHING_MOST: Final = 100.0


def parse_grade_limits(text: str) -> Mapping[str, float]:
    """Return the grade limits by class, the user's own in place of the defaults.

    Parameters
    ----------
    text
        Comma-separated ``class=limit``, the class a value of OSM's ``highway``, the limit in rise per metre or per
        cent: ``motorway=0.05,residential=12%``.

    Raises
    ------
    InputError
        An entry has another form, its class is no road, or its limit is not one that a road can have.
    """
    known = {*GRADE_LIMIT, *_OTHER_CLASSES}
    own: dict[str, float] = {}
    for entry in text.split(","):
        name, equals, value = (part.strip() for part in entry.partition("="))
        if not equals or not name or not value:
            entry = entry.strip()
            raise InputError(f"max grade '{entry}' is not class=limit; write e.g. motorway=0.05,residential=12%")
        if name not in known:
            classes = ", ".join(sorted(known))
            raise InputError(f"max grade for '{name}': no such class of roads; choose from {classes}")
        if name in own:
            raise InputError(f"max grade for '{name}' is given twice; give it once")
        own[name] = _parse_limit(name, value)
    return MappingProxyType({**GRADE_LIMIT, **own})


def _parse_limit(name: str, value: str) -> float:
    """Return a limit in rise per metre."""
    try:
        limit = float(value.removesuffix("%")) * (0.01 if value.endswith("%") else 1.0)
    except ValueError:
        raise InputError(f"max grade for '{name}': '{value}' is not a number; write e.g. 0.08 or 8%") from None
    if not _GRADE_LIMIT_MIN <= limit <= GRADE_MAX:
        raise InputError(
            f"max grade for '{name}': {value} is not between {_GRADE_LIMIT_MIN:g} and "
            f"{GRADE_MAX:g}; write rise per metre, e.g. 0.08, or 8%"
        )
    return limit


def _check_smoothing(factor: float) -> float:
    """Return the factor on the length of smoothing; InputError if it cannot be."""
    if not 0.0 < factor < math.inf:
        raise InputError(f"{factor:g} is not above 0; 1 is the usual, 2 is smoother")
    if factor > _SMOOTHING_MOST:
        what = f"{factor:g} is above {_SMOOTHING_MOST:g}, which levels mountains"
        raise InputError(f"{what}; 1 is the usual, 2 is smoother")
    return factor


@record
class ElevationOptions:
    """What a user may choose about heights."""

    # 1 is what the elevation model itself calls for
    smoothing: float = option(
        "smoothing",
        Group.HEIGHTS,
        "Factor on the length over which heights are smoothed.",
        float,
        default=1.0,
        metavar="FACTOR",
        parse=_check_smoothing,
    )
    # By OSM's ``highway`` value, rise per metre
    grade_limit: Mapping[str, float] = option(
        "max_grade",
        Group.HEIGHTS,
        "Largest grades by class, such as motorway=0.05,residential=12%.  [default: see docs/elevation.md]",
        metavar="TABLE",
        parse=parse_grade_limits,
        stage=GRADE_LIMIT,
    )
    # Whether bridges and tunnels leave the ground, and roads of different layers keep clear of each other
    structures: bool = flag(
        "no_structures", Group.HEIGHTS, "Lay bridges and tunnels on the ground.", negates="structures"
    )
    superelevation: str = option(
        "superelevation",
        Group.HEIGHTS,
        "Cross slope of motorways and trunk roads: as a fine elevation model shows it (cells up to 2 m), elsewhere as"
        " roads are designed (auto); as such a model shows it alone; or none.",
        default=SUPERELEVATION[0],
        choices=SUPERELEVATION,
    )


@record
class RoadOptions:
    """What the user chose about roads."""

    # Those at turning circles have one anyway
    turnarounds: bool = flag("turnarounds", Group.LANES, "End every dead end of a two-way street in a loop.")
    u_turns: str = option(
        "u_turns",
        Group.LANES,
        "U-turns between carriageways that are kept: as the country's law says at signals, all that OSM allows, those"
        " that it maps, or none.",
        default=U_TURNS[0],
        choices=U_TURNS,
    )
    plan: str = option(
        "plan",
        Group.MORE,
        "Reference lines with spirals, of continuous curvature on plain roads, or of lines and arcs alone.",
        default=PLANS[0],
        choices=PLANS,
    )
