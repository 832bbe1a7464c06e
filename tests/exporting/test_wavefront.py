"""Wavefront OBJ, read back."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from exported_network import network

from osm2xodr.exporting.mesh import road_mesh
from osm2xodr.exporting.wavefront import write_obj


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
