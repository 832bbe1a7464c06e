"""Binary glTF, read back by its specification."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from exported_network import network
from xodr_text import PROJECTION

from osm2xodr.exporting.mesh import road_mesh, write_glb


def parse_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    document = json.loads(data[20 : 20 + size])
    binary, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    assert 28 + size + binary == len(data)
    return document, data[28 + size :]


def accessor(parsed: dict[str, Any], binary: bytes, index: int) -> npt.NDArray[Any]:
    entry = parsed["accessors"][index]
    view = parsed["bufferViews"][entry["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[entry["type"]]
    dtype = {5126: "<f4", 5125: "<u4"}[entry["componentType"]]
    assert view["byteOffset"] % 4 == 0
    assert view["byteLength"] == entry["count"] * width * 4
    values = np.frombuffer(binary, dtype, entry["count"] * width, view["byteOffset"]).reshape(-1, width)
    assert entry["min"] == values.min(0).tolist()
    assert entry["max"] == values.max(0).tolist()
    return values


def test_gltf_is_what_its_specification_says(tmp_path: Path) -> None:
    file = network(tmp_path)
    mesh = road_mesh(file, 0.05, 10.0)
    stream = io.BytesIO()
    write_glb(mesh, file.header, stream, "1.2.3")
    parsed, binary = parse_glb(stream.getvalue())
    assert parsed["asset"] == {"version": "2.0", "generator": "osm2xodr 1.2.3"}
    assert parsed["buffers"] == [{"byteLength": len(binary)}]
    assert [item["name"] for item in parsed["materials"]] == list(mesh.faces)
    points = accessor(parsed, binary, 0)
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(points, np.column_stack([x, z, -y]), atol=1e-4)
    for primitive, rows in zip(parsed["meshes"][0]["primitives"], mesh.faces.values(), strict=True):
        assert primitive["attributes"] == {"POSITION": 0}
        assert primitive["mode"] == 4
        indices = accessor(parsed, binary, primitive["indices"])
        assert indices.max() < len(points)
        assert indices.reshape(-1, 3).tolist() == rows.tolist()
    # Faces that look up look along +y.
    a, b, c = (points[accessor(parsed, binary, 1).reshape(-1, 3)[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 1] > 0).all()
    assert parsed["nodes"][0]["extras"]["geo_reference"] == PROJECTION
