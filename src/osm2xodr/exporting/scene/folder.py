"""The folder that a scene is written to: its tiles, and what tells about them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.scene.carla import TILES_INFO, carla_names, carla_tiles, package_of, tiles_info, without_gaps
from osm2xodr.exporting.scene.glb import material_name, write_tile
from osm2xodr.exporting.scene.materials import material_of
from osm2xodr.exporting.scene.obj import obj_materials, write_obj_tile
from osm2xodr.exporting.scene.scene import Scene
from osm2xodr.exporting.scene.tiles import Tile, in_single_precision, tiles_of
from osm2xodr.opendrive import OpenDrive
from osm2xodr.system import FILES_KEY

MANIFEST: Final = "scene.json"
_LIBRARY: Final = "scene.mtl"


@dataclass(frozen=True)
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
    owed = "; ".join(credits)
    rows = []
    for tile, name in zip(tiles, names, strict=True):
        middle = _middle(tile, form, scene)
        with (folder / name).open("wb") as stream:
            if form.format == "glb":
                place = np.asarray(middle) - scene.origin
                write_tile(tile, middle, place.tolist(), stream, generator, owed)
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
