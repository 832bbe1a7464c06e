"""The folder that a scene is written to: its tiles, as OBJ too, and what tells about them, also to CARLA."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.mesh import TRIANGLES, GltfFile, material, write_head, write_rows, y_up
from osm2xodr.exporting.scene.meshes import has_area
from osm2xodr.exporting.scene.model import Part, material_of
from osm2xodr.exporting.scene.scene import Scene
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import OpenDrive
from osm2xodr.system import FILES_KEY, ByteSink, record

# ---------------------------------------------------------------- tiles


@record
class Tile:
    """A square of a scene, column and row of which count from inertial x and y = 0 to the east and north."""

    column: int
    row: int
    parts: tuple[Part, ...]

    @property
    def triangles(self) -> int:
        """Number of triangles in all levels of detail."""
        return sum(len(part.faces) for part in self.parts)


def tiles_of(parts: Iterable[Part], size: float) -> list[Tile]:
    """Return parts cut into tiles of a size, m, row by row from the south-west; a triangle goes where its middle is.

    Parts of several levels of detail come out as one part for each, named ``_LOD0``, ``_LOD1`` …
    """
    found: dict[tuple[int, int], list[Part]] = {}
    for part in parts:
        middle = part.vertices[part.faces].mean(1)[:, :2]
        cell = np.floor(middle / size).astype(np.int64)
        detail = np.zeros(len(part.faces), np.int64) if part.detail is None else part.detail
        keys, which = np.unique(np.column_stack([cell, detail]), axis=0, return_inverse=True)
        order = np.argsort(which.ravel(), kind="stable")
        bounds = np.searchsorted(which.ravel()[order], np.arange(len(keys) + 1))
        for k, (column, row, level) in enumerate(keys.tolist()):
            rows = order[bounds[k] : bounds[k + 1]]
            name = part.name if part.detail is None else f"{part.name}_LOD{level}"
            found.setdefault((row, column), []).append(replace(part.only(rows), name=name))
    return [Tile(column, row, tuple(_named(found[row, column]))) for row, column in sorted(found)]


def finest(part: Part) -> Part:
    """Return the finest level of detail of a part, as one without levels."""
    return part if part.detail is None else part.only(np.flatnonzero(part.detail == 0))


def in_single_precision(tile: Tile, middle: Sequence[float]) -> Tile:
    """Return a tile without triangles that have no area once vertices are single numbers that count from `middle`, m.

    Corners that lie closer than single precision resolves become one there.
    """
    parts = []
    for part in tile.parts:
        points = (part.vertices - np.asarray(middle)).astype(np.float32).astype(np.float64)
        kept = np.flatnonzero(has_area(points, part.faces))
        parts += [part] if len(kept) == len(part.faces) else [part.only(kept)] if len(kept) else []
    return replace(tile, parts=tuple(parts))


def _named(parts: list[Part]) -> Iterator[Part]:
    """Yield parts by name and material, with a number where several have the same name."""
    seen: dict[str, int] = {}
    for part in sorted(parts, key=lambda part: (part.name, part.material)):
        count = seen[part.name] = seen.get(part.name, 0) + 1
        yield part if count == 1 else replace(part, name=f"{part.name}_{count}")


def normals_of(part: Part) -> FloatArray:
    """Return the normals of vertices, (n, 3): of the triangles around them, each by its area."""
    a, b, c = np.moveaxis(part.vertices[part.faces], 1, 0)
    area = np.cross(b - a, c - a)
    out = np.zeros((len(part.vertices), 3))
    for k in range(3):
        for axis in range(3):
            out[:, axis] += np.bincount(part.faces[:, k], weights=area[:, axis], minlength=len(out))
    length = np.linalg.norm(out, axis=1)
    out[length < 1e-12] = [0.0, 0.0, 1.0]
    out /= np.where(length < 1e-12, 1.0, length)[:, None]
    return out


# ---------------------------------------------------------------- glTF

_LOD: Final = "MSFT_lod"


def write_tile(
    tile: Tile, middle: Sequence[float], place: Sequence[float], stream: ByteSink, generator: str, credits: str
) -> None:
    """Write a tile, each part as a node of its name.

    Vertices count from `middle` (inertial x, y, z, m), and the tile's node stands at `place` (likewise, from the
    scene's origin). x, y, z of glTF are x, z, -y of OpenDRIVE. Coarser levels of detail of a node hang on it by the
    extension MSFT_lod, so that programs without it show the finest.
    """
    file, lods = GltfFile(), False
    materials = list(dict.fromkeys(part.material for part in tile.parts))
    nodes = list[dict[str, Any]]()
    meshes = []
    for k, part in enumerate(tile.parts):
        attributes = {
            "POSITION": file.vertices(y_up(part.vertices - np.asarray(middle)), "VEC3", bounds=True),
            "NORMAL": file.vertices(y_up(normals_of(part)), "VEC3"),
            "TEXCOORD_0": file.vertices(part.uv, "VEC2"),
        }
        look = {"material": materials.index(part.material), "mode": TRIANGLES}
        primitive = {"attributes": attributes, "indices": file.triangles(part.faces), **look}
        meshes.append({"name": part.name, "primitives": [primitive]})
        nodes.append({"name": part.name, "mesh": k})
    names = [part.name for part in tile.parts]
    finest = [k for k, name in enumerate(names) if "_LOD" not in name or name.endswith("_LOD0")]
    for k in finest:
        ids = [other for other, name in enumerate(names) if other != k and name[:-1] == names[k][:-1]]
        if names[k].endswith("_LOD0") and ids:
            nodes[k]["extensions"] = {_LOD: {"ids": ids}}
            lods = True
    x, y, z = place
    nodes.append({"name": f"Tile_{tile.column}_{tile.row}", "children": finest, "translation": [x, z, -y + 0.0]})
    asset = {"version": "2.0", "generator": generator}
    document = {
        "asset": asset | ({"copyright": credits} if credits else {}),
        **({"extensionsUsed": [_LOD]} if lods else {}),
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(name) for name in materials],
    }
    file.write(document, stream)


def material_name(name: str) -> str:
    """Return the name of a material in files: letters, digits and underscores."""
    return f"colour_{name[1:]}" if name.startswith("#") else name


def _material(name: str) -> dict[str, Any]:
    """Return a material."""
    look = material_of(name)
    linear = tuple(round(value, 4) for value in look.linear)
    return material(material_name(name), linear, look.metallic, look.roughness)


# ---------------------------------------------------------------- CARLA

TILES_INFO: Final = "TilesInfo.txt"
# Width of what stands for the ground in tiles without anything, m.
_PATCH: Final = 1.0


def carla_tiles(parts: Sequence[Part], size: float) -> list[Tile]:
    """Return parts in tiles of a size, m, in their finest level of detail, but in one if they fit into it."""
    used = [part for part in map(finest, parts) if len(part.faces)]
    low, high = (np.array([side(part.vertices[:, :2], axis=0) for part in used]) for side in (np.min, np.max))
    return tiles_of(used, size if (high.max(0) - low.min(0) > size).any() else np.inf)


def without_gaps(tiles: Sequence[Tile], size: float) -> list[Tile]:
    """Return tiles of a size, m, row by row from the south-west, each row from the first column to its last tile.

    Those that were not there have a metre of ground.
    """
    there = {(tile.row, tile.column): tile for tile in tiles}
    west = min(tile.column for tile in tiles)
    low = min(float(part.vertices[:, 2].min()) for tile in tiles for part in tile.parts)
    out = []
    for row in range(min(tile.row for tile in tiles), max(tile.row for tile in tiles) + 1):
        last = max((tile.column for tile in tiles if tile.row == row), default=west)
        out += [
            there.get((row, column)) or Tile(column, row, (_patch(column, row, size, low),))
            for column in range(west, last + 1)
        ]
    return out


def _patch(column: int, row: int, size: float, z: float) -> Part:
    """Return a square in the middle of a tile."""
    corners = _PATCH * np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    xy = size * (np.array([column, row]) + 0.5) + corners
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.int64)
    return Part("Terrain", "grass", np.column_stack([xy, np.full(4, z)]), xy.copy(), faces)


def carla_names(tiles: Sequence[Tile], name: str, suffix: str) -> list[str]:
    """Return the file of each tile of a map, the first of which is the south-western one; one alone is the map."""
    if len(tiles) == 1:
        return [f"{name}.{suffix}"]
    first = tiles[0]
    return [f"{name}_Tile_{tile.column - first.column}_{tile.row - first.row}.{suffix}" for tile in tiles]


def tiles_info(first: Tile, size: float) -> str:
    """Return x and y of CARLA of the middle of the first tile, and the width of tiles, m."""
    return f"{(first.column + 0.5) * size:.3f},{-(first.row + 0.5) * size:.3f},{size:.3f}"


def package_of(name: str, size: float, files: Sequence[str]) -> dict[str, Any]:
    """Return the description of a package with one map, of tiles of a size, m."""
    meshes = [f"./{Path(file).with_suffix('.fbx')}" for file in files]
    shape = {"source": meshes[0]} if len(meshes) == 1 else {"tile_size": size, "tiles": meshes}
    entry = {"name": name, "xodr": f"./{name}.xodr", "use_carla_materials": True, **shape}
    return {"maps": [entry], "props": []}


# ---------------------------------------------------------------- OBJ


def write_obj_tile(tile: Tile, origin: Sequence[float], stream: ByteSink, library: str, *, y_up: bool) -> None:
    """Write a tile, each part as a group of its name; coarser levels of detail are groups too.

    Coordinates count from `origin` (inertial x, y, z, m); `y_up` makes y up and -z north.
    """
    write_head(stream, f"tile {tile.column} {tile.row}", origin, library, y_up=y_up)
    first = 1
    for part in tile.parts:
        points = part.vertices - np.asarray(origin)
        points = points[:, [0, 2, 1]] * [1, 1, -1] if y_up else points
        stream.write(f"g {part.name}\nusemtl {material_name(part.material)}\n".encode())
        write_rows(stream, "v %.4f %.4f %.4f\n", np.round(points, 4) + 0.0)
        write_rows(stream, "vt %.3f %.3f\n", np.round(part.uv, 3) + 0.0)
        write_rows(stream, "f %d/%d %d/%d %d/%d\n", np.repeat(part.faces + first, 2, axis=1))
        first += len(points)


def obj_materials(names: Iterable[str]) -> bytes:
    """Return the file of materials."""
    out = []
    for name in sorted(set(names)):
        colour = material_of(name).colour
        red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
        out.append(f"newmtl {material_name(name)}\nKd {red:.4f} {green:.4f} {blue:.4f}\nKs 0 0 0\nillum 1\n")
    return "".join(out).encode()


# ---------------------------------------------------------------- the folder

MANIFEST: Final = "scene.json"
_LIBRARY: Final = "scene.mtl"


@record
class SceneFormat:
    """How a scene is written."""

    format: str = "glb"  # ``glb`` or ``obj``
    tile: float = 500.0  # Width of tiles, m
    y_up: bool = False  # Whether y is up in OBJ
    carla: str = ""  # Name of the map in CARLA, whose large maps have tiles of other names; empty for none


def write_scene(
    scene: Scene, file: OpenDrive, folder: Path, form: SceneFormat, generator: str, credits: Sequence[str]
) -> tuple[str, ...]:
    """Write a scene into an empty folder, and return the names of its files.

    `credits` name whom the data are owed.
    """
    found = carla_tiles(scene.parts, form.tile) if form.carla else tiles_of(scene.parts, form.tile)
    whole = [in_single_precision(tile, _middle(tile, form, scene)) for tile in found]
    tiles = [tile for tile in whole if tile.parts]
    if form.carla:
        tiles = without_gaps(tiles, form.tile)
    names = tile_names(tiles, form)
    attribution = "; ".join(credits)
    rows = []
    for tile, name in zip(tiles, names, strict=True):
        middle = _middle(tile, form, scene)
        with (folder / name).open("wb") as stream:
            if form.format == "glb":
                place = np.asarray(middle) - scene.origin
                write_tile(tile, middle, place.tolist(), stream, generator, attribution)
            else:
                write_obj_tile(tile, scene.origin, stream, _LIBRARY, y_up=form.y_up)
        rows.append(_row(tile, name))
    extra = []
    if form.format == "obj":
        used = [part.material for part in scene.parts]
        (folder / _LIBRARY).write_bytes(obj_materials(used))
        extra.append(_LIBRARY)
    if form.carla:
        extra.append(f"{form.carla}.json")
        text = json.dumps(package_of(form.carla, form.tile, names), indent=2)
        (folder / extra[-1]).write_text(text + "\n", encoding="utf-8")
        extra.append(f"{form.carla}.xodr")
        (folder / extra[-1]).write_bytes(file.path.read_bytes())
        if len(tiles) > 1:
            extra.append(TILES_INFO)
            (folder / TILES_INFO).write_text(tiles_info(tiles[0], form.tile), encoding="ascii")
    document = _manifest(scene, file, form, generator, credits, rows, [*names, *extra])
    # Names of files may contain lone surrogates, which UTF-8 cannot encode.
    text = json.dumps(document, ensure_ascii=False, indent=1) + "\n"
    (folder / MANIFEST).write_bytes(text.encode("utf-8", "replace"))
    return (*names, *extra, MANIFEST)


def tile_names(tiles: Sequence[Tile], form: SceneFormat) -> list[str]:
    """Return the file of each tile, of which the first one is the south-western one for CARLA."""
    if not form.carla:
        return [f"tile_{tile.column}_{tile.row}.{form.format}" for tile in tiles]
    return carla_names(tiles, form.carla, form.format)


def _middle(tile: Tile, form: SceneFormat, scene: Scene) -> tuple[float, float, float]:
    """Return the point that vertices of a tile count from: its middle, but the scene's origin for CARLA."""
    if form.carla:
        return scene.origin
    return (tile.column + 0.5) * form.tile, (tile.row + 0.5) * form.tile, 0.0


def _row(tile: Tile, name: str) -> dict[str, Any]:
    """Return what the manifest says about a tile."""
    used = np.concatenate([part.vertices for part in tile.parts])
    parts = [
        {"name": part.name, "material": material_name(part.material), "triangles": len(part.faces)}
        for part in tile.parts
    ]
    bounds = [np.round(side, 3).tolist() for side in (used.min(0), used.max(0))]
    return {"file": name, "column": tile.column, "row": tile.row, "bounds": bounds, "parts": parts}


def _manifest(
    scene: Scene,
    file: OpenDrive,
    form: SceneFormat,
    generator: str,
    credits: Sequence[str],
    rows: Sequence[dict[str, Any]],
    files: Sequence[str],
) -> dict[str, Any]:
    """Return what tells programs about the scene."""
    up = "y" if form.format == "glb" or form.y_up else "z"
    looks = {
        material_name(name): {"colour": look.colour, "roughness": look.roughness, "metallic": look.metallic}
        for name in sorted({part.material for part in scene.parts})
        for look in [material_of(name)]
    }
    return {
        "format": 1,
        "generator": generator,
        "source": file.path.name,
        "units": "m",
        "up": up,
        "inertial_origin": list(scene.origin),
        "geo_reference": file.header.geo_reference,
        "offset": file.header.offset,
        "attribution": list(credits),
        "notes": list(scene.notes),
        "tile_size": form.tile,
        FILES_KEY: list(files),
        "tiles": list(rows),
        "materials": looks,
    }
