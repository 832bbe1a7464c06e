"""Where cars turn round: what tags of nodes on streets say about turning circles."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from osm2xodr.model import TurningPlace

_CIRCLES: Final = frozenset({"turning_circle", "turning_loop", "mini_roundabout"})
_DIAMETER: Final = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(m|ft|')?\s*")
_FOOT: Final = 0.3048


def turning_places(node_tags: Mapping[int, Mapping[str, str]]) -> dict[int, TurningPlace]:
    """Return what the tags of nodes, by id, say about room to turn round; nothing about most of them."""
    found = {}
    for node, tags in node_tags.items():
        place = TurningPlace(tags.get("highway") in _CIRCLES, _diameter(tags.get("diameter", "")))
        if place.circle or place.diameter is not None:
            found[node] = place
    return found


def _diameter(text: str) -> float | None:
    """Read a diameter in metres or feet, m."""
    match = _DIAMETER.fullmatch(text)
    return None if match is None else float(match[1]) * (1.0 if match[2] in (None, "m") else _FOOT)
