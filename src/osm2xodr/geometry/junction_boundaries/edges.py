"""The outer edges of roads whose sections all have the same lanes, as those through junctions; crossing lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    cubic_value,
    lengths,
    owners,
    pose,
    profile_of,
    ranks,
    repeated,
    runs,
    sine,
    starts,
)
from osm2xodr.geometry.junction_boundaries import defaults
from osm2xodr.model import CubicProfile, FloatArray, IntArray, Lane, LaneSection, RoadMap
from osm2xodr.system import record

# Lines are compared in parts of so many segments, whose bounding boxes overlap.
_SEGMENTS: Final = 6


@record(eq=False)
class Lines:
    """Lines along roads, in the direction in which their junction lies left of them."""

    start: IntArray  # (lines + 1,) Index of the first point of each line
    s: FloatArray  # (points,) m
    xy: FloatArray  # (points, 2) m

    def between(self, k: IntArray, share: FloatArray) -> FloatArray:
        """Return s at a share of the way from points k to those that follow, (n,), m."""
        return np.asarray(self.s[k] + share * (self.s[k + 1] - self.s[k]))


@record(eq=False)
class _Parts:
    """Parts of lines."""

    start: IntArray  # (lines + 1,) Index of each line's first part
    # (parts,) Their first segment and that behind their last, by the index of the point that it begins at
    begin: IntArray
    end: IntArray
    # (parts, 2) Bounding box, m
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, lines: Lines) -> _Parts:
        """Return all parts of lines."""
        count = -(-(np.diff(lines.start) - 1) // _SEGMENTS)
        owner = owners(starts(count))
        begin = lines.start[:-1][owner] + _SEGMENTS * ranks(count)
        end = np.minimum(begin + _SEGMENTS, lines.start[1:][owner] - 1)
        points, first = lines.xy[runs(begin, end + 1 - begin)], starts(end + 1 - begin)[:-1]
        return cls(starts(count), begin, end, np.minimum.reduceat(points, first), np.maximum.reduceat(points, first))


def near_segments(one: Lines, other: Lines, row: IntArray, line: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pairs of segments of lines `row` of one and `line` of the other that may cross.

    Segments are named by the index of the point that they begin at, the third is the index of the pair of lines.
    """
    if not len(row):
        return row, line, row
    p, q = _Parts.of(one), _Parts.of(other)
    a, b, pair = products(p.start[row], p.start[row + 1], q.start[line], q.start[line + 1])
    near = ((p.low[a] <= q.high[b]) & (q.low[b] <= p.high[a])).all(axis=1)
    a, b, pair = a[near], b[near], pair[near]
    i, j, part = products(p.begin[a], p.end[a], q.begin[b], q.end[b])
    return i, j, pair[part]


def products(
    first: IntArray, last: IntArray, other_first: IntArray, other_last: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return all pairs of the numbers of two ranges each, up to before their last, and the ranges' index."""
    count = other_last - other_first
    pairs = (last - first) * count
    owner, rank = owners(starts(pairs)), ranks(pairs)
    return first[owner] + rank // count[owner], other_first[owner] + rank % count[owner], owner


def crossings(one: Lines, other: Lines, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where segments a of one and b of the other cross, as shares of either; NaN where they do not.

    The third is positive where the other one goes over to the left, negative where to the right.
    """
    p, q = one.xy[a], other.xy[b]
    along, across, between = one.xy[a + 1] - p, other.xy[b + 1] - q, q - p
    turned = _cross(along, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = _cross(between, across) / turned, _cross(between, along) / turned
        none = ~((u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0))
    u[none] = np.nan
    return u, v, turned


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@record(eq=False)
class Edges:
    """The edges of connecting roads, right and left of all of their lanes."""

    road_map: RoadMap
    road: IntArray  # (n,) Index of each connecting road in the road map
    length: FloatArray  # (n,) m
    lane: IntArray  # (2 n,) Id of the outermost lane of each edge: 0, the centre lane, where there is none
    start: IntArray  # (n + 1,) Index of each road's first lane in these columns
    right: IntArray  # (lanes,) 0 for those right of the centre lane, 1 left of it, -1 for the centre lane
    widths: CubicProfile  # (lanes,)

    @classmethod
    def of(cls, road_map: RoadMap) -> Edges:
        """Return the edges of all roads of a road map that connect others."""
        joined = (
            k
            for k, item in enumerate(road_map.roads)
            if item.junction is not None and item.predecessor is not None and item.successor is not None
        )
        road = np.array(list(joined), np.int64)
        lanes = [_whole_lanes(road_map.roads[k].lane_sections) for k in road.tolist()]
        number = np.array([lane.id for lane in chain.from_iterable(lanes)], np.int64)
        outer = [(min(item[-1].id, 0), max(item[0].id, 0)) for item in lanes]
        return cls(
            road_map,
            road,
            lengths(road_map.plan_view, road),
            np.array(outer, np.int64).reshape(-1),
            starts([len(item) for item in lanes]),
            np.where(number == 0, -1, number > 0),
            profile_of([lane.widths for item in lanes for lane in item]),
        )

    def at(self, edge: IntArray, s: FloatArray, inwards: float = 0.0) -> FloatArray:
        """Return x, y (n, 2) at s of edges (n,), or so far inside of them, m."""
        row, left = edge // 2, edge % 2
        road, count = self.road[row], np.diff(self.start)[row]
        owner, lane = repeated(count), runs(self.start[row], count)
        beyond = np.flatnonzero(self.right[lane] == left[owner])
        owner, lane = owner[beyond], lane[beyond]
        wide = np.bincount(owner, cubic_value(self.widths, lane, s[owner]), len(row)) - inwards
        t = cubic_value(self.road_map.lane_offset, road, s) + np.where(left, wide, -wide)
        x, y, hdg = pose(self.road_map.plan_view, road, s)
        return np.column_stack([x - t * sine(hdg), y + t * cosine(hdg)])


def _whole_lanes(sections: Sequence[LaneSection]) -> tuple[Lane, ...]:
    """Return the lanes of a road all of whose sections have the same ones, with their widths along the road."""
    first, *others = sections
    if not others:
        return first.lanes
    return tuple(
        replace(
            lane, widths=tuple(replace(item, s=part.s + item.s) for part in sections for item in part.lanes[k].widths)
        )
        for k, lane in enumerate(first.lanes)
    )


def edge_lines(edges: Edges, edge: IntArray) -> Lines:
    """Return whole edges as lines."""
    length = edges.length[edge // 2]
    left = edge % 2 == 1
    return lines_along(edges, edge, np.where(left, length, 0.0), np.where(left, 0.0, length), defaults.EDGE_SPACING)


def lines_along(edges: Edges, edge: IntArray, begin: FloatArray, end: FloatArray, spacing: float) -> Lines:
    """Return edges from s = begin to s = end as lines of places at most `spacing` apart, m."""
    count = np.maximum(np.ceil(np.abs(end - begin) / spacing).astype(np.int64), 1) + 1
    start = starts(count)
    owner = owners(start)
    s = begin[owner] + (ranks(count) / (count - 1)[owner]) * (end - begin)[owner]
    return Lines(start, s, edges.at(edge[owner], s))
