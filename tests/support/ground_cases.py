"""Roads as strips of triangles, and what ground around them has to be like."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.model import FloatArray, IntArray

Corner = tuple[float, float, float]


def strips(*roads: tuple[Sequence[Corner], Sequence[Corner], Sequence[Level]]) -> RoadSurface:
    """Return roads between left and right borders of as many corners, and the level of each piece between these."""
    vertices, faces, levels = list[Corner](), list[tuple[int, int, int]](), list[Level]()
    number: dict[Corner, int] = {}

    def at(corner: Corner) -> int:
        if corner not in number:
            number[corner] = len(vertices)
            vertices.append(corner)
        return number[corner]

    for left, right, level in roads:
        for k, piece in enumerate(level):
            a, b, c, d = at(right[k]), at(right[k + 1]), at(left[k + 1]), at(left[k])
            faces += [(a, b, c), (a, c, d)]
            levels += [piece, piece]
    xyz = np.array(vertices, float)
    kind = np.zeros(len(faces), np.int64)
    return RoadSurface(xyz, xyz[:, :2].copy(), np.array(faces), kind, ("driving",), np.array(levels, np.int64))


def straight(
    stations: Sequence[tuple[float, float]],
    levels: Sequence[Level] | None = None,
    y: float = 0.0,
    width: float = 8.0,
) -> tuple[list[Corner], list[Corner], list[Level]]:
    """Return a road along x through stations of x and z, for `strips`; on the ground if nothing else is said."""
    left, right = ([(x, y + side * 0.5 * width, z) for x, z in stations] for side in (1, -1))
    return left, right, list(levels or [Level.GROUND] * (len(stations) - 1))


def edges_of(triangles: FloatArray) -> Counter[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Count directed edges between exact corners of triangles (n, 3, 3)."""
    found: Counter[tuple[tuple[float, ...], tuple[float, ...]]] = Counter()
    for row in (triangles + 0.0).tolist():
        for k in range(3):
            found[tuple(row[k]), tuple(row[(k + 1) % 3])] += 1
    return found


def areas(triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the areas of triangles (n, 3, 3) in space, and in plan as seen from above, m²."""
    normal = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.linalg.norm(normal, axis=1), normal[:, 2]


def rim_edges(vertices: FloatArray, edges: IntArray) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Return edges as the ground has them, the other way round."""
    return [(tuple(b), tuple(a)) for a, b in (vertices[edges] + 0.0).tolist()]
