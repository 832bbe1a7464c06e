"""Areas of OSM files: closed ways, and multipolygons whose outlines several ways may share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set as AbstractSet
from typing import Any, Final, TypeAlias

import numpy as np
import osmium

from osm2xodr.model import FloatArray
from osm2xodr.osmParsing.file.access import RawNodes, all_tags, forgiving, handle, readable
from osm2xodr.osmParsing.file.file_format import OsmFile
from osm2xodr.system import record

# Type of relations that are areas (OSM wiki, Relation:multipolygon).
AREA_TYPE: Final = "multipolygon"
# Fewer nodes make no area, with the first one at the end again.
_LEAST_NODES: Final = 4

# Keys and values.
Tags: TypeAlias = tuple[tuple[str, str], ...]


@record
class RawArea:
    """An area as in the file: rings of ids of nodes, the first one of each not repeated."""

    osm_id: str  # ``way/1`` or ``relation/2``
    outer: tuple[tuple[int, ...], ...]
    inner: tuple[tuple[int, ...], ...]
    tags: Mapping[str, str]
    lines: tuple[tuple[int, ...], ...] = ()  # What a relation has of rings that are not closed, ids of nodes


@forgiving
def read_areas(file: OsmFile, keys: AbstractSet[str] | Tags) -> tuple[list[RawArea], list[str]]:
    """Read the areas that have one of some keys, or of some tags: ways first, then relations, each in ascending id.

    Also returned are the ids of relations and ways whose outlines are not closed, as at the edges of cut-outs: such
    relations may have no ring. Raises InputError if the file is damaged or incomplete.
    """
    wanted = osmium.filter.TagFilter(*keys) if isinstance(keys, tuple) else osmium.filter.KeyFilter(*sorted(keys))
    ways: dict[int, tuple[list[int], dict[str, str]]] = {}
    relations: dict[int, tuple[dict[str, list[int]], dict[str, str]]] = {}
    with readable(file):
        item: Any
        found = osmium.FileProcessor(handle(file), osmium.osm.WAY | osmium.osm.RELATION)
        for item in found.with_filter(wanted):
            tags = dict(all_tags(item))
            if item.is_way():
                if not item.deleted and ("way", item.id) not in file.deleted:
                    ways[item.id] = [node.ref for node in item.nodes], tags
            elif tags.get("type") == AREA_TYPE and ("relation", item.id) not in file.deleted:
                members: dict[str, list[int]] = {"outer": [], "inner": []}
                for member in item.members:
                    if member.type == "w":
                        members["inner" if member.role == "inner" else "outer"].append(member.ref)
                relations[item.id] = members, tags
    lines = _read_lines(file, {way for members, _ in relations.values() for refs in members.values() for way in refs})
    areas, open_ones = [], []
    for number in sorted(ways):
        refs, tags = ways[number]
        if len(refs) >= _LEAST_NODES and refs[0] == refs[-1]:
            areas.append(RawArea(f"way/{number}", (tuple(refs[:-1]),), (), tags))
        else:
            open_ones.append(f"way/{number}")
    for number in sorted(relations):
        members, tags = relations[number]
        outer, outer_left = _rings(lines[way] for way in members["outer"] if way in lines)
        inner, inner_left = _rings(lines[way] for way in members["inner"] if way in lines)
        if outer_left or not outer or any(way not in lines for way in members["outer"]):
            open_ones.append(f"relation/{number}")
        areas.append(RawArea(f"relation/{number}", outer, inner, tags, outer_left + inner_left))
    return areas, open_ones


def rings_of(area: RawArea, nodes: RawNodes) -> tuple[list[FloatArray], tuple[FloatArray, ...]]:
    """Return the outlines of an area and its holes as longitude and latitude, (n, 2), degrees, but no broken ones."""
    outer, inner = (
        [ring for ring in (places_of(refs, nodes) for refs in rings) if ring is not None]
        for rings in (area.outer, area.inner)
    )
    return outer, tuple(inner)


def places_of(refs: Sequence[int], nodes: RawNodes, least: int = 3) -> FloatArray | None:
    """Return longitude and latitude of nodes, (n, 2), degrees; None if one is missing or there are too few."""
    ids = np.array(refs, np.int64)
    at = np.minimum(np.searchsorted(nodes.ids, ids), max(len(nodes.ids) - 1, 0))
    if len(ids) < least or not len(nodes.ids) or (nodes.ids[at] != ids).any():
        return None
    return np.column_stack([nodes.lon_deg[at], nodes.lat_deg[at]])


def known_pieces(refs: Sequence[int], nodes: RawNodes) -> list[FloatArray]:
    """Return the pieces of a line whose nodes are all known, as longitude and latitude, (n, 2), degrees."""
    ids = np.array(refs, np.int64)
    border = np.flatnonzero(np.diff(np.isin(ids, nodes.ids))) + 1
    pieces = (places_of(piece.tolist(), nodes, least=2) for piece in np.split(ids, border))
    return [piece for piece in pieces if piece is not None]


@forgiving
def read_bounds(file: OsmFile) -> tuple[float, float, float, float] | None:
    """Return the rectangle that a file says it was cut to: west, south, east, north, degrees; None without any.

    `InputError` if the file is damaged.
    """
    with readable(file), osmium.io.Reader(handle(file), osmium.osm.NOTHING) as reader:
        box = reader.header().box()
        if not box.valid():
            return None
        low, high = box.bottom_left, box.top_right
        return low.lon, low.lat, high.lon, high.lat


@forgiving
def read_lines(file: OsmFile, tags: Tags) -> list[tuple[int, ...]]:
    """Read the nodes of the ways that have one of some tags, in ascending id; `InputError` if the file is damaged."""
    found: dict[int, tuple[int, ...]] = {}
    with readable(file):
        item: Any
        ways = osmium.FileProcessor(handle(file), osmium.osm.WAY)
        for item in ways.with_filter(osmium.filter.TagFilter(*tags)):
            if not item.deleted and ("way", item.id) not in file.deleted:
                found[item.id] = tuple(node.ref for node in item.nodes)
    return [found[number] for number in sorted(found)]


@forgiving
def _read_lines(file: OsmFile, wanted: AbstractSet[int]) -> dict[int, Sequence[int]]:
    """Return the nodes of ways."""
    lines: dict[int, Sequence[int]] = {}
    if wanted:
        with readable(file):
            item: Any
            ways = osmium.FileProcessor(handle(file), osmium.osm.WAY)
            for item in ways.with_filter(osmium.filter.IdFilter(sorted(wanted))):
                lines[item.id] = [node.ref for node in item.nodes]
    return lines


def _rings(lines: Iterable[Sequence[int]]) -> tuple[tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]:
    """Join lines at their ends to rings; return these, and the lines that are left over."""
    rings, rest, left = [], [], [list(line) for line in lines if len(line) > 1]
    while left:
        ring = left.pop(0)
        while ring[0] != ring[-1]:
            follows = next((k for k, line in enumerate(left) if ring[-1] in (line[0], line[-1])), None)
            if follows is None:
                break
            line = left.pop(follows)
            ring += line[1:] if line[0] == ring[-1] else line[-2::-1]
        if ring[0] == ring[-1] and len(ring) >= _LEAST_NODES:
            rings.append(tuple(ring[:-1]))
        else:
            rest.append(tuple(ring))
    return tuple(rings), tuple(rest)
