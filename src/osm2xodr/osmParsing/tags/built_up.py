"""Whether a way lies in a built-up area, and is built as streets there are."""

from __future__ import annotations

import re
from typing import Final

from osm2xodr.osmParsing.defaults import TOWN_SPEED_MAX_KMH
from osm2xodr.osmParsing.tags.legal_speeds import EVIDENCE_TAGS, is_built_up
from osm2xodr.osmParsing.tags.values import Tags, parse_speed

# Tags whose values, such as ``DE:urban``, say where a way is, the surest first (OSM wiki, Key:source:maxspeed).
_PLACE_TAGS: Final = ("zone:traffic", "maxspeed:type", "source:maxspeed", "zone:maxspeed", "maxspeed")
_URBAN: Final = re.compile(r"[A-Z-]+:\s*(urban|nsl_restricted|(zone:?)?\d+$|living_street)|zone", re.IGNORECASE)
_RURAL: Final = re.compile(r"[A-Z-]+:\s*(rural|trunk|motorway|motorroad|nsl_single|nsl_dual)", re.IGNORECASE)
BUILT_UP_TAGS: Final = (*_PLACE_TAGS, *EVIDENCE_TAGS, "motorroad")


def in_town(tags: Tags, dense: bool) -> bool:
    """Whether a way lies in a built-up area: as tagged, else where there are lamps, sidewalks or dwellings.

    `dense` says whether residential streets lie densely around it.
    """
    for key in _PLACE_TAGS:
        if key in tags and (_URBAN.match(tags[key]) or _RURAL.match(tags[key])):
            return bool(_URBAN.match(tags[key]))
    if tags.get("motorroad") == "yes":
        return False
    return is_built_up(tags) or dense


def is_town_street(tags: Tags, dense: bool) -> bool:
    """Whether a way has the lanes of a street in town: by its limit, else by where it lies."""
    if tags["highway"].startswith("motorway") or tags.get("motorroad") == "yes":
        return False
    speed = parse_speed(tags.get("maxspeed", ""))
    return in_town(tags, dense) if speed is None else speed <= TOWN_SPEED_MAX_KMH / 3.6
