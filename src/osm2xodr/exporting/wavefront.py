"""Meshes as Wavefront OBJ, with a library of materials (MTL)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.exporting.mesh import RoadMesh, color_of
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.system import ByteSink

# Rows of text that are formatted at a time.
_BLOCK: Final = 100_000


def write_obj(mesh: RoadMesh, stream: ByteSink, library: str | None, *, y_up: bool) -> None:
    """Write a mesh as OBJ, one group and material per type of lane, which the file `library`, if any, describes.

    `y_up` makes y up and -z north, as in most programs for 3D scenes; else z is up and y north, as in OpenDRIVE.
    """
    write_head(stream, "road surface", mesh.origin, library, y_up=y_up)
    vertices = mesh.vertices[:, [0, 2, 1]] * [1, 1, -1] if y_up else mesh.vertices
    write_rows(stream, "v %.4f %.4f %.4f\n", np.round(vertices, 4) + 0.0)
    for kind, triangles in mesh.faces.items():
        name = _name(kind)
        stream.write(f"g {name}\nusemtl {name}\n".encode())
        write_rows(stream, "f %d %d %d\n", triangles + 1)


def write_head(stream: ByteSink, what: str, origin: Sequence[float], library: str | None, *, y_up: bool) -> None:
    """Write what a file is of, the inertial point (m) that it counts from, and its library of materials."""
    x, y, z = origin
    axes = "y up, x east, -z north" if y_up else "z up, x east, y north"
    stream.write(f"# osm2xodr: {what}, m, {axes}\n# origin at inertial x={x:g} y={y:g} z={z:g}\n".encode())
    if library is not None:
        stream.write(f"mtllib {library}\n".encode("utf-8", "surrogateescape"))


def write_rows(stream: ByteSink, form: str, rows: FloatArray | IntArray) -> None:
    """Write a line for each row."""
    for first in range(0, len(rows), _BLOCK):
        block = rows[first : first + _BLOCK]
        stream.write((form * len(block) % tuple(block.ravel().tolist())).encode())


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
