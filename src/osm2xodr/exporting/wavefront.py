"""Meshes as Wavefront OBJ, with a library of materials (MTL)."""

from __future__ import annotations

import re
from typing import Final

import numpy as np

from osm2xodr.exporting.mesh import RoadMesh, color_of
from osm2xodr.system import ByteSink

# Rows of text that are formatted at a time.
_BLOCK: Final = 100_000


def write_obj(mesh: RoadMesh, stream: ByteSink, library: str | None, *, y_up: bool) -> None:
    """Write a mesh as OBJ, one group and material per type of lane, which the file `library`, if any, describes.

    `y_up` makes y up and -z north, as in most programs for 3D scenes; else z is up and y north, as in OpenDRIVE.
    """
    x, y, z = mesh.origin
    axes = "y up, x east, -z north" if y_up else "z up, x east, y north"
    stream.write(f"# osm2xodr: road surface, m, {axes}\n# origin at inertial x={x:g} y={y:g} z={z:g}\n".encode())
    if library is not None:
        stream.write(f"mtllib {library}\n".encode("utf-8", "surrogateescape"))
    vertices = mesh.vertices[:, [0, 2, 1]] * [1, 1, -1] if y_up else mesh.vertices
    for first in range(0, len(vertices), _BLOCK):
        rows = np.round(vertices[first : first + _BLOCK], 4) + 0.0
        stream.write(("v %.4f %.4f %.4f\n" * len(rows) % tuple(rows.ravel().tolist())).encode())
    for kind, triangles in mesh.faces.items():
        name = _name(kind)
        stream.write(f"g {name}\nusemtl {name}\n".encode())
        for first in range(0, len(triangles), _BLOCK):
            corners = triangles[first : first + _BLOCK] + 1
            stream.write(("f %d %d %d\n" * len(corners) % tuple(corners.ravel().tolist())).encode())


def material_library(mesh: RoadMesh) -> bytes:
    """Return the file of materials of a mesh."""
    return "".join(
        f"newmtl {_name(kind)}\nKd {red:g} {green:g} {blue:g}\nKs 0 0 0\nillum 1\n"
        for kind in mesh.faces
        for red, green, blue in [color_of(kind)]
    ).encode()


def _name(kind: str) -> str:
    """Return a type as a name without blanks."""
    return re.sub(r"\s+", "_", kind)
