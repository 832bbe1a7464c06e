"""Boundaries of junctions as records of a road map."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import unique_first, unique_inverse
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.boundaries import defaults
from osm2xodr.geometry.boundaries.arms import Arms, lanes_across
from osm2xodr.geometry.boundaries.bulges import around_bulges
from osm2xodr.geometry.boundaries.corners import Pieces, find_pieces
from osm2xodr.geometry.boundaries.edges import Edges
from osm2xodr.model import BoolArray, BoundaryEdge, BoundaryJoint, FloatArray, RoadMap

# Decimals of the places where edges meet, m.
_DECIMALS: Final = 3


def find_boundaries(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return a road map whose junctions know their boundary, as `with_boundaries` says."""
    edges = Edges.of(road_map)
    if not len(edges.road):
        return road_map
    arms = Arms.of(road_map, edges)
    pieces = around_bulges(arms, edges, find_pieces(arms, edges))
    lanes, right, left = lanes_across(road_map, arms)
    closed = _closed(arms, edges, pieces, right, left)
    roads, segments = road_map.roads, _edge_segments(road_map, edges, pieces)
    found: dict[int, list[BoundaryEdge | BoundaryJoint]] = {}
    order = np.lexsort((arms.rank, arms.junction))
    for k in order[closed[order]].tolist():
        across = lanes[k] or (None, None)
        joint = BoundaryJoint(roads[arms.road[k]].id, bool(arms.at_start[k]), *across)
        found.setdefault(int(arms.junction[k]), []).extend([joint, *segments[k]])
    junctions = tuple(replace(item, boundary=tuple(found.get(item.id, ()))) for item in road_map.junctions)
    if len(found) < len(junctions):
        open_ = len(junctions) - len(found)
        said = f"{open_} of {len(junctions)} junctions have no boundary: their roads leave gaps between arms"
        diagnostics.note("junction-boundary", "", said)
    return replace(road_map, junctions=junctions)


def _closed(arms: Arms, edges: Edges, pieces: Pieces, right: FloatArray, left: FloatArray) -> BoolArray:
    """Say for which arms the boundary of their junction is closed, (arms,); u of their joints' ends, (arms,), m."""
    good = pieces.gap <= defaults.CLOSED_WITHIN
    arm, begin = unique_first(pieces.arm)
    last = np.append(begin[1:], len(pieces.arm)) - 1
    for face, u, row, s in (
        (arm, left, begin, pieces.begin),
        (arms.following[arm], right, last, pieces.end),
    ):
        off = np.hypot(*(edges.at(pieces.edge[row], s[row]) - arms.at(face, u[face])).T)
        good &= off <= defaults.CLOSED_WITHIN
    group = unique_inverse(arms.junction)[1]
    bad = np.bincount(group[~good], minlength=int(group.max()) + 1) > 0
    return ~bad[group]


def _edge_segments(road_map: RoadMap, edges: Edges, pieces: Pieces) -> dict[int, list[BoundaryEdge]]:
    """Return the segments along connecting roads behind each arm."""
    out: dict[int, list[BoundaryEdge]] = {}
    length = edges.length[pieces.edge // 2]
    s = [np.where(v >= length, np.inf, v.round(_DECIMALS)) for v in (pieces.begin, pieces.end)]
    columns = pieces.arm, edges.road[pieces.edge // 2], edges.lane[pieces.edge], *s
    for arm, road, *rest in zip(*(column.tolist() for column in columns), strict=True):
        out.setdefault(arm, []).append(BoundaryEdge(road_map.roads[road].id, *rest))
    return out
