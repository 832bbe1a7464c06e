"""The ground between the edges of roads and the whole squares around them, as triangles between just their corners.

Nothing is cut and nothing rounded: edges of roads and sides of squares do not touch, so that polygons between them
need no overlay, and the triangles of the ground have the very corners of the roads.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt
import shapely
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.cells import Cells, on_the_left
from osm2xodr.model import FloatArray, IntArray

ComplexArray: TypeAlias = npt.NDArray[np.complex128]

# Corners of squares per line across the band.
_PER_SPOKE: Final = 3


def band_triangles(cells: Cells, xy: FloatArray, rim: IntArray) -> IntArray:
    """Return the triangles (n, 3) between rims and whole squares, counter-clockwise.

    `xy`, (points, 2), m, are different places, and `rim`, (m, 2), edges between them with the road on their left.
    Of the triangles' corners those below `points` are rows of `xy`, the others corners of squares, in rows from
    south to north, after all of these.
    """
    if not len(rim):
        return np.zeros((0, 3), np.int64)
    nodes = np.column_stack([axis.ravel() for axis in cells.node_xy()])
    sides = _sides(cells)
    places = np.concatenate([xy, nodes])
    edges = np.concatenate([rim[:, ::-1], len(xy) + sides])
    used = np.unique(edges)
    lines = shapely.linestrings(places[np.concatenate([edges, _spokes(places, rim, edges, len(xy))])])
    faces = shapely.get_parts(shapely.polygonize(lines))
    faces = shapely.orient_polygons(faces)
    index = _Places(places[used], used)
    corners, face = shapely.get_coordinates(shapely.get_exterior_ring(faces), return_index=True)
    number = index.find(corners)
    follows = face[1:] == face[:-1]
    # All edges of an outline have the same on their left: ground, if one has; not so where roads lie over each other.
    total = len(places)
    here, there, known = number[:-1] * total + number[1:], number[1:] * total + number[:-1], edges @ (total, 1)
    ground, road = (
        np.bincount(face[:-1][np.isin(keys, known) & follows], minlength=len(faces)) > 0 for keys in (here, there)
    )
    both = np.flatnonzero(ground & road)
    inside = shapely.get_coordinates(shapely.point_on_surface(faces[both])).reshape(-1, 2)
    ground[both] = ~on_the_left(inside, xy[rim[:, 0]], xy[rim[:, 1]])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(faces[ground]))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    triangles = index.find(corners.reshape(-1, 2)).reshape(-1, 3)
    a, b, c = (places[triangles[:, k]] for k in range(3))
    turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    triangles[turn < 0] = triangles[turn < 0][:, ::-1]
    return triangles


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
    nearest = ends[cKDTree(places[ends]).query(places[corners])[1]]
    spokes = np.column_stack([corners, nearest])
    tree = shapely.STRtree(shapely.linestrings(places[edges]))
    spoke, edge = tree.query(shapely.linestrings(places[spokes]), predicate="intersects")
    meets = (spokes[spoke][:, :, None] == edges[edge][:, None]).any((1, 2))
    crossed = np.unique(spoke[~meets])
    return np.delete(spokes, crossed, 0)


class _Places:
    """Finds places by their exact coordinates."""

    def __init__(self, xy: FloatArray, number: IntArray) -> None:
        order = np.lexsort((xy[:, 1], xy[:, 0]))
        self._keys = _key(xy[order])
        self._number = number[order]

    def find(self, xy: FloatArray) -> IntArray:
        """Return the numbers of places (n, 2) that are known."""
        out: IntArray = self._number[np.searchsorted(self._keys, _key(xy))]
        return out


def _key(xy: FloatArray) -> ComplexArray:
    """Return complex numbers, which are in order by x, then y."""
    # Not -0.0, which is in the same place.
    return np.ascontiguousarray(xy + 0.0).view(np.complex128).ravel()
