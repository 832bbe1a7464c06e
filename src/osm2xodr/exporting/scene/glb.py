"""Tiles of a scene as binary glTF 2.0, with levels of detail."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.scene.materials import material_of
from osm2xodr.exporting.scene.model import Part
from osm2xodr.exporting.scene.tiles import Tile, normals_of
from osm2xodr.system import ByteSink

# Numbers of the specification: of the file and its chunks, of types of components, of uses of buffers.
_MAGIC: Final = 0x46546C67
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
_FLOAT: Final = 5126
_UNSIGNED_INT: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_ARRAY_BUFFER: Final = 34963
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
    stream.write(document.bytes(generator, credits))


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
        self._meshes: list[dict[str, Any]] = []
        self._materials: dict[str, int] = {}
        self._accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._blocks: list[bytes] = []
        self._size = 0

    def node(self, part: Part, middle: Sequence[float]) -> int:
        """Add a part and return its node."""
        points = (part.vertices - np.asarray(middle))[:, [0, 2, 1]] * [1, 1, -1]
        normals = normals_of(part)[:, [0, 2, 1]] * [1, 1, -1]
        attributes = {
            "POSITION": self._array(points, "VEC3", bounds=True),
            "NORMAL": self._array(normals, "VEC3"),
            "TEXCOORD_0": self._array(part.uv, "VEC2"),
        }
        indices = self._indices(part)
        material = self._materials.setdefault(part.material, len(self._materials))
        primitive = {"attributes": attributes, "indices": indices, "material": material, "mode": 4}
        self._meshes.append({"name": part.name, "primitives": [primitive]})
        self.nodes.append({"name": part.name, "mesh": len(self._meshes) - 1})
        return len(self.nodes) - 1

    def _array(self, values: Any, kind: str, *, bounds: bool = False) -> int:
        """Add an array of numbers per vertex, and return its accessor."""
        block = np.ascontiguousarray(values, "<f4")
        view = self._view(block.tobytes(), _ARRAY_BUFFER)
        accessor: dict[str, Any] = {"bufferView": view, "componentType": _FLOAT}
        accessor |= {"count": len(block), "type": kind}
        if bounds:
            low, high = block.min(0).astype(float), block.max(0).astype(float)
            accessor |= {"min": low.tolist(), "max": high.tolist()}
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def _indices(self, part: Part) -> int:
        """Add the triangles of a part, and return their accessor."""
        block = np.ascontiguousarray(part.faces, "<u4").tobytes()
        view = self._view(block, _ELEMENT_ARRAY_BUFFER)
        accessor = {"bufferView": view, "componentType": _UNSIGNED_INT, "count": part.faces.size, "type": "SCALAR"}
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def _view(self, block: bytes, target: int) -> int:
        """Add bytes to the buffer; all have multiples of 4."""
        view = {"buffer": 0, "byteOffset": self._size, "byteLength": len(block), "target": target}
        self._views.append(view)
        self._blocks.append(block)
        self._size += len(block)
        return len(self._views) - 1

    def bytes(self, generator: str, credits: str) -> bytes:
        """Return the file; its scene shows the last node."""
        asset = {"version": "2.0", "generator": generator}
        document = {
            "asset": asset | ({"copyright": credits} if credits else {}),
            **({"extensionsUsed": [_LOD]} if self.lods else {}),
            "scene": 0,
            "scenes": [{"nodes": [len(self.nodes) - 1]}],
            "nodes": self.nodes,
            "meshes": self._meshes,
            "materials": [_material(name) for name in self._materials],
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": self._size}],
        }
        text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<III", _MAGIC, 2, 12 + 8 + len(text) + 8 + self._size)
        parts = [
            head,
            struct.pack("<II", len(text), _JSON_CHUNK),
            text,
            struct.pack("<II", self._size, _BINARY_CHUNK),
        ]
        return b"".join([*parts, *self._blocks])


def material_name(name: str) -> str:
    """Return the name of a material in files: letters, digits and underscores."""
    return f"colour_{name[1:]}" if name.startswith("#") else name


def _material(name: str) -> dict[str, Any]:
    """Return a material; both sides are shown."""
    look = material_of(name)
    colour = [round(value, 4) for value in look.linear]
    finish = {"baseColorFactor": [*colour, 1.0], "metallicFactor": look.metallic, "roughnessFactor": look.roughness}
    return {"name": material_name(name), "doubleSided": True, "pbrMetallicRoughness": finish}
