"""Which ways are open to cars, and in which direction: pure functions of a way's tags."""

from __future__ import annotations

from typing import Final

from osm2xodr.osmParsing.options import WaySelection
from osm2xodr.osmParsing.tags.values import Tags

# OSM wiki, Key:access: the most specific key present decides.
CAR_KEYS: Final = ("motorcar", "motor_vehicle", "vehicle", "access")
# Values that close a way to the public's cars.
CLOSED_VALUES: Final = frozenset({"no", "private", "agricultural", "forestry", "delivery", "permit"})

_FORWARD: Final = frozenset({"yes", "true", "1"})
_BACKWARD: Final = frozenset({"-1", "reverse"})
NO_VALUES: Final = frozenset({"no", "false", "0"})
# OSM wiki, Key:oneway: the direction changes with time.
_CHANGING: Final = frozenset({"reversible", "alternating"})
_ROUNDABOUTS: Final = frozenset({"roundabout", "circular"})
_ONEWAY_HIGHWAYS: Final = frozenset({"motorway", "motorway_link"})

# Tags that close one direction of a road to cars only.
_ONEWAY_FOR_CARS: Final = ("oneway:motorcar", "oneway:motor_vehicle", "oneway:vehicle")
_DIRECTIONS: Final = tuple(f"{key}:{way}" for key in CAR_KEYS for way in ("forward", "backward"))

# OSM wiki, Key:hov: values that keep a way or lane for cars with several people in them.
KEPT_FOR_HOV: Final = frozenset({"designated", "only", "official"})

ACCESS_TAGS: Final[tuple[str, ...]] = (
    "area",
    "service",
    "oneway",
    "junction",
    "hov",
    *CAR_KEYS,
    *_ONEWAY_FOR_CARS,
    *_DIRECTIONS,
)


def closing_tag(tags: Tags) -> str | None:
    """Return the tag that closes a way to cars, as ``key=value``; None if it is open."""
    if tags.get("hov") in KEPT_FOR_HOV:
        return None
    for key in CAR_KEYS:
        value = tags.get(key)
        if value is not None:
            # Of several values each one must close it.
            parts = value.split(";") if ";" in value else (value,)
            return f"{key}={value}" if all(part.strip() in CLOSED_VALUES for part in parts) else None
    return None


def is_roundabout(tags: Tags) -> bool:
    """Whether a way is part of a roundabout."""
    return tags.get("junction") in _ROUNDABOUTS


def oneway(tags: Tags) -> tuple[int, bool]:
    """Return the direction of traffic relative to the order of nodes: 1 along it, -1 against it, 0 both.

    The second value is False where the tag says something else (such as ``reversible``), so that this is a guess.
    """
    value = tags.get("oneway")
    for values, direction in ((_FORWARD, 1), (_BACKWARD, -1), (NO_VALUES, 0)):
        if value in values:
            return direction, True
    implied = int(is_roundabout(tags) or tags.get("highway") in _ONEWAY_HIGHWAYS)
    if value in _CHANGING and "lanes:forward" in tags and "lanes:backward" in tags:
        implied = 0
    return implied, value is None


def closed_direction(tags: Tags) -> tuple[int, str] | None:
    """Return the direction (1 or -1, as of `oneway`) of a two-way road that is closed to cars, and the closing tag.

    None where neither is closed, or both. `oneway` does not include this: the road stays two-way for others, and
    ``lanes`` counts the lanes of both directions.
    """
    for key in _ONEWAY_FOR_CARS:
        value = tags.get(key)
        if value in _FORWARD or value in _BACKWARD:
            return (-1 if value in _FORWARD else 1), f"{key}={value}"
    # The most specific key decides for each direction.
    found: list[tuple[int, str]] = []
    for way, direction in (("forward", 1), ("backward", -1)):
        name = next((name for key in CAR_KEYS if (name := f"{key}:{way}") in tags), "")
        if name and tags[name] in CLOSED_VALUES:
            found.append((direction, f"{name}={tags[name]}"))
    return found[0] if len(found) == 1 else None


def changes_direction(tags: Tags) -> bool:
    """Whether the direction of traffic changes with time."""
    return tags.get("oneway") in _CHANGING


def reason_left_out(tags: Tags, selection: WaySelection, include_private: bool) -> tuple[str, str] | None:
    """Return why a way of a selected ``highway`` value does not become a street: code and words; None if it does."""
    if tags.get("area") == "yes":
        return "area", "is an area, not a road, and is left out"
    service = tags.get("service")
    if service in selection.services_out and tags.get("highway") == "service":
        return "way-selection", f"service={service} is not among the ways asked for"
    if not include_private:
        closed = closing_tag(tags)
        if closed is not None:
            return "closed", f"{closed} closes it to cars, it is left out"
    return None
