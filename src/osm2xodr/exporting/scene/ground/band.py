"""The ground between the edges of roads and the whole squares around them, as triangles between just their corners.

Edges of roads and sides of squares do not touch, so that the triangles of the ground have the very corners of the
roads. Where these have several heights, as at portals, walls stand between the triangles that meet them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np
import shapely

from osm2xodr.curves import PointTree, runs
from osm2xodr.exporting.scene.arrangement import first_of, half_edges, places_of, steps, triangles_of
from osm2xodr.exporting.scene.ground.cells import Cells
from osm2xodr.exporting.scene.ground.defaults import GROUND_CELL
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Whether places in plan (n, 2), m, lie on a road on the ground.
Covered: TypeAlias = Callable[[FloatArray], BoolArray]

# Places closer together than this are the same, m: what is left of rounding.
_SAME: Final = 1e-6
# Corners of squares per line across the band.
_PER_SPOKE: Final = 3


def raised_triangles(
    triangles: IntArray, xyz: FloatArray, place: IntArray, rim: IntArray
) -> tuple[IntArray, IntArray]:
    """Return triangles (n, 3) of points instead of places, and the walls (k, 3) where they differ in height.

    Triangles consist of places; `place`, (points,), is that of each point of `xyz`, (points, 3), m. `rim`, (m, 2),
    are edges of points that have the road on their left: those that the ground has to meet. Places without an edge
    have one point.
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
    side = np.flatnonzero(key[order][found] == start * total + end)
    row, corner, met = side // 3, side % 3, rim[order[found[side]]]
    out[row, corner], out[row, (corner + 1) % 3] = met[:, 1], met[:, 0]
    start, end = half_edges(out)
    walls, _, _ = steps(np.concatenate([start, rim[:, 0]]), np.concatenate([end, rim[:, 1]]), place, xyz, np.inf)
    return out, walls


def band_triangles(cells: Cells, xy: FloatArray, rim: IntArray, covered: Covered) -> IntArray:
    """Return the triangles (n, 3) between rims and whole squares, counter-clockwise.

    `xy`, (points, 2), m, are different places, and `rim`, (m, 2), edges between them. Of the triangles' corners those
    below `points` are rows of `xy`, the others corners of squares, in rows from south to north, after all of these.
    """
    if not len(rim):
        return np.zeros((0, 3), np.int64)
    nodes = np.column_stack([axis.ravel() for axis in cells.node_xy()])
    places = np.concatenate([xy, nodes])
    edges = np.concatenate([rim[:, ::-1], len(xy) + _sides(cells)])
    used = np.unique(edges)
    lines = shapely.linestrings(places[np.concatenate([edges, _spokes(places, rim, edges, len(xy))])])
    faces = shapely.get_parts(shapely.polygonize(lines))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces)).reshape(-1, 2)
    column, row = np.floor(inside / GROUND_CELL).astype(np.int64).T
    band = (cells.near & cells.ground)[row - cells.row, column - cells.column] & ~covered(inside)
    corners, _ = triangles_of(faces[band])
    place, first = places_of(np.concatenate([places[used], corners.reshape(-1, 2)]), _SAME)
    out: IntArray = used[first[place[len(used) :]]].reshape(-1, 3)
    return out


def _sides(cells: Cells) -> IntArray:
    """Return the sides of squares between those near roads and whole ones, the former on their left."""
    near = cells.near & cells.ground
    stride = cells.nodes[1]
    found = []
    for (dy, dx), (a, b) in (
        ((-1, 0), (0, 1)),
        ((0, 1), (1, stride + 1)),
        ((1, 0), (stride + 1, stride)),
        ((0, -1), (stride, 0)),
    ):
        # No square at the outermost rows and columns has ground.
        other = np.roll(near, (-dy, -dx), (0, 1))
        row, column = np.nonzero(near & ~other)
        first = row * stride + column
        found.append(np.column_stack([first + a, first + b]))
    return np.concatenate(found)


def _spokes(places: FloatArray, rim: IntArray, edges: IntArray, first: int) -> IntArray:
    """Return lines across the band, from corners of squares to the nearest place on a road, that cross no edge.

    They divide it into small pieces, which are triangulated many times as fast as a large one. `first` is the index
    of the first corner.
    """
    corners = np.unique(edges[edges >= first])
    corners = corners[::_PER_SPOKE]
    ends = np.unique(rim)
    nearest = ends[PointTree(places[ends]).nearest(places[corners])[1]]
    spokes = np.column_stack([corners, nearest])
    tree = shapely.STRtree(shapely.linestrings(places[edges]))
    spoke, edge = tree.query(shapely.linestrings(places[spokes]), predicate="intersects")
    meets = (spokes[spoke][:, :, None] == edges[edge][:, None]).any((1, 2))
    crossed = np.unique(spoke[~meets])
    return np.delete(spokes, crossed, 0)
