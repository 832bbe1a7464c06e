"""Tiles of a scene as binary glTF 2.0, with levels of detail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.binary_gltf import TRIANGLES, GltfFile, material, y_up
from osm2xodr.exporting.scene.materials import material_of
from osm2xodr.exporting.scene.model import Part
from osm2xodr.exporting.scene.tiles import Tile, normals_of
from osm2xodr.system import ByteSink

_LOD: Final = "MSFT_lod"


def write_tile(
    tile: Tile, middle: Sequence[float], place: Sequence[float], stream: ByteSink, generator: str, credits: str
) -> None:
    """Write a tile, each part as a node of its name.

    Vertices count from `middle` (inertial x, y, z, m), and the tile's node stands at `place` (likewise, from the
    scene's origin). x, y, z of glTF are x, z, -y of OpenDRIVE. Coarser levels of detail of a node hang on it by the
    extension MSFT_lod, so that programs without it show the finest.
    """
    document = _Document()
    nodes = [document.node(part, middle) for part in tile.parts]
    finest = [k for k in nodes if not _coarse(document.nodes[k]["name"])]
    for k in finest:
        name = document.nodes[k]["name"]
        if name.endswith("_LOD0"):
            stem = name.removesuffix("0")
            ids = [other for other in nodes if other != k and document.nodes[other]["name"].startswith(stem)]
            if ids:
                document.nodes[k]["extensions"] = {_LOD: {"ids": ids}}
                document.lods = True
    document.nodes.append(
        {"name": f"Tile_{tile.column}_{tile.row}", "children": finest, "translation": _turned(place)}
    )
    document.write(generator, credits, stream)


def _coarse(name: str) -> bool:
    """Whether a node is a coarser level of detail of another one."""
    stem, _, level = name.rpartition("_LOD")
    return bool(stem) and level != "0"


def _turned(point: Sequence[float]) -> list[float]:
    """Return x, y, z of glTF for those of OpenDRIVE."""
    x, y, z = point
    return [x, z, -y + 0.0]


class _Document:
    """Collects nodes and what they hold."""

    def __init__(self) -> None:
        self.nodes: list[dict[str, Any]] = []
        self.lods = False
        self._file = GltfFile()
        self._meshes: list[dict[str, Any]] = []
        self._materials: dict[str, int] = {}

    def node(self, part: Part, middle: Sequence[float]) -> int:
        """Add a part and return its node."""
        attributes = {
            "POSITION": self._file.vertices(y_up(part.vertices - np.asarray(middle)), "VEC3", bounds=True),
            "NORMAL": self._file.vertices(y_up(normals_of(part)), "VEC3"),
            "TEXCOORD_0": self._file.vertices(part.uv, "VEC2"),
        }
        indices = self._file.triangles(part.faces)
        number = self._materials.setdefault(part.material, len(self._materials))
        primitive = {"attributes": attributes, "indices": indices, "material": number, "mode": TRIANGLES}
        self._meshes.append({"name": part.name, "primitives": [primitive]})
        self.nodes.append({"name": part.name, "mesh": len(self._meshes) - 1})
        return len(self.nodes) - 1

    def write(self, generator: str, credits: str, stream: ByteSink) -> None:
        """Write the file; its scene shows the last node."""
        asset = {"version": "2.0", "generator": generator}
        document = {
            "asset": asset | ({"copyright": credits} if credits else {}),
            **({"extensionsUsed": [_LOD]} if self.lods else {}),
            "scene": 0,
            "scenes": [{"nodes": [len(self.nodes) - 1]}],
            "nodes": self.nodes,
            "meshes": self._meshes,
            "materials": [_material(name) for name in self._materials],
        }
        self._file.write(document, stream)


def material_name(name: str) -> str:
    """Return the name of a material in files: letters, digits and underscores."""
    return f"colour_{name[1:]}" if name.startswith("#") else name


def _material(name: str) -> dict[str, Any]:
    """Return a material."""
    look = material_of(name)
    linear = tuple(round(value, 4) for value in look.linear)
    return material(material_name(name), linear, look.metallic, look.roughness)
