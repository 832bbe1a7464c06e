"""The user's own grade limits."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from osm2xodr.defaults import GRADE_LIMIT
from osm2xodr.errors import InputError
from osm2xodr.geometry.defaults import GRADE_MAX
from osm2xodr.geometry.heights import defaults

# Classes that the defaults leave to the value for all others.
_OTHER = ("busway", "pedestrian", "raceway", "road")


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
        An entry is not of that form, its class no road, or its limit none that a road can have.
    """
    known = {*GRADE_LIMIT, *_OTHER}
    table = dict(GRADE_LIMIT)
    seen: set[str] = set()
    for entry in text.split(","):
        name, equals, value = (part.strip() for part in entry.partition("="))
        if not equals or not name or not value:
            raise InputError(
                f"max grade '{entry.strip()}' is not class=limit; write e.g. motorway=0.05,residential=12%"
            )
        if name not in known:
            raise InputError(
                f"max grade for '{name}': no such class of roads; choose from {', '.join(sorted(known))}"
            )
        if name in seen:
            raise InputError(f"max grade for '{name}' is given twice; give it once")
        seen.add(name)
        table[name] = _limit(name, value)
    return MappingProxyType(table)


def _limit(name: str, value: str) -> float:
    """Return a limit in rise per metre."""
    number, percent = (value[:-1], True) if value.endswith("%") else (value, False)
    try:
        limit = float(number) * (0.01 if percent else 1.0)
    except ValueError:
        raise InputError(f"max grade for '{name}': '{value}' is no number; write e.g. 0.08 or 8%") from None
    if not defaults.GRADE_LIMIT_LEAST <= limit <= GRADE_MAX:
        raise InputError(
            f"max grade for '{name}': {value} is not between {defaults.GRADE_LIMIT_LEAST:g} and "
            f"{GRADE_MAX:g}; write rise per metre, e.g. 0.08, or 8%"
        )
    return limit
