"""The road surface as binary glTF 2.0 (.glb)."""

from __future__ import annotations

from osm2xodr.exporting.binary_gltf import TRIANGLES, GltfFile, material, y_up
from osm2xodr.exporting.mesh import RoadMesh, color_of
from osm2xodr.opendrive import Header
from osm2xodr.system import ByteSink


def write_glb(mesh: RoadMesh, header: Header, stream: ByteSink, version: str) -> None:
    """Write a mesh as one node of one mesh, with a primitive and a material per type of lane.

    x, y, z of glTF are x, z, -y of OpenDRIVE. The node's extras hold the origin in inertial coordinates and, from the
    network's header, geoReference and offset; the asset holds the version of this program.
    """
    file = GltfFile()
    points = {"POSITION": file.vertices(y_up(mesh.vertices), "VEC3", bounds=True)}
    parts = [
        {"attributes": points, "indices": file.triangles(rows, bounds=True), "material": k, "mode": TRIANGLES}
        for k, rows in enumerate(mesh.faces.values())
    ]
    extras = {"inertial_origin": list(mesh.origin), "geo_reference": header.geo_reference, "offset": header.offset}
    document = {
        "asset": {"version": "2.0", "generator": f"osm2xodr {version}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "road surface", "mesh": 0, "extras": extras}],
        "meshes": [{"name": "road surface", "primitives": parts}],
        "materials": [material(kind, color_of(kind), 0.0, 0.9) for kind in mesh.faces],
    }
    file.write(document, stream)
