"""What users may correct of ways, nodes and relations: keys and their values."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Any, Final, TypeVar

from osm2xodr.model import EVERY_LANE, NodeCorrection, WayCorrection
from osm2xodr.osmParsing.defaults import (
    CARRIAGEWAY_WIDTHS,
    LANES_PLAUSIBLE_MAX,
    TAGGED_LANE_WIDTH_MAX,
    TAGGED_LANE_WIDTH_MIN,
)
from osm2xodr.osmParsing.options import HIGHWAYS
from osm2xodr.osmParsing.tags import parse_ele, parse_layer, parse_speed

# Heights between two roads that are plausible, m: from a passage for cars to the highest viaducts.
_CLEARANCES: Final = (1.5, 350.0)
_LANE_WIDTHS: Final = (TAGGED_LANE_WIDTH_MIN, TAGGED_LANE_WIDTH_MAX)
_DIRECTIONS: Final = ("forward", "backward")

_Correction = TypeVar("_Correction", WayCorrection, NodeCorrection)
# Takes a value as it is written, and returns fields of a correction; ValueError says what to write.
_Reader = Callable[[Any], dict[str, Any]]


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
