"""Road marks as strips above the surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from osm2xodr.exporting.scene.materials import MARKING
from osm2xodr.exporting.scene.meshes import Meshes, SurfaceHeights
from osm2xodr.exporting.scene.model import Part
from osm2xodr.furniture_shapes import DASH, DASH_GAP, DRAWN_MARK_WIDTH, mark_pattern
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import ABSENT, OpenDrive, Ribbons, Stations, lane_ribbons, sample_roads

# Height of paint above the surface, m: enough for depth buffers from afar, too little to be seen from the side.
PAINT: Final = 0.015
# Surfaces farther away in height are not those that a mark is on, m.
_REACH: Final = 1.0


def mark_parts(file: OpenDrive, heights: SurfaceHeights, tolerance: float, step: float) -> list[Part]:
    """Return the road marks of all lanes; see `sample_roads` for `tolerance` and `step`, m."""
    stations = sample_roads(file, tolerance, step)
    ribbons = lane_ribbons(file, stations)
    strips: dict[str, list[FloatArray]] = {}
    for line, colour in _lines(file, stations, ribbons):
        strips.setdefault(colour, []).append(line)
    meshes = Meshes()
    for colour, lines in sorted(strips.items()):
        _add(meshes, f"marking_{colour}", lines, heights)
    return meshes.parts()


def _lines(file: OpenDrive, stations: Stations, ribbons: Ribbons) -> Iterator[tuple[FloatArray, str]]:
    """Yield left and right edge of each painted piece, (points, 2, 4) s, x, y, z, and its colour."""
    marks = file.lanes.marks
    section_s = file.sections.s
    points = np.column_stack([stations.s[ribbons.station], ribbons.x, ribbons.y, ribbons.z])
    for lane in np.flatnonzero(np.diff(marks.start) > 0).tolist():
        border, outward = _border_of(file, ribbons, lane)
        if border is None:
            continue
        line = points[ribbons.start[border] : ribbons.start[border + 1]]
        rows = range(int(marks.start[lane]), int(marks.start[lane + 1]))
        begins = [float(section_s[file.lanes.section[lane]] + marks.s[row]) for row in rows]
        for row, low, high in zip(rows, begins, [*begins[1:], np.inf], strict=True):
            name = marks.type[row]
            colour = "yellow" if file.lanes.mark_color[lane] == "yellow" else "white"
            for lateral, broken, _ in (
                mark_pattern(name, 2 if name == "broken" else 1, colour) if name != "curb" else ()
            ):
                moved = lateral - outward * 0.5 * DRAWN_MARK_WIDTH
                for piece in _pieces(line, low, high, broken=broken):
                    yield _strip(piece, moved), colour


def _border_of(file: OpenDrive, ribbons: Ribbons, lane: int) -> tuple[int | None, int]:
    """Return the border that a lane's marks are on, and which side of it has no lane: 1 the right, -1 the left."""
    number = int(file.lanes.id[lane])
    section = file.lanes.section[lane]
    if number == ABSENT:
        return None, 0
    if number:
        border = int((ribbons.left if number > 0 else ribbons.right)[lane])
        return (None, 0) if border == ABSENT else (border, _outward(file, lane, number))
    for row in range(int(file.lanes.start[section]), int(file.lanes.start[section + 1])):
        if file.lanes.id[row] in (1, -1):
            border = int((ribbons.right if file.lanes.id[row] > 0 else ribbons.left)[row])
            return (None, 0) if border == ABSENT else (border, 0)
    return None, 0


def _outward(file: OpenDrive, lane: int, number: int) -> int:
    """Return the side beyond an outermost border, 0 if there is a lane."""
    step = -1 if number > 0 else 1
    beyond = lane + step
    inside = 0 <= beyond < len(file.lanes.id) and file.lanes.section[beyond] == file.lanes.section[lane]
    return 0 if inside else step


def _pieces(line: FloatArray, low: float, high: float, *, broken: bool) -> Iterator[FloatArray]:
    """Yield the painted pieces of a line (points, 4) between two s."""
    low, high = max(low, float(line[0, 0])), min(high, float(line[-1, 0]))
    while high - low > 1e-3:
        end = min(low + DASH, high) if broken else high
        inner = line[(line[:, 0] > low + 1e-6) & (line[:, 0] < end - 1e-6), 0]
        at = np.concatenate([[low], inner, [end]])
        yield np.column_stack([at, *(np.interp(at, line[:, 0], line[:, k]) for k in (1, 2, 3))])
        low = end + DASH_GAP if broken else high


def _strip(line: FloatArray, lateral: float) -> FloatArray:
    """Return left and right edge, (points, 2, 4), of a line that is moved to the right."""
    along = np.gradient(line[:, 1:3], axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    right = np.column_stack([along[:, 1], -along[:, 0]])
    out = np.repeat(line[:, None], 2, axis=1)
    for k, side in enumerate((-0.5, 0.5)):
        out[:, k, 1:3] += (lateral + side * DRAWN_MARK_WIDTH) * right
    return out


def _add(meshes: Meshes, material: str, strips: list[FloatArray], heights: SurfaceHeights) -> None:
    """Add strips on the surface."""
    points = np.concatenate(strips).reshape(-1, 4)
    z = heights.at(points[:, 1], points[:, 2], points[:, 3], _REACH) + PAINT
    count = np.array([len(strip) for strip in strips])
    last = np.zeros(int(count.sum()), np.bool_)
    last[np.cumsum(count) - 1] = True
    k = 2 * np.flatnonzero(~last)
    faces = np.concatenate([np.column_stack([k, k + 1, k + 3]), np.column_stack([k, k + 3, k + 2])])
    side = np.tile([0.0, DRAWN_MARK_WIDTH], len(last))
    vertices = np.column_stack([points[:, 1:3], z])
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    flat = np.cross(b - a, c - a)[:, 2] > 1e-6
    meshes.add(MARKING, material, vertices, np.column_stack([points[:, 0], side]), faces[flat])
