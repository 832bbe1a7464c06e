"""Ways, nodes and relations of OSM files.

A file is read twice, so that the order of its elements does not matter: first ways and relations, then the nodes that
they need. Of elements that occur several times the newest version is taken, among equal ones the way with most nodes,
else the last, as where extracts were pasted together; `Content` keeps which they are.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence, Set as AbstractSet
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import osmium

from osm2xodr import projection
from osm2xodr.curves import repeated, sorted_unique, unique_counts
from osm2xodr.model import FloatArray, IntArray, LocalFrame
from osm2xodr.osmParsing.file.access import (
    RawMember,
    RawNodes,
    RawRelation,
    RawWay,
    all_tags,
    forgiving,
    handle,
    readable,
)
from osm2xodr.osmParsing.file.file_format import OsmFile, open_osm_file
from osm2xodr.system import record

RELATION_TYPES: Final = (
    *("restriction", "restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle"),
    "connectivity",
)
_LANELET: Final = "lanelet"
# libosmium's integer positions; missing or impossible ones lie outside the Earth.
UNITS_PER_DEGREE: Final = 1e7
_MEMBER_TYPES: Final = {"n": "node", "w": "way", "r": "relation"}


@record
class OtherWays:
    """Which ways are read besides streets."""

    values: Mapping[str, AbstractSet[str]]  # Values of tags by key; ways with one of them are candidates
    keys: AbstractSet[str]  # Keys of the tags to keep of them
    wanted: Callable[[Mapping[str, str]], bool]  # Decides by these tags whether a candidate is kept
    every: AbstractSet[str] = frozenset()  # Keys; ways with one of them are candidates too, whatever its value
    # Decides likewise which other candidates are kept without their nodes: those that are only spoken of
    named: Callable[[Mapping[str, str]], bool] = lambda tags: False


@forgiving
def read_ways(
    file: OsmFile,
    highways: frozenset[str],
    keys: AbstractSet[str],
    others: OtherWays | None = None,
    also: AbstractSet[int] = frozenset(),
) -> tuple[list[RawWay], list[RawRelation]]:
    """Read the ways with given values of ``highway`` and the relations of `RELATION_TYPES`, in ascending id.

    `keys` are those of the tags to keep of these ways. `others` are further ways to read, with other values of
    ``highway``; they are returned among the ways. Of `also`, ids of ways with any ``highway``, the tags of both are
    kept. Raises InputError if the file is damaged or incomplete.
    """
    only_ways = _way_filter(others)
    only_ways.enable_for(osmium.osm.WAY)
    only_relations = osmium.filter.TagFilter(*(("type", value) for value in RELATION_TYPES))
    only_relations.enable_for(osmium.osm.RELATION)
    every = keys if others is None else keys | others.keys
    ways: dict[int, tuple[int, RawWay | None]] = {}
    relations: dict[int, tuple[int, RawRelation | None]] = {}
    with readable(file):
        found = osmium.FileProcessor(handle(file), osmium.osm.WAY | osmium.osm.RELATION)
        item: Any
        for item in found.with_filter(only_ways).with_filter(only_relations):
            number, version = item.id, item.version
            if item.is_way():
                gone = item.deleted or ("way", number) in file.deleted
                if number in also:
                    way: RawWay | None = RawWay(item.id, _refs(item), _tags(item, every))
                elif class_of(item.tags) in highways:
                    way = RawWay(item.id, _refs(item), _tags(item, keys))
                else:
                    way = None if others is None else _other_way(item, others)
                found_way = version, None if gone else way
                ways[number] = longer_or_newer(file, ways[number], found_way) if number in ways else found_way
            elif number not in relations or version >= relations[number][0]:
                gone = item.deleted or ("relation", number) in file.deleted
                relations[number] = version, None if gone else _relation(item)
    kept_ways = [way for _, (_, way) in sorted(ways.items()) if way is not None]
    kept_relations = [relation for _, (_, relation) in sorted(relations.items()) if relation is not None]
    return kept_ways, kept_relations


def class_of(tags: Any) -> str:
    """Return the value of ``highway`` among tags, of several (``primary;secondary``) the first; empty for none."""
    return str(tags.get("highway", "")).partition(";")[0].strip()


def _way_filter(others: OtherWays | None) -> Any:
    beside = () if others is None else (*others.every, *others.values)
    return osmium.filter.KeyFilter(*sorted({"highway", *beside}))


@forgiving
def _read_refs(file: OsmFile, ways: AbstractSet[int], relations: AbstractSet[int]) -> dict[str, list[int]]:
    """Return the ids of the nodes of ways and of relations' members, by ``way/1`` or ``relation/2``.

    Ways and relations (ids) that are not in the file are left out.
    """
    members: dict[int, tuple[list[int], list[int]]] = {}
    with readable(file):
        item: Any
        if relations:
            for item in osmium.FileProcessor(handle(file), osmium.osm.RELATION):
                if item.id in relations:
                    pairs = [(member.type, member.ref) for member in item.members]
                    nodes, of_ways = ([ref for kind, ref in pairs if kind == wanted] for wanted in "nw")
                    members[item.id] = nodes, of_ways
        wanted_ways = set(ways).union(*(of_ways for _, of_ways in members.values()))
        refs: dict[int, list[int]] = {}
        if wanted_ways:
            for item in osmium.FileProcessor(handle(file), osmium.osm.WAY):
                if item.id in wanted_ways:
                    refs[item.id] = [node.ref for node in item.nodes]
    found = {f"way/{way}": refs[way] for way in ways if way in refs}
    for relation, (nodes, of_ways) in members.items():
        found[f"relation/{relation}"] = [*nodes, *(ref for way in of_ways for ref in refs.get(way, ()))]
    return found


def element_places(path: Path, frame: LocalFrame, osm_ids: Iterable[str]) -> dict[str, FloatArray]:
    """Return the local x, y (n, 2), m, of the nodes that elements (``node/1``, ``way/2``, ``relation/3``) consist of.

    Elements of which the file has no node are left out. Raises InputError if the file cannot be read.
    """
    file = open_osm_file(path)
    numbers: dict[str, set[int]] = {"node": set(), "way": set(), "relation": set()}
    for osm_id in osm_ids:
        kind, _, number = osm_id.partition("/")
        numbers[kind].add(int(number))
    refs = {f"node/{number}": [number] for number in sorted(numbers["node"])}
    refs |= _read_refs(file, numbers["way"], numbers["relation"])
    if not refs:
        return {}
    wanted = np.array([ref for item in refs.values() for ref in item], np.int64)
    nodes = read_nodes(file, sorted_unique(wanted))
    xy = np.column_stack(projection.to_local(frame, nodes.lon_deg, nodes.lat_deg))
    known = np.isin(wanted, nodes.ids)
    place = np.searchsorted(nodes.ids, wanted)
    owner = repeated([len(item) for item in refs.values()])[known]
    border = np.searchsorted(owner, np.arange(1, len(refs)))
    rows = np.split(place[known], border)
    return {osm_id: xy[found] for osm_id, found in zip(refs, rows, strict=True) if len(found)}


@forgiving
def read_nodes(
    file: OsmFile,
    ids: IntArray,
    keys: AbstractSet[str] = frozenset(),
    more_keys: AbstractSet[str] = frozenset(),
    also: Callable[[Mapping[str, str]], bool] | None = None,
) -> RawNodes:
    """Read the nodes with given ids (n,), ascending, each once; those without a valid position count as absent.

    Tags with `keys` are kept, and those with `more_keys` of nodes that have one of `keys`; `also` decides by these
    tags which further nodes are read. Raises InputError if the file is damaged or incomplete.
    """
    deleted = np.array([number for kind, number in file.deleted if kind == "node"], np.int64)
    ids = ids[~np.isin(ids, deleted)]
    # Positions are collected in C++. Negative ids are not kept.
    with readable(file):
        nodes = osmium.FileProcessor(handle(file), osmium.osm.NODE)
        header = nodes.header
        is_sorted = header.get("sorting", "") == "Type_then_ID"
        # A map has three times the size, but keeps the last version of nodes that occur several times.
        once = is_sorted and not header.has_multiple_object_versions
        nodes.with_locations("sparse_mem_array" if once else "sparse_mem_map")
        if not len(ids) or ids[0] >= 0:
            only_ways = osmium.filter.EntityFilter(osmium.osm.WAY)
            nodes.with_filter(osmium.filter.KeyFilter(*sorted(keys)) if keys else only_ways)
        tags, negative = _tagged(nodes, keys, more_keys)
    if also is not None:
        further = np.array([number for number, found in tags.items() if also(found)], np.int64)
        ids = np.union1d(ids, further[~np.isin(further, deleted)])
    table: Any = nodes.node_location_storage
    if has_repeated_nodes(file, table):
        for number, location in repeated_nodes(file, ids).items():
            if number < 0:
                negative[number] = location
            else:
                table.set(number, location)
    present, places = array("q"), array("q")
    for number in np.ascontiguousarray(ids).data:
        if number < 0:
            if number not in negative:
                continue
            location = negative[number]
        else:
            try:
                location = table.get(number)
            except KeyError:
                continue
        present.append(number)
        places.append(location.x)
        places.append(location.y)
    lon_lat = np.array(places, np.int64).reshape(-1, 2) / UNITS_PER_DEGREE
    valid = (np.abs(lon_lat) <= (180.0, 90.0)).all(axis=1)
    kept = np.array(present, np.int64)[valid]
    tagged = np.array(sorted(tags), np.int64)
    known = tagged[np.isin(tagged, kept)].tolist()
    return RawNodes(
        kept,
        np.ascontiguousarray(lon_lat[valid, 0]),
        np.ascontiguousarray(lon_lat[valid, 1]),
        {number: tags[number] for number in known},
    )


def _tagged(
    nodes: Any, keys: AbstractSet[str], more_keys: AbstractSet[str]
) -> tuple[dict[int, dict[str, str]], dict[int, Any]]:
    """Return the tags of nodes, and the positions of those with negative ids, which libosmium does not keep."""
    tags: dict[int, dict[str, str]] = {}
    negative: dict[int, Any] = {}
    kept = keys | more_keys
    for node in nodes:
        number = node.id
        found = {key: value for key, value in all_tags(node) if key in kept}
        if found and (not more_keys or not keys.isdisjoint(found)):
            tags[number] = found
        if number < 0:
            negative[number] = node.location
    return tags, negative


class Contents(NamedTuple):
    """What a file has, for messages when there is no street in it."""

    nodes: int
    highways: Counter[str]  # How many ways there are, by value of ``highway``
    lanelets: int  # Relations of Lanelet2, whose maps are written in OSM's format


@forgiving
def count_contents(file: OsmFile) -> Contents:
    """Count what a file has."""
    item: Any
    highways: Counter[str] = Counter()
    lanelets = 0
    with readable(file):
        found = osmium.FileProcessor(handle(file), osmium.osm.WAY | osmium.osm.RELATION)
        for item in found.with_filter(osmium.filter.KeyFilter("highway", "type")):
            if item.is_way() and "highway" in item.tags:
                highways[item.tags["highway"]] += 1
            lanelets += item.is_relation() and item.tags.get("type") == _LANELET
        nodes = sum(1 for _ in osmium.FileProcessor(handle(file), osmium.osm.NODE))
    return Contents(nodes, highways, lanelets)


def _other_way(item: Any, others: OtherWays) -> RawWay | None:
    every = item.tags
    if not any(key in every for key in others.every) and not any(
        every.get(key) in values for key, values in others.values.items()
    ):
        return None
    tags = _tags(item, others.keys)
    if others.wanted(tags):
        return RawWay(item.id, _refs(item), tags)
    return RawWay(item.id, (), tags) if others.named(tags) else None


def _tags(item: Any, keys: AbstractSet[str]) -> dict[str, str]:
    # Sorted: results must not depend on the order of tags in the file.
    found = {key: value for key, value in all_tags(item) if key in keys}
    return dict(sorted(found.items()))


def _refs(item: Any) -> Sequence[int]:
    nodes = item.nodes
    # Not `for node in nodes`, which makes two more calls per node.
    return array("q", [node.ref for node in map(nodes.__getitem__, range(len(nodes)))])


def _relation(item: Any) -> RawRelation:
    members = tuple(
        RawMember(_MEMBER_TYPES.get(member.type, member.type), member.ref, member.role) for member in item.members
    )
    return RawRelation(item.id, members, dict(all_tags(item)))


def longer_or_newer(
    file: OsmFile, one: tuple[int, RawWay | None], other: tuple[int, RawWay | None]
) -> tuple[int, RawWay | None]:
    """Return which of two ways with one id, (version, way), is taken; deleted ones are None."""
    first, second = one[1], other[1]
    named = second or first
    if one[0] != other[0]:
        if named is not None:
            file.content.several_versions.add(f"way/{named.id}")
        return max(one, other, key=lambda item: item[0])
    if first is None or second is None:
        return other
    of_nodes, of_tags = list(first.refs) != list(second.refs), first.tags != second.tags
    if of_nodes or of_tags:
        what = "nodes" if of_nodes else "tags"
        taken = "the longest one" if len(first.refs) != len(second.refs) else "the last one"
        file.content.repeated[f"way/{second.id}"] = f"with different {what}; {taken} is taken"
    return one if len(first.refs) > len(second.refs) else other


@lru_cache
def _memory_of_one() -> int:
    """Return how much memory a node takes in the table of positions, bytes: it does not say how many it has."""
    table: Any = osmium.index.create_map("sparse_mem_map")
    table.set(1, osmium.osm.Location(0.0, 0.0))
    return int(table.used_memory())


def has_repeated_nodes(file: OsmFile, table: Any) -> bool:
    """Whether a file has more nodes than its table of positions; False where they were not counted."""
    return file.content.nodes is not None and file.content.nodes != table.used_memory() // _memory_of_one()


class _Node(NamedTuple):
    """One of several nodes with the same id."""

    version: int
    location: Any
    tags: dict[str, str]


def repeated_nodes(file: OsmFile, ids: IntArray) -> dict[int, Any]:
    """Return the positions of those of some nodes (ids) that stand in a file more than once; record what differs."""
    with readable(file):
        numbers = np.fromiter((node.id for node in osmium.FileProcessor(handle(file), osmium.osm.NODE)), np.int64)
        unique, counts = unique_counts(numbers)
        repeated = set(np.intersect1d(unique[counts > 1], ids).tolist())
        found: dict[int, list[_Node]] = {}
        node: Any
        for node in osmium.FileProcessor(handle(file), osmium.osm.NODE) if repeated else ():
            if node.id in repeated and node.location.valid():
                one = _Node(node.version, node.location, dict(all_tags(node)))
                found.setdefault(node.id, []).append(one)
    taken = {}
    for number, nodes in sorted(found.items()):
        newest = [node for node in nodes if node.version == max(other.version for other in nodes)]
        last = newest[-1]
        if len(newest) < len(nodes):
            file.content.several_versions.add(f"node/{number}")
        elsewhere = any((node.location.x, node.location.y) != (last.location.x, last.location.y) for node in newest)
        if elsewhere or any(node.tags != last.tags for node in newest):
            what = "positions" if elsewhere else "tags"
            file.content.repeated[f"node/{number}"] = f"with different {what}; the last one is taken"
        taken[number] = last.location
    return taken
