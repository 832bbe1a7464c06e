"""Triangles: areas and lines as faces, what meets at one place, and parts that are put together piece by piece.

Lines lie on a grid in plan, so that faces that touch have the very same corners. A place, a point in plan, may have
several heights: of a kerb and the road beside it, of a bridge and the road below.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import numpy as np
import shapely

from osm2xodr.exporting.scene.model import Part, RoadSurface
from osm2xodr.furniture_shapes import LEVEL_APART
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

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


# The area of the smallest triangle, m²: a choice, below what can be seen.
_LEAST_AREA: Final = 5e-7


def has_area(vertices: FloatArray, faces: IntArray, least: float = _LEAST_AREA) -> BoolArray:
    """Return which triangles (m, 3) of vertices (n, 3), m, exceed `least`, m²; unknown corners never do."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    out: BoolArray = np.isfinite(twice) & (twice > 2.0 * least)
    return out


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
        return on_planes(self.corners[face], xy)


def on_planes(triangles: FloatArray, xy: FloatArray) -> FloatArray:
    """Return what is linear in triangles (n, 3, 2 + k) of x, y, m, and it at a place (n, 2) each, (n, k)."""
    a, b, c = np.moveaxis(triangles, 1, 0)
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


@record(eq=False)
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


# ---------------------------------------------------------------- parts

Corner: TypeAlias = tuple[float, float, float]
Flat: TypeAlias = tuple[float, float]


def part_of(name: str, material: str, vertices: FloatArray, faces: IntArray, detail: int | None = None) -> Part:
    """Return triangles of a level of detail, or of all of them, with just the vertices that they need."""
    used, number = np.unique(faces, return_inverse=True)
    corners = vertices[used]
    own = None if detail is None else np.full(len(faces), detail)
    return Part(name, material, corners, corners[:, :2].copy(), number.reshape(-1, 3), own)


def walls_between(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return vertices, uv and triangles of upright faces between edges, (n, 2, 3), m, and those above or below them.

    They are seen from the right of edges below. Each has its own corners, so that edges between them are sharp.
    """
    corners = np.concatenate([low, high[:, ::-1]], axis=1).reshape(-1, 3)
    along = np.hypot(*(low[:, 1] - low[:, 0])[:, :2].T)
    zero = np.zeros(len(low))
    u = np.column_stack([zero, along, along, zero]).ravel()
    faces = 4 * np.arange(len(low))[:, None] + np.array([[0, 1, 2, 0, 2, 3]])
    return corners, np.column_stack([u, corners[:, 2] - np.repeat(low[:, 0, 2], 4)]), faces.reshape(-1, 3)


class Meshes:
    """Collects triangles by name and material."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], list[tuple[FloatArray, FloatArray, IntArray]]] = {}

    def add(self, name: str, material: str, vertices: FloatArray, uv: FloatArray, faces: IntArray) -> None:
        """Add triangles: vertices (n, 3), their uv (n, 2), faces (m, 3)."""
        if len(faces):
            self._found.setdefault((name, material), []).append((vertices, uv, faces))

    def face(self, name: str, material: str, corners: FloatArray, across: FloatArray) -> None:
        """Add a plane area by its corners in space, (n, 3), and in its own plane, (n, 2), m, if it has any area."""
        shape = shapely.Polygon(across)
        if shape.is_valid and shape.area > _LEAST_AREA:
            points = triangles_of([shape])[0].reshape(-1, 2)
            away = np.abs(points[:, None, :] - across[None]).sum(2)
            self.add(name, material, corners, across, np.argmin(away, axis=1).reshape(-1, 3))

    def prism(self, name: str, material: str, corners: Sequence[Flat], low: float, high: float) -> None:
        """Add a body over an area: its walls and its lid."""
        flat = shapely.Polygon(corners)
        if not flat.is_valid or flat.area < _LEAST_AREA:
            return
        ring = np.array(corners if flat.exterior.is_ccw else corners[::-1])
        a, b = (np.column_stack([ring, np.full(len(ring), z)]) for z in (low, high))
        edges = np.stack([np.arange(len(ring)), (np.arange(len(ring)) + 1) % len(ring)], axis=1)
        self.add(name, material, *walls_between(a[edges], b[edges]))
        self.face(name, material, b, ring)

    def post(self, name: str, material: str, at: Corner, high: float, *radii: float) -> None:
        """Add a round body with six sides that stands at a place, by its radius below and, if it differs, above."""
        radius, wide = radii[0], radii[-1]
        turn = 2.0 * np.pi * np.arange(6) / 6
        x, y, low = at
        ring = np.column_stack([np.cos(turn), np.sin(turn)])
        a = np.column_stack([x + radius * ring[:, 0], y + radius * ring[:, 1], np.full(6, low)])
        k, after = np.arange(6), (np.arange(6) + 1) % 6
        uv = np.column_stack([radius * turn, np.full(6, low)])
        if wide <= 0.0:
            tip = np.array([[x, y, high]])
            self.add(
                name,
                material,
                np.concatenate([a, tip]),
                np.concatenate([uv, [[0.0, high]]]),
                np.column_stack([k, after, np.full(6, 6)]),
            )
            return
        b = np.column_stack([x + wide * ring[:, 0], y + wide * ring[:, 1], np.full(6, high)])
        sides = np.concatenate([np.column_stack([k, after, 6 + after]), np.column_stack([k, 6 + after, 6 + k])])
        lid = np.column_stack([np.full(4, 6), np.arange(7, 11), np.arange(8, 12)])
        both = np.concatenate([uv, np.column_stack([radius * turn, np.full(6, high)])])
        self.add(name, material, np.concatenate([a, b]), both, np.concatenate([sides, lid]))

    def parts(self) -> list[Part]:
        """Return one part of each name and material, in order."""
        out = []
        for (name, material), pieces in sorted(self._found.items()):
            first = np.cumsum([0, *(len(vertices) for vertices, _, _ in pieces)])
            faces = [rows + at for (_, _, rows), at in zip(pieces, first[:-1].tolist(), strict=True)]
            vertices, uv = (np.concatenate([piece[k] for piece in pieces]) for k in (0, 1))
            out.append(Part(name, material, vertices, uv, np.concatenate(faces)))
        return out


class SurfaceHeights:
    """Finds the height of the road surface at places."""

    def __init__(self, surface: RoadSurface) -> None:
        self._planes = Planes(surface.vertices[surface.faces], 0.5e-9)
        self._level = surface.level[self._planes.rows]

    def at(self, x: FloatArray, y: FloatArray, near: FloatArray, apart: float = math.inf) -> FloatArray:
        """Return z at inertial x, y, (n,), m, nearest to `near`, which stays where no surface is within `apart`."""
        xy = np.column_stack([x, y])
        place, face = self._planes.at(xy)
        z = self._planes.values(face, xy[place])[:, 0]
        away = np.abs(z - near[place])
        best = first_of(place, z, away)
        best = best[away[best] < apart]
        out = np.array(near, np.float64)
        out[place[best]] = z[best]
        return out

    def covered(self, shape: shapely.Polygon, level: int) -> bool:
        """Return whether any of the surface at a level lies in an area in plan."""
        return bool((self._level[self._planes.within(shape)] == level).any())
