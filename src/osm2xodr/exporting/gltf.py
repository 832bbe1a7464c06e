"""Meshes as binary glTF 2.0 (.glb).

Written after the specification of glTF 2.0 (Khronos Group, 2021), sections 3.6 (binary data), 3.7 (meshes) and 4
(GLB): little-endian throughout, chunks padded to 4 bytes, y up.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr.exporting.mesh import RoadMesh, color_of
from osm2xodr.opendrive import Header
from osm2xodr.system import ByteSink

# Numbers of the specification: of the file and its chunks, of types of components, of uses of buffers.
_MAGIC: Final = 0x46546C67
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
_FLOAT: Final = 5126
_UNSIGNED_INT: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_ARRAY_BUFFER: Final = 34963


def write_glb(mesh: RoadMesh, header: Header, stream: ByteSink, version: str) -> None:
    """Write a mesh as one node of one mesh, with a primitive and a material per type of lane.

    x, y, z of glTF are x, z, -y of OpenDRIVE. The node's extras hold the origin in inertial coordinates and, from the
    network's header, geoReference and offset; the asset holds the version of this program.
    """
    points = np.ascontiguousarray(mesh.vertices[:, [0, 2, 1]] * [1, 1, -1], "<f4")
    blocks = [points.tobytes(), *(np.ascontiguousarray(rows, "<u4").tobytes() for rows in mesh.faces.values())]
    size = sum(map(len, blocks))
    extras = {"inertial_origin": list(mesh.origin), "geo_reference": header.geo_reference, "offset": header.offset}
    # Mode 4 is triangles.
    parts = [
        {"attributes": {"POSITION": 0}, "indices": k, "material": k - 1, "mode": 4} for k in range(1, len(blocks))
    ]
    document = {
        "asset": {"version": "2.0", "generator": f"osm2xodr {version}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "road surface", "mesh": 0, "extras": extras}],
        "meshes": [{"name": "road surface", "primitives": parts}],
        "materials": [_material(kind) for kind in mesh.faces],
        "accessors": _accessors(mesh, points),
        "bufferViews": _buffer_views(blocks),
        "buffers": [{"byteLength": size}],
    }
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    # Floats and unsigned integers both have 4 bytes: the binary chunk needs no padding.
    stream.write(struct.pack("<III", _MAGIC, 2, 12 + 8 + len(text) + 8 + size))
    stream.write(struct.pack("<II", len(text), _JSON_CHUNK) + text)
    for block in (struct.pack("<II", size, _BINARY_CHUNK), *blocks):
        stream.write(block)


def _buffer_views(blocks: Sequence[bytes]) -> list[dict[str, Any]]:
    """Return where the blocks lie in the buffer: first the vertices, then the triangles of each material."""
    views, offset = [], 0
    for k, block in enumerate(blocks):
        target = _ELEMENT_ARRAY_BUFFER if k else _ARRAY_BUFFER
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(block), "target": target})
        offset += len(block)
    return views


def _accessors(mesh: RoadMesh, points: npt.NDArray[np.float32]) -> list[dict[str, Any]]:
    """Return what the blocks hold."""
    low, high = points.min(0).astype(float).tolist(), points.max(0).astype(float).tolist()
    triangles = [
        _accessor(k, _UNSIGNED_INT, rows.size, "SCALAR", [int(rows.min())], [int(rows.max())])
        for k, rows in enumerate(mesh.faces.values(), 1)
    ]
    return [_accessor(0, _FLOAT, len(points), "VEC3", low, high), *triangles]


def _accessor(view: int, component: int, count: int, kind: str, low: list[Any], high: list[Any]) -> dict[str, Any]:
    """Return what one block holds."""
    return {"bufferView": view, "componentType": component, "count": count, "type": kind, "min": low, "max": high}


def _material(kind: str) -> dict[str, Any]:
    """Return the material of a type of lanes."""
    finish = {"baseColorFactor": [*color_of(kind), 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}
    return {"name": kind, "doubleSided": True, "pbrMetallicRoughness": finish}
