"""Edges of roads that lie over each other are cut where they cross, so that they bound areas."""

from __future__ import annotations

import numpy as np
import shapely

from osm2xodr.curves import ranks
from osm2xodr.model import FloatArray, IntArray

# Crossings as close to an end of an edge as this share of its length are at that end.
_AT_END = 1e-9


def planar_edges(points: FloatArray, edges: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points (n, 3), m, edges (m, 2) between them, and of which of the given ones each is a piece.

    Edges that cross have a point of their own there, at the same x, y; points that were there stay the first ones.
    """
    xy = points[:, :2]
    lines = shapely.linestrings(xy[edges])
    one, other = shapely.STRtree(lines).query(lines, predicate="intersects")
    later = one < other
    one, other = one[later], other[later]
    same = (xy[edges[one]][:, :, None] == xy[edges[other]][:, None]).all(3).any((1, 2))
    one, other = one[~same], other[~same]
    a, d = xy[edges[one, 0]], xy[edges[one, 1]] - xy[edges[one, 0]]
    b, e = xy[edges[other, 0]], xy[edges[other, 1]] - xy[edges[other, 0]]
    cross = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    # Edges on one line have common points at their ends only, and are left alone.
    kept = np.abs(cross) > _AT_END * np.hypot(*d.T) * np.hypot(*e.T)
    one, other, a, b, d, e, cross = (value[kept] for value in (one, other, a, b, d, e, cross))
    off = b - a
    u = (off[:, 0] * e[:, 1] - off[:, 1] * e[:, 0]) / cross
    v = (off[:, 0] * d[:, 1] - off[:, 1] * d[:, 0]) / cross
    place = a + u[:, None] * d
    for shares, rows in ((u, one), (v, other)):
        for side in (0, 1):
            at = np.flatnonzero(np.abs(shares - side) < _AT_END)
            place[at] = xy[edges[rows[at], side]]
    line, share = np.concatenate([one, other]), np.concatenate([u, v])
    inner = (share > _AT_END) & (share < 1.0 - _AT_END)
    line, share, place = line[inner], share[inner], np.concatenate([place, place])[inner]
    order = np.lexsort((share, line))
    line, share, place = line[order], share[order], place[order]
    first, last = (points[edges[line, k], 2] for k in (0, 1))
    more = np.column_stack([place, first + share * (last - first)])
    # Each edge becomes one piece more than it has cuts.
    count = np.bincount(line, minlength=len(edges)) + 1
    origin, rank = np.repeat(np.arange(len(edges)), count), ranks(count)
    # Cuts stand in the order of their edges.
    cut = len(points) + np.cumsum(rank > 0) - 1
    start = np.where(rank > 0, cut, edges[origin, 0])
    end = np.where(rank < count[origin] - 1, cut + 1, edges[origin, 1])
    return np.concatenate([points, more]), np.column_stack([start, end]), origin
