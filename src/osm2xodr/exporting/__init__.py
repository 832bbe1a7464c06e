"""Road networks for other programs: GeoJSON for maps, OBJ and glTF for scenes.

The files are simple enough to be written by hand, and are written faster so: a whole city is a few array operations
and one pass of text. A library for meshes or maps would be a dependency for three short modules.
"""

from __future__ import annotations

from osm2xodr.exporting.geojson import LAYERS, write_geojson
from osm2xodr.exporting.gltf import write_glb
from osm2xodr.exporting.mesh import RoadMesh, road_mesh
from osm2xodr.exporting.wavefront import material_library, write_obj

__all__ = ["LAYERS", "RoadMesh", "material_library", "road_mesh", "write_geojson", "write_glb", "write_obj"]
