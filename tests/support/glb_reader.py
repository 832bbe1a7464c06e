"""Binary glTF 2.0, read back strictly: what Khronos' validator calls an error is one here."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}
COMPONENTS: dict[int, npt.DTypeLike] = {5126: "<f4", 5125: "<u4"}
TARGETS = {5126: 34962, 5125: 34963}
KNOWN = {"asset", "extensionsUsed", "scene", "scenes", "nodes", "meshes", "materials", "accessors"} | {
    "bufferViews",
    "buffers",
}


@dataclass(frozen=True)
class GlbMesh:
    name: str
    material: str
    points: npt.NDArray[np.float64]  # Inertial x, y, z in the tile's frame
    faces: npt.NDArray[np.int64]
    shown: bool  # Whether a node of the scene has it, not a level of detail alone


def read_glb(data: bytes) -> tuple[dict[str, Any], list[GlbMesh]]:
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert (kind, size % 4) == (b"JSON", 0)
    parsed = json.loads(data[20 : 20 + size])
    binary, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert (kind, binary % 4, 28 + size + binary) == (b"BIN\0", 0, len(data))
    assert set(parsed) <= KNOWN
    assert parsed["buffers"] == [{"byteLength": binary}]
    body = data[28 + size :]
    ends = 0
    for view in parsed["bufferViews"]:
        assert view["byteOffset"] == ends
        ends += view["byteLength"]
    assert ends == binary
    (root,) = parsed["scenes"][parsed["scene"]]["nodes"]
    top = parsed["nodes"][root]
    lods = [k for node in parsed["nodes"] for k in node.get("extensions", {}).get("MSFT_lod", {}).get("ids", ())]
    assert bool(lods) == ("MSFT_lod" in parsed.get("extensionsUsed", ()))
    # Every node hangs once, on the tile or on a finer level of detail.
    assert sorted([root, *top["children"], *lods]) == list(range(len(parsed["nodes"])))
    moved = np.array(top["translation"])
    out = []
    for k in (*top["children"], *lods):
        node = parsed["nodes"][k]
        mesh = parsed["meshes"][node["mesh"]]
        assert mesh["name"] == node["name"]
        (part,) = mesh["primitives"]
        assert part["mode"] == 4
        arrays = {name: _array(parsed, body, at) for name, at in part["attributes"].items()}
        count = len(arrays["POSITION"])
        assert {name: values.shape for name, values in arrays.items()} == {
            "POSITION": (count, 3),
            "NORMAL": (count, 3),
            "TEXCOORD_0": (count, 2),
        }
        np.testing.assert_allclose(np.linalg.norm(arrays["NORMAL"], axis=1), 1.0, atol=1e-5)
        position = parsed["accessors"][part["attributes"]["POSITION"]]
        assert position["min"] == arrays["POSITION"].min(0).tolist()
        assert position["max"] == arrays["POSITION"].max(0).tolist()
        faces = _array(parsed, body, part["indices"]).reshape(-1, 3).astype(np.int64)
        assert faces.max() < count
        assert len(np.unique(faces)) == count, "every vertex is used"
        x, y, z = (arrays["POSITION"] + moved).T
        material = parsed["materials"][part["material"]]
        assert all(0 <= value <= 1 for value in material["pbrMetallicRoughness"]["baseColorFactor"])
        shown = k not in lods
        out.append(GlbMesh(node["name"], material["name"], np.column_stack([x, -z, y]), faces, shown))
    return parsed, out


def _array(parsed: dict[str, Any], body: bytes, at: int) -> npt.NDArray[Any]:
    entry = parsed["accessors"][at]
    view = parsed["bufferViews"][entry["bufferView"]]
    width = TYPES[entry["type"]]
    assert view["target"] == TARGETS[entry["componentType"]]
    assert view["byteLength"] == entry["count"] * width * 4
    dtype = COMPONENTS[entry["componentType"]]
    values = np.frombuffer(body, dtype, entry["count"] * width, view["byteOffset"]).reshape(-1, width)
    assert np.isfinite(values).all()
    return values
