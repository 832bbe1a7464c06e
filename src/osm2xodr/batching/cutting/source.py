"""Reads the part of a map that conversions and scenes use into flat arrays: ways, relations, positions of nodes.

There are no objects per node, and nodes without a way of interest are left out, so that a country fits into memory.
`Streets` are the segments of all ways, the streets that they make up, and an index of where ways and nodes are.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set as AbstractSet
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
import osmium

from osm2xodr.curves import connected_groups, owners, ranks, repeated, runs, sorted_unique, starts
from osm2xodr.model import BoolArray, FloatArray, IntArray, freeze_arrays
from osm2xodr.osmParsing import (
    AREA_TYPE,
    HIGHWAYS,
    RELATION_TYPES,
    UNITS_PER_DEGREE,
    OsmFile,
    WaySelection,
    all_tags,
    class_of,
    forgiving,
    handle,
    in_surroundings,
    is_thing,
    node_keys,
    readable,
    reason_left_out,
    way_values,
)
from osm2xodr.system import record

# What conversions read on request; a cut has all of it.
_EXTRA: Final = frozenset({"lamps", "trees"})
# In files larger than this, bytes, libosmium picks the nodes by a set of ids. The set takes a gigabyte whatever is in
# it, so all nodes of smaller files are read.
_LARGE: Final = 100_000_000
# Below all ids; libosmium's order has negative ids first, the lowest last.
_FIRST: Final = -(2**62)

# Side of the cells of the index, degrees: about 1 km, so that most ways are in one or two of them.
_CELL_DEG: Final = 0.01
_COLUMNS: Final = round(360.0 / _CELL_DEG)
# A segment in more cells than these, such as one round the Earth, counts as being everywhere.
_CELLS_MAX: Final = 10_000


class Driven(NamedTuple):
    """Which ways become streets."""

    ways: WaySelection | None = None  # By their tags; None for all that a car fits on
    include_private: bool = False  # Whether those closed to the public do
    kept: frozenset[int] = frozenset()  # OSM ids of ways that do in any case


@record(eq=False)
class Source:
    """The part of a map that is of use; ways and relations are those that `ways_and_relations_of` yields."""

    file: OsmFile  # The map
    way_ids: IntArray  # (ways,) OSM ids
    way_current: BoolArray  # (ways,) Whether the way is neither deleted nor replaced by a newer version
    way_read: BoolArray  # (ways,) Whether conversions read the way; scenes alone have the others
    way_shown: BoolArray  # (ways,) Whether the way is a building or water of scenes by its own tags
    first: IntArray  # (ways + 1,) Index of each way's first entry in `row`
    row: IntArray  # (refs,) Nodes of the ways, rows of `node_ids`, without nodes that are not in the file
    driven: Mapping[Driven, BoolArray]  # (ways,) Which ways become streets, by selection
    relation_ids: IntArray  # (relations,) OSM ids
    relation_current: BoolArray  # (relations,) As `way_current`
    relation_read: BoolArray  # (relations,) As `way_read`; the others are multipolygons of scenes
    # OSM ids of the ways of these multipolygons; None where only what conversions read was asked for
    outlines: AbstractSet[int] | None
    # Of each relation: ids of its members
    member_ways: Sequence[IntArray]
    member_nodes: Sequence[IntArray]
    node_ids: IntArray  # (nodes,) OSM ids of the nodes of ways and of `thing`, ascending
    # (nodes,) Their positions, whole units of 1e-7 degrees, WGS 84
    lon: IntArray
    lat: IntArray
    # (nodes,) Position of each among those that `nodes_of` returns; empty where nodes stand in the order of their
    # ids, none of them negative
    node_at: IntArray
    thing: BoolArray  # (nodes,) Whether the node is of interest by itself
    in_order: bool  # Whether the file has all of this in the order of ids, ways before relations

    def __post_init__(self) -> None:
        freeze_arrays(self)

    def degrees(self, rows: IntArray | slice = slice(None)) -> tuple[FloatArray, FloatArray]:
        """Return longitude and latitude of nodes, degrees."""
        return self.lon[rows] / UNITS_PER_DEGREE, self.lat[rows] / UNITS_PER_DEGREE


@dataclass(slots=True)
class _Ways:
    """What is collected of ways."""

    ids: array[int]
    versions: array[int]
    gone: array[int]
    read: array[int]
    shown: array[int]
    lengths: array[int]
    refs: array[int]
    driven: dict[Driven, array[int]]


@dataclass(slots=True)
class _Relations:
    """What is collected of relations."""

    ids: array[int]
    versions: array[int]
    gone: array[int]
    read: array[int]
    ways: list[IntArray]
    nodes: list[IntArray]


def ways_and_relations_of(file: OsmFile, outlines: AbstractSet[int] | None) -> Iterator[tuple[Any, bool]]:
    """Yield ways and relations of interest in the order of the file, all versions, and whether conversions read them.

    Each is valid until the next. `outlines` is that of `Source`.
    """
    values = _other_values()
    only_ways = osmium.filter.KeyFilter("highway", *values)
    only_ways.enable_for(osmium.osm.WAY)
    kinds = RELATION_TYPES if outlines is None else (*RELATION_TYPES, AREA_TYPE)
    only_relations = osmium.filter.TagFilter(*(("type", value) for value in kinds))
    only_relations.enable_for(osmium.osm.RELATION)
    found = osmium.FileProcessor(handle(file), osmium.osm.WAY | osmium.osm.RELATION).with_filter(only_relations)
    if outlines is None:
        found = found.with_filter(only_ways)
    wanted = [(key, value) for key, names in sorted(values.items()) for value in sorted(names)]
    item: Any
    for item in found:
        tags = item.tags
        if item.is_relation():
            read = tags.get("type") in RELATION_TYPES
        else:
            read = "highway" in tags or any(tags.get(key) == value for key, value in wanted)
        if read or (outlines is not None and (in_surroundings(tags) or (item.is_way() and item.id in outlines))):
            yield item, read


def _other_values() -> dict[str, frozenset[str]]:
    """Return the values by key of which a way without ``highway`` must have one to be read by conversions."""
    values = way_values(frozenset(), _EXTRA)
    del values["highway"]
    return values


def without_roads(tags: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return the tags of a way without those for which conversions would read it."""
    values = _other_values()
    return {key: value for key, value in tags if key != "highway" and value not in values.get(key, ())}


def nodes_of(file: OsmFile, ids: IntArray) -> Iterable[Any]:
    """Return the nodes with some ids (n,), ascending, in the order of the file, all versions; of small files all."""
    found = osmium.FileProcessor(handle(file), osmium.osm.NODE)
    # Sets of ids hold none below 0.
    if len(ids) and ids[0] >= 0 and file.path.stat().st_size > _LARGE:
        found.with_filter(osmium.filter.IdFilter(np.ascontiguousarray(ids).data))
    return found


@forgiving
def read_source(file: OsmFile, driven: Iterable[Driven], *, surroundings: bool = False) -> Source:
    """Read the part of a map that conversions use; `driven` are selections of ways that become streets.

    `surroundings` reads what scenes have beside roads as well. Raises `InputError` if the file is damaged or
    incomplete.
    """
    choices = tuple(dict.fromkeys(driven))
    with readable(file):
        outlines = _read_outlines(file) if surroundings else None
        ways, relations, mixed = _read_ways_and_relations(file, choices, outlines)
        things = _read_things(file)
        refs = np.array(ways.refs, np.int64)
        ids, lon, lat, node_at, ordered = _read_nodes(file, np.union1d(refs, things))
    first, row = _rows(ids, refs, np.array(ways.lengths, np.int64))
    way_ids, relation_ids = np.array(ways.ids, np.int64), np.array(relations.ids, np.int64)
    return Source(
        file=file,
        way_ids=way_ids,
        way_current=_current(way_ids, ways.versions, ways.gone, ways.lengths),
        way_read=np.array(ways.read, np.bool_),
        way_shown=np.array(ways.shown, np.bool_),
        first=first,
        row=row,
        driven={choice: np.array(found, np.bool_) for choice, found in ways.driven.items()},
        relation_ids=relation_ids,
        relation_current=_current(relation_ids, relations.versions, relations.gone),
        relation_read=np.array(relations.read, np.bool_),
        outlines=outlines,
        member_ways=relations.ways,
        member_nodes=relations.nodes,
        node_ids=ids,
        lon=lon,
        lat=lat,
        node_at=node_at,
        thing=np.isin(ids, things),
        in_order=ordered and not mixed and _ascending(way_ids) and _ascending(relation_ids),
    )


def _read_outlines(file: OsmFile) -> frozenset[int]:
    """Return the ids of the ways of all multipolygons that scenes show."""
    found: Any = osmium.FileProcessor(handle(file), osmium.osm.RELATION)
    found.with_filter(osmium.filter.TagFilter(("type", AREA_TYPE)))
    return frozenset(
        member.ref for item in found if in_surroundings(item.tags) for member in item.members if member.type == "w"
    )


def _read_ways_and_relations(
    file: OsmFile, choices: Sequence[Driven], outlines: AbstractSet[int] | None
) -> tuple[_Ways, _Relations, bool]:
    """Read ways and relations, and return whether any relation stands before a way as well."""
    ways = _Ways(
        *(array("q"), array("q"), array("b"), array("b"), array("b")),
        *(array("q"), array("q"), {choice: array("b") for choice in choices}),
    )
    relations = _Relations(array("q"), array("q"), array("b"), array("b"), [], [])
    mixed = False
    for item, read in ways_and_relations_of(file, outlines):
        if item.is_way():
            mixed |= len(relations.ids) > 0
            _add_way(item, file, ways, read, outlines is not None and in_surroundings(item.tags))
        else:
            _add_relation(item, file, relations, read)
    return ways, relations, mixed


def _add_way(way: Any, file: OsmFile, out: _Ways, read: bool, shown: bool) -> None:
    tags = {**dict(all_tags(way)), "highway": first} if (first := class_of(way.tags)) in HIGHWAYS else None
    number = way.id
    on = [
        (read and number in choice.kept) or (tags is not None and _is_driven(tags, choice)) for choice in out.driven
    ]
    out.ids.append(number)
    out.versions.append(way.version)
    out.gone.append(way.deleted or ("way", number) in file.deleted)
    out.read.append(read)
    out.shown.append(shown)
    nodes = way.nodes
    out.lengths.append(len(nodes))
    # Not `for node in nodes`, which takes two more calls for each.
    out.refs.extend([node.ref for node in map(nodes.__getitem__, range(len(nodes)))])
    for found, is_on in zip(out.driven.values(), on, strict=True):
        found.append(is_on)


def _add_relation(relation: Any, file: OsmFile, out: _Relations, read: bool) -> None:
    number = relation.id
    out.ids.append(number)
    out.versions.append(relation.version)
    out.gone.append(relation.deleted or ("relation", number) in file.deleted)
    out.read.append(read)
    members = [(member.type, member.ref) for member in relation.members]
    for kind, refs in (("w", out.ways), ("n", out.nodes)):
        refs.append(np.array([ref for of_kind, ref in members if of_kind == kind], np.int64))


def _is_driven(tags: Mapping[str, str], choice: Driven) -> bool:
    ways = choice.ways
    return ways is None or (
        tags["highway"] in ways.highways and reason_left_out(tags, ways, choice.include_private) is None
    )


def _read_things(file: OsmFile) -> IntArray:
    """Return the ids of nodes that are of interest by themselves."""
    keys, _ = node_keys(True, _EXTRA)
    found = osmium.FileProcessor(handle(file), osmium.osm.NODE)
    found.with_filter(osmium.filter.KeyFilter(*sorted(keys)))
    return np.array(array("q", (node.id for node in found if is_thing(dict(all_tags(node)), _EXTRA))), np.int64)


def _read_nodes(file: OsmFile, needed: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray, bool]:
    """Return ids, `lon`, `lat` and `node_at` of nodes as in `Source`, and whether they stand in the order of ids."""
    numbers, versions, gone, places = array("q"), array("q"), array("b"), array("q")
    for node in nodes_of(file, needed):
        location = node.location
        numbers.append(node.id)
        versions.append(node.version)
        gone.append(node.deleted)
        places.append(location.x)
        places.append(location.y)
    ids, place = np.array(numbers, np.int64), np.array(places, np.int64).reshape(-1, 2)
    deleted = np.array([number for kind, number in file.deleted if kind == "node"], np.int64)
    valid = (np.abs(place / UNITS_PER_DEGREE) <= (180.0, 90.0)).all(axis=1)
    ordered = _ascending(ids)
    kept = _current(ids, versions, gone) & valid & np.isin(ids, needed) & ~np.isin(ids, deleted)
    at = np.flatnonzero(kept)
    at = at[np.argsort(ids[at], kind="stable")]
    by_id = ordered and not (ids < 0).any()
    lon, lat = place[at].T
    return ids[at], lon, lat, np.zeros(0, np.int64) if by_id else at, ordered


def _ascending(ids: IntArray) -> bool:
    """Return whether ids are in libosmium's order, each once: negative ones first, the lowest last."""
    place = np.where(ids < 0, _FIRST - ids, ids)
    return bool((place[1:] > place[:-1]).all())


def _current(
    ids: IntArray, versions: Sequence[int], gone: Sequence[int], lengths: Sequence[int] | None = None
) -> BoolArray:
    """Return which elements (n,) are their newest version, the longest, then last among equals, and not deleted."""
    out = ~np.array(gone, np.bool_)
    if _ascending(ids):
        return out
    size = np.zeros(len(ids), np.int64) if lengths is None else np.array(lengths, np.int64)
    order = np.lexsort((np.arange(len(ids)), size, np.array(versions, np.int64), ids))
    newest = np.zeros(len(ids), np.bool_)
    newest[order[np.append(ids[order][1:] != ids[order][:-1], True)]] = True
    return out & newest


def _rows(ids: IntArray, refs: IntArray, lengths: IntArray) -> tuple[IntArray, IntArray]:
    """Return `first` and `row` of `Source`."""
    row = np.searchsorted(ids, refs)
    row[row == len(ids)] = 0
    present = ids[row] == refs if len(ids) else np.zeros(len(refs), np.bool_)
    way = repeated(lengths)
    count = np.bincount(way[present], minlength=len(lengths))
    return starts(count), row[present]


@record(eq=False)
class Segments:
    """Straight pieces between the nodes of ways, in the order of ways."""

    first: IntArray  # (ways + 1,) Index of each way's first segment
    # (segments,) Nodes, rows of `Source.node_ids`; never the same
    start: IntArray
    end: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@record(eq=False)
class Streets:
    """Ways joined to streets, from intersection to intersection."""

    of_segment: IntArray  # (segments,) Street of each segment of `Segments`, -1 without one
    # Ways of each street, from `first_way` [street] to `first_way` [street + 1]
    first_way: IntArray
    ways: IntArray
    # Likewise: intersections and dead ends of each street, rows of `Source.node_ids`
    first_end: IntArray
    ends: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@record(eq=False)
class Cells:
    """An index of ways or nodes by cells of a grid of longitude and latitude."""

    keys: IntArray  # (entries,) Numbers of cells, ascending
    items: IntArray  # (entries,) The way or node in the cell
    everywhere: IntArray  # Items that count as being in every cell

    def __post_init__(self) -> None:
        freeze_arrays(self)


def make_segments(source: Source) -> Segments:
    """Return the segments of all ways; those that are no current version have none."""
    count = np.diff(source.first)
    way = repeated(count)
    follows = (way[1:] == way[:-1]) & (source.row[1:] != source.row[:-1]) & source.way_current[way[1:]]
    at = np.flatnonzero(follows)
    first = np.searchsorted(way[at], np.arange(len(count) + 1))
    return Segments(first, source.row[at], source.row[at + 1])


def make_streets(source: Source, segments: Segments, driven: BoolArray) -> Streets:
    """Join the `driven` ways (ways,) to streets."""
    way = owners(segments.first)
    kept = np.flatnonzero(driven[way])
    way, start, end = way[kept], segments.start[kept], segments.end[kept]
    nodes = len(source.node_ids)
    # Number of segments that begin or end at each node; a street goes on where it is two.
    degree = np.bincount(start, minlength=nodes) + np.bincount(end, minlength=nodes)
    begins = np.ones(len(kept), np.bool_)
    begins[1:] = (way[1:] != way[:-1]) | (end[:-1] != start[1:]) | (degree[start[1:]] != 2)
    piece = np.cumsum(begins) - 1
    is_first = np.flatnonzero(begins)
    is_last = np.append(is_first[1:], len(kept)) - 1 if len(kept) else is_first
    pieces = len(is_first)
    # Both ends of all pieces.
    ends = np.concatenate([start[is_first], end[is_last]])
    owner = np.tile(np.arange(pieces), 2)
    order = np.argsort(ends, kind="stable")
    ends, owner = ends[order], owner[order]
    joint = degree[ends] == 2
    # The ends of two pieces, or both of one, stand next to each other.
    one, other = owner[joint][0::2], owner[joint][1::2]
    street = connected_groups(pieces, one, other)
    count = int(street.max(initial=-1)) + 1
    of_segment = np.full(len(segments.start), -1, np.int64)
    of_segment[kept] = street[piece]
    first_way, ways = _grouped(street, way[is_first], count)
    first_end, limits = _grouped(street[owner[~joint]], ends[~joint], count)
    return Streets(of_segment, first_way, ways, first_end, limits)


def _grouped(group: IntArray, item: IntArray, groups: int) -> tuple[IntArray, IntArray]:
    """Return where each group begins, and the items of all groups in a row."""
    order = np.argsort(group, kind="stable")
    return np.searchsorted(group[order], np.arange(groups + 1)), item[order]


def make_way_cells(source: Source, segments: Segments) -> Cells:
    """Return the cells of ways: all that their segments may run through."""
    # Ways of a single node have a segment from it to itself.
    alone = np.flatnonzero((np.diff(segments.first) == 0) & (np.diff(source.first) > 0) & source.way_current)
    way = np.concatenate([owners(segments.first), alone])
    single = source.row[source.first[alone]]
    column, row = _cell(*source.degrees())
    start, end = np.concatenate([segments.start, single]), np.concatenate([segments.end, single])
    west, south = np.minimum(column[start], column[end]), np.minimum(row[start], row[end])
    wide = np.abs(column[start] - column[end]) + 1
    cells = wide * (np.abs(row[start] - row[end]) + 1)
    # Those that cross the 180th meridian are among the long ones.
    long = (cells > _CELLS_MAX) | (wide > _COLUMNS // 2)
    everywhere = sorted_unique(way[long])
    way, west, south, wide, cells = (item[~long] for item in (way, west, south, wide, cells))
    step = ranks(cells)
    again = repeated(cells)
    keys = (south[again] + step // wide[again]) * _COLUMNS + west[again] + step % wide[again]
    return _unique_cells(keys, way[again], everywhere)


def make_node_cells(source: Source, rows: IntArray) -> Cells:
    """Return the cells of nodes."""
    column, row = _cell(*source.degrees(rows))
    return _unique_cells(row * _COLUMNS + column, rows, np.zeros(0, np.int64))


def only(cells: Cells, kept: BoolArray) -> Cells:
    """Return the cells without the items (items,) that are not kept."""
    at = kept[cells.items]
    return Cells(cells.keys[at], cells.items[at], cells.everywhere[kept[cells.everywhere]])


def _cell(lon: FloatArray, lat: FloatArray) -> tuple[IntArray, IntArray]:
    column = np.floor((lon + 180.0) / _CELL_DEG).astype(np.int64)
    return np.clip(column, 0, _COLUMNS - 1), np.floor((lat + 90.0) / _CELL_DEG).astype(np.int64)


def _unique_cells(keys: IntArray, items: IntArray, everywhere: IntArray) -> Cells:
    order = np.lexsort((items, keys))
    keys, items = keys[order], items[order]
    new = np.ones(len(keys), np.bool_)
    new[1:] = (keys[1:] != keys[:-1]) | (items[1:] != items[:-1])
    return Cells(keys[new], items[new], everywhere)


def find_in_boxes(cells: Cells, boxes_deg: FloatArray) -> IntArray:
    """Return what may be in any of the boxes (boxes, 4), ascending.

    Boxes are west, south, east, north, degrees; west may be below -180, east above 180.
    """
    found = [cells.everywhere]
    for shift in (-360.0, 0.0, 360.0):
        west, east = boxes_deg[:, 0] + shift, boxes_deg[:, 2] + shift
        here = boxes_deg[(east >= -180.0) & (west <= 180.0)] + (shift, 0.0, shift, 0.0)
        if not len(here):
            continue
        left, low = _cell(here[:, 0], np.maximum(here[:, 1], -90.0))
        right, high = _cell(here[:, 2], np.minimum(here[:, 3], 90.0))
        tall = np.maximum(high - low + 1, 0)
        box = repeated(tall)
        line = runs(low, tall) * _COLUMNS
        first = np.searchsorted(cells.keys, line + left[box])
        last = np.searchsorted(cells.keys, line + right[box], side="right")
        found.append(sorted_unique(cells.items[runs(first, last - first)]))
    return sorted_unique(np.concatenate(found))
