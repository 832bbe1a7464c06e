"""Water: its areas, their levels, and the triangles of the ground that are water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.arrangement import area_of, places_of, polygons_of
from osm2xodr.exporting.scene.ground.covers import Height
from osm2xodr.exporting.scene.ground.defaults import (
    AT_SHORE,
    MOST_LOWERED,
    WATER_BELOW_ROADS,
    WATER_LEVEL_SPREAD,
    WATER_REACH,
    WATER_SAMPLE,
)
from osm2xodr.exporting.scene.ground.open_water import closed_water, sea_of
from osm2xodr.exporting.scene.model import GRID
from osm2xodr.model import BoolArray, FloatArray, IntArray, Water
from osm2xodr.opendrive import Frame

# Corners along the northern and southern side of a rectangle of longitude and latitude, which is bent.
_SIDE: Final = 16
# How far shores in files without bounds lie within the rectangle to whose sides they go, m.
_MARGIN: Final = 50.0
# Lower steps between water and land are none, m.
_LEAST_WALL: Final = 0.01


@dataclass(frozen=True, eq=False)
class WaterShapes:
    """Areas of water in inertial x, y, m: polygons that may overlap."""

    areas: tuple[Any, ...] = ()
    seas: int = 0  # How many of them, the first ones, are the sea
    levels: FloatArray = field(default_factory=lambda: np.zeros(0))  # Of each area, m; NaN where it is not level
    # OSM ids of areas whose outline is not whole in the file: those closed along the side, and those left out
    closed: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    @cached_property
    def union(self) -> Any:
        """All areas as one."""
        out = shapely.union_all(np.array(self.areas, object))
        shapely.prepare(out)
        return out

    @cached_property
    def shore(self) -> Any:
        """The outline of all areas."""
        return shapely.boundary(self.union)

    def found_at(self, x: FloatArray, y: FloatArray) -> IntArray:
        """Return the first area at each place, (n,), -1 for none."""
        out = np.full(len(x), -1)
        for row in range(len(self.areas) - 1, -1, -1):
            low_x, low_y, high_x, high_y = self.areas[row].bounds
            near = np.flatnonzero((x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y))
            out[near[shapely.contains_xy(self.areas[row], x[near], y[near])]] = row
        return out

    def level_at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the height of level water at each place, (n,), m; NaN where there is none."""
        return self.level_of(self.found_at(x, y))

    def level_of(self, area: IntArray) -> FloatArray:
        """Return the height of level water in areas, -1 for none, m; NaN where there is none or it falls."""
        found: FloatArray = np.append(self.levels, np.nan)[area]
        return found


def water_shapes(water: Water, frame: Frame, roads: FloatArray, on_land: FloatArray) -> WaterShapes:
    """Return the water around roads, whose surface has vertices (n, 2 or 3), m, some of them on land (n, 2 or 3)."""
    low, high = roads[:, :2].min(0) - 2.0 * WATER_REACH, roads[:, :2].max(0) + 2.0 * WATER_REACH
    box = shapely.box(*low, *high)
    lines = [line for line in _places(water.coastlines, frame) if np.isfinite(line).all()]
    sea = [
        part for shape in sea_of(lines, box, on_land[:, :2]) for part in polygons_of(shapely.intersection(shape, box))
    ]
    inland = []
    for area in water.areas:
        outline, *holes = _places((area.outline, *area.holes), frame)
        if not all(np.isfinite(ring).all() for ring in (outline, *holes)):
            continue
        inland += list(polygons_of(shapely.intersection(area_of(outline, holes)[0], box)))
    more, closed, left_out = _open_areas(water, frame, box, on_land[:, :2])
    inland += more
    for part in (*sea, *inland):
        shapely.prepare(part)
    return WaterShapes((*sea, *inland), len(sea), closed=closed, left_out=left_out)


def _open_areas(
    water: Water, frame: Frame, box: Any, on_land: FloatArray
) -> tuple[list[Any], tuple[str, ...], tuple[str, ...]]:
    """Return the water in a rectangle of areas that are not whole, and the ids of those closed and left out."""
    if not water.open_areas:
        return [], (), ()
    known = box if water.bounds is None else _within(box, water.bounds, frame)
    found, closed, left_out = list[Any](), list[str](), list[str]()
    for area in water.open_areas:
        rings = _places((*area.lines, *area.holes), frame)
        lines, holes = rings[: len(area.lines)], rings[len(area.lines) :]
        if not all(np.isfinite(ring).all() for ring in rings):
            left_out.append(area.osm_id)
            continue
        if water.bounds is None:
            around = shapely.box(*shapely.total_bounds(shapely.linestrings(np.concatenate(lines))))
            known = shapely.intersection(box, around.buffer(_MARGIN, join_style="mitre"))
        if known.is_empty:
            continue
        shape = closed_water(lines, known, on_land)
        if shape is None:
            left_out.append(area.osm_id)
            continue
        for hole in holes:
            shape = shapely.difference(shape, shapely.make_valid(shapely.Polygon(hole)))
        parts = polygons_of(shape)
        found += list(parts)
        closed += [area.osm_id] if len(parts) else []
    return found, tuple(closed), tuple(left_out)


def _within(box: Any, bounds: tuple[float, float, float, float], frame: Frame) -> Any:
    """Return what of a rectangle in inertial x, y, m, is within bounds of longitude and latitude, degrees."""
    corners = np.column_stack(frame.to_geographic(*shapely.get_coordinates(box).T))
    west, south = np.maximum(corners.min(0), bounds[:2])
    east, north = np.minimum(corners.max(0), bounds[2:])
    if not (west < east and south < north):
        return shapely.Polygon()
    lon = np.concatenate([np.linspace(west, east, _SIDE), np.linspace(east, west, _SIDE)])
    xy = np.column_stack(frame.to_inertial(lon, np.repeat([south, north], _SIDE)))
    return shapely.intersection(box, shapely.Polygon(xy))


def _places(rings: Sequence[FloatArray], frame: Frame) -> list[FloatArray]:
    """Return inertial x, y (n, 2), m, of lines of longitude and latitude."""
    if not rings:
        return []
    xy = np.column_stack(frame.to_inertial(*np.concatenate(rings).T))
    return np.split(xy, np.cumsum([len(ring) for ring in rings])[:-1])


def levelled(shapes: WaterShapes, height: Height, beside: FloatArray) -> WaterShapes:
    """Return areas of water with their levels.

    Elevation models have waves and noise there. Inland water that falls, as rivers do, stays as it is. Level
    water is lower than what lies `beside` it: places of roads on the ground, (n, 3), m.
    """
    spread = [np.inf if row < shapes.seas else WATER_LEVEL_SPREAD for row in range(len(shapes.areas))]
    levels = np.array([_level(area, height, most) for area, most in zip(shapes.areas, spread, strict=True)])
    row, at = shapely.STRtree(shapely.points(beside[:, :2])).query(
        np.array(shapes.areas, object), "dwithin", distance=AT_SHORE
    )
    z = beside[at, 2] - WATER_BELOW_ROADS
    most = np.full(len(levels), np.inf)
    if (row < shapes.seas).any():
        # There is one sea, and models without heights on it know cliffs alone.
        most[: shapes.seas] = np.percentile(z[row < shapes.seas], 10)
    kept = (row >= shapes.seas) & (z > levels[row] - MOST_LOWERED)
    np.minimum.at(most, row[kept], z[kept])
    return replace(shapes, levels=np.minimum(levels, most))


def _level(area: Any, height: Height, spread: float) -> float:
    """Return the height of an area of water, m; NaN where it varies by more than a spread, m, or is not known."""
    low_x, low_y, high_x, high_y = area.bounds
    x, y = (axis.ravel() for axis in np.meshgrid(_steps(low_x, high_x), _steps(low_y, high_y)))
    inside = shapely.contains_xy(area, x, y)
    z = height(x[inside], y[inside])
    z = z[np.isfinite(z)]
    if not len(z):
        return float("nan")
    low, middle, high = np.percentile(z, [10, 50, 90])
    return float(middle) if high - low <= spread else float("nan")


def _steps(low: float, high: float) -> FloatArray:
    """Return places from one to another, m, at least some in small areas."""
    count = max(int((high - low) / WATER_SAMPLE), 8)
    out: FloatArray = low + (high - low) * (np.arange(count) + 0.5) / count
    return out


@dataclass(frozen=True, eq=False)
class Split:
    """Triangles (m, 3) of vertices (n, 3 or more), m, that are land, water, and walls at shores."""

    vertices: FloatArray
    land: IntArray
    water: IntArray
    walls: IntArray


def split_by_water(vertices: FloatArray, faces: IntArray, shapes: WaterShapes) -> Split:
    """Return the triangles of the ground, cut at the shores.

    Pieces lie in the plane of their triangle, so that neighbours still meet: the ground goes on as it is below level
    water, and land ends at the shore at its own height, at that of the water at least. Walls stand between both.
    What `vertices` (n, 3 or more) have beside x, y, z is interpolated.
    """
    vertices, faces, wet, area = _cut(vertices, faces, shapes)
    rows = np.flatnonzero(wet & np.isfinite(shapes.level_of(area)))
    area = area[rows]
    used, corner = np.unique(faces[rows], return_inverse=True)
    place, _ = places_of(vertices[used][:, :2], GRID)
    corner = corner.reshape(-1, 3)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    total, levels = len(used), np.repeat(shapes.levels[area], 3)
    p, q = place[start], place[end]
    outer = ~np.isin(p * total + q, q * total + p) & (p != q)
    a, b = vertices[used[start[outer]]], vertices[used[end[outer]]]
    z = levels[outer]
    high = (np.abs(np.column_stack([a[:, 2], b[:, 2]]) - z[:, None]) > _LEAST_WALL).any(1)
    a, b, z = a[high], b[high], z[high]
    # One level corner of each area at a place.
    key, flat_corner = np.unique(np.repeat(area, 3) * total + start, return_inverse=True)
    area_of, vertex = np.divmod(key, total)
    flat = _at_level(vertices[used[vertex]], shapes.levels[area_of])
    quads = np.stack([a, b, _at_level(b, z), _at_level(a, z)], axis=1).reshape(-1, vertices.shape[1])
    walls = 4 * np.arange(len(a))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    first = len(vertices)
    faces = faces.copy()
    faces[rows] = first + flat_corner.reshape(-1, 3)
    return Split(
        np.concatenate([vertices, flat, quads]), faces[~wet], faces[wet], first + len(flat) + walls.reshape(-1, 3)
    )


def _at_level(points: FloatArray, z: FloatArray) -> FloatArray:
    """Return points (n, 3 or more) at heights (n,), m."""
    return np.column_stack([points[:, :2], z, points[:, 3:]])


def _cut(
    vertices: FloatArray, faces: IntArray, shapes: WaterShapes
) -> tuple[FloatArray, IntArray, BoolArray, IntArray]:
    """Return vertices, those that were there first, triangles cut at the shores, which are water, and their areas."""
    corners = vertices[faces]
    area = _area_of(corners, shapes)
    low, high = corners[:, :, :2].min(1), corners[:, :, :2].max(1)
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    _, near = shapely.STRtree(boxes).query(_segments(shapes.shore), predicate="intersects")
    near = np.unique(near)
    plan = shapely.polygons(corners[near][:, :, :2])
    crossed = shapely.intersects(plan, shapes.shore)
    near, plan = near[crossed], plan[crossed]
    pieces, row, wets = list[Any](), list[IntArray](), list[BoolArray]()
    for shape, is_wet in (
        (shapely.intersection(plan, shapes.union), True),
        (shapely.difference(plan, shapes.union), False),
    ):
        parts, of = shapely.get_parts(shapely.constrained_delaunay_triangles(shape), return_index=True)
        pieces.append(shapely.orient_polygons(parts))
        row.append(near[of])
        wets.append(np.full(len(parts), is_wet))
    xy = shapely.get_coordinates(np.concatenate(pieces)).reshape(-1, 4, 2)[:, :3]
    more = np.dstack([xy, _values(corners[np.concatenate(row)], xy)])
    new_wet, new_area = np.concatenate(wets), _area_of(more, shapes)
    more[..., 2] = np.maximum(more[..., 2], _at_shores(more, new_wet, shapes.level_of(new_area)))
    more, new = np.unique(more.reshape(-1, vertices.shape[1]), axis=0, return_inverse=True)
    new = len(vertices) + new.reshape(-1, 3)
    kept = np.delete(np.arange(len(faces)), near)
    return (
        np.concatenate([vertices, more]),
        np.concatenate([faces[kept], new]),
        np.concatenate([area[kept] >= 0, new_wet]),
        np.concatenate([area[kept], new_area]),
    )


def _area_of(corners: FloatArray, shapes: WaterShapes) -> IntArray:
    """Return the area of water in which the middle of each triangle (n, 3, 2 or more) lies, (n,), -1 for none."""
    middle = corners[:, :, :2].mean(1)
    return shapes.found_at(middle[:, 0], middle[:, 1])


def _at_shores(corners: FloatArray, wet: BoolArray, level: FloatArray) -> FloatArray:
    """Return the height of level water at corners (n, 3) of triangles that lie at its shore, m; -inf elsewhere.

    `corners`, (n, 3, 2 or more), are of triangles on both sides, of which those that are `wet` (n,) have a level,
    (n,), m, or NaN.
    """
    _, place = np.unique(corners[..., :2].reshape(-1, 2), axis=0, return_inverse=True)
    place = place.reshape(-1, 3)
    high = np.full(place.max(initial=0) + 1, -np.inf)
    known = wet & np.isfinite(level)
    np.maximum.at(high, place[known], level[known, None])
    dry = np.zeros(len(high), np.bool_)
    dry[place[~wet]] = True
    return np.where(dry, high, -np.inf)[place]


def _segments(shape: Any) -> Any:
    """Return the lines between the corners of lines."""
    at, row = shapely.get_coordinates(shapely.get_parts(shape), return_index=True)
    same = row[1:] == row[:-1]
    return shapely.linestrings(np.stack([at[:-1][same], at[1:][same]], axis=1))


def _values(corners: FloatArray, xy: FloatArray) -> FloatArray:
    """Return what triangles (n, 3, 2 + k) have beside x, y at places in them, (n, 3, 2); exact at corners."""
    a, b, c = (corners[:, None, k] for k in range(3))
    one, other, off = (b - a)[..., :2], (c - a)[..., :2], xy - a[..., :2]
    area = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    to_b = (off[..., 0] * other[..., 1] - off[..., 1] * other[..., 0]) / area
    to_c = (one[..., 0] * off[..., 1] - one[..., 1] * off[..., 0]) / area
    out: FloatArray = a[..., 2:] + to_b[..., None] * (b - a)[..., 2:] + to_c[..., None] * (c - a)[..., 2:]
    for corner in (a, b, c):
        same = (xy == corner[..., :2]).all(2)
        out = np.where(same[..., None], corner[..., 2:], out)
    return out
