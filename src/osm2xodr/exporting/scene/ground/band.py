"""The ground at roads and shores: all lines there are noded once, and each face between them is land or water.

Edges of roads and sides of squares do not touch, so that the triangles of the ground have the very corners of the
roads. Where a place has several heights, as at portals and at shores of level water, walls stand between triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.curves import PointTree, runs
from osm2xodr.exporting.scene.arrangement import (
    Planes,
    first_of,
    half_edges,
    lone,
    places_of,
    triangles_of,
)
from osm2xodr.exporting.scene.ground.cells import Cells
from osm2xodr.exporting.scene.ground.water import WaterShapes
from osm2xodr.exporting.scene.model import GRID
from osm2xodr.model import FloatArray, IntArray

# Places closer together than this are the same, m: what is left of rounding.
_SAME: Final = 1e-6
# Corners of squares per line across the band.
_PER_SPOKE: Final = 3


@dataclass(frozen=True, eq=False)
class Band:
    """Triangles of places: those of the roads, then corners of squares, then more."""

    triangles: IntArray  # (n, 3) counter-clockwise
    area: IntArray  # (n,) The area of water that each is in; -1 for land
    more: FloatArray  # (k, 2) Places where shores cross other lines, and along them, m


def band_of(cells: Cells, xy: FloatArray, rim: IntArray, roads: Planes, water: WaterShapes) -> Band:
    """Return the ground between the edges of roads, shores and whole squares.

    `xy`, (points, 2), m, are different places, and `rim`, (m, 2), edges between them.
    """
    known = np.concatenate([xy, cells.node_xy()])
    around = cells.sides(cells.roads & cells.ground)
    around = len(xy) + around[lone(*around.T)]
    edges = np.concatenate([rim, around, len(xy) + cells.sides(cells.shores)])
    lines = _lines(known, np.concatenate([edges, _spokes(known, rim, around)]))
    # Not on a grid, as edges of roads have to stay as they are.
    noded = shapely.union_all(np.concatenate([lines, water.shores]))
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    kept = cells.has((cells.roads | cells.shores) & cells.ground, inside) & ~roads.cover(inside)
    corners, of = triangles_of(faces[kept])
    used, corners = np.unique(edges), corners.reshape(-1, 2)
    place, first = places_of(np.concatenate([known[used], corners]), _SAME)
    new = first >= len(used)
    number = np.where(new, len(known) + np.cumsum(new) - 1, np.append(used, 0)[np.where(new, len(used), first)])
    return Band(
        number[place[len(used) :]].reshape(-1, 3),
        water.found_at(*inside[kept].T)[of],
        corners[first[new] - len(used)],
    )


def _lines(places: FloatArray, edges: IntArray) -> Any:
    """Return edges between places as lines."""
    return shapely.linestrings(places[edges])


def _spokes(places: FloatArray, rim: IntArray, around: IntArray) -> IntArray:
    """Return lines across the band, from corners of squares to the nearest place on a road, that cross no edge.

    They divide it into small pieces, which are triangulated many times as fast as a large one.
    """
    corners, ends = np.unique(around)[::_PER_SPOKE], np.unique(rim)
    if not len(ends):
        return np.zeros((0, 2), np.int64)
    spokes = np.column_stack([corners, ends[PointTree(places[ends]).nearest(places[corners])[1]]])
    edges = np.concatenate([rim, around])
    spoke, edge = shapely.STRtree(_lines(places, edges)).query(_lines(places, spokes), predicate="intersects")
    meets = (spokes[spoke][:, :, None] == edges[edge][:, None]).any((1, 2))
    return np.delete(spokes, np.unique(spoke[~meets]), 0)


def raised(triangles: IntArray, xyz: FloatArray, place: IntArray, rim: IntArray) -> IntArray:
    """Return triangles (n, 3) of points instead of places.

    `place`, (points,), is that of each point of `xyz`, (points, 3), m. `rim`, (m, 2), are edges of points that have
    the road on their left: those that the ground has to meet. Places without an edge have one point.
    """
    point = np.zeros(int(place.max()) + 1, np.int64)
    point[place] = np.arange(len(place))
    # Each place has the points of its edges: of several the lowest one.
    ends, edge = rim.ravel(), np.repeat(np.arange(len(rim)), 2)
    order = np.lexsort((xyz[ends, 2], place[ends]))
    ends, edge = ends[order], edge[order]
    first = np.flatnonzero(np.diff(place[ends], prepend=-1) != 0)
    count = np.diff(np.append(first, len(ends)))
    point[place[ends[first]]] = ends[first]
    out = point[triangles]
    # Triangles on the right of the line of a higher edge go with it, as above a portal and straight on beside it.
    many = np.maximum.reduceat(ends, first) > np.minimum.reduceat(ends, first) if len(first) else first > 0
    rank = np.full(len(point), -1)
    rank[place[ends[first[many]]]] = np.flatnonzero(many)
    row, corner = np.nonzero(rank[triangles] >= 0)
    own = rank[triangles[row, corner]]
    owner, at = np.repeat(np.arange(len(row)), count[own]), runs(first[own], count[own])
    begin, along = xyz[rim[edge[at], 0], :2], np.diff(xyz[rim[edge[at]], :2], axis=1)[:, 0]
    off = xyz[out[row[owner]], :2].mean(1) - begin
    right = along[:, 0] * off[:, 1] < along[:, 1] * off[:, 0]
    z = xyz[ends[at], 2]
    best = first_of(owner, np.where(right, -z, z), ~right)
    out[row, corner] = ends[at[best]]
    # Sides at an edge have its points.
    total = len(point)
    key = place[rim[:, 1]] * total + place[rim[:, 0]]
    order = np.argsort(key, kind="stable")
    start, end = half_edges(triangles)
    found = np.minimum(np.searchsorted(key[order], start * total + end), max(len(key) - 1, 0))
    side = np.flatnonzero(key[order][found] == start * total + end) if len(key) else np.zeros(0, np.int64)
    row, corner, met = side // 3, side % 3, rim[order[found[side]]]
    out[row, corner], out[row, (corner + 1) % 3] = met[:, 1], met[:, 0]
    return out


def on_edges(xy: FloatArray, z: FloatArray, xyz: FloatArray, edges: IntArray) -> tuple[FloatArray, IntArray]:
    """Return heights of places (n, 2), m, and edges (m, 2) of points (k, 3) that end at the places on them as well.

    Places on edges are as high as these, the others `z`, (n,), m. They are the points behind those that are given.
    """
    tree = shapely.STRtree(_lines(xyz[:, :2], edges))
    at, edge = tree.query(shapely.points(xy), predicate="dwithin", distance=2.0 * GRID)
    begin, along = xyz[edges[edge, 0]], xyz[edges[edge, 1]] - xyz[edges[edge, 0]]
    share = ((xy[at] - begin[:, :2]) * along[:, :2]).sum(1) / np.maximum((along[:, :2] ** 2).sum(1), GRID**2)
    kept = (share > 0.0) & (share < 1.0)
    height = (begin[:, 2] + share * along[:, 2])[kept]
    at, edge, share = at[kept], edge[kept], share[kept]
    lowest = first_of(at, height)
    out = z.copy()
    out[at[lowest]] = height[lowest]
    # All points along each edge.
    count = len(edges)
    edge = np.concatenate([np.tile(np.arange(count), 2), edge])
    order = np.lexsort((np.concatenate([np.zeros(count), np.ones(count), share]), edge))
    point = np.concatenate([edges.T.ravel(), len(xyz) + at])[order]
    goes_on = np.diff(edge[order]) == 0
    return out, np.column_stack([point[:-1][goes_on], point[1:][goes_on]])


def level_water(
    vertices: FloatArray, place: IntArray, faces: IntArray, area: IntArray, level: FloatArray, fixed: int
) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Return vertices, the vertex that each comes from, its place, and triangles, of which those in water are level.

    Triangles (n, 3) of vertices (m, 2 or more), m, whose places are given, are in areas of water, -1 for none, of a
    level, (n,), m, or NaN. Land at its shore is no lower, but for the first `fixed` vertices: those of roads.
    """
    wet = np.flatnonzero(np.isfinite(level))
    high = np.full(int(place.max(initial=-1)) + 1, -np.inf)
    np.maximum.at(high, place[faces[wet]], level[wet, None])
    dry = np.unique(faces[~np.isfinite(level)])
    dry = dry[dry >= fixed]
    vertices = vertices.copy()
    vertices[dry, 2] = np.maximum(vertices[dry, 2], high[place[dry]])
    # One corner of each area at a vertex.
    key = np.repeat(area[wet], 3) * len(vertices) + faces[wet].ravel()
    key, first, corner = np.unique(key, return_index=True, return_inverse=True)
    own = key % len(vertices)
    flat = np.column_stack([vertices[own, :2], np.repeat(level[wet], 3)[first]])
    out = faces.copy()
    out[wet] = len(vertices) + corner.reshape(-1, 3)
    origin = np.concatenate([np.arange(len(vertices)), own])
    return np.concatenate([vertices, flat]), origin, place[origin], out
