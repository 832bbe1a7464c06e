"""Walls and roofs of buildings as triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.scene.buildings.roofs import Box, roof_pieces
from osm2xodr.exporting.scene.model import Part
from osm2xodr.model import FloatArray, IntArray

# Corners of roofs closer together than this are one, m; triangles of less area than its square are none.
_SAME: Final = 1e-4
_NAME: Final = "Building"


@dataclass(frozen=True, eq=False)
class Block:
    """A building between two heights."""

    area: Any  # A polygon
    box: Box  # Of the whole building, over which its roof stands
    shape: str  # Of the roof: a value of `SHAPES`, or ``flat``
    # Heights, m
    low: float
    eaves: float
    ridge: float
    hangs: bool  # Whether one can see it from below


def meshes_of(blocks: Sequence[Block]) -> tuple[Part, ...]:
    """Return the walls and roofs of blocks."""
    roofs = [_roof(block) for block in blocks]
    if not roofs:
        return ()
    corners = np.concatenate(roofs)
    owner = np.repeat(np.arange(len(blocks)), [len(roof) for roof in roofs])
    vertices, faces = _merged(corners, owner)
    # A triangle whose corners are the same, or on one line, is none.
    a, b, c = (vertices[faces[:, k], :2] for k in range(3))
    whole = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]) > _SAME**2
    faces, owner = faces[whole], owner[whole]
    low = np.array([block.low for block in blocks])
    hangs = np.array([block.hangs for block in blocks])[owner]
    start, end, of = _outer_edges(faces, len(vertices))
    walls, walls_uv = _walls(vertices[start], vertices[end], low[owner[of]])
    floors = vertices[faces[hangs][:, ::-1]]
    floors[..., 2] = low[owner[hangs], None]
    standing = np.concatenate([walls, floors]).reshape(-1, 3)
    standing_uv = np.concatenate([walls_uv, floors[..., :2]]).reshape(-1, 2)
    flat = np.array([block.shape == "flat" for block in blocks])[owner]
    return (
        Part(_NAME, "wall", standing, standing_uv, np.arange(len(standing)).reshape(-1, 3)),
        _roofs("roof", vertices, faces[~flat]),
        _roofs("roof_flat", vertices, faces[flat]),
    )


def _roofs(material: str, vertices: FloatArray, faces: IntArray) -> Part:
    """Return triangles of roofs of one material, with the vertices that they have."""
    used, number = np.unique(faces, return_inverse=True)
    return Part(_NAME, material, vertices[used], vertices[used, :2], number.reshape(-1, 3))


def _roof(block: Block) -> FloatArray:
    """Return the triangles of a roof, (n, 3, 3), m."""
    out = roof_pieces(block.area, block.box, block.shape)
    out[..., 2] = block.eaves + out[..., 2] * (block.ridge - block.eaves)
    return out


def _merged(corners: FloatArray, owner: IntArray) -> tuple[FloatArray, IntArray]:
    """Return vertices (n, 3), m, and triangles (m, 3) of them: each block has its own."""
    flat = corners.reshape(-1, 3)
    keys = np.column_stack([np.repeat(owner, 3), np.rint(flat[:, :2] / _SAME).astype(np.int64)])
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return flat[first], number.reshape(-1, 3)


def _outer_edges(faces: IntArray, count: int) -> tuple[IntArray, IntArray, IntArray]:
    """Return both ends of the edges that only one triangle has, and that triangle."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    outer = np.flatnonzero(~np.isin(start * count + end, end * count + start))
    return start[outer], end[outer], outer // 3


def _walls(start: FloatArray, end: FloatArray, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the triangles of walls below edges, (n, 3, 3), m, and their u along the wall and v from its foot."""
    foot, last = start.copy(), end.copy()
    foot[:, 2] = last[:, 2] = low
    length = np.hypot(*(end - start)[:, :2].T)
    zero = np.zeros(len(start))
    quads = np.stack([foot, last, end, start], 1)
    u = np.column_stack([zero, length, length, zero])
    v = np.column_stack([zero, zero, end[:, 2] - low, start[:, 2] - low])
    halves = np.array([0, 1, 2, 0, 2, 3])
    return quads[:, halves].reshape(-1, 3, 3), np.stack([u, v], -1)[:, halves].reshape(-1, 3, 2)
