"""What a scene consists of: parts and their materials, and the surface of the roads that all of them meet."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum
from types import MappingProxyType
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray, IntArray, freeze_arrays
from osm2xodr.system import record

# Length of the smallest squares of ground, m: half a carriageway, so that slopes beside roads have a shape.
GROUND_CELL: Final = 5.0
# How far the ground reaches beyond the roads, m, and the largest gap in it that is closed, m². Choices.
REACH: Final = 100.0
LARGEST_GAP: Final = 1e6
# How far water reaches beyond the roads if it begins on that ground, m: a harbour and the sea before it.
WATER_REACH: Final = 500.0
# How far the ground reaches beside roads where no elevation model knows it, m, level across: a choice.
APRON: Final = 10.0
# Height of the opening of tunnels, and from their road to the ground above, m: RABT's clearance of 4.5 m, and
# 0.5 m each for signs and the ceiling.
TUNNEL_OPENING: Final = 5.0
TUNNEL_COVER: Final = 5.5

# Coordinates of the road surface in plan are whole multiples of this, m.
GRID: Final = 1e-3


class Level(IntEnum):
    """What carries a road."""

    GROUND = 0
    BRIDGE = 1
    TUNNEL = 2


@record(eq=False)
class Part:
    """Triangles of one name and one material.

    Triangles are counter-clockwise seen from outside: the ground and roads from above, walls from where one stands.
    """

    # What engines know it by, without a number or tile: ``Road_Road``, ``Terrain`` …
    name: str
    material: str  # One of `MATERIALS`
    vertices: FloatArray  # (n, 3) inertial x, y, z, m
    uv: FloatArray  # (n, 2) Coordinates on the surface, m
    faces: IntArray  # (m, 3) Vertices of each triangle
    # (m,) Level of detail of each triangle: 0 is the finest; None: in all of them
    detail: IntArray | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self)

    def only(self, rows: IntArray) -> Part:
        """Return some of the triangles, of no level of detail, with the vertices that they have."""
        used, faces = np.unique(self.faces[rows], return_inverse=True)
        return replace(self, vertices=self.vertices[used], uv=self.uv[used], faces=faces.reshape(-1, 3), detail=None)


@record(eq=False)
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


@record(eq=False)
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


# ---------------------------------------------------------------- materials


@record
class Material:
    """How a surface looks: base colour, sRGB as #rrggbb, and the other factors of glTF's metallic-roughness model."""

    colour: str
    roughness: float = 0.9
    metallic: float = 0.0

    @property
    def linear(self) -> tuple[float, float, float]:
        """Red, green and blue of the base colour in linear light, 0 to 1 (IEC 61966-2-1)."""
        red, green, blue = (int(self.colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
        return _linear(red), _linear(green), _linear(blue)


def _linear(value: float) -> float:
    """Return a channel of sRGB in linear light."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


# Colours and finish are choices.
MATERIALS: Final = MappingProxyType(
    {
        "asphalt": Material("#4a4b4d"),
        "bus_lane": Material("#6b4a47"),
        "concrete": Material("#a5a29b"),
        "cycleway": Material("#8c4a3e"),
        "grass": Material("#6f8a4f", 1.0),
        "kerb": Material("#b9b6ae"),
        "marking_white": Material("#e8e8e4", 0.7),
        "marking_yellow": Material("#e0b63a", 0.7),
        "metal": Material("#8b9096", 0.5, 0.6),
        "paving": Material("#a9a399"),
        "rail": Material("#6a5f55"),
        "roof": Material("#96543f"),
        "roof_flat": Material("#9b978f"),
        "soil": Material("#84775f", 1.0),
        "sign_back": Material("#80868c", 0.6, 0.4),
        "vegetation": Material("#5d8a48", 1.0),
        "wall": Material("#d3cab8"),
        "water": Material("#4d7d9c", 0.2),
    }
)

# Name and material of lane types; all others are driven on.
_DRIVEN: Final = ("Road_Road", "asphalt")
_LANES: Final = MappingProxyType(
    {
        "biking": ("Road_Road_Cycleway", "cycleway"),
        "border": ("Road_Grass", "grass"),
        "bus": ("Road_Road_Bus", "bus_lane"),
        "curb": ("Road_Curb", "kerb"),
        "kerb": ("Road_Curb", "kerb"),
        "median": ("Road_Grass", "grass"),
        "none": ("Road_Grass", "grass"),
        "parking": ("Road_Road_Parking", "asphalt"),
        "rail": ("Road_Road_Rail", "rail"),
        "shoulder": ("Road_Gutter", "asphalt"),
        "sidewalk": ("Road_Sidewalk", "paving"),
        "tram": ("Road_Road_Rail", "rail"),
        "walking": ("Road_Sidewalk", "paving"),
    }
)
MARKING: Final = "Road_Marking"
CROSSWALK: Final = "Road_Crosswalk"


def lane_part(kind: str) -> tuple[str, str]:
    """Return name and material of the surface of a type of lanes."""
    return _LANES.get(kind, _DRIVEN)


def material_of(name: str) -> Material:
    """Return a material by its name, or one of a plain colour (#rrggbb)."""
    return Material(name) if name.startswith("#") else MATERIALS[name]
