"""Corrections of a way's tags: each does what the same change in OSM would do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from osm2xodr.model import WayCorrection
from osm2xodr.osmParsing.tags import COUNT_TAGS, LIST_TAGS, WIDTH_TAGS, Tags, oneway

_SPEED_TAGS: Final = ("maxspeed", "maxspeed:forward", "maxspeed:backward")
_COUNTED: Final = frozenset(COUNT_TAGS)
_LISTS: Final = frozenset(LIST_TAGS)
_WIDTHS: Final = frozenset((*WIDTH_TAGS, *(key for key in LIST_TAGS if key.startswith("width:"))))


def corrected_tags(tags: Tags, known: WayCorrection) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the key of each correction of tags, and the tags with this one and those before it."""
    found = dict(tags)
    if known.lanes:
        found = _with_lanes(found, known.lanes)
        yield "lanes", found
    if known.width is not None:
        found = _changed(found, _WIDTHS, {"width": f"{known.width:g}"})
        yield "width", found
    if known.speed:
        replaced = _SPEED_TAGS if "" in known.speed else ()
        found = _changed(found, replaced, {_key("maxspeed", way): text for way, text in known.speed.items()})
        yield "speed", found
    if known.layer is not None:
        found = _changed(found, (), {"layer": str(known.layer)})
        yield "layer", found


def difference(before: Tags, after: Tags) -> str:
    """Return in which tags two ways differ, in words; empty if in none."""
    keys = [key for key in sorted({*before, *after}) if before.get(key) != after.get(key)]
    old, new = (", ".join(f"{key}={tags[key]}" for key in keys if key in tags) for tags in (before, after))
    if not keys:
        return ""
    return f"{new or 'nothing'} in place of {old}" if old else f"{new}, which OSM lacks"


def _key(name: str, way: str) -> str:
    return f"{name}:{way}" if way else name


def _changed(tags: Tags, without: Iterable[str], new: Tags) -> dict[str, str]:
    """Return tags without some, and with others; in the order of their keys, as they are read."""
    gone = frozenset(without)
    return dict(sorted({**{key: value for key, value in tags.items() if key not in gone}, **new}.items()))


def _with_lanes(tags: Tags, lanes: Mapping[str, int]) -> dict[str, str]:
    """Return tags with other numbers of lanes, by direction, and without the lists that have another length."""
    new = {_key("lanes", way): str(count) for way, count in lanes.items()}
    if "" not in lanes and {"forward", "backward"} <= lanes.keys():
        new["lanes"] = str(sum(lanes.values()))
    counts = dict(lanes)
    direction = oneway(tags)[0]
    if direction:
        side = "forward" if direction > 0 else "backward"
        total = lanes.get("", lanes.get(side, 0))
        counts.update({"": total, side: total})
    misfits = frozenset(
        key for key in _LISTS & tags.keys() if tags[key].count("|") + 1 != counts.get(_direction(key), 0)
    )
    return _changed(tags, _COUNTED | misfits, new)


def _direction(key: str) -> str:
    """Return the direction that a list of lanes is about; empty where it names none."""
    return key.partition(":lanes")[2].removeprefix(":")
