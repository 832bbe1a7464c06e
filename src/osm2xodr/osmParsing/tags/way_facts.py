"""What tags of ways say beside lanes: overtaking, dividers, signed limits, rails, bridges and tunnels, layers."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Direction, Structure, StructureTags
from osm2xodr.osmParsing.tags.values import Findings, Tags, parse_layer, parse_speed, plausible_length

_OVERTAKING: Final = {
    "": (Direction.FORWARD, Direction.BACKWARD),
    ":forward": (Direction.FORWARD,),
    ":backward": (Direction.BACKWARD,),
}
_OVERTAKING_TAGS: Final = tuple(f"overtaking{way}" for way in _OVERTAKING)
# Tags with the origin of ``maxspeed`` (OSM wiki, Key:source:maxspeed).
_SPEED_SOURCES: Final = ("maxspeed:type", "source:maxspeed")
_SPEEDS: Final = ("maxspeed", "maxspeed:forward", "maxspeed:backward")
MARK_TAGS: Final = (
    *("lane_markings", "divider", "surface", "traffic_sign", "embedded_rails", "railway"),
    *(*_OVERTAKING_TAGS, *_SPEED_SOURCES, *_SPEEDS),
)

# OSM wiki, Key:overtaking: the directions in which it is allowed.
_ALLOWED: Final = {
    **dict.fromkeys(("yes", "both", "caution"), frozenset({Direction.FORWARD, Direction.BACKWARD})),
    "forward": frozenset({Direction.FORWARD}),
    "backward": frozenset({Direction.BACKWARD}),
    "no": frozenset[Direction](),
}
# Sets of directions, shared by all ways: bit 1 is forward, bit 2 backward.
_SETS: Final = tuple(
    frozenset(way for way, bit in ((Direction.FORWARD, 1), (Direction.BACKWARD, 2)) if bits & bit)
    for bits in range(4)
)
_RAILS: Final = frozenset({"tram", "light_rail", "yes"})
_TRAMS: Final = frozenset({"tram", "light_rail"})
_OTHER_SIDE: Final = {"left": "right", "right": "left", "forward": "backward", "backward": "forward"}
_SIDE_WORD: Final = re.compile("|".join(_OTHER_SIDE))

STRUCTURE_TAGS: Final = (
    "bridge",
    "tunnel",
    "layer",
    "bridge:material",
    "material",
    "bridge:name",
    "tunnel:name",
    "lit",
    "maxheight",
)

# Values of ``maxheight`` that stand for no sign (OSM wiki, Key:maxheight), and what is no height of vehicles, m.
_NO_HEIGHTS: Final = frozenset({"default", "none", "no", "unsigned", "no_sign", "below_default", "no_indications"})
_HEIGHT_MAX: Final = 10.0
# Values of ``tunnel`` with the road on the ground: passages through buildings, galleries, and drains below it.
_GROUND_TUNNELS: Final = frozenset({"no", "building_passage", "avalanche_protector", "culvert", "flooded"})
# Of these: roads without any cover, and covers that are open at a side.
_NO_TUNNELS: Final = frozenset({"no", "culvert", "flooded"})
_GALLERIES: Final = frozenset({"avalanche_protector"})
# OpenDRIVE's materials of bridges by OSM's values.
_MATERIALS: Final = {
    **dict.fromkeys(("concrete", "prestressed_concrete", "reinforced_concrete"), "concrete"),
    **dict.fromkeys(("aluminium", "cast_iron", "iron", "metal", "steel", "wrought_iron"), "steel"),
    **dict.fromkeys(("brick", "granite", "limestone", "masonry", "sandstone", "stone"), "brick"),
    **dict.fromkeys(("timber", "wood"), "wood"),
}
_LIT: Final = {"yes": True, "24/7": True, "automatic": True, "no": False, "disused": False}


def no_overtaking(tags: Tags, direction: int, findings: Findings) -> frozenset[Direction]:
    """Return the directions along the way in which overtaking is forbidden.

    `direction` is 1 or -1 if the way is one-way along or against its order of nodes, else 0.
    """
    if not any(key in tags for key in _OVERTAKING_TAGS):
        return _SETS[0]
    forbidden = {Direction.FORWARD: False, Direction.BACKWARD: False}
    # Tags for one direction come last and take precedence.
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


def opposite_directions(directions: frozenset[Direction]) -> frozenset[Direction]:
    """Return directions as seen against the way."""
    if len(directions) != 1:
        return directions
    return _SETS[1] if Direction.BACKWARD in directions else _SETS[2]


def lanes_marked(tags: Tags, findings: Findings) -> bool | None:
    """Return whether lanes are marked; None if not tagged."""
    value = tags.get("lane_markings")
    if value not in (None, "yes", "no"):
        findings.append((Kind.DROPPED, "lane-markings", f"lane_markings={value} is not known and is ignored"))
    return {"yes": True, "no": False}.get(value or "")


@lru_cache(maxsize=256)
def reversed_divider(value: str) -> str:
    """Return a value of ``divider`` as seen against the way: lists and sides are swapped."""
    parts = reversed(value.split(";"))
    return ";".join(_SIDE_WORD.sub(lambda word: _OTHER_SIDE[word[0]], part) for part in parts)


def has_tram(tags: Tags) -> bool:
    """Whether tram tracks lie in the carriageway."""
    if "embedded_rails" not in tags and "railway" not in tags:
        return False
    embedded = {part.strip() for part in tags.get("embedded_rails", "").split(";")}
    return not _RAILS.isdisjoint(embedded) or tags.get("railway") in _TRAMS


def speed_is_signed(tags: Tags) -> bool:
    """Whether ``maxspeed`` gives a number and no tag says that it follows from the law for a kind of road.

    The limit of a zone such as ``DE:zone30`` is signed.
    """
    is_number = any(key in tags and _is_number(tags[key]) for key in _SPEEDS)
    return is_number and not any(_is_law(tags[key]) for key in _SPEED_SOURCES if key in tags)


@lru_cache(maxsize=1024)
def _is_number(text: str) -> bool:
    return text != "walk" and ":" not in text and parse_speed(text) is not None


@lru_cache(maxsize=1024)
def _is_law(text: str) -> bool:
    return ":" in text and "zone" not in text.lower() and parse_speed(text) is not None


def structure_of(tags: Tags) -> Structure:
    """Return whether a way is on a bridge, in a tunnel or on the ground."""
    if tags.get("bridge", "no") != "no":
        return Structure.BRIDGE
    return Structure.GROUND if tags.get("tunnel", "no") in _GROUND_TUNNELS else Structure.TUNNEL


def layer_of(tags: Tags, structure: Structure, findings: Findings) -> int:
    """Return a way's ``layer``, or the usual one of its structure."""
    text = tags.get("layer")
    layer = parse_layer(text or "")
    if text is not None and layer is None:
        findings.append((Kind.DROPPED, "layer", f"layer={text} is not a layer and is ignored"))
    elif text is not None and ";" in text:
        findings.append((Kind.GUESSED, "layer", f"layer={text} taken for {layer}"))
    if layer is not None:
        return layer
    return {Structure.GROUND: 0, Structure.BRIDGE: 1, Structure.TUNNEL: -1}[structure]


def max_height(tags: Tags, findings: Findings) -> float | None:
    """Return how high vehicles on a way may be by ``maxheight``, m; None where it gives no height."""
    text = tags.get("maxheight", "")
    if not text or text.lower() in _NO_HEIGHTS:
        return None
    height = plausible_length(text, _HEIGHT_MAX)
    if height is None:
        findings.append((Kind.DROPPED, "max-height", f"maxheight={text} is no height and is ignored"))
    return height


def structure_tags(tags: Tags) -> StructureTags | None:
    """Return material, cover, lighting and name of a way's bridge or tunnel; None if it has neither."""
    if tags.get("bridge", "no") != "no":
        material = tags.get("bridge:material", tags.get("material", ""))
        return StructureTags("bridge", _MATERIALS.get(material, ""), name=tags.get("bridge:name", ""))
    tunnel = tags.get("tunnel", "no")
    if tunnel in _NO_TUNNELS:
        return None
    lit = _LIT.get(tags.get("lit", ""))
    return StructureTags("tunnel", "", tunnel in _GALLERIES, lit, tags.get("tunnel:name", ""))
