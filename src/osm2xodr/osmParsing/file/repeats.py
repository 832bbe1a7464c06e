"""Elements that stand in a file more than once, as where extracts were pasted together: which one is taken."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import osmium

from osm2xodr.curves import unique_counts
from osm2xodr.model import IntArray
from osm2xodr.osmParsing.file.access import all_tags, handle, readable
from osm2xodr.osmParsing.file.file_format import OsmFile
from osm2xodr.osmParsing.file.raw import RawWay


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
