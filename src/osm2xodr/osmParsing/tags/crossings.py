"""Crossings for people on streets, from tags of nodes and of the ways that cross there. Pure functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from osm2xodr.model import Footway, MappedCrossing
from osm2xodr.osmParsing.tags.values import Tags, plausible_length

# Wider crossings are mistakes, m; a choice.
_WIDTH_MAX: Final = 20.0
# British names of crossings with lights (OSM wiki, Key:crossing_ref).
_WITH_LIGHTS: Final = frozenset({"pelican", "puffin", "toucan", "pegasus"})
# Values of ``crossing`` for crossings that are painted in a way that is not said.
_PAINTED: Final = frozenset({"marked", "uncontrolled", "traffic_signals"})
# Values of ``railway`` where ``crossing`` is about a crossing of tracks.
TRACK_CROSSINGS: Final = frozenset({"level_crossing", "crossing", "tram_level_crossing", "tram_crossing"})


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
            heading = float(np.arctan2(along[1], along[0]))
            out.append(_crossing(node, {**footway.tags, **tags}, heading))
        else:
            out.append(_crossing(node, tags, None))
    return tuple(out)


def is_crossing(tags: Tags) -> bool:
    """Return whether a node on a street is a crossing for people, marked or not."""
    value = tags.get("crossing", "")
    for_people = bool(value) and tags.get("railway") not in TRACK_CROSSINGS
    return value != "no" and (for_people or tags.get("highway") == "crossing")


def _crossing(node: int, tags: Tags, heading: float | None) -> MappedCrossing:
    widths = (plausible_length(tags.get(key, ""), _WIDTH_MAX) for key in ("crossing:width", "width"))
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
