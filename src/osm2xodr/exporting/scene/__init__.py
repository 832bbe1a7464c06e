"""Roads, ground and buildings as a scene of meshes, in tiles.

`scene` has the steps in order. `roads` makes one surface of all roads: `lane_faces` are the lanes as they are, whose
edges are noded once; `arrangement` has what makes triangles, and steps where they differ in height, of such lines.
`marks`, `things` and `structures` add what is on, beside, below and around roads, `ground` and `buildings` the rest.
`folder` writes it, in tiles (`tiles`), as glTF (`glb`) or OBJ (`obj`).
"""

from __future__ import annotations

from osm2xodr.exporting.scene.folder import MANIFEST, SceneFormat, write_scene
from osm2xodr.exporting.scene.model import material_of
from osm2xodr.exporting.scene.scene import Scene, make_scene

__all__ = ["MANIFEST", "Scene", "SceneFormat", "make_scene", "material_of", "write_scene"]
