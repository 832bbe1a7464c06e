"""What tags of nodes on streets, of ways that cross there, and of things beside streets say. Pure functions."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from osm2xodr.curves import arctan2
from osm2xodr.defaults import KERB_HEIGHT
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import (
    BusStop,
    Footway,
    Light,
    MappedCrossing,
    NodeControl,
    NodeFacts,
    RailCrossing,
    RoadsideKind,
    Sign,
    ThingFacts,
)
from osm2xodr.osmParsing.tags.traffic_signs import SIGN_KEYS, read_facing, read_sign_post
from osm2xodr.osmParsing.tags.values import FOOT, Tags, plausible_length

# Signals that are not those of a junction (OSM wiki, Key:traffic_signals).
_SPECIAL_LIGHTS: Final = {
    **dict.fromkeys(("pedestrian_crossing", "crossing"), Light.CROSSING),
    **dict.fromkeys(("tunnel", "ramp_meter", "emergency", "bottleneck", "bridge"), Light.ROAD),
    **dict.fromkeys(("level_crossing", "blinker", "blink_mode", "no"), Light.OTHER),
}
_TAGGED: Final = {sign.value: sign for sign in Sign}
# Values of ``stop`` for signs before all arms.
_ALL_WAY: Final = frozenset({"all", "4-way", "4way"})
# Other words for kinds of ``traffic_calming``, and values that name none.
_CALMING: Final = {
    **{f"{kind}s": kind for kind in ("hump", "bump", "cushion", "rumble_strip")},
    **dict.fromkeys(("no", "yes", "none"), ""),
    "raised_crossing": "table",
}
_CIRCLES: Final = frozenset({"turning_circle", "turning_loop", "mini_roundabout"})
_DIAMETER: Final = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(m|ft|')?\s*")
# A number, and its unit unless it is metres; anything more (two values, a range, a datum) is not a height.
_ELE: Final = re.compile(r"([+-]?\d+(?:\.\d+)?)\s*(m|ft|feet)?", re.IGNORECASE)
# Values of ``ele`` beyond these are mistakes, m: shore of the Dead Sea, highest roads.
_ELE_PLAUSIBLE: Final = (-450.0, 6000.0)
# Values of ``bus_bay`` and ``bay`` where there is a bay.
_BAY: Final = frozenset({"yes", "left", "right", "both"})
# Higher and wider things beside the road are mistakes, m; choices.
_HEIGHT_MAX: Final = 60.0
_WIDTH_MAX: Final = 5.0
# Gauges of tracks, mm; others are mistakes.
_GAUGES: Final = range(500, 2001)
# Wider crossings are mistakes, m; a choice.
_CROSSING_WIDTH_MAX: Final = 20.0
# British names of crossings with lights (OSM wiki, Key:crossing_ref).
_WITH_LIGHTS: Final = frozenset({"pelican", "puffin", "toucan", "pegasus"})
# Values of ``crossing`` for crossings that are painted in a way that is not said.
_PAINTED: Final = frozenset({"marked", "uncontrolled", "traffic_signals"})
# Values of ``railway`` where ``crossing`` is about a crossing of tracks.
_TRACK_CROSSINGS: Final = frozenset({"level_crossing", "crossing", "tram_level_crossing", "tram_crossing"})
# The part of the road that barriers of level crossings close by ``crossing:barrier``; half of it for other values.
_BARRIERS: Final = {"no": "", "open": "", "full": "full", "double_half": "full", "double_full": "full"}


def read_node_facts(node_tags: Mapping[int, Tags], footways: Sequence[Footway], country: str) -> NodeFacts:
    """Read the tags of the nodes on streets, in ascending id, in a country (ISO 3166-1 alpha-2)."""
    tagged = node_tags.items()
    signed = [(node, tags) for node, tags in tagged if any(key in tags for key in SIGN_KEYS)]
    return NodeFacts(
        controls={node: control for node, tags in tagged if (control := read_control(tags)) is not None},
        sign_posts={node: read_sign_post(tags, country) for node, tags in signed},
        crossings=read_crossings(node_tags, footways),
        calming={node: kind for node, tags in tagged if (kind := _calming(tags))},
        bus_stops={node: _bus_stop(tags) for node, tags in tagged if tags.get("highway") == "bus_stop"},
        track_crossings=frozenset(node for node, tags in tagged if tags.get("railway") in _TRACK_CROSSINGS),
        rail_crossings={node: _rail(tags) for node, tags in tagged if tags.get("railway") == "level_crossing"},
        mini_roundabouts=frozenset(node for node, tags in tagged if tags.get("highway") == "mini_roundabout"),
    )


def _rail(tags: Tags) -> RailCrossing:
    """Return what stands at a level crossing (OSM wiki, Tag:railway=level_crossing)."""
    barriers = tags.get("crossing:barrier", "no")
    kind = _BARRIERS.get(barriers, "half")
    return RailCrossing(tags.get("crossing:saltire") != "no", tags.get("crossing:light", "no") != "no", kind)


def node_heights(node_tags: Mapping[int, Tags], diagnostics: Diagnostics) -> dict[int, float]:
    """Return the heights that ``ele`` gives nodes, by id, m, and report other values."""
    found = {}
    for node, tags in sorted(node_tags.items()):
        if "ele" in tags:
            z = parse_ele(tags["ele"])
            if z is None:
                message = f"ele '{tags['ele']}' is not a height in metres, it is ignored"
                diagnostics.dropped("ele", f"node/{node}", message)
            else:
                found[node] = z
    return found


def parse_ele(text: str) -> float | None:
    """Read a value of ``ele``, m; None if it is not a plausible height."""
    match = _ELE.fullmatch(text.strip())
    if match is None:
        return None
    z = float(match[1]) * (1.0 if (match[2] or "m").lower() == "m" else FOOT)
    return z if _ELE_PLAUSIBLE[0] <= z <= _ELE_PLAUSIBLE[1] else None


def turning_circles(node_tags: Mapping[int, Tags]) -> dict[int, float | None]:
    """Return the nodes that are turning circles, by id, with the diameter, m, that tags give, None if none."""
    found: dict[int, float | None] = {}
    for node, tags in node_tags.items():
        if tags.get("highway") in _CIRCLES:
            match = _DIAMETER.fullmatch(tags.get("diameter", ""))
            found[node] = float(match[1]) * (1.0 if match[2] in (None, "m") else FOOT) if match else None
    return found


def read_thing_facts(kind: RoadsideKind, tags: Tags, country: str) -> ThingFacts:
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


def read_control(tags: Tags) -> NodeControl | None:
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


def _light(tags: Tags) -> Light | None:
    if tags.get("highway") == "traffic_signals":
        return _SPECIAL_LIGHTS.get(tags.get("traffic_signals", ""), Light.JUNCTION)
    crossing = tags.get("crossing") == "traffic_signals" or tags.get("crossing:signals") == "yes"
    return Light.CROSSING if crossing else None


def _calming(tags: Tags) -> str:
    """Return what calms traffic, empty for nothing; islands of crossings belong to these."""
    value = tags.get("traffic_calming", "")
    kind = _CALMING.get(value, value)
    return "" if kind == "island" and is_crossing(tags) else kind


def _bus_stop(tags: Tags) -> BusStop:
    bay = not _BAY.isdisjoint((tags.get("bus_bay", ""), tags.get("bay", "")))
    return BusStop(tags.get("name", ""), bay, read_facing(tags.get("direction", "")).along)


def read_crossings(node_tags: Mapping[int, Tags], footways: Sequence[Footway]) -> tuple[MappedCrossing, ...]:
    """Find the crossings on streets, in ascending node.

    Each node of a street that is tagged as a crossing is one, and each node of a way that crosses. Where both have a
    tag, that of the node counts.
    """
    ways: dict[int, tuple[Footway, int]] = {}
    for footway in footways:
        if footway.crossing and footway.tags.get("crossing") != "no":
            for at, node in enumerate(footway.node_ids.tolist()):
                ways.setdefault(node, (footway, at))
    out = []
    for node in sorted({node for node, tags in node_tags.items() if is_crossing(tags)} | ways.keys()):
        tags = node_tags.get(node, {})
        if tags.get("crossing") == "no":
            continue
        if node in ways:
            footway, at = ways[node]
            along = footway.points[min(at + 1, len(footway.points) - 1)] - footway.points[max(at - 1, 0)]
            heading = float(arctan2(along[1], along[0]))
            out.append(_crossing(node, {**footway.tags, **tags}, heading))
        else:
            out.append(_crossing(node, tags, None))
    return tuple(out)


def is_crossing(tags: Tags) -> bool:
    """Return whether a node on a street is a crossing for people, marked or not."""
    value = tags.get("crossing", "")
    for_people = bool(value) and tags.get("railway") not in _TRACK_CROSSINGS
    return value != "no" and (for_people or tags.get("highway") == "crossing")


def _crossing(node: int, tags: Tags, heading: float | None) -> MappedCrossing:
    widths = (plausible_length(tags.get(key, ""), _CROSSING_WIDTH_MAX) for key in ("crossing:width", "width"))
    return MappedCrossing(
        node,
        heading,
        lights=_has_lights(tags),
        island=_has_island(tags),
        marking=_marking(tags),
        width=next((width for width in widths if width is not None), None),
        width_tagged="crossing:width" in tags or "width" in tags,
    )


def _has_lights(tags: Tags) -> bool:
    """Return whether a crossing has traffic lights; ``crossing:signals`` goes before all other tags."""
    if "crossing:signals" in tags:
        return tags["crossing:signals"] != "no"
    return (
        tags.get("crossing") == "traffic_signals"
        or tags.get("crossing_ref") in _WITH_LIGHTS
        or (tags.get("highway") == "traffic_signals" and "crossing" in tags)
    )


def _has_island(tags: Tags) -> bool:
    """Return whether people can wait in the middle of a crossing."""
    if value := tags.get("crossing:island", ""):
        return value != "no"
    return tags.get("crossing") == "island" or tags.get("traffic_calming") == "island"


def _marking(tags: Tags) -> str:
    """Return what is painted, in the words of ``crossing:markings``: ``zebra``, ``lines`` …, ``unmarked``.

    ``yes`` stands for any kind of marks.
    """
    value = tags.get("crossing:markings", "")
    if value == "no":
        return "unmarked"
    zebra = "zebra" in (tags.get("crossing"), tags.get("crossing_ref"))
    if value and not (value == "yes" and zebra):
        return value
    if zebra:
        return "zebra"
    return "yes" if tags.get("crossing") in _PAINTED or _has_lights(tags) else "unmarked"
