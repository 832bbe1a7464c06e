"""Tiles of a scene as Wavefront OBJ, with one library of materials (MTL)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from osm2xodr.exporting.scene.glb import material_name
from osm2xodr.exporting.scene.materials import material_of
from osm2xodr.exporting.scene.tiles import Tile
from osm2xodr.model import FloatArray
from osm2xodr.system import ByteSink

# Rows of text that are formatted at a time.
_BLOCK: Final = 100_000


def write_obj_tile(tile: Tile, origin: Sequence[float], stream: ByteSink, library: str, *, y_up: bool) -> None:
    """Write a tile, each part as a group of its name; coarser levels of detail are groups too.

    Coordinates count from `origin` (inertial x, y, z, m); `y_up` makes y up and -z north.
    """
    axes = "y up, x east, -z north" if y_up else "z up, x east, y north"
    x, y, z = origin
    head = f"# osm2xodr: tile {tile.column} {tile.row}, m, {axes}\n# origin at inertial x={x:g} y={y:g} z={z:g}\n"
    stream.write(f"{head}mtllib {library}\n".encode())
    first = 1
    for part in tile.parts:
        points = part.vertices - np.asarray(origin)
        points = points[:, [0, 2, 1]] * [1, 1, -1] if y_up else points
        stream.write(f"g {part.name}\nusemtl {material_name(part.material)}\n".encode())
        _write_rows(stream, "v %.4f %.4f %.4f\n", np.round(points, 4) + 0.0)
        _write_rows(stream, "vt %.3f %.3f\n", np.round(part.uv, 3) + 0.0)
        _write_rows(stream, "f %d/%d %d/%d %d/%d\n", np.repeat(part.faces + first, 2, axis=1))
        first += len(points)


def _write_rows(stream: ByteSink, form: str, rows: FloatArray) -> None:
    """Write a line for each row."""
    for at in range(0, len(rows), _BLOCK):
        block = rows[at : at + _BLOCK]
        stream.write((form * len(block) % tuple(block.ravel().tolist())).encode())


def obj_materials(names: Iterable[str]) -> bytes:
    """Return the file of materials."""
    out = []
    for name in sorted(set(names)):
        colour = material_of(name).colour
        red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
        out.append(f"newmtl {material_name(name)}\nKd {red:.4f} {green:.4f} {blue:.4f}\nKs 0 0 0\nillum 1\n")
    return "".join(out).encode()
