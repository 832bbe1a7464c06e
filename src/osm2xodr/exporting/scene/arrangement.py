"""Areas as triangles: lines noded once, faces between them, heights at their corners, and steps where these differ.

All lines lie on a grid in plan, so that faces that touch have the very same corners. A place, a point in plan, may
have several heights: of a kerb and the road beside it, of a bridge and the road below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.furniture_shapes import LEVEL_APART
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Heights at one place that differ by less are one, m: half of the lowest kerb (`KERB_HEIGHT`).
ONE_HEIGHT: Final = 0.015


def polygons_of(shape: Any) -> Any:
    """Return the polygons of shapes, (n,), without their lines and points."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return parts[(shapely.get_type_id(parts) == int(shapely.GeometryType.POLYGON)) & ~shapely.is_empty(parts)]


def area_of(outline: FloatArray, holes: Sequence[FloatArray]) -> tuple[Any, bool]:
    """Return the area within an outline without its holes, (n, 2), m, each, and whether the outline was repaired."""
    shape = shapely.Polygon(outline)
    repaired = not shape.is_valid
    if repaired:
        shape = shapely.make_valid(shape)
    for hole in holes:
        shape = shapely.difference(shape, shapely.make_valid(shapely.Polygon(hole)))
    return shape, repaired


def triangles_of(faces: Any) -> tuple[FloatArray, IntArray]:
    """Return the triangles of polygons, (n, 3, 2), counter-clockwise, and the polygon of each."""
    parts, of = shapely.get_parts(shapely.constrained_delaunay_triangles(faces), return_index=True)
    return shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3], of


class Planes:
    """Triangles that look up, found by the places below and above them."""

    def __init__(self, corners: FloatArray, least: float = 0.0) -> None:
        """Take triangles (n, 3, 2 + k) of x, y, m, and what is linear in them, but those with less area, m²."""
        one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        self.rows = np.flatnonzero(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] > 2.0 * least)
        self.corners = corners[self.rows]
        self._tree = shapely.STRtree(shapely.polygons(self.corners[:, :, :2]))

    def at(self, xy: FloatArray, reach: float = 0.0) -> tuple[IntArray, IntArray]:
        """Return pairs of places (n, 2), m, and triangles that come as close to them as `reach`, m."""
        place, face = self._tree.query(shapely.points(xy), predicate="dwithin", distance=reach)
        return place, face

    def within(self, area: Any) -> IntArray:
        """Return the triangles that share a place with an area."""
        out: IntArray = self._tree.query(area, predicate="intersects")
        return out

    def cover(self, xy: FloatArray) -> BoolArray:
        """Return which places (n, 2), m, lie on a triangle."""
        out = np.zeros(len(xy), np.bool_)
        out[self._tree.query(shapely.points(xy), predicate="intersects")[0]] = True
        return out

    def values(self, face: IntArray, xy: FloatArray) -> FloatArray:
        """Return what triangles (n,) have beside x, y at a place (n, 2) each, (n, k)."""
        a, b, c = np.moveaxis(self.corners[face], 1, 0)
        one, other, off = (b - a)[:, :2], (c - a)[:, :2], xy - a[:, :2]
        area = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
        to_b = (off[:, 0] * other[:, 1] - off[:, 1] * other[:, 0]) / area
        to_c = (one[:, 0] * off[:, 1] - one[:, 1] * off[:, 0]) / area
        out: FloatArray = a[:, 2:] + to_b[:, None] * (b - a)[:, 2:] + to_c[:, None] * (c - a)[:, 2:]
        return out


def places_of(xy: FloatArray, grid: float) -> tuple[IntArray, IntArray]:
    """Return the place of each point (n, 2), m, and the first point of each: those at one node of a grid are one."""
    nodes = np.rint(xy / grid)
    _, first, place = np.unique(nodes[:, 0] + 1j * nodes[:, 1], return_index=True, return_inverse=True)
    return place, first


def segments_of(lines: Any, grid: float) -> Any:
    """Return the straight pieces of lines between nodes of a grid, m, each once."""
    at, row = shapely.get_coordinates(shapely.get_parts(lines), return_index=True)
    place, first = places_of(at, grid)
    nodes = np.rint(at[first] / grid) * grid
    one, other = place[:-1][row[1:] == row[:-1]], place[1:][row[1:] == row[:-1]]
    low, high = np.minimum(one, other), np.maximum(one, other)
    pairs = np.unique((low * len(nodes) + high)[low < high])
    return shapely.linestrings(nodes[np.column_stack(np.divmod(pairs, len(nodes)))])


def clusters(key: IntArray, value: FloatArray, gap: float) -> IntArray:
    """Return the number of the run that each value is in: of one key, without a larger gap, in ascending order."""
    order = np.lexsort((value, key))
    new = (np.diff(key[order], prepend=-1) != 0) | (np.diff(value[order], prepend=-np.inf) > gap)
    out = np.empty(len(order), np.int64)
    out[order] = np.cumsum(new) - 1
    return out


def first_of(label: IntArray, *by: Any) -> IntArray:
    """Return the row of each label, in ascending order, that comes first by some values, the last of most weight."""
    order = np.lexsort((*by, label))
    out: IntArray = order[np.diff(label[order], prepend=-1) != 0]
    return out


@dataclass(frozen=True, eq=False)
class Soup:
    """Triangles of which each has corners of its own, at places that they share."""

    place: IntArray  # (n, 3) Index in `xy`
    xy: FloatArray  # (places, 2) m
    z: FloatArray  # (n, 3) m


def welded(soup: Soup) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the vertex of each corner, (n, 3), and the place and x, y, z of vertices; close heights are one."""
    vertex = clusters(soup.place.ravel(), soup.z.ravel(), ONE_HEIGHT)
    place = soup.place.ravel()[np.unique(vertex, return_index=True)[1]]
    z = np.bincount(vertex, weights=soup.z.ravel()) / np.maximum(np.bincount(vertex), 1)
    return vertex.reshape(-1, 3), place, np.column_stack([soup.xy[place], z])


def half_edges(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return begin and end of the sides of triangles, 3 * row + side."""
    return faces.ravel(), np.roll(faces, -1, axis=1).ravel()


def lone(start: IntArray, end: IntArray) -> BoolArray:
    """Return which sides have no other one the other way round."""
    total = int(max(start.max(initial=0), end.max(initial=0))) + 1
    out: BoolArray = ~np.isin(start * total + end, end * total + start)
    return out


def steps(
    start: IntArray, end: IntArray, place: IntArray, xyz: FloatArray, apart: float = LEVEL_APART
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the vertical triangles between sides that run together in plan but not in height.

    Sides run from and to vertices, whose place and x, y, z are given; those farther `apart`, m, are of roads above
    each other. Besides return the two sides of each triangle, and the sides that are left without another one.
    """
    open_ = np.flatnonzero(lone(start, end) & (place[start] != place[end]))
    p, q, z = place[start[open_]], place[end[open_]], 0.5 * (xyz[start[open_], 2] + xyz[end[open_], 2])
    ahead = p < q
    key = np.where(ahead, p, q) * (int(place.max(initial=0)) + 1) + np.where(ahead, q, p)
    run = clusters(key, z, apart)
    order = np.lexsort((ahead, z, run))
    # Two that follow each other in height, and run against each other, belong together.
    one, other = order[:-1], order[1:]
    match = np.flatnonzero((run[one] == run[other]) & (ahead[one] != ahead[other]))
    count = np.diff(match, prepend=-2)
    begin = np.flatnonzero(count != 1)
    rank = np.arange(len(match)) - np.repeat(begin, np.diff(np.append(begin, len(match))))
    match = match[rank % 2 == 0]
    left = np.ones(len(order), np.bool_)
    left[order[match]] = left[order[match + 1]] = False
    a, b = open_[order[match]], open_[order[match + 1]]
    quads = np.stack(
        [np.column_stack([end[a], start[a], end[b]]), np.column_stack([end[a], end[b], start[b]])], axis=1
    ).reshape(-1, 3)
    real = (quads != np.roll(quads, 1, axis=1)).all(1)
    return quads[real], np.repeat(np.column_stack([a, b]), 2, axis=0)[real], open_[left]
