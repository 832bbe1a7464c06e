"""Parts that are put together piece by piece, and places on the road surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import shapely

from osm2xodr.curves import running_lengths
from osm2xodr.exporting.scene.arrangement import Planes, first_of, triangles_of
from osm2xodr.exporting.scene.model import Part, RoadSurface
from osm2xodr.model import FloatArray, IntArray

Corner: TypeAlias = tuple[float, float, float]
Flat: TypeAlias = tuple[float, float]


def part_of(name: str, material: str, vertices: FloatArray, faces: IntArray, detail: int | None = None) -> Part:
    """Return triangles of a level of detail, or of all of them, with just the vertices that they need."""
    used, number = np.unique(faces, return_inverse=True)
    corners = vertices[used]
    own = None if detail is None else np.full(len(faces), detail)
    return Part(name, material, corners, corners[:, :2].copy(), number.reshape(-1, 3), own)


class Meshes:
    """Collects triangles by name and material."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], list[tuple[FloatArray, FloatArray, IntArray]]] = {}

    def add(self, name: str, material: str, vertices: FloatArray, uv: FloatArray, faces: IntArray) -> None:
        """Add triangles: vertices (n, 3), their uv (n, 2), faces (m, 3)."""
        if len(faces):
            self._found.setdefault((name, material), []).append((vertices, uv, faces))

    def polygon(self, name: str, material: str, corners: Sequence[Corner]) -> None:
        """Add a plane area by its corners in space, which is not upright."""
        flat = shapely.Polygon([(x, y) for x, y, _ in corners])
        if not flat.is_valid or flat.area < 1e-6:
            return
        points = np.array(corners)
        faces = _triangulated(flat, points[:, :2])
        self.add(name, material, points, points[:, :2], faces)

    def face(self, name: str, material: str, corners: Sequence[Corner], across: Sequence[Flat]) -> None:
        """Add a plane area in space by its corners there, and in its own plane."""
        faces = _triangulated(shapely.Polygon(across), np.array(across))
        self.add(name, material, np.array(corners), np.array(across), faces)

    def prism(self, name: str, material: str, corners: Sequence[Flat], low: float, high: float) -> None:
        """Add a body over an area: its walls and its lid."""
        flat = shapely.Polygon(corners)
        if not flat.is_valid or flat.area < 1e-6:
            return
        ring = np.array(corners if flat.exterior.is_ccw else corners[::-1])
        n = len(ring)
        k = np.arange(n)
        along = running_lengths(np.concatenate([ring, ring[:1]]))
        a = np.column_stack([ring, np.full(n, low)])
        b = np.column_stack([ring, np.full(n, high)])
        after = (k + 1) % n
        # Each wall has its own corners, so that edges are sharp.
        walls = np.stack([a, a[after], b[after], b], axis=1).reshape(-1, 3)
        sizes = [np.column_stack([along[:-1], a[:, 2]]), np.column_stack([along[1:], a[:, 2]])]
        sizes += [np.column_stack([along[1:], b[:, 2]]), np.column_stack([along[:-1], b[:, 2]])]
        quads = 4 * k[:, None] + np.array([[0, 1, 2, 0, 2, 3]])
        self.add(name, material, walls, np.stack(sizes, axis=1).reshape(-1, 2), quads.reshape(-1, 3))
        self.add(name, material, b, ring, _triangulated(flat, ring))

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


def _triangulated(shape: shapely.Polygon, points: FloatArray) -> IntArray:
    """Return triangles of a polygon, (m, 3), counter-clockwise, as rows of its corners."""
    if not shape.is_valid:
        return np.zeros((0, 3), np.int64)
    corners = triangles_of([shape])[0].reshape(-1, 2)
    away = np.abs(corners[:, None, :] - points[None]).sum(2)
    out: IntArray = np.argmin(away, axis=1).reshape(-1, 3)
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
