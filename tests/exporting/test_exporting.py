"""Exported files, read back by what their formats say."""

from __future__ import annotations

import io
import json
import math
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import Transformer
from xodr_text import PROJECTION, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.cli import main
from osm2xodr.exporting import LAYERS, RoadMesh, road_mesh, write_geojson, write_glb, write_obj
from osm2xodr.library import EXPORT_LAYERS
from osm2xodr.opendrive.tables import OpenDrive

# 100 m, of which the first 50 m have a lane that opens out from nothing, then a cycle lane.
LANES = section(0.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0)) + lane(-2, (0, 0.0, 0.04))) + section(
    50.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0)) + lane(-2, (0, 2.0), kind="biking")
)
FURNITURE = (
    '<objects><object id="c" type="crosswalk" s="10" t="0" hdg="0"><outline>'
    '<cornerLocal u="-1" v="-3" z="0" height="0"/><cornerLocal u="-1" v="3" z="0" height="0"/>'
    '<cornerLocal u="1" v="3" z="0" height="0"/><cornerLocal u="1" v="-3" z="0" height="0"/></outline></object>'
    '<object id="tree" type="tree" s="20" t="6" zOffset="0.5"/></objects>'
    '<signals><signal id="x" s="30" t="-6" zOffset="3" type="274" value="50"/></signals>'
)


def network(folder: Path, *, x: float = 0.0) -> OpenDrive:
    curve = geometry("<line/>", 50.0, x=x) + geometry('<arc curvature="0.02"/>', 50.0, 50.0, 50.0 + x)
    roads = [
        road("1", curve, lanes=LANES, more=FURNITURE, elevation=cubics("elevation", (0, 100.0, 0.02))),
        road("2", geometry("<line/>", 20.0, x=200.0 + x), 20.0, junction="9"),
    ]
    connection = '<connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"/>'
    return read_text(folder, document(*roads, f'<junction id="9" name="J">{connection}</junction>'))


# ---------------------------------------------------------------- mesh


def area(mesh: RoadMesh, kind: str) -> float:
    a, b, c = (mesh.vertices[mesh.faces[kind][:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] > 0).all(), "faces look up"
    return float(0.5 * np.abs(normals[:, 2]).sum())


def test_lanes_have_their_area_and_no_cracks(tmp_path: Path) -> None:
    mesh = road_mesh(network(tmp_path), 0.001, 10.0)
    # Lanes 1 and -1, the lane that opens out (50 m, 1 m wide on average); on the arc, the area of lane 1 is 3 m times
    # its length in the middle.
    bend = 50 * (3 * (1 - 0.02 * 1.5) + 3 * (1 + 0.02 * 1.5))
    assert area(mesh, "driving") == pytest.approx(300 + 50 + bend + 2 * 3.5 * 20, rel=1e-4)
    assert area(mesh, "biking") == pytest.approx(50 * 2 * (1 + 0.02 * 4), rel=1e-4)
    # Every edge lies in one or two triangles, and those in one make one closed line around each of the two roads.
    triangles = np.concatenate(list(mesh.faces.values()))
    edges = Counter(tuple(sorted((int(row[k]), int(row[(k + 1) % 3])))) for row in triangles for k in range(3))
    assert set(edges.values()) == {1, 2}
    border = [edge for edge, count in edges.items() if count == 1]
    corners = Counter(corner for edge in border for corner in edge)
    assert set(corners.values()) == {2}
    assert loops(border) == 2


def loops(edges: list[tuple[int, ...]]) -> int:
    """Count the parts of a graph."""
    parent = {corner: corner for edge in edges for corner in edge}

    def top(corner: int) -> int:
        while parent[corner] != corner:
            corner = parent[corner]
        return corner

    for one, other in edges:
        parent[top(one)] = top(other)
    return len({top(corner) for corner in parent})


def test_raised_lanes_have_kerbs(tmp_path: Path) -> None:
    walk = lane(-2, (0, 2.0), kind="sidewalk", more='<height sOffset="0" inner="0.12" outer="0.15"/>')
    file = read_text(tmp_path, document(road(lanes=section(0.0, "", lane(-1, (0, 3.0)) + walk))))
    mesh = road_mesh(file, 0.05, 200.0)
    assert sorted(mesh.faces) == ["driving", "kerb", "sidewalk"]
    assert sorted(set(np.round(mesh.vertices[:, 2], 6).tolist())) == [0, 0.12, 0.15]
    kerb = mesh.vertices[np.unique(mesh.faces["kerb"])]
    np.testing.assert_allclose(kerb[:, 1], -3.0)
    assert len(mesh.faces["kerb"]) == 2


def test_large_coordinates_get_an_origin(tmp_path: Path) -> None:
    mesh = road_mesh(network(tmp_path, x=5.7e6), 0.05, 10.0)
    assert mesh.origin == (5_700_000.0, 0.0, 0.0)
    assert np.abs(mesh.vertices).max() < 300
    assert road_mesh(network(tmp_path), 0.05, 10.0).origin == (0, 0, 0)


# ---------------------------------------------------------------- glTF


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


# ---------------------------------------------------------------- OBJ


@pytest.mark.parametrize("y_up", [False, True])
def test_obj_has_the_mesh(tmp_path: Path, y_up: bool) -> None:
    mesh = road_mesh(network(tmp_path), 0.05, 10.0)
    stream = io.BytesIO()
    write_obj(mesh, stream, "map.mtl", y_up=y_up)
    lines = [line.split() for line in stream.getvalue().decode().splitlines()]
    assert ["mtllib", "map.mtl"] in lines
    vertices = np.array([line[1:] for line in lines if line[0] == "v"], np.float64)
    x, y, z = mesh.vertices.T
    expected = np.column_stack([x, z, -y]) if y_up else mesh.vertices
    np.testing.assert_allclose(vertices, expected, atol=6e-5)
    faces = np.array([line[1:] for line in lines if line[0] == "f"], np.int64)
    assert (faces - 1).tolist() == np.concatenate(list(mesh.faces.values())).tolist()
    assert [line[1] for line in lines if line[0] == "usemtl"] == list(mesh.faces)


# ---------------------------------------------------------------- GeoJSON


def features(file: OpenDrive, *layers: str) -> list[dict[str, Any]]:
    stream = io.BytesIO()
    write_geojson(file, stream, 0.05, 10.0, layers or LAYERS)
    parsed = json.loads(stream.getvalue())
    assert parsed["type"] == "FeatureCollection"
    found: list[dict[str, Any]] = parsed["features"]
    return found


def local(coordinates: list[list[float]]) -> npt.NDArray[np.float64]:
    """Return x, y, z of coordinates by pyproj."""
    lon, lat, height = np.array(coordinates).T
    # Lists, for pyproj takes an array of one element for a number.
    x, y = Transformer.from_crs("EPSG:4326", PROJECTION, always_xy=True).transform(lon.tolist(), lat.tolist())
    return np.column_stack([x, y, height])


def test_all_layers_are_there(tmp_path: Path) -> None:
    found = Counter(item["properties"]["layer"] for item in features(network(tmp_path)))
    assert found == {"roads": 2, "lanes": 8, "junctions": 1, "signals": 1, "objects": 2}
    assert {item["properties"]["layer"] for item in features(network(tmp_path), "signals")} == {"signals"}


def test_lanes_are_rings_where_they_are(tmp_path: Path) -> None:
    lanes = features(network(tmp_path), "lanes")
    first = lanes[0]
    assert first["properties"]["road"] == "1"
    assert first["properties"]["lane"] == 1
    assert first["properties"]["width"] == 3.0
    (ring,) = first["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    points = local(ring)
    # 1e-8 degrees are 1.1 mm.
    np.testing.assert_allclose(points[0], [0, 0, 100], atol=2e-3)
    np.testing.assert_allclose(points[:, 2], 100 + 0.02 * points[:, 0], atol=2e-3)
    assert set(np.round(points[:, 1]).tolist()) == {0, 3}
    for item in lanes:
        x, y, _ = local(item["geometry"]["coordinates"][0][:-1]).T
        assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0, "rings run counter-clockwise"


def test_reference_lines_and_junctions(tmp_path: Path) -> None:
    roads = features(network(tmp_path), "roads", "junctions")
    points = local(roads[0]["geometry"]["coordinates"])
    end = (50 + 50 * math.sin(1), 50 * (1 - math.cos(1)), 102)
    np.testing.assert_allclose(points[-1], end, atol=2e-3)
    assert roads[1]["properties"]["junction"] == "9"
    junction = roads[2]
    assert junction["properties"] == {
        "layer": "junctions",
        "junction": "9",
        "name": "J",
        "type": "",
        "connections": 1,
    }
    corners = local(junction["geometry"]["coordinates"][0])
    np.testing.assert_allclose([corners[:, 0].min(), corners[:, 0].max()], [200, 220], atol=2e-3)
    np.testing.assert_allclose([corners[:, 1].min(), corners[:, 1].max()], [-3.5, 3.5], atol=2e-3)


def test_signals_and_objects(tmp_path: Path) -> None:
    signal, tree, crossing = features(network(tmp_path), "signals", "objects")
    np.testing.assert_allclose(local([signal["geometry"]["coordinates"]])[0], [30, -6, 103.6], atol=2e-3)
    assert signal["properties"]["type"] == "274"
    assert signal["properties"]["kind"] == "signal"
    np.testing.assert_allclose(local([tree["geometry"]["coordinates"]])[0], [20, 6, 100.9], atol=2e-3)
    corners = local(crossing["geometry"]["coordinates"][0][:-1])
    assert sorted(np.round(corners[:, :2]).tolist()) == [[9, -3], [9, 3], [11, -3], [11, 3]]


# ---------------------------------------------------------------- the command


@pytest.fixture
def path(tmp_path: Path) -> Path:
    network(tmp_path)
    return tmp_path / "map.xodr"


def export(path: Path, target: str, *arguments: str) -> int:
    return main(["export", str(path), "-o", str(path.parent / target), *arguments])


def test_layers_of_the_command_are_those_of_the_module() -> None:
    assert EXPORT_LAYERS == LAYERS


def test_formats_by_name(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for target in ("a.geojson", "a.glb", "a.obj"):
        assert export(path, target) == 0
        assert target in capsys.readouterr().err
    folder = path.parent
    assert json.loads((folder / "a.geojson").read_text(encoding="utf-8"))["type"] == "FeatureCollection"
    assert (folder / "a.glb").read_bytes()[:4] == b"glTF"
    assert "mtllib a.mtl" in (folder / "a.obj").read_text(encoding="utf-8")
    materials = (folder / "a.mtl").read_text(encoding="utf-8")
    assert [line.split()[1] for line in materials.splitlines() if line.startswith("newmtl")] == ["biking", "driving"]


def test_same_file_same_bytes(path: Path) -> None:
    for form in ("geojson", "glb", "obj"):
        assert export(path, f"a.{form}") == 0
        assert export(path, f"a.{form}", "--overwrite") == 0
        first = (path.parent / f"a.{form}").read_bytes()
        assert export(path, f"a.{form}", "--overwrite") == 0
        assert (path.parent / f"a.{form}").read_bytes() == first


@pytest.mark.parametrize(
    ("target", "arguments", "words"),
    [
        ("a.dae", [], "a.dae does not tell it"),
        ("a.glb", ["--layers", "lanes"], "--layers is for geojson alone"),
        ("a.geojson", ["--up", "y"], "--up is for obj alone"),
        ("a.geojson", ["--layers", "lanes,trees"], "no 'trees'"),
        ("map.xodr", ["--format", "glb"], "is one of the inputs"),
    ],
)
def test_wrong_usage(
    path: Path, capsys: pytest.CaptureFixture[str], target: str, arguments: list[str], words: str
) -> None:
    assert export(path, target, *arguments) == 2
    assert words in capsys.readouterr().err


def test_files_are_not_overwritten_unasked(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path.parent / "a.mtl").write_text("mine", encoding="utf-8")
    assert export(path, "a.obj") == 2
    assert "a.mtl exists" in capsys.readouterr().err
    assert (path.parent / "a.mtl").read_text(encoding="utf-8") == "mine"
    assert not (path.parent / "a.obj").exists()


def test_what_cannot_be_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "map.xodr"
    path.write_text(document(road(lanes=""), header='<header revMajor="1" revMinor="4"/>'), encoding="utf-8")
    assert export(path, "a.glb") == 1
    assert "has no lane with a surface" in capsys.readouterr().err
    assert export(path, "a.geojson") == 1
    assert "GeoJSON is always in WGS 84" in capsys.readouterr().err
    assert [item.name for item in tmp_path.iterdir()] == ["map.xodr"]
