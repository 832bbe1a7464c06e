"""What tags say about crossings. Pure functions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import length_of

_YES: Final = frozenset({"yes", "traffic_signals"})
# British names of crossings with lights (OSM wiki, Key:crossing_ref).
_WITH_LIGHTS: Final = frozenset({"pelican", "puffin", "toucan", "pegasus"})
# Values of ``crossing`` for what is painted in some way that is not said.
_PAINTED: Final = frozenset({"marked", "uncontrolled", "traffic_signals"})
_RAILWAY: Final = frozenset({"level_crossing", "crossing", "tram_level_crossing", "tram_crossing"})


def is_crossing(tags: Mapping[str, str]) -> bool:
    """Say whether a node on a street is a crossing for people, marked or not."""
    value = tags.get("crossing", "")
    if value == "no":
        return False
    if tags.get("highway") == "crossing":
        return True
    return bool(value) and tags.get("railway") not in _RAILWAY


def has_lights(tags: Mapping[str, str]) -> bool:
    """Say whether a crossing has traffic lights; ``crossing:signals`` decides where it is there."""
    if "crossing:signals" in tags:
        return tags["crossing:signals"] != "no"
    return (
        tags.get("crossing") == "traffic_signals"
        or tags.get("crossing_ref") in _WITH_LIGHTS
        or (tags.get("highway") == "traffic_signals" and "crossing" in tags)
    )


def has_island(tags: Mapping[str, str]) -> bool:
    """Say whether people can wait in the middle of a crossing."""
    value = tags.get("crossing:island", "")
    return (
        (value not in ("", "no")) or tags.get("crossing") == "island" or (tags.get("traffic_calming") == "island")
    ) and value != "no"


def marking_of(tags: Mapping[str, str]) -> str:
    """Return what is painted, in the words of ``crossing:markings``: ``zebra``, ``lines`` …, ``unmarked``.

    ``yes`` stands for marks of a kind that OSM does not tell.
    """
    value = tags.get("crossing:markings", "")
    if value == "no":
        return "unmarked"
    zebra = "zebra" in (tags.get("crossing"), tags.get("crossing_ref"))
    if value and not (value == "yes" and zebra):
        return value
    if zebra:
        return "zebra"
    return "yes" if tags.get("crossing") in _PAINTED or has_lights(tags) else "unmarked"


def width_of(tags: Mapping[str, str], lights: bool) -> float:
    """Return the extent of a crossing along the road, m: as tagged, else usual."""
    for key in ("crossing:width", "width"):
        width = length_of(tags, key, defaults.CROSSING_WIDTH_MAX)
        if width is not None:
            return max(width, defaults.CROSSING_WIDTH_MIN)
    return defaults.CROSSING_WIDTH_SIGNALS if lights else defaults.CROSSING_WIDTH
