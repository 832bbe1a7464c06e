"""The road surface as triangles with colours, and meshes as files: Wavefront OBJ and binary glTF 2.0 (.glb).

glTF after its specification (Khronos Group, 2021), sections 3.6 (binary data), 3.7 (meshes) and 4 (GLB):
little-endian throughout, chunks padded to 4 bytes, y up.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from osm2xodr.curves import owners, repeated, runs
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, Header, OpenDrive, Ribbons, lane_ribbons, points_beside, sample_roads
from osm2xodr.system import ByteSink, record

# Coordinates of meshes are those of the file up to here, m: single precision (24 bits) resolves them to 1 mm. Larger
# ones count from an origin on a grid of this width, m. Choices.
_LARGEST_COORDINATE: Final = 16_384.0
_ORIGIN_GRID: Final = 1000.0
# Points closer together than this across the road are one, m.
_SAME: Final = 1e-6
# Coordinates of damaged files may be larger than single precision can hold, m.
_FARTHEST: Final = 1e30
# The type of the faces between lanes of different heights.
KERB: Final = "kerb"

_ASPHALT: Final = (0.22, 0.22, 0.24)
_PAVING: Final = (0.55, 0.53, 0.50)
_GRASS: Final = (0.30, 0.42, 0.20)
# Linear red, green, blue from 0 to 1 by OpenDRIVE's types of lanes; choices.
_COLORS: Final = MappingProxyType(
    {
        "biking": (0.45, 0.18, 0.14),
        "border": _GRASS,
        "bus": (0.30, 0.22, 0.22),
        "curb": _PAVING,
        KERB: _PAVING,
        "median": _GRASS,
        "none": _GRASS,
        "parking": (0.32, 0.32, 0.36),
        "rail": (0.28, 0.22, 0.18),
        "restricted": (0.40, 0.38, 0.30),
        "shoulder": (0.26, 0.26, 0.28),
        "sidewalk": _PAVING,
        "stop": (0.30, 0.30, 0.33),
        "tram": (0.28, 0.22, 0.18),
        "walking": _PAVING,
    }
)

# Rows of text that are formatted at a time.
_BLOCK: Final = 100_000


@record(eq=False)
class RoadMesh:
    """Triangles of the surface of all lanes.

    Lanes that touch share their vertices, and so do lane sections that follow each other, so that the surface of a
    road has no cracks. Parts of lanes without width have no faces.
    """

    vertices: FloatArray  # (n, 3) x, y, z from `origin`, m; z is up
    # Inertial x, y, z, m: 0, 0, 0 unless coordinates are too large for single precision
    origin: tuple[float, float, float]
    # Vertices of triangles (m, 3) by the type of their lane, in alphabetical order; counter-clockwise from above
    faces: dict[str, IntArray]


def road_mesh(file: OpenDrive, tolerance: float, step: float) -> RoadMesh:
    """Return the surface of all lanes; for `tolerance` and `step`, m, see `osm2xodr.opendrive.sample_roads`.

    `InputError` if no lane has a surface.
    """
    stations = sample_roads(file, tolerance, step)
    ribbons = lane_ribbons(file, stations)
    lane, side, point = _corners(ribbons)
    # Heights above the road, m: the left border of lanes on the left is the outer one.
    inner, outer = np.nan_to_num(file.lanes.height[lane]).T
    lift = np.where((side == 0) == (file.lanes.id[lane] > 0), outer, inner)
    station, t = ribbons.station[point], ribbons.t[point]
    vertex, unique = _merged(station, t, lift)
    columns = stations.x, stations.y, stations.z, stations.hdg, stations.roll
    x, y, z, hdg, roll = (column[station[unique]] for column in columns)
    vertices = np.column_stack(points_beside(x, y, z, hdg, roll, t[unique], lift[unique]))
    faces = _faces(file, lane, side, vertex)
    faces[KERB] = _kerbs(file, ribbons, side, point, vertex)
    # Damaged files have points that are unknown or too far out for single precision.
    finite = (np.abs(vertices) < _FARTHEST).all(1)
    usable = {kind: rows for kind in sorted(faces) if len(rows := _usable(faces[kind], finite))}
    if not usable:
        raise InputError(f"{file.path} has no lane with a surface; osm2xodr check lists what is wrong with it")
    return _compact(vertices, usable)


def _corners(ribbons: Ribbons) -> tuple[IntArray, IntArray, IntArray]:
    """Return lane, side (0 left, 1 right) and point of the corners of all lanes.

    The left corners of a lane come first, then its right ones, each along the road.
    """
    lanes = np.flatnonzero(ribbons.left != ABSENT)
    borders = np.column_stack([ribbons.left[lanes], ribbons.right[lanes]]).ravel()
    count = ribbons.start[borders + 1] - ribbons.start[borders]
    row = repeated(count)
    point = runs(ribbons.start[borders], count)
    return np.repeat(lanes, 2)[row], row % 2, point


def _merged(station: IntArray, t: FloatArray, lift: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the vertex of each corner, and one corner of each vertex.

    Corners beside the same station whose t and height differ by rounding only are one vertex.
    """
    order = np.lexsort((t, lift, station))
    apart = np.ones(len(order), np.bool_)
    apart[1:] = (np.diff(station[order]) != 0) | (np.diff(lift[order]) != 0) | ~(np.diff(t[order]) < _SAME)
    vertex = np.empty(len(order), np.int64)
    vertex[order] = np.cumsum(apart) - 1
    return vertex, order[apart]


def _faces(file: OpenDrive, lane: IntArray, side: IntArray, vertex: IntArray) -> dict[str, IntArray]:
    """Return two triangles for each piece of each lane, by the type of the lane."""
    # A left corner and the next one; the right ones stand as many rows farther on as the lane has stations.
    goes_on = np.flatnonzero((side[:-1] == 0) & (side[1:] == 0) & (lane[1:] == lane[:-1]))
    across = np.bincount(lane[side == 0], minlength=len(file.lanes.id))[lane[goes_on]]
    quads = np.column_stack([goes_on + across, goes_on + across + 1, goes_on + 1, goes_on])
    triangles = vertex[quads[:, [0, 1, 2, 0, 2, 3]]].reshape(-1, 2, 3)
    kinds = np.array([kind or "none" for kind in file.lanes.type])[lane[goes_on]] if len(goes_on) else np.array([])
    return {str(kind): triangles[kinds == kind].reshape(-1, 3) for kind in np.unique(kinds)}


def _kerbs(file: OpenDrive, ribbons: Ribbons, side: IntArray, point: IntArray, vertex: IntArray) -> IntArray:
    """Return triangles between lanes of different heights at the border that they share."""
    if not file.lanes.height.any():
        return np.zeros((0, 3), np.int64)
    # The vertex of each point as the right side of one lane and as the left side of the next.
    seen = np.full((len(ribbons.t), 2), ABSENT)
    seen[point, side] = vertex
    border = owners(ribbons.start)
    row = np.flatnonzero((border[1:] == border[:-1]) & (seen[:-1] != ABSENT).all(1) & (seen[1:] != ABSENT).all(1))
    row = row[(seen[row, 0] != seen[row, 1]) | (seen[row + 1, 0] != seen[row + 1, 1])]
    of_left, of_right = seen[:, 1], seen[:, 0]
    corners = np.column_stack([of_right[row], of_right[row + 1], of_left[row + 1], of_left[row]])
    return corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _usable(triangles: IntArray, finite: BoolArray) -> IntArray:
    """Return the triangles that have three different corners, all of which are known."""
    a, b, c = triangles.T
    out: IntArray = triangles[(a != b) & (b != c) & (c != a) & finite[triangles].all(1)]
    return out


def _compact(vertices: FloatArray, faces: dict[str, IntArray]) -> RoadMesh:
    """Return a mesh of the vertices in use, with an origin from which single precision is enough."""
    used = np.zeros(len(vertices), np.bool_)
    for triangles in faces.values():
        used[triangles] = True
    number, kept = np.cumsum(used) - 1, vertices[used]
    origin = file_origin(kept)
    return RoadMesh(kept - origin, origin, {kind: number[triangles] for kind, triangles in faces.items()})


def file_origin(vertices: FloatArray) -> tuple[float, float, float]:
    """Return the point that files count from: 0, 0, 0 unless coordinates are too large for single precision."""
    middle = np.round(0.5 * (vertices.min(0) + vertices.max(0)) / _ORIGIN_GRID) * _ORIGIN_GRID
    x, y, z = np.where(np.abs(vertices).max(0) > _LARGEST_COORDINATE, middle, 0.0).tolist()
    return x, y, z


def color_of(kind: str) -> tuple[float, float, float]:
    """Return the colour of a type of lanes; unknown types look like asphalt."""
    return _COLORS.get(kind, _ASPHALT)


def write_obj(mesh: RoadMesh, stream: ByteSink, library: str | None, *, y_up: bool) -> None:
    """Write a mesh as OBJ, one group and material per type of lane, which the file `library`, if any, describes.

    `y_up` makes y up and -z north, as in most programs for 3D scenes; else z is up and y north, as in OpenDRIVE.
    """
    write_head(stream, "road surface", mesh.origin, library, y_up=y_up)
    vertices = mesh.vertices[:, [0, 2, 1]] * [1, 1, -1] if y_up else mesh.vertices
    write_rows(stream, "v %.4f %.4f %.4f\n", np.round(vertices, 4) + 0.0)
    for kind, triangles in mesh.faces.items():
        name = _name(kind)
        stream.write(f"g {name}\nusemtl {name}\n".encode())
        write_rows(stream, "f %d %d %d\n", triangles + 1)


def write_head(stream: ByteSink, what: str, origin: Sequence[float], library: str | None, *, y_up: bool) -> None:
    """Write what a file is of, the inertial point (m) that it counts from, and its library of materials."""
    x, y, z = origin
    axes = "y up, x east, -z north" if y_up else "z up, x east, y north"
    stream.write(f"# osm2xodr: {what}, m, {axes}\n# origin at inertial x={x:g} y={y:g} z={z:g}\n".encode())
    if library is not None:
        stream.write(f"mtllib {library}\n".encode("utf-8", "surrogateescape"))


def write_rows(stream: ByteSink, form: str, rows: FloatArray | IntArray) -> None:
    """Write a line for each row."""
    for first in range(0, len(rows), _BLOCK):
        block = rows[first : first + _BLOCK]
        stream.write((form * len(block) % tuple(block.ravel().tolist())).encode())


def material_library(mesh: RoadMesh) -> bytes:
    """Return the file of materials of a mesh."""
    return "".join(
        f"newmtl {_name(kind)}\nKd {red:g} {green:g} {blue:g}\nKs 0 0 0\nillum 1\n"
        for kind in mesh.faces
        for red, green, blue in [color_of(kind)]
    ).encode()


def _name(kind: str) -> str:
    """Return a type as a name without blanks."""
    return re.sub(r"\s+", "_", kind)


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


# ---------------------------------------------------------------- the container

# Numbers of the specification: of the file and its chunks, of types of components, of uses of buffers.
_MAGIC: Final = 0x46546C67
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
_FLOAT: Final = 5126
_UNSIGNED_INT: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_ARRAY_BUFFER: Final = 34963
TRIANGLES: Final = 4


def y_up(points: FloatArray) -> FloatArray:
    """Return x, y, z of glTF for those of OpenDRIVE, (n, 3)."""
    turned: FloatArray = points[:, [0, 2, 1]] * [1, 1, -1]
    return turned


class GltfFile:
    """Collects arrays, and writes them with the document that refers to them."""

    def __init__(self) -> None:
        self._accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._blocks: list[bytes] = []
        self._size = 0

    def vertices(self, values: FloatArray, kind: str, *, bounds: bool = False) -> int:
        """Add an array of numbers per vertex, (n, 2 or 3), and return its accessor, with its bounds if asked."""
        block = np.ascontiguousarray(values, "<f4")
        low_high = (block.min(0).astype(float).tolist(), block.max(0).astype(float).tolist()) if bounds else None
        return self._array(block.tobytes(), _ARRAY_BUFFER, _FLOAT, len(block), kind, low_high)

    def triangles(self, faces: IntArray, *, bounds: bool = False) -> int:
        """Add the vertices of triangles, (n, 3), and return their accessor, with its bounds if asked."""
        low_high = ([int(faces.min())], [int(faces.max())]) if bounds else None
        block = np.ascontiguousarray(faces, "<u4").tobytes()
        return self._array(block, _ELEMENT_ARRAY_BUFFER, _UNSIGNED_INT, faces.size, "SCALAR", low_high)

    def _array(
        self,
        block: bytes,
        use: int,
        component: int,
        count: int,
        kind: str,
        bounds: tuple[list[Any], list[Any]] | None,
    ) -> int:
        """Add bytes, whose components have 4 each, to the buffer."""
        self._views.append({"buffer": 0, "byteOffset": self._size, "byteLength": len(block), "target": use})
        self._blocks.append(block)
        self._size += len(block)
        accessor = {"bufferView": len(self._views) - 1, "componentType": component, "count": count, "type": kind}
        self._accessors.append(accessor | ({"min": bounds[0], "max": bounds[1]} if bounds else {}))
        return len(self._accessors) - 1

    def write(self, document: dict[str, Any], stream: ByteSink) -> None:
        """Write the file; the document has all but accessors and buffers."""
        buffers = {"accessors": self._accessors, "bufferViews": self._views, "buffers": [{"byteLength": self._size}]}
        text = json.dumps({**document, **buffers}, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        # All components have 4 bytes: the binary chunk needs no padding.
        stream.write(struct.pack("<III", _MAGIC, 2, 12 + 8 + len(text) + 8 + self._size))
        stream.write(struct.pack("<II", len(text), _JSON_CHUNK) + text)
        for block in (struct.pack("<II", self._size, _BINARY_CHUNK), *self._blocks):
            stream.write(block)


def material(name: str, linear: tuple[float, ...], metallic: float, roughness: float) -> dict[str, Any]:
    """Return a material of a base colour, linear red, green and blue from 0 to 1; both sides are shown."""
    finish = {"baseColorFactor": [*linear, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": finish}
