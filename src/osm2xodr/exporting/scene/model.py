"""What a scene consists of: parts, each of one material, and the surface of the roads that all of them meet."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from osm2xodr.model import FloatArray, IntArray, freeze_arrays

# Coordinates of the road surface in plan are whole multiples of this, m.
GRID: Final = 1e-3


class Level(IntEnum):
    """What carries a road."""

    GROUND = 0
    BRIDGE = 1
    TUNNEL = 2


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one name and one material.

    Triangles are counter-clockwise seen from outside: the ground and roads from above, walls from where one stands.
    """

    # What engines know it by, without a number or tile: ``Road_Road``, ``Terrain`` …
    name: str
    material: str  # One of `osm2xodr.exporting.scene.materials.MATERIALS`
    vertices: FloatArray  # (n, 3) inertial x, y, z, m
    uv: FloatArray  # (n, 2) Coordinates on the surface, m
    faces: IntArray  # (m, 3) Vertices of each triangle
    # (m,) Level of detail of each triangle: 0 is the finest; None: in all of them
    detail: IntArray | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, eq=False)
class RoadSurface:
    """The surface of all roads, without overlap: every place of one level is covered once.

    Triangles that touch share their vertices. Steps between lanes of different heights have vertical triangles, so
    that an edge that only one triangle has is a rim.
    """

    vertices: FloatArray  # (n, 3) inertial x, y, z, m; no two are the same
    uv: FloatArray  # (n, 2) m
    faces: IntArray  # (m, 3) counter-clockwise from above
    kind: IntArray  # (m,) Index in `kinds`
    kinds: tuple[str, ...]  # OpenDRIVE's types of lanes, and ``kerb`` for vertical faces
    level: IntArray  # (m,) `Level`

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True, eq=False)
class Rim:
    """The edges at which the road surface on the ground ends: its lane borders, and the feet of bridges and tunnels.

    Each edge has the road on its left, so outer outlines are counter-clockwise and holes (islands) clockwise, and
    every end of an edge is the begin of another one. More than two edges may meet where outlines touch in a point.
    """

    edges: IntArray  # (n, 2) Vertices of the surface
    # (n,) `Level` of what is beyond: GROUND, or BRIDGE or TUNNEL where the road goes on there
    beyond: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self)
