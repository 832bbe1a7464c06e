"""Roads, ground and buildings as a scene of meshes, in tiles.

`scene` has the steps in order. `roads` makes one surface of all roads, `things` adds what is on and beside them,
`ground`, `water` and `buildings` the rest. `folder` writes it, in tiles, as glTF or OBJ.
"""

from __future__ import annotations

from osm2xodr.exporting.scene.folder import (
    MANIFEST as MANIFEST,
    SceneFormat as SceneFormat,
    write_scene as write_scene,
)
from osm2xodr.exporting.scene.model import material_of as material_of
from osm2xodr.exporting.scene.scene import Scene as Scene, make_scene as make_scene
