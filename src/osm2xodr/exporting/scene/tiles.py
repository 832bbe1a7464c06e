"""Parts in tiles: squares of a grid of inertial x and y."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.exporting.scene.model import Part
from osm2xodr.model import BoolArray, FloatArray, IntArray

# The area of the smallest triangle, m²: a choice, below what can be seen.
_LEAST_AREA: Final = 5e-7


@dataclass(frozen=True)
class Tile:
    """A square of a scene, column and row of which count from inertial x and y = 0 to the east and north."""

    column: int
    row: int
    parts: tuple[Part, ...]

    @property
    def triangles(self) -> int:
        """Number of triangles in all levels of detail."""
        return sum(len(part.faces) for part in self.parts)


def tiles_of(parts: Iterable[Part], size: float) -> list[Tile]:
    """Return parts cut into tiles of a size, m, row by row from the south-west; a triangle goes where its middle is.

    Parts of several levels of detail come out as one part for each, named ``_LOD0``, ``_LOD1`` …
    """
    found: dict[tuple[int, int], list[Part]] = {}
    for part in parts:
        middle = part.vertices[part.faces].mean(1)[:, :2]
        cell = np.floor(middle / size).astype(np.int64)
        detail = np.zeros(len(part.faces), np.int64) if part.detail is None else part.detail
        keys, which = np.unique(np.column_stack([cell, detail]), axis=0, return_inverse=True)
        order = np.argsort(which.ravel(), kind="stable")
        bounds = np.searchsorted(which.ravel()[order], np.arange(len(keys) + 1))
        for k, (column, row, level) in enumerate(keys.tolist()):
            rows = order[bounds[k] : bounds[k + 1]]
            name = part.name if part.detail is None else f"{part.name}_LOD{level}"
            found.setdefault((row, column), []).append(replace(_only(part, rows), name=name))
    return [Tile(column, row, tuple(_named(found[row, column]))) for row, column in sorted(found)]


def finest(part: Part) -> Part:
    """Return the finest level of detail of a part, as one without levels."""
    return part if part.detail is None else _only(part, np.flatnonzero(part.detail == 0))


def in_single_precision(tile: Tile, middle: Sequence[float]) -> Tile:
    """Return a tile without triangles that have no area once vertices are single numbers that count from `middle`, m.

    Corners that lie closer than single precision resolves become one there.
    """
    parts = []
    for part in tile.parts:
        points = (part.vertices - np.asarray(middle)).astype(np.float32).astype(np.float64)
        kept = np.flatnonzero(has_area(points, part.faces))
        parts += [part] if len(kept) == len(part.faces) else [_only(part, kept)] if len(kept) else []
    return replace(tile, parts=tuple(parts))


def has_area(vertices: FloatArray, faces: IntArray, least: float = _LEAST_AREA) -> BoolArray:
    """Return which triangles (m, 3) of vertices (n, 3), m, exceed `least`, m²; unknown corners never do."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    out: BoolArray = np.isfinite(twice) & (twice > 2.0 * least)
    return out


def _only(part: Part, rows: IntArray) -> Part:
    """Return some of the triangles of a part, with the vertices that they have."""
    used, faces = np.unique(part.faces[rows], return_inverse=True)
    return replace(
        part, vertices=part.vertices[used], uv=part.uv[used], faces=faces.reshape(-1, 3).astype(np.int64), detail=None
    )


def _named(parts: list[Part]) -> Iterator[Part]:
    """Yield parts by name and material, with a number where several have the same name."""
    seen: dict[str, int] = {}
    for part in sorted(parts, key=lambda part: (part.name, part.material)):
        count = seen[part.name] = seen.get(part.name, 0) + 1
        yield part if count == 1 else replace(part, name=f"{part.name}_{count}")


def normals_of(part: Part) -> FloatArray:
    """Return the normals of vertices, (n, 3): of the triangles around them, each by its area."""
    a, b, c = np.moveaxis(part.vertices[part.faces], 1, 0)
    area = np.cross(b - a, c - a)
    out = np.zeros((len(part.vertices), 3))
    for k in range(3):
        for axis in range(3):
            out[:, axis] += np.bincount(part.faces[:, k], weights=area[:, axis], minlength=len(out))
    length = np.linalg.norm(out, axis=1)
    out[length < 1e-12] = [0.0, 0.0, 1.0]
    out /= np.where(length < 1e-12, 1.0, length)[:, None]
    return out
