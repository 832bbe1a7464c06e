"""Road networks for other programs: GeoJSON for maps, OBJ and glTF for 3D scenes, Lanelet2 for automated driving.

The formats are simple enough to write without a library, and faster so: a whole city is a few array operations and
one pass of text. Whole scenes (`scene`) are cut and triangulated by shapely, which takes long to load; tables and
graphs for Python need geopandas and networkx, which not everybody has.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.exporting.elevation import places_around as places_around, read_heights as read_heights
from osm2xodr.exporting.geojson import LAYERS as LAYERS, write_geojson as write_geojson
from osm2xodr.exporting.lanelet2 import (
    PROJECTORS as PROJECTORS,
    projector_info as projector_info,
    write_lanelet2 as write_lanelet2,
)
from osm2xodr.exporting.mesh import (
    RoadMesh as RoadMesh,
    material_library as material_library,
    road_mesh as road_mesh,
    write_glb as write_glb,
    write_obj as write_obj,
)
from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.exporting.frames import geodataframe as geodataframe, write_geopackage as write_geopackage
    from osm2xodr.exporting.graphs import lane_graph as lane_graph
    from osm2xodr.exporting.scene import (
        MANIFEST as MANIFEST,
        Scene as Scene,
        SceneFormat as SceneFormat,
        make_scene as make_scene,
        material_of as material_of,
        write_scene as write_scene,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "frames": ("geodataframe", "write_geopackage"),
        "graphs": ("lane_graph",),
        "scene": ("MANIFEST", "Scene", "SceneFormat", "make_scene", "material_of", "write_scene"),
    },
)
