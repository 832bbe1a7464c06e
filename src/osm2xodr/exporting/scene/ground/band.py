"""The ground between the edges of roads and the whole squares around them, as triangles between just their corners.

Nothing is cut and nothing rounded: edges of roads and sides of squares do not touch, so that polygons between them
need no overlay, and the triangles of the ground have the very corners of the roads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt
import shapely
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.cells import Cells, on_the_left
from osm2xodr.model import FloatArray, IntArray


@dataclass(frozen=True)
class _Spokes:
    """A fan of triangles around a place."""

    around: tuple[int, ...]  # The other ends of its spokes, counter-clockwise, one more than triangles
    triangles: tuple[int, ...]  # Rows
    heights: tuple[int, int]  # The points that the place is where the fan begins and where it ends


def raised_triangles(
    triangles: IntArray, xyz: FloatArray, place: IntArray, rim: IntArray
) -> tuple[IntArray, IntArray]:
    """Return triangles (n, 3) of points instead of places, and the walls between split fans (k, 3) likewise.

    Triangles consist of places; `place`, (points,), is that of each point of `xyz`, (points, 3), m. `rim`, (m, 2),
    are edges of points that have the road on their left: those that the ground has to meet. Places without an edge
    have one point.
    """
    point = np.zeros(int(place.max()) + 1, np.int64)
    # The last one stays; of a place that ground stands at in two heights it is replaced below.
    point[place] = np.arange(len(place))
    point[place[rim[:, 0]]] = rim[:, 0]
    out = point[triangles]
    ends = np.concatenate([place[rim.ravel()][:, None], rim.reshape(-1, 1)], 1)
    several = np.unique(ends, axis=0)[:, 0]
    several = several[1:][several[1:] == several[:-1]]
    if not len(several):
        return out, np.zeros((0, 3), np.int64)
    walls: list[tuple[int, int, int, int]] = []
    # Triangles around the places in question, with the place first.
    row, corner = np.nonzero(np.isin(triangles, several))
    owner = triangles[row, corner]
    others = np.column_stack([triangles[row, (corner + 1) % 3], triangles[row, (corner + 2) % 3]])
    before, behind = _edges_at(rim, place, np.unique(several))
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.unique(several), "left")
    stops = np.searchsorted(owner[order], np.unique(several), "right")
    for here, start, stop in zip(np.unique(several).tolist(), starts.tolist(), stops.tolist(), strict=True):
        rows = order[start:stop]
        for fan in _fans(row[rows].tolist(), others[rows].tolist(), before[here], behind[here]):
            split = _split(fan, xyz, point, here)
            for k, triangle in enumerate(fan.triangles):
                out[triangle, triangles[triangle] == here] = fan.heights[k >= split]
            if fan.heights[0] != fan.heights[1]:
                beside = fan.triangles[max(split - 1, 0)]
                walls.append((*fan.heights, beside, fan.around[split]))
    return out, np.array([_wall(out, triangles, *wall) for wall in walls], np.int64).reshape(-1, 3)


def _edges_at(
    rim: IntArray, place: IntArray, places: IntArray
) -> tuple[dict[int, dict[int, int]], dict[int, dict[int, int]]]:
    """Return by place the edges that come to it and that leave it: the place they join it to, and its point."""
    before: dict[int, dict[int, int]] = {int(item): {} for item in places}
    behind: dict[int, dict[int, int]] = {int(item): {} for item in places}
    for a, b in rim[np.isin(place[rim], places).any(1)].tolist():
        one, other = int(place[a]), int(place[b])
        if one == other:
            continue
        if other in before:
            before[other][one] = b
        if one in behind:
            behind[one][other] = a
    return before, behind


def _fans(
    rows: Sequence[int], others: Sequence[Sequence[int]], before: dict[int, int], behind: dict[int, int]
) -> list[_Spokes]:
    """Return the fans around a place: they begin at an edge that comes to it and end at one that leaves it."""
    follows = {first: (row, second) for row, (first, second) in zip(rows, others, strict=True)}
    out = []
    for first in sorted(before):
        around, triangles = [first], list[int]()
        while around[-1] in follows and (len(around) == 1 or around[-1] not in behind):
            row, last = follows[around[-1]]
            triangles.append(row)
            around.append(last)
        if triangles and around[-1] in behind:
            out.append(_Spokes(tuple(around), tuple(triangles), (before[first], behind[around[-1]])))
    return out


def _split(fan: _Spokes, xyz: FloatArray, point: IntArray, here: int) -> int:
    """Return the spoke at which a fan is split: that which goes on straight from the higher edge's line."""
    low, high = xyz[list(fan.heights), 2]
    ends = xyz[point[list(fan.around)], :2] - xyz[point[here], :2]
    ends /= np.maximum(np.hypot(*ends.T), 1e-9)[:, None]
    return int(np.argmin(ends @ ends[-1 if high > low else 0]))


def _wall(out: IntArray, triangles: IntArray, first: int, last: int, beside: int, end: int) -> tuple[int, int, int]:
    """Return the triangle between the parts of a fan, whose spoke ends at a place."""
    return first, int(out[beside][triangles[beside] == end][0]), last


# ---------------------------------------------------------------- the band

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
