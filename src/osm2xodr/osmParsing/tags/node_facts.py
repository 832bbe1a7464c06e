"""What tags of nodes on streets and of things beside them say. Pure functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.defaults import KERB_HEIGHT
from osm2xodr.model import (
    BusStop,
    Footway,
    Light,
    NodeControl,
    NodeFacts,
    RoadsideKind,
    Sign,
    ThingFacts,
)
from osm2xodr.osmParsing.tags.crossings import TRACK_CROSSINGS, is_crossing, read_crossings
from osm2xodr.osmParsing.tags.traffic_signs import SIGN_KEYS, read_facing, read_sign_post
from osm2xodr.osmParsing.tags.values import plausible_length

# Signals that are not those of a junction (OSM wiki, Key:traffic_signals).
_SPECIAL_LIGHTS: Final = {
    "pedestrian_crossing": Light.CROSSING,
    "crossing": Light.CROSSING,
    "tunnel": Light.ROAD,
    "ramp_meter": Light.ROAD,
    "emergency": Light.ROAD,
    "bottleneck": Light.ROAD,
    "bridge": Light.ROAD,
    "level_crossing": Light.OTHER,
    "blinker": Light.OTHER,
    "blink_mode": Light.OTHER,
    "no": Light.OTHER,
}
_TAGGED: Final = {sign.value: sign for sign in Sign}
# Values of ``stop`` for signs before all arms.
_ALL_WAY: Final = frozenset({"all", "4-way", "4way"})
# Other words for kinds of ``traffic_calming``, and values that name none.
_CALMING: Final = {
    "humps": "hump",
    "bumps": "bump",
    "cushions": "cushion",
    "raised_crossing": "table",
    "rumble_strips": "rumble_strip",
    "no": "",
    "yes": "",
    "none": "",
}
# Values of ``bus_bay`` and ``bay`` where there is a bay.
_BAY: Final = frozenset({"yes", "left", "right", "both"})
# Higher and wider things beside the road are mistakes, m; choices.
_HEIGHT_MAX: Final = 60.0
_WIDTH_MAX: Final = 5.0
# Gauges of tracks, mm; others are mistakes.
_GAUGES: Final = range(500, 2001)


def read_node_facts(
    node_tags: Mapping[int, Mapping[str, str]], footways: Sequence[Footway], country: str
) -> NodeFacts:
    """Read the tags of the nodes on streets, in ascending id, in a country (ISO 3166-1 alpha-2)."""
    controls = {node: read_control(tags) for node, tags in node_tags.items()}
    calming = {node: _calming(tags) for node, tags in node_tags.items()}
    return NodeFacts(
        controls={node: control for node, control in controls.items() if control is not None},
        sign_posts={
            node: read_sign_post(tags, country)
            for node, tags in node_tags.items()
            if any(key in tags for key in SIGN_KEYS)
        },
        crossings=read_crossings(node_tags, footways),
        calming={node: kind for node, kind in calming.items() if kind},
        bus_stops={node: _bus_stop(tags) for node, tags in node_tags.items() if tags.get("highway") == "bus_stop"},
        track_crossings=frozenset(node for node, tags in node_tags.items() if tags.get("railway") in TRACK_CROSSINGS),
    )


def read_thing_facts(kind: RoadsideKind, tags: Mapping[str, str], country: str) -> ThingFacts:
    """Read the tags of a thing beside the road."""
    if kind is RoadsideKind.BUS_STOP:
        return ThingFacts(bus_stop=_bus_stop(tags))
    if kind is RoadsideKind.TRAM_TRACK:
        text = tags.get("gauge", "")
        return ThingFacts(gauge=int(text) / 1000.0 if text.isdecimal() and int(text) in _GAUGES else None)
    if kind is RoadsideKind.TRAFFIC_SIGN:
        return ThingFacts(sign_post=read_sign_post(tags, country))
    if kind is RoadsideKind.TRAFFIC_SIGNALS:
        return ThingFacts(at_crossing="crossing" in tags)
    height = plausible_length(tags.get("height", ""), _HEIGHT_MAX)
    if kind is RoadsideKind.KERB:
        height = KERB_HEIGHT.get(tags.get("kerb", ""), height)
    return ThingFacts(plausible_length(tags.get("width", ""), _WIDTH_MAX), height)


def read_control(tags: Mapping[str, str]) -> NodeControl | None:
    """Read the stop or give-way sign or traffic lights of a node; None where it has none."""
    tagged = _TAGGED.get(tags.get("highway", ""))
    light = _light(tags)
    if tagged is None and light is None:
        return None
    return NodeControl(
        tagged,
        light,
        read_facing(tags.get("traffic_signals:direction") or tags.get("direction", "")),
        tags.get("stop") in _ALL_WAY,
        tags.get("crossing") == "traffic_signals",
        tags.get("traffic_signals", ""),
    )


def _light(tags: Mapping[str, str]) -> Light | None:
    if tags.get("highway") == "traffic_signals":
        return _SPECIAL_LIGHTS.get(tags.get("traffic_signals", ""), Light.JUNCTION)
    crossing = tags.get("crossing") == "traffic_signals" or tags.get("crossing:signals") == "yes"
    return Light.CROSSING if crossing else None


def _calming(tags: Mapping[str, str]) -> str:
    """Return what calms traffic, empty for nothing; islands of crossings belong to these."""
    value = tags.get("traffic_calming", "")
    kind = _CALMING.get(value, value)
    return "" if kind == "island" and is_crossing(tags) else kind


def _bus_stop(tags: Mapping[str, str]) -> BusStop:
    bay = not _BAY.isdisjoint((tags.get("bus_bay", ""), tags.get("bay", "")))
    return BusStop(tags.get("name", ""), bay, read_facing(tags.get("direction", "")).along)
