"""What tags of nodes on streets, of ways that cross there, and of things beside streets say. Pure functions.

Among them are traffic signs (OSM wiki, Key:traffic_sign).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

from osm2xodr.conventions import find_country, is_supplementary, sign_meaning, sign_meanings
from osm2xodr.curves import arctan2
from osm2xodr.defaults import KERB_HEIGHT
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import (
    BusStop,
    Facing,
    FacingSigns,
    Footway,
    Light,
    MappedCrossing,
    NodeControl,
    NodeFacts,
    RailCrossing,
    RoadsideKind,
    Sign,
    SignFace,
    SignPost,
    StreetAttributes,
    ThingFacts,
)
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

SIGN_KEYS: Final = ("traffic_sign", "traffic_sign:forward", "traffic_sign:backward", "traffic_sign:both")
_ALONG: Final = {"forward": True, "backward": False}
_DEGREES: Final = re.compile(r"\d+(?:\.\d+)?")
_COMPASS_POINTS: Final = (
    *("N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE"),
    *("S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"),
)

# OSM's words whose meaning has another name in the table of codes.
_WORDS: Final = {
    **{f"max{what}": f"max_{what}" for what in ("height", "width", "length", "weight")},
    **dict.fromkeys(("yield", "giveway"), "give_way"),
    **dict.fromkeys(("pedestrian_crossing", "crossing"), "crosswalk"),
    **dict.fromkeys(("speed_limit", "max_speed"), "maxspeed"),
    "maxaxleload": "max_axle_load",
    "overtaking": "no_overtaking",
    "oneway": "one_way",
    "traffic_signals": "signals_ahead",
    "school": "children",
    "noexit": "dead_end",
    "city_limit_begin": "city_limit",
}
# Values of ``hazard`` (OSM wiki, Key:hazard).
_HAZARDS: Final = {
    **dict.fromkeys(("animal_crossing", "animals", "wild_animals", "deer"), "animals"),
    **dict.fromkeys(("bump", "dip", "bumps"), "bumps"),
    **dict.fromkeys(("children", "school_zone"), "children"),
    **dict.fromkeys(("cyclists", "bicycles"), "bicycles"),
    **dict.fromkeys(("narrow", "road_narrows"), "road_narrows"),
    **dict.fromkeys(("slippery", "slippery_road"), "slippery"),
    "pedestrians": "pedestrians",
    "queues_likely": "queues",
    "side_winds": "side_wind",
    "traffic_signals": "signals_ahead",
}
# Words that do not say which sign it is, or that it does not regulate traffic.
_VAGUE: Final = frozenset({"", "yes", "no", "none", "variable", "information", "street_name_sign", "id", "unknown"})
# The tag with the number on a sign, and the unit of numbers without one, by meaning; empty for that of speed limits.
_VALUE_TAGS: Final = {
    **dict.fromkeys(("maxspeed", "maxspeed_zone"), ("maxspeed", "")),
    "minspeed": ("minspeed", ""),
    "advisory_speed": ("maxspeed:advisory", ""),
    **{f"max_{what}": (f"max{what}", "m") for what in ("height", "width", "length")},
    "max_weight": ("maxweight", "t"),
    "max_axle_load": ("maxaxleload", "t"),
}
# Meanings of signs with a speed.
_SPEEDS: Final = frozenset(
    f"{kind}{end}" for kind in ("maxspeed", "maxspeed_zone", "minspeed", "advisory_speed") for end in ("", "_end")
)
_ITEM: Final = re.compile(r"\s*(?:([A-Za-z]{2})(?:-[A-Za-z]{1,3})?\s*:)?\s*(.*?)\s*", re.DOTALL)
_IN_BRACKETS: Final = re.compile(r"([^\[\]]*?)\s*\[(.*)\]")
_NUMBER: Final = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mph|km/h|kmh|t|m)?")


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


def read_facing(text: str, *, compass_points: bool = False) -> Facing:
    """Read a value of ``direction``: ``forward``, ``backward``, ``both``, degrees, or compass points if wanted."""
    place = text.strip().upper() if compass_points else text
    azimuth = float(place) if _DEGREES.fullmatch(place) else None
    if compass_points and place in _COMPASS_POINTS:
        azimuth = _COMPASS_POINTS.index(place) * 360.0 / len(_COMPASS_POINTS)
    return Facing(_ALONG.get(text), text == "both", azimuth)


def read_sign_post(tags: Tags, country: str) -> SignPost:
    """Read all signs of a node in a country (ISO 3166-1 alpha-2)."""
    highway = tags.get("highway", "")
    return SignPost(
        tuple(
            FacingSigns(read_facing(word, compass_points=True), read_faces(text, tags, country, word))
            for word, text in directed_values(tags)
        ),
        read_facing(_direction(tags), compass_points=True),
        Sign(highway) if highway in ("stop", "give_way") else None,
        tags.get("city_limit", ""),
    )


def with_speed_zones(attributes: Sequence[StreetAttributes], country: str) -> list[StreetAttributes]:
    """Mark the ways whose traffic signs say that their limit is that of a zone."""
    return [replace(item, speed_zone=True) if _is_zone(item.traffic_sign, country) else item for item in attributes]


@lru_cache(maxsize=1024)
def _is_zone(text: str, country: str) -> bool:
    return bool(text) and any(face.meaning == "maxspeed_zone" for face in read_faces(text, {}, country))


def _direction(tags: Tags) -> str:
    return tags.get("traffic_sign:direction") or tags.get("direction", "")


def directed_values(tags: Tags) -> Iterator[tuple[str, str]]:
    """Yield (direction, empty where unknown, and value) of each tag that names signs."""
    for key in SIGN_KEYS:
        if key in tags:
            yield _direction(tags) if key == "traffic_sign" else key.removeprefix("traffic_sign:"), tags[key]


def read_faces(text: str, tags: Tags, country: str, direction: str = "") -> tuple[SignFace, ...]:
    """Read a value of ``traffic_sign``; empty where it names no sign.

    Commas separate signs on one pole, semicolons those that stand apart; a country's prefix holds for what follows.
    All tags of the node say what is written on the signs, those for the direction of the value first.
    """
    out: list[SignFace] = []
    owner = ""
    for group in _split(text, ";"):
        for place, item in enumerate(_split(group, ",")):
            found = _ITEM.fullmatch(item)
            if found is None or found[2].lower() in _VAGUE:
                continue
            owner = (found[1] or owner).upper()
            face = _face(found[2], owner, country, first=place == 0)
            out.append(_completed(face, tags, country, direction))
    return tuple(out)


def _split(text: str, mark: str) -> list[str]:
    """Split at a mark outside quotes and brackets."""
    out, depth, quoted = [""], 0, False
    for sign in text:
        quoted ^= sign == '"'
        depth += (sign == "[") - (sign == "]")
        if sign == mark and not quoted and depth <= 0:
            out.append("")
        else:
            out[-1] += sign
    return out


def _face(text: str, owner: str, country: str, *, first: bool) -> SignFace:
    if text.startswith('"'):
        return SignFace("", text=text.strip('"'), supplementary=not first)
    bracket = _IN_BRACKETS.fullmatch(text)
    name, written = (bracket[1], bracket[2]) if bracket else (text, "")
    word = name.lower().replace(" ", "_")
    word = _WORDS.get(word, word)
    if not owner and word in sign_meanings():
        value, unit, rest = _read_value(written)
        return SignFace(word, value=value, unit=unit, text=rest)
    of_whom = owner or country
    meaning, value = sign_meaning(of_whom, name)
    if not owner and not meaning:
        return SignFace("", text=name, supplementary=not first)
    in_bracket, unit, rest = _read_value(written)
    value = value if in_bracket is None else in_bracket
    adds = not meaning and is_supplementary(of_whom, name)
    return SignFace(meaning, of_whom, name, value, unit, rest, adds)


def _read_value(text: str) -> tuple[float | None, str, str]:
    """Read what is in brackets: a number and its unit, or else text."""
    found = _NUMBER.fullmatch(text.strip().lower())
    if found is None:
        return None, "", text.strip().strip('"')
    return float(found[1].replace(",", ".")), (found[2] or "").replace("kmh", "km/h"), ""


def _completed(face: SignFace, tags: Tags, country: str, direction: str) -> SignFace:
    """Add what other tags say: the number on the sign, its unit, the name of the town, the kind of hazard."""
    meaning, value, unit, text = face.meaning, face.value, face.unit, face.text
    if meaning == "hazard":
        meaning = _HAZARDS.get(tags.get("hazard", ""), meaning)
    key, usual = _VALUE_TAGS.get(meaning, ("", ""))
    if value is None and key:
        value, unit, _ = _read_value(tags.get(f"{key}:{direction}") or tags.get(key, ""))
    if value is not None and not unit:
        unit = find_country(face.country or country).speed_unit if meaning in _SPEEDS else usual
    if meaning in ("city_limit", "city_limit_end"):
        text = text or tags.get("name", "")
    return SignFace(meaning, face.country, face.code, value, unit, text, face.supplementary)
