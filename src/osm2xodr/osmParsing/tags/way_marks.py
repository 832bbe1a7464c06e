"""What tags of a way say about overtaking, marks and rails on it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction
from osm2xodr.osmParsing.tags.lane_lists import Findings
from osm2xodr.osmParsing.tags.values import parse_speed

_OVERTAKING: Final = {
    "": (Direction.FORWARD, Direction.BACKWARD),
    ":forward": (Direction.FORWARD,),
    ":backward": (Direction.BACKWARD,),
}
_OVERTAKING_TAGS: Final = tuple(f"overtaking{way}" for way in _OVERTAKING)
# Tags that say where ``maxspeed`` comes from (OSM wiki, Key:source:maxspeed).
_SPEED_SOURCES: Final = ("maxspeed:type", "source:maxspeed")
_SPEEDS: Final = ("maxspeed", "maxspeed:forward", "maxspeed:backward")
MARK_TAGS: Final = (
    *("lane_markings", "divider", "surface", "traffic_sign", "embedded_rails", "railway"),
    *(*_OVERTAKING_TAGS, *_SPEED_SOURCES, *_SPEEDS),
)

# OSM wiki, Key:overtaking: in which directions it is allowed.
_ALLOWED: Final = {
    "yes": frozenset({Direction.FORWARD, Direction.BACKWARD}),
    "both": frozenset({Direction.FORWARD, Direction.BACKWARD}),
    "caution": frozenset({Direction.FORWARD, Direction.BACKWARD}),
    "forward": frozenset({Direction.FORWARD}),
    "backward": frozenset({Direction.BACKWARD}),
    "no": frozenset[Direction](),
}
# Few sets are shared by all ways.
_SETS: Final = {
    bits: frozenset(way for way, bit in ((Direction.FORWARD, 1), (Direction.BACKWARD, 2)) if bits & bit)
    for bits in range(4)
}
_RAILS: Final = frozenset({"tram", "light_rail", "yes"})
_TRAMS: Final = frozenset({"tram", "light_rail"})
_OTHER_SIDE: Final = {"left": "right", "right": "left", "forward": "backward", "backward": "forward"}
_SIDE_WORD: Final = re.compile("|".join(_OTHER_SIDE))


def no_overtaking(tags: Mapping[str, str], direction: int, findings: Findings) -> frozenset[Direction]:
    """Return the directions along the way in which overtaking is forbidden.

    Parameters
    ----------
    tags
        Of the way.
    direction
        1 or -1 if it is one-way along or against its order of nodes, else 0.
    findings
        What is not known is added.
    """
    if "overtaking" not in tags and "overtaking:forward" not in tags and "overtaking:backward" not in tags:
        return _SETS[0]
    forbidden = {Direction.FORWARD: False, Direction.BACKWARD: False}
    # Tags for one direction come last: they go before the one for both.
    for ending, about in _OVERTAKING.items():
        value = tags.get(f"overtaking{ending}")
        if value is None:
            continue
        allowed = _ALLOWED.get(value.strip().lower())
        if allowed is None or (ending and value in ("forward", "backward")):
            findings.append((Kind.DROPPED, "overtaking", f"overtaking{ending}={value} is not known and is ignored"))
            continue
        for way in about:
            forbidden[way] = way not in allowed
    bits = forbidden[Direction.FORWARD] * (direction >= 0) + 2 * forbidden[Direction.BACKWARD] * (direction <= 0)
    return _SETS[bits]


def other_way(directions: frozenset[Direction]) -> frozenset[Direction]:
    """Return directions as they are seen against the way."""
    if len(directions) != 1:
        return directions
    return _SETS[1] if Direction.BACKWARD in directions else _SETS[2]


def lanes_marked(tags: Mapping[str, str], findings: Findings) -> bool | None:
    """Return whether lanes are marked; None where OSM does not say."""
    value = tags.get("lane_markings")
    if value is None:
        return None
    if value in ("yes", "no"):
        return value == "yes"
    findings.append((Kind.DROPPED, "lane-markings", f"lane_markings={value} is not known and is ignored"))
    return None


@lru_cache(maxsize=256)
def divider_seen_backwards(value: str) -> str:
    """Return a value of ``divider`` as it is seen against the way: lists and sides are turned round."""
    parts = reversed(value.split(";"))
    return ";".join(_SIDE_WORD.sub(lambda word: _OTHER_SIDE[word[0]], part) for part in parts)


def has_tram(tags: Mapping[str, str]) -> bool:
    """Whether tram tracks lie in the carriageway."""
    if "embedded_rails" not in tags and "railway" not in tags:
        return False
    embedded = {part.strip() for part in tags.get("embedded_rails", "").split(";")}
    return not _RAILS.isdisjoint(embedded) or tags.get("railway") in _TRAMS


def speed_is_signed(tags: Mapping[str, str]) -> bool:
    """Whether limits stand in ``maxspeed`` itself and no tag says that they follow from the law for a kind of road.

    The limit of a zone such as ``DE:zone30`` is signed.
    """
    if "maxspeed" not in tags and "maxspeed:forward" not in tags and "maxspeed:backward" not in tags:
        return False
    if not any(key in tags and _is_number(tags[key]) for key in _SPEEDS):
        return False
    return not any(_is_law(tags[key]) for key in _SPEED_SOURCES if key in tags)


@lru_cache(maxsize=1024)
def _is_number(text: str) -> bool:
    return text != "walk" and ":" not in text and parse_speed(text) is not None


@lru_cache(maxsize=1024)
def _is_law(text: str) -> bool:
    return ":" in text and "zone" not in text.lower() and parse_speed(text) is not None
