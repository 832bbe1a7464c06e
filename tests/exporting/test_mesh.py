"""The road surface as triangles.

Wavefront OBJ, read back.
"""

from __future__ import annotations

import io
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from exported_network import network
from xodr_text import document, lane, read_text, road, section

from osm2xodr.exporting.mesh import RoadMesh, road_mesh, write_obj


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
