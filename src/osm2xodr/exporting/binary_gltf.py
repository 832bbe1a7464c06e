"""Files of binary glTF 2.0 (.glb): the buffer with its views and accessors, and the container.

Written after the specification of glTF 2.0 (Khronos Group, 2021), sections 3.6 (binary data), 3.7 (meshes) and 4
(GLB): little-endian throughout, chunks padded to 4 bytes, y up.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.mesh import RoadMesh, color_of
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import Header
from osm2xodr.system import ByteSink


def write_glb(mesh: RoadMesh, header: Header, stream: ByteSink, version: str) -> None:
    """Write a mesh as one node of one mesh, with a primitive and a material per type of lane.

    x, y, z of glTF are x, z, -y of OpenDRIVE. The node's extras hold the origin in inertial coordinates and, from the
    network's header, geoReference and offset; the asset holds the version of this program.
    """
    file = GltfFile()
    points = {"POSITION": file.vertices(y_up(mesh.vertices), "VEC3", bounds=True)}
    parts = [
        {"attributes": points, "indices": file.triangles(rows, bounds=True), "material": k, "mode": TRIANGLES}
        for k, rows in enumerate(mesh.faces.values())
    ]
    extras = {"inertial_origin": list(mesh.origin), "geo_reference": header.geo_reference, "offset": header.offset}
    document = {
        "asset": {"version": "2.0", "generator": f"osm2xodr {version}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "road surface", "mesh": 0, "extras": extras}],
        "meshes": [{"name": "road surface", "primitives": parts}],
        "materials": [material(kind, color_of(kind), 0.0, 0.9) for kind in mesh.faces],
    }
    file.write(document, stream)


# ---------------------------------------------------------------- the container

# Numbers of the specification: of the file and its chunks, of types of components, of uses of buffers.
_MAGIC: Final = 0x46546C67
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
_FLOAT: Final = 5126
_UNSIGNED_INT: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_ARRAY_BUFFER: Final = 34963
TRIANGLES: Final = 4


def y_up(points: FloatArray) -> FloatArray:
    """Return x, y, z of glTF for those of OpenDRIVE, (n, 3)."""
    turned: FloatArray = points[:, [0, 2, 1]] * [1, 1, -1]
    return turned


class GltfFile:
    """Collects arrays, and writes them with the document that refers to them."""

    def __init__(self) -> None:
        self._accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._blocks: list[bytes] = []
        self._size = 0

    def vertices(self, values: FloatArray, kind: str, *, bounds: bool = False) -> int:
        """Add an array of numbers per vertex, (n, 2 or 3), and return its accessor, with its bounds if asked."""
        block = np.ascontiguousarray(values, "<f4")
        low_high = (block.min(0).astype(float).tolist(), block.max(0).astype(float).tolist()) if bounds else None
        return self._array(block.tobytes(), _ARRAY_BUFFER, _FLOAT, len(block), kind, low_high)

    def triangles(self, faces: IntArray, *, bounds: bool = False) -> int:
        """Add the vertices of triangles, (n, 3), and return their accessor, with its bounds if asked."""
        low_high = ([int(faces.min())], [int(faces.max())]) if bounds else None
        block = np.ascontiguousarray(faces, "<u4").tobytes()
        return self._array(block, _ELEMENT_ARRAY_BUFFER, _UNSIGNED_INT, faces.size, "SCALAR", low_high)

    def _array(
        self,
        block: bytes,
        use: int,
        component: int,
        count: int,
        kind: str,
        bounds: tuple[list[Any], list[Any]] | None,
    ) -> int:
        """Add bytes, whose components have 4 each, to the buffer."""
        self._views.append({"buffer": 0, "byteOffset": self._size, "byteLength": len(block), "target": use})
        self._blocks.append(block)
        self._size += len(block)
        accessor = {"bufferView": len(self._views) - 1, "componentType": component, "count": count, "type": kind}
        self._accessors.append(accessor | ({"min": bounds[0], "max": bounds[1]} if bounds else {}))
        return len(self._accessors) - 1

    def write(self, document: dict[str, Any], stream: ByteSink) -> None:
        """Write the file; the document has all but accessors and buffers."""
        buffers = {"accessors": self._accessors, "bufferViews": self._views, "buffers": [{"byteLength": self._size}]}
        text = json.dumps({**document, **buffers}, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        # All components have 4 bytes: the binary chunk needs no padding.
        stream.write(struct.pack("<III", _MAGIC, 2, 12 + 8 + len(text) + 8 + self._size))
        stream.write(struct.pack("<II", len(text), _JSON_CHUNK) + text)
        for block in (struct.pack("<II", self._size, _BINARY_CHUNK), *self._blocks):
            stream.write(block)


def material(name: str, linear: tuple[float, ...], metallic: float, roughness: float) -> dict[str, Any]:
    """Return a material of a base colour, linear red, green and blue from 0 to 1; both sides are shown."""
    finish = {"baseColorFactor": [*linear, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": finish}
