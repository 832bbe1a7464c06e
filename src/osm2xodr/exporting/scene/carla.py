"""How CARLA's importer wants the tiles of a map: names, no gaps, and two files about them.

From the sources of CARLA 0.9.13 to 0.9.15. `Import.py` reads the package, and gives maps of one ``source`` their
walkers' navigation. `PrepareAssetsForCookingCommandlet` looks for tiles from 0, 0 on, and for no more of a row after
the first one that is missing, and for no more rows after the first one without any.
`ALargeMapManager::GetTileLocation` puts tile X, Y at X and -Y times the width from the middle of tile 0, 0, which it
has from ``TilesInfo.txt``; y of CARLA is -y of OpenDRIVE.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from osm2xodr.exporting.scene.model import Part
from osm2xodr.exporting.scene.tiles import Tile, finest, tiles_of

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
