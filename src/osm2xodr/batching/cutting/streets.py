"""Segments of all ways of a map, the streets that they make up, and an index of where ways and nodes are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.batching.cutting.source import Source
from osm2xodr.curves import connected_groups, owners, ranks, repeated, runs, sorted_unique
from osm2xodr.model import BoolArray, FloatArray, IntArray, freeze_arrays

# Side of the cells of the index, degrees: about 1 km, so that most ways are in one or two of them.
_CELL_DEG: Final = 0.01
_COLUMNS: Final = round(360.0 / _CELL_DEG)
# A segment in more cells than these, such as one round the Earth, counts as being everywhere.
_CELLS_MAX: Final = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Straight pieces between the nodes of ways, in the order of ways."""

    first: IntArray  # (ways + 1,) Index of each way's first segment
    # (segments,) Nodes, rows of `Source.node_ids`; never the same
    start: IntArray
    end: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, slots=True, eq=False)
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


@dataclass(frozen=True, slots=True, eq=False)
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
