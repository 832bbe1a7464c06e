"""The road surface as triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import runs
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive, Ribbons, Stations, lane_ribbons, points_beside, sample_roads

# Up to here coordinates of meshes stay those of the file, m: single precision (24 bits) knows them to 1 mm at least.
# Beyond, they count from a round place, m. Choices.
_EXPORT_EXACT: Final = 16_384.0
_EXPORT_ORIGIN_GRID: Final = 1000.0

# Points closer together than this across the road are one, m.
_SAME: Final = 1e-6
_FARTHEST: Final = 1e30
# What the steps between lanes of different heights are made of.
KERB: Final = "kerb"


@dataclass(frozen=True, eq=False)
class RoadMesh:
    """Triangles of the surface of all lanes.

    Lanes that touch share their vertices, and so do lane sections that follow each other, so that the surface of a
    road has no cracks. Zero-width parts of lanes have no faces.
    """

    vertices: FloatArray  # (n, 3) x, y, z less `origin`, m; z is up
    # Inertial x, y, z of the mesh's own zero, m: 0, 0, 0 unless coordinates are too large for single precision
    origin: tuple[float, float, float]
    # Vertices of triangles (m, 3) by the type of their lane, in alphabetical order; counter-clockwise from above
    faces: dict[str, IntArray]


def road_mesh(file: OpenDrive, tolerance: float, step: float) -> RoadMesh:
    """Return the surface of all lanes.

    Parameters
    ----------
    file
        The network.
    tolerance, step
        See `osm2xodr.opendrive.space.sample_roads`.

    Raises
    ------
    InputError
        If no lane has a surface.
    """
    stations = sample_roads(file, tolerance, step)
    ribbons = lane_ribbons(file, stations)
    lane, side, point = _corners(file, ribbons)
    lift = np.where(side == 0, *_heights(file, lane))
    vertex, unique = _merged(ribbons.station[point], ribbons.t[point], lift)
    vertices = _placed(stations, ribbons.station[point][unique], ribbons.t[point][unique], lift[unique])
    faces = _faces(file, lane, side, vertex)
    faces[KERB] = _kerbs(file, ribbons, lane, side, point, vertex)
    # Damaged files have points that are nowhere, or so far out that single precision does not know them.
    finite = (np.abs(vertices) < _FARTHEST).all(1)
    usable = {kind: triangles[_real(triangles, finite)] for kind, triangles in sorted(faces.items())}
    usable = {kind: triangles for kind, triangles in usable.items() if len(triangles)}
    if not usable:
        raise InputError(f"{file.path} has no lane with a surface; osm2xodr check says what is wrong with it")
    return _compact(vertices, usable)


def _corners(file: OpenDrive, ribbons: Ribbons) -> tuple[IntArray, IntArray, IntArray]:
    """Return lane, side (0 left, 1 right) and point of the corners of all lanes.

    The left corners of a lane come first, then its right ones, each along the road.
    """
    lanes = np.flatnonzero(ribbons.left != ABSENT)
    borders = np.column_stack([ribbons.left[lanes], ribbons.right[lanes]]).ravel()
    count = ribbons.start[borders + 1] - ribbons.start[borders]
    row = np.repeat(np.arange(len(borders)), count)
    point = runs(ribbons.start[borders], count)
    return np.repeat(lanes, 2)[row], row % 2, point


def _heights(file: OpenDrive, lane: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the heights of the left and right borders of lanes above the road, m."""
    inner, outer = np.nan_to_num(file.lanes.height[lane]).T
    left = file.lanes.id[lane] > 0
    return np.where(left, outer, inner), np.where(left, inner, outer)


def _merged(station: IntArray, t: FloatArray, lift: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the vertex of each corner, and one corner of each vertex.

    Corners beside the same station whose t and height differ by rounding only are one vertex.
    """
    order = np.lexsort((t, lift, station))
    apart = np.ones(len(order), np.bool_)
    same = (np.diff(station[order]) == 0) & (np.diff(lift[order]) == 0) & (np.diff(t[order]) < _SAME)
    apart[1:] = ~same
    vertex = np.empty(len(order), np.int64)
    vertex[order] = np.cumsum(apart) - 1
    return vertex, order[apart]


def _placed(stations: Stations, station: IntArray, t: FloatArray, lift: FloatArray) -> FloatArray:
    """Return vertices in space, (n, 3)."""
    x, y, z = stations.x[station], stations.y[station], stations.z[station]
    return np.column_stack(points_beside(x, y, z, stations.hdg[station], stations.roll[station], t, lift))


def _faces(file: OpenDrive, lane: IntArray, side: IntArray, vertex: IntArray) -> dict[str, IntArray]:
    """Return two triangles for each piece of each lane, by the type of the lane."""
    # A left corner and the next one; the right ones lie as many rows farther as the lane has stations.
    goes_on = np.flatnonzero((side[:-1] == 0) & (side[1:] == 0) & (lane[1:] == lane[:-1]))
    across = np.bincount(lane[side == 0], minlength=len(file.lanes.id))[lane[goes_on]]
    quads = np.column_stack([goes_on + across, goes_on + across + 1, goes_on + 1, goes_on])
    triangles = vertex[quads[:, [0, 1, 2, 0, 2, 3]]].reshape(-1, 2, 3)
    kinds = np.array([kind or "none" for kind in file.lanes.type])[lane[goes_on]] if len(goes_on) else np.array([])
    return {str(kind): triangles[kinds == kind].reshape(-1, 3) for kind in np.unique(kinds)}


def _kerbs(
    file: OpenDrive, ribbons: Ribbons, lane: IntArray, side: IntArray, point: IntArray, vertex: IntArray
) -> IntArray:
    """Return triangles between lanes of different heights at the border that they share."""
    if not file.lanes.height.any():
        return np.zeros((0, 3), np.int64)
    # The vertex of each point as the right side of one lane and as the left side of the next.
    seen = np.full((len(ribbons.t), 2), ABSENT)
    seen[point, side] = vertex
    border = np.repeat(np.arange(len(ribbons.section)), np.diff(ribbons.start))
    row = np.flatnonzero((border[1:] == border[:-1]) & (seen[:-1] != ABSENT).all(1) & (seen[1:] != ABSENT).all(1))
    row = row[(seen[row, 0] != seen[row, 1]) | (seen[row + 1, 0] != seen[row + 1, 1])]
    of_left, of_right = seen[:, 1], seen[:, 0]
    corners = np.column_stack([of_right[row], of_right[row + 1], of_left[row + 1], of_left[row]])
    return corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _real(triangles: IntArray, finite: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> IntArray:
    """Return the triangles that have three corners, all of which are known."""
    a, b, c = triangles.T
    rows: IntArray = np.flatnonzero((a != b) & (b != c) & (c != a) & finite[triangles].all(1))
    return rows


def _compact(vertices: FloatArray, faces: dict[str, IntArray]) -> RoadMesh:
    """Return a mesh of the vertices that are used, with an origin that single precision can bear."""
    used = np.zeros(len(vertices), np.bool_)
    for triangles in faces.values():
        used[triangles] = True
    number = np.cumsum(used) - 1
    kept = vertices[used]
    low, high = kept.min(0), kept.max(0)
    origin = np.where(
        np.maximum(np.abs(low), np.abs(high)) > _EXPORT_EXACT,
        np.round(0.5 * (low + high) / _EXPORT_ORIGIN_GRID) * _EXPORT_ORIGIN_GRID,
        0.0,
    )
    x, y, z = origin.tolist()
    return RoadMesh(kept - origin, (x, y, z), {kind: number[triangles] for kind, triangles in faces.items()})
