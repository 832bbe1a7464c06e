"""Bridges, tunnels, galleries and passages, and the layer of a way."""

from __future__ import annotations

from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Structure, StructureTags
from osm2xodr.osmParsing.tags.values import Findings, Tags, parse_layer, plausible_length

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
