"""Road networks for other programs: GeoJSON for maps, OBJ and glTF for 3D scenes, Lanelet2 for automated driving.

The formats are simple enough to write without a library, and faster so: a whole city is a few array operations and
one pass of text.
"""

from __future__ import annotations

from osm2xodr.exporting.geojson import LAYERS, write_geojson
from osm2xodr.exporting.gltf import write_glb
from osm2xodr.exporting.lanelet2 import PROJECTORS, projector_info, write_lanelet2
from osm2xodr.exporting.mesh import RoadMesh, road_mesh
from osm2xodr.exporting.wavefront import material_library, write_obj

__all__ = [
    "LAYERS",
    "PROJECTORS",
    "RoadMesh",
    "material_library",
    "projector_info",
    "road_mesh",
    "write_geojson",
    "write_glb",
    "write_lanelet2",
    "write_obj",
]
