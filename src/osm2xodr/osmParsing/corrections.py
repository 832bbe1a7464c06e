"""Corrections of ways, nodes and relations as they are read: what users may say of them, and what comes of it.

They are left out, kept, or get other tags. Each correction of tags does what the same change in OSM would do.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Any, Final, TypeVar

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import EVERY_LANE, Corrections, NodeCorrection, WayCorrection, applied, unused
from osm2xodr.osmParsing.defaults import (
    CARRIAGEWAY_WIDTHS,
    LANES_PLAUSIBLE_MAX,
    TAGGED_LANE_WIDTH_MAX,
    TAGGED_LANE_WIDTH_MIN,
)
from osm2xodr.osmParsing.file import RawNodes, RawRelation, RawWay
from osm2xodr.osmParsing.options import HIGHWAYS, WaySelection
from osm2xodr.osmParsing.tags import (
    COUNT_TAGS,
    LIST_TAGS,
    WIDTH_TAGS,
    Tags,
    oneway,
    parse_ele,
    parse_layer,
    parse_speed,
    reason_left_out,
)
from osm2xodr.system import record

# Heights between two roads that are plausible, m: from a passage for cars to the highest viaducts.
_CLEARANCES: Final = (1.5, 350.0)
_LANE_WIDTHS: Final = (TAGGED_LANE_WIDTH_MIN, TAGGED_LANE_WIDTH_MAX)
_DIRECTIONS: Final = ("forward", "backward")

_Correction = TypeVar("_Correction", WayCorrection, NodeCorrection)
# Takes a value as it is written, and returns fields of a correction; ValueError says what to write.
_Reader = Callable[[Any], dict[str, Any]]

_MENDED: Final = "OSM says so itself"
_NO_WAY: Final = "no such way is read of the map"
_SPEED_TAGS: Final = ("maxspeed", "maxspeed:forward", "maxspeed:backward")
_COUNTED: Final = frozenset(COUNT_TAGS)
_LISTS: Final = frozenset(LIST_TAGS)
_WIDTHS: Final = frozenset((*WIDTH_TAGS, *(key for key in LIST_TAGS if key.startswith("width:"))))


def way_correction(keys: Mapping[str, Any]) -> WayCorrection:
    """Return what `CORRECTION_KEYS` say about a way; ValueError says in one sentence what is wrong."""
    return _filled(WayCorrection(), keys, _WAY_KEYS)


def node_correction(number: int, keys: Mapping[str, Any]) -> NodeCorrection:
    """Return what `CORRECTION_KEYS` say about a node, by its OSM id; ValueError says what is wrong."""
    item = _filled(NodeCorrection(), keys, _NODE_KEYS)
    if number in (*item.join, *item.split):
        raise ValueError("join and split name other nodes, not the node itself")
    both = sorted(set(item.join) & set(item.split)) or (item.join if item.split_all else ())
    if both:
        raise ValueError(f"join and split both name node/{both[0]}; give one of them")
    return item


def drops_relation(keys: Mapping[str, Any]) -> bool:
    """Return whether `CORRECTION_KEYS` leave out a relation; ValueError says what is wrong."""
    return _filled(NodeCorrection(), keys, _RELATION_KEYS).drop


def _filled(item: _Correction, keys: Mapping[str, Any], known: Mapping[str, _Reader]) -> _Correction:
    """Return a correction with what keys say."""
    values: dict[str, Any] = {}
    for key, value in keys.items():
        try:
            values |= known[key](value)
        except ValueError as error:
            raise ValueError(f"{key} is {value!r}; write {error}") from error
    item = replace(item, **values)
    if item.drop and any(values.get(field.name) for field in fields(item) if field.name != "drop"):
        other = next(key for key in keys if key not in ("drop", "note"))
        raise ValueError(f"drop and {other} exclude each other; give one of them")
    return item


def _flag(name: str) -> _Reader:
    def read(value: Any) -> dict[str, Any]:
        if not isinstance(value, bool):
            raise ValueError("true or false")
        return {name: value}

    return read


def _number(name: str, low: float, high: float) -> _Reader:
    def read(value: Any) -> dict[str, Any]:
        return {name: _measure(value, low, high)}

    return read


def _measure(value: Any, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError("a number of metres")
    if not low <= value <= high:
        raise ValueError(f"metres, from {low:g} to {high:g}")
    return float(value)


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= LANES_PLAUSIBLE_MAX:
        raise ValueError(
            f"a whole number from 1 to {LANES_PLAUSIBLE_MAX}, or such as {{ forward = 2, backward = 1 }}"
        )
    return value


def _lanes(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {"lanes": {"": _count(value)}}
    if not value or not value.keys() <= {*_DIRECTIONS, "both_ways"}:
        raise ValueError("numbers of lanes by direction: forward, backward, both_ways")
    return {"lanes": {way: _count(count) for way, count in value.items()}}


def _lane_width(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {"lane_width": {EVERY_LANE: _measure(value, *_LANE_WIDTHS)}}
    if not value or not all(re.fullmatch(r"[1-9]\d?", number, re.ASCII) for number in value):
        raise ValueError("metres, or such as { 1 = 3.0 }: lanes count from 1 on from the left")
    return {"lane_width": {int(number): _measure(width, *_LANE_WIDTHS) for number, width in value.items()}}


def _limit(value: Any) -> str:
    text = f"{value:g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else value
    if not isinstance(text, str) or parse_speed(text) is None:
        raise ValueError('km/h, or as in OSM: "30 mph", "none", "walk"')
    return text


def _speed(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {"speed": {"": _limit(value)}}
    if not value or not value.keys() <= set(_DIRECTIONS):
        raise ValueError("limits by direction: forward, backward")
    return {"speed": {way: _limit(limit) for way, limit in value.items()}}


def _layer(value: Any) -> dict[str, Any]:
    if isinstance(value, bool) or not isinstance(value, int) or parse_layer(str(value)) is None:
        raise ValueError("a layer, such as 1")
    return {"layer": value}


def _z(value: Any) -> dict[str, Any]:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or parse_ele(f"{value:f}") is None:
        raise ValueError("the height of the road there, m")
    return {"z": float(value)}


def _keep(value: Any) -> dict[str, Any]:
    if isinstance(value, bool):
        return {"keep": value}
    if value not in HIGHWAYS:
        raise ValueError('true, or the class to carry it as, such as "service"')
    return {"keep": True, "highway": value}


def _ids(value: Any) -> tuple[int, ...]:
    listed = value if isinstance(value, list) else [value]
    if not listed or not all(isinstance(item, int) and not isinstance(item, bool) for item in listed):
        raise ValueError("ids of nodes, such as [123, 456]")
    return tuple(dict.fromkeys(listed))


def _join(value: Any) -> dict[str, Any]:
    return {"join": _ids(value)}


def _split(value: Any) -> dict[str, Any]:
    return {"split_all": value} if isinstance(value, bool) else {"split": _ids(value)}


def _note(value: Any) -> dict[str, Any]:
    if not isinstance(value, str):
        raise ValueError("text")
    return {}


_WAY_KEYS: Final[Mapping[str, _Reader]] = MappingProxyType(
    {
        "drop": _flag("drop"),
        "keep": _keep,
        "lanes": _lanes,
        "width": _number("width", *CARRIAGEWAY_WIDTHS),
        "lane-width": _lane_width,
        "speed": _speed,
        "layer": _layer,
        "clearance": _number("clearance", *_CLEARANCES),
        "no-u-turn": _flag("no_u_turn"),
        "note": _note,
    }
)
_NODE_KEYS: Final[Mapping[str, _Reader]] = MappingProxyType(
    {
        "drop": _flag("drop"),
        "z": _z,
        "no-u-turn": _flag("no_u_turn"),
        "join": _join,
        "split": _split,
        "note": _note,
    }
)
_RELATION_KEYS: Final[Mapping[str, _Reader]] = MappingProxyType({"drop": _flag("drop"), "note": _note})
# The keys of each kind of element.
CORRECTION_KEYS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {"way": tuple(_WAY_KEYS), "node": tuple(_NODE_KEYS), "relation": tuple(_RELATION_KEYS)}
)


@record
class CorrectedWays:
    """Ways as corrected, and what is to be said about that when it is known which of them become streets."""

    ways: list[RawWay]
    changes: Mapping[int, Mapping[str, str]]  # By way and key: in which tags it differs; empty where in none

    def report(self, corrections: Corrections, streets: Sequence[RawWay], diagnostics: Diagnostics) -> None:
        """Report the corrections of tags and widths; `streets` are the ways that become streets."""
        if not corrections.ways:
            return
        read, carried = {way.id for way in self.ways}, {way.id for way in streets}
        for number, known in sorted(corrections.ways.items()):
            changes, osm_id = self.changes.get(number, {}), f"way/{number}"
            for key in _early_keys(known):
                if number not in carried:
                    # What was dropped has been reported.
                    why = "it is no street, and left out" if number in read else _NO_WAY
                    unused(diagnostics, osm_id, key, why)
                elif changes.get(key):
                    applied(diagnostics, osm_id, key, changes[key])
                elif key in changes:
                    unused(diagnostics, osm_id, key, _MENDED)


def _early_keys(known: WayCorrection) -> Iterator[str]:
    """Yield the keys of the corrections of tags and widths of lanes, which are of use to streets alone."""
    yield from (key for key, _ in corrected_tags({}, known))
    if known.lane_width:
        yield "lane-width"


def correct_ways(ways: Sequence[RawWay], corrections: Corrections, diagnostics: Diagnostics) -> CorrectedWays:
    """Return ways without those that are dropped, and with corrected tags."""
    if not corrections.ways:
        return CorrectedWays(list(ways), {})
    out: list[RawWay] = []
    changes: dict[int, dict[str, str]] = {}
    dropped: set[int] = set()
    for way in ways:
        known = corrections.ways.get(way.id)
        if known is None:
            out.append(way)
        elif known.drop:
            dropped.add(way.id)
            applied(diagnostics, f"way/{way.id}", "drop", "it is left out")
        else:
            tags, stated = dict(way.tags), changes.setdefault(way.id, {})
            for key, after in corrected_tags(tags, known):
                stated[key], tags = difference(tags, after), after
            out.append(replace(way, tags=tags))
    for number, known in sorted(corrections.ways.items()):
        if known.drop and number not in dropped:
            unused(diagnostics, f"way/{number}", "drop", _NO_WAY)
    return CorrectedWays(out, changes)


def kept_ways(ways: Sequence[RawWay], corrections: Corrections, diagnostics: Diagnostics) -> set[int]:
    """Return the ways that become streets in any case, and report those that cannot."""
    found: set[int] = set()
    by_id = {way.id: way for way in ways} if corrections.kept_ways() else {}
    for number in sorted(corrections.kept_ways()):
        way, known = by_id.get(number), corrections.ways[number]
        if way is None:
            unused(diagnostics, f"way/{number}", "keep", _NO_WAY)
        elif _class(way, known) not in HIGHWAYS:
            why = f'{_named(way)} is no class that can be carried; name one, such as keep = "service"'
            unused(diagnostics, f"way/{number}", "keep", why)
        else:
            found.add(number)
    return found


def keep_way(
    way: RawWay, known: WayCorrection, ways: WaySelection, include_private: bool, diagnostics: Diagnostics
) -> RawWay:
    """Return a way that becomes a street in any case, with its class, and report what would have kept it out."""
    asked = way.tags.get("highway", "") in ways.highways
    reason = reason_left_out(way.tags, ways, include_private) if asked else None
    highway = _class(way, known)
    why = reason[1] if reason else "" if asked else f"{_named(way)} is not among the ways asked for"
    if why or highway != way.tags.get("highway", ""):
        stated = f"it becomes a street of class {highway}" + (f"; without this: {why}" if why else "")
        applied(diagnostics, f"way/{way.id}", "keep", stated)
    else:
        unused(diagnostics, f"way/{way.id}", "keep", "it is a street without it")
    return replace(way, tags=dict(sorted({**way.tags, "highway": highway}.items())))


def _class(way: RawWay, known: WayCorrection) -> str:
    return known.highway or way.tags.get("highway", "")


def _named(way: RawWay) -> str:
    return f"highway={way.tags['highway']}" if "highway" in way.tags else "a way without highway=*"


def correct_relations(
    relations: Sequence[RawRelation], corrections: Corrections, diagnostics: Diagnostics
) -> list[RawRelation]:
    """Return relations without those that are dropped."""
    there = {relation.id for relation in relations}
    for number in sorted(corrections.relations):
        if number in there:
            applied(diagnostics, f"relation/{number}", "drop", "it is left out")
        else:
            unused(diagnostics, f"relation/{number}", "drop", "no such relation is read of the map")
    return [relation for relation in relations if relation.id not in corrections.relations]


def correct_nodes(nodes: RawNodes, corrections: Corrections, diagnostics: Diagnostics) -> RawNodes:
    """Return nodes, those that are dropped without their tags."""
    dropped = {number for number, known in corrections.nodes.items() if known.drop}
    for number in sorted(dropped):
        if number in nodes.tags:
            tags = ", ".join(f"{key}={value}" for key, value in sorted(nodes.tags[number].items()))
            applied(diagnostics, f"node/{number}", "drop", f"without {tags}")
        else:
            unused(diagnostics, f"node/{number}", "drop", "no such node with tags is read of the map")
    if dropped.isdisjoint(nodes.tags):
        return nodes
    return replace(nodes, tags={number: tags for number, tags in nodes.tags.items() if number not in dropped})


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
