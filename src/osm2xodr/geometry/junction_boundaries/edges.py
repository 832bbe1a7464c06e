"""The outer edges of all lanes of roads that have one lane section, as those through junctions do.

Edges are numbered: 2 k is the right edge of the k-th connecting road, 2 k + 1 its left one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

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
from osm2xodr.geometry.junction_boundaries.lines import Lines
from osm2xodr.model import CubicProfile, FloatArray, IntArray, RoadMap


@dataclass(frozen=True, slots=True, eq=False)
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
        lanes = [road_map.roads[k].lane_sections[0].lanes for k in road.tolist()]
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
