"""What carries or covers a way: bridges, tunnels, galleries, passages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from osm2xodr.diagnostics import Kind
from osm2xodr.model import Structure, StructureTags
from osm2xodr.osmParsing.tags.lane_lists import Findings
from osm2xodr.osmParsing.tags.values import parse_layer

STRUCTURE_TAGS: Final = (
    "bridge",
    "tunnel",
    "layer",
    "bridge:material",
    "material",
    "bridge:name",
    "tunnel:name",
    "lit",
)

# Values of ``tunnel`` that leave the road on the ground: passages through houses, galleries, and drains below it.
_GROUND_TUNNELS: Final = frozenset({"no", "building_passage", "avalanche_protector", "culvert", "flooded"})
# Those of them that nothing covers, and those that are open at a side.
_NO_TUNNELS: Final = frozenset({"no", "culvert", "flooded"})
_GALLERIES: Final = frozenset({"avalanche_protector"})
# OpenDRIVE's words for what OSM calls the material of bridges.
_MATERIALS: Final = {
    "concrete": "concrete",
    "prestressed_concrete": "concrete",
    "reinforced_concrete": "concrete",
    "aluminium": "steel",
    "cast_iron": "steel",
    "iron": "steel",
    "metal": "steel",
    "steel": "steel",
    "wrought_iron": "steel",
    "brick": "brick",
    "granite": "brick",
    "limestone": "brick",
    "masonry": "brick",
    "sandstone": "brick",
    "stone": "brick",
    "timber": "wood",
    "wood": "wood",
}
_LIT: Final = {"yes": True, "24/7": True, "automatic": True, "no": False, "disused": False}


def structure_of(tags: Mapping[str, str]) -> Structure:
    """Return what carries a way."""
    if tags.get("bridge", "no") != "no":
        return Structure.BRIDGE
    return Structure.GROUND if tags.get("tunnel", "no") in _GROUND_TUNNELS else Structure.TUNNEL


def layer_of(tags: Mapping[str, str], structure: Structure, findings: Findings) -> int:
    """Return a way's ``layer``, or the usual one of what carries it."""
    text = tags.get("layer")
    if text is not None:
        layer = parse_layer(text)
        if layer is None:
            findings.append((Kind.DROPPED, "layer", f"layer={text} is no layer and is ignored"))
        else:
            if ";" in text:
                findings.append((Kind.GUESSED, "layer", f"layer={text} taken for {layer}"))
            return layer
    return {Structure.GROUND: 0, Structure.BRIDGE: 1, Structure.TUNNEL: -1}[structure]


def structure_tags(tags: Mapping[str, str]) -> StructureTags | None:
    """Return more about the bridge or tunnel of a way; None where it has none."""
    if tags.get("bridge", "no") != "no":
        material = tags.get("bridge:material", tags.get("material", ""))
        return StructureTags("bridge", _MATERIALS.get(material, ""), name=tags.get("bridge:name", ""))
    tunnel = tags.get("tunnel", "no")
    if tunnel in _NO_TUNNELS:
        return None
    lit = _LIT.get(tags.get("lit", ""))
    return StructureTags("tunnel", "", tunnel in _GALLERIES, lit, tags.get("tunnel:name", ""))
