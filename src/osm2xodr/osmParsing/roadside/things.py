"""Footways and things beside streets, selected from a file's ways and nodes near them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set as AbstractSet
from typing import Final

import numpy as np

from osm2xodr.curves import (
    hypot,
    repeated,
    sorted_unique,
    unique_all,
)
from osm2xodr.model import FloatArray, Footway, IntArray, RoadsideKind, RoadsideThing
from osm2xodr.osmParsing.file import OtherWays, RawNodes, RawWay
from osm2xodr.osmParsing.roadside.reach import StreetSamples, near_streets
from osm2xodr.osmParsing.roadside.tags import (
    BESIDE_TAGS,
    footway_tags,
    is_building,
    is_carriageway_area,
    is_crossing,
    is_footway,
    is_kerb,
    kerb_values,
    kind_of_node,
    kind_of_way,
    thing_tags,
    way_values,
)
from osm2xodr.osmParsing.tags import read_thing_facts

# Nodes of the smallest area, the first one at the end again.
_LEAST_OF_AREA: Final = 4


def ways_beside(streets: AbstractSet[str], extra: AbstractSet[str], fronts: bool) -> OtherWays:
    """Return which ways are read besides those whose ``highway`` is among `streets`.

    `extra` are kinds of things read on request: ``lamps``, ``trees``; `fronts` says whether buildings are read.
    """
    values = way_values(streets, extra)

    def wanted(tags: Mapping[str, str]) -> bool:
        read = any(tags.get(key) in names for key, names in values.items())
        if read and (is_footway(tags) or kind_of_way(tags) is not None or _bounds_carriageways(tags)):
            return True
        return fronts and is_building(tags)

    return OtherWays(values, BESIDE_TAGS, wanted, frozenset({"building"}) if fronts else frozenset())


def kerbs_beside() -> OtherWays:
    """Return which ways are read besides streets if nothing but their widths is asked for."""
    return OtherWays(kerb_values(), BESIDE_TAGS, _bounds_carriageways)


def _bounds_carriageways(tags: Mapping[str, str]) -> bool:
    return is_kerb(tags) or is_carriageway_area(tags)


def read_beside(
    ways: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
    samples: StreetSamples,
    carried: IntArray,
    extra: AbstractSet[str],
    country: str,
) -> tuple[tuple[Footway, ...], tuple[RoadsideThing, ...]]:
    """Select the footways (ascending in id) and things (in kind and id, nodes before ways) within reach of streets.

    `ways` are those of `ways_beside`, `points` (n, 2) the local x, y of the nodes, m, `samples` points along the
    streets, `carried` (m,) the OSM ids of nodes on streets, ascending. `extra` are the kinds of things read on
    request; `country` (ISO 3166-1 alpha-2) says whose signs they are.
    """
    ways = [way for way in ways if is_footway(way.tags) or kind_of_way(way.tags) is not None]
    lengths = np.array([len(way.refs) for way in ways], np.int64)
    refs = np.concatenate([np.zeros(0, np.int64), *[way.refs for way in ways]])
    row = np.searchsorted(nodes.ids, refs)
    row[row == len(nodes.ids)] = 0
    present = (nodes.ids[row] == refs) & np.isfinite(points[row]).all(axis=1)
    row, way = row[present], repeated(lengths)[present]
    # Nodes that are things and not on streets.
    single_ids = np.array([number for number, tags in nodes.tags.items() if kind_of_node(tags, extra)], np.int64)
    single = np.searchsorted(nodes.ids, single_ids[~np.isin(single_ids, carried)])
    asked = sorted_unique(np.concatenate([row, single]))
    near = np.zeros(len(nodes.ids), np.bool_)
    near[asked] = near_streets(samples, points[asked])
    things = [_node(int(index), nodes, points, extra, country) for index in single[near[single]].tolist()]
    near[np.searchsorted(nodes.ids, carried)] = True
    reached = np.zeros(len(ways), np.bool_)
    reached[way[near[row]]] = True
    row, way = row[reached[way]], way[reached[way]]
    # Consecutive nodes at one place count once.
    again = np.zeros(len(row), np.bool_)
    again[1:] = (way[1:] == way[:-1]) & (points[row[1:]] == points[row[:-1]]).all(axis=1)
    row, way = row[~again], way[~again]
    ids, places = nodes.ids[row], points[row]
    numbers, begin, _, count = unique_all(way)
    footways: list[Footway] = []
    for number, first, size in zip(numbers.tolist(), begin.tolist(), count.tolist(), strict=True):
        # A way of a single node has no extent.
        if size > 1:
            _add_way(ways[number], ids[first : first + size], places[first : first + size], footways, things)

    def order(thing: RoadsideThing) -> tuple[str, str, int]:
        element, _, number = thing.osm_id.partition("/")
        return thing.kind.value, element, int(number)

    return tuple(footways), tuple(sorted(things, key=order))


def _node(index: int, nodes: RawNodes, points: FloatArray, extra: AbstractSet[str], country: str) -> RoadsideThing:
    ids, points = nodes.ids[index : index + 1].copy(), points[index : index + 1].copy()
    tags = nodes.tags[int(ids[0])]
    kind = kind_of_node(tags, extra)
    assert kind is not None
    facts = read_thing_facts(kind, thing_tags(kind, tags), country)
    return RoadsideThing(kind, f"node/{ids[0]}", points, ids, facts)


def _add_way(
    way: RawWay, ids: IntArray, points: FloatArray, footways: list[Footway], things: list[RoadsideThing]
) -> None:
    """Add a way to the footways or the things, or to both."""
    if is_footway(way.tags):
        footways.append(Footway(way.id, is_crossing(way.tags), points, ids, footway_tags(way.tags)))
    kind = kind_of_way(way.tags)
    if kind is None or (kind is RoadsideKind.ISLAND and (len(ids) < _LEAST_OF_AREA or ids[0] != ids[-1])):
        return
    facts = read_thing_facts(kind, thing_tags(kind, way.tags), "")
    if kind is RoadsideKind.BUS_STOP:
        # Of a platform's outline or line only the middle is kept.
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))[None, :]
        nearest = int(np.argmin(hypot(*(points - middle).T)))
        points, ids = middle, ids[nearest : nearest + 1]
    things.append(RoadsideThing(kind, f"way/{way.id}", points, ids, facts))
