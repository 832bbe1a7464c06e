"""Water: the sea and other areas, those whose outline is not whole in the file, and their levels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.curves import connected_groups
from osm2xodr.exporting.scene.levels import Height
from osm2xodr.exporting.scene.meshes import area_of, polygons_of, segments_of
from osm2xodr.exporting.scene.model import GRID, GROUND_CELL, WATER_REACH
from osm2xodr.model import BoolArray, FloatArray, IntArray, Water
from osm2xodr.opendrive import Frame

# Water whose heights differ by more between the lowest and the highest tenth falls, as rivers do, m; and how close
# the places are whose heights are looked at, m. Choices: coarse models err by 1 to 2 m on water.
_WATER_LEVEL_SPREAD: Final = 4.0
_WATER_SAMPLE: Final = 20.0
# How far beside shores it is looked which area is there, m.
_BESIDE_SHORE: Final = 0.05
# Shores that are not whole are closed if at most this share of the roads on the ground comes to lie in water: maps
# have bridges without tags, and quays drawn to the metre. A choice.
_MOST_FLOODED: Final = 0.02
# Level water lies at least this far below roads at its shore, m, and what distance that is, m. Roads that are lower
# than lakes by more than the third, m, lead down to a tunnel or lie behind a dam. Choices: coarse models err so.
_WATER_BELOW_ROADS: Final = 0.2
_AT_SHORE: Final = 2.0
_MOST_LOWERED: Final = 5.0

# ---------------------------------------------------------------- the sea

# How far ends of coasts, and shores in files without bounds, lie within the rectangle to whose sides they go, m.
_MARGIN: Final = 50.0
# Ends of coasts go on to the nearest side unless another way drowns fewer roads by this share of them. So many are
# looked at: other ways go into so many directions. Choices: some lie on quays and bridges without tags.
_FEWER_FLOODED: Final = 0.001
_ROADS: Final = 20_000
_DIRECTIONS: Final = 8
# Of rings at most this share may lack. A choice.
_GAP: Final = 0.5
# How far from its end a line that goes on is looked at for whether it crosses a coast, m.
_OFF: Final = 0.01


def sea_of(lines: Sequence[FloatArray], box: Any, on_land: FloatArray) -> list[Any]:
    """Return the areas in and around a rectangle that lie on the right of coastlines (n, 2), m.

    Where a coast ends and another one begins, as where a file lacks a piece, they are joined if they are closer to
    each other than to the side of a rectangle around all of them. Other ends go straight on to that side, the nearest
    one, or so that fewer places of roads `on_land` (n, 2), m, lie in the sea.
    """
    if not lines:
        return []
    merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(lines), directed=True))
    around = shapely.box(*shapely.total_bounds(np.array([box, *merged], object))).buffer(_MARGIN, join_style="mitre")
    side = shapely.get_exterior_ring(around)
    coast, ends = _joined(merged, side)
    roads = shapely.points(on_land[:: len(on_land) // _ROADS + 1])
    nearest = list(shapely.shortest_line(ends, side))
    out = _on_the_right(coast, [*nearest, side])
    flooded = _flooded(out, roads)
    for row, end in enumerate(ends):
        if flooded <= _FEWER_FLOODED * len(roads):
            break
        for other in _rays(end, coast, side):
            areas = _on_the_right(coast, [*nearest[:row], other, *nearest[row + 1 :], side])
            count = _flooded(areas, roads)
            if count < flooded - _FEWER_FLOODED * len(roads):
                out, flooded, nearest[row] = areas, count, other
    return out


def _joined(merged: Any, side: Any) -> tuple[Any, Any]:
    """Return coasts with the gaps between them closed, and the ends that are left."""
    lone = merged[~shapely.is_closed(merged)]
    first, last = shapely.get_point(lone, 0), shapely.get_point(lone, -1)
    apart = shapely.distance(last[:, None], first[None])
    far = np.minimum(shapely.distance(last, side)[:, None], shapely.distance(first, side)[None])
    # A coast goes on to its own begin if it is a ring but for a piece.
    np.fill_diagonal(far, np.minimum(far.diagonal(), _GAP * shapely.length(lone)))
    apart = np.where(apart < far, apart, np.inf)
    gaps, free = [], np.ones((2, len(lone)), np.bool_)
    while apart.size and np.isfinite(apart.min()):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        gaps.append(shapely.LineString([last[row], first[column]]))
        free[0, column] = free[1, row] = False
        apart[row] = apart[:, column] = np.inf
    return np.concatenate([merged, np.array(gaps, object)]), np.concatenate([first[free[0]], last[free[1]]])


def _rays(end: Any, coast: Any, side: Any) -> list[Any]:
    """Return lines from an end to the side that cross no coast."""
    x, y = shapely.get_coordinates(end)[0]
    far, out = shapely.length(side), []
    for angle in 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
        ahead = np.array([np.cos(angle), np.sin(angle)])
        ray = shapely.LineString([(x, y) + _OFF * ahead, (x, y) + far * ahead])
        if not shapely.intersects(coast, ray).any():
            out.append(shapely.LineString([end, shapely.intersection(ray, side)]))
    return out


def _on_the_right(coast: Any, more: Sequence[Any]) -> list[Any]:
    """Return the areas between coasts and other lines that lie on the right of coasts."""
    areas = shapely.get_parts(shapely.polygonize([shapely.union_all([*coast, *more])]))
    left, right, length = beside_shores(coast)
    tree, share = shapely.STRtree(areas), np.zeros(len(areas))
    for places, way in ((right, 1.0), (left, -1.0)):
        at, area = tree.query(shapely.points(places), predicate="intersects")
        share += way * np.bincount(area, weights=length[at], minlength=len(areas))
    return list(areas[share > 0.0])


def _flooded(areas: Sequence[Any], roads: Any) -> int:
    """Return how many places of roads lie in areas."""
    return len(np.unique(shapely.STRtree(roads).query(np.array(areas, object), predicate="contains")[1]))


# ---------------------------------------------------------------- areas that are not whole


def closed_water(shores: Sequence[FloatArray], area: Any, on_land: FloatArray) -> Any | None:
    """Return the water in an area of which only some shores are known.

    The shores part the area into faces that are water and land in turn: water are those with fewer roads, if hardly
    any are there. Shores that end within the area go straight on to its side.

    Parameters
    ----------
    shores
        Inertial x, y (n, 2), m, of pieces of the outline.
    area
        Polygon in which water is wanted and the file knows of it.
    on_land
        Inertial x, y, m, of places all over the roads that stand on the ground, (n, 2).

    Returns
    -------
    polygons or None
        Empty where no shore lies in the area; None if shores do not part the area, or it is not clear on which side
        there is water.
    """
    known = shapely.union_all([shapely.LineString(shore) for shore in shores])
    inside = shapely.intersection(known, area)
    if shapely.length(inside) == 0.0:
        return shapely.MultiPolygon()
    side = shapely.get_exterior_ring(area)
    more = _continued(known, area, side)
    if shapely.length(more) > shapely.length(inside):
        return None
    lines = shapely.union(known, more)
    faces = shapely.get_parts(shapely.polygonize([shapely.union(lines, side)]))
    faces = faces[shapely.contains_properly(area, shapely.point_on_surface(faces))]
    of_one = _parted(faces, shapely.intersection(lines, area))
    return None if of_one is None else _wet(faces, of_one, on_land)


def _continued(shores: Any, area: Any, side: Any) -> Any:
    """Return straight lines to the side of an area from where shores end in it."""
    merged = shapely.get_parts(shapely.line_merge(shores))
    merged = merged[~shapely.is_closed(merged)]
    ends = np.concatenate([shapely.get_point(merged, 0), shapely.get_point(merged, -1)])
    ends = ends[shapely.contains_properly(area, ends)]
    at, count = np.unique(shapely.get_coordinates(ends), axis=0, return_counts=True)
    # Where three lines or more meet none of them ends.
    lone = shapely.points(at[count == 1])
    return shapely.union_all(shapely.shortest_line(lone, side))


def _parted(faces: Any, lines: Any) -> BoolArray | None:
    """Return the faces on one side of lines, (n,); None if these do not part them in two."""
    *sides, length = beside_shores(shapely.get_parts(lines))
    left, right = (_face_at(faces, xy[length > _BESIDE_SHORE]) for xy in sides)
    found = (left >= 0) & (right >= 0) & (left != right)
    left, right, total = left[found], right[found], len(faces)
    # Each face is twice there, as water and as land: what is joined holds together.
    start, end = np.concatenate([left, left + total]), np.concatenate([right + total, right])
    group = connected_groups(2 * total, start, end)
    if total < 2 or group.max() != 1:
        return None
    out: BoolArray = group[:total] == 0
    return out


def beside_shores(lines: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places on the left and on the right of the pieces of lines, (n, 2), and the pieces' lengths, (n,), m."""
    at, row = shapely.get_coordinates(lines, return_index=True)
    a, b = at[:-1][row[1:] == row[:-1]], at[1:][row[1:] == row[:-1]]
    length = np.hypot(*(b - a).T)
    a, b, length = a[length > 0.0], b[length > 0.0], length[length > 0.0]
    right = np.column_stack([(b - a)[:, 1], (a - b)[:, 0]]) * (_BESIDE_SHORE / length)[:, None]
    return 0.5 * (a + b) - right, 0.5 * (a + b) + right, length


def _face_at(faces: Any, xy: FloatArray) -> IntArray:
    """Return the face at each place, (n,), -1 for none."""
    out = np.full(len(xy), -1)
    at, face = shapely.STRtree(faces).query(shapely.points(xy), predicate="intersects")
    out[at] = face
    return out


def _wet(faces: Any, of_one: BoolArray, on_land: FloatArray) -> Any | None:
    """Return the side of faces that is water; None if it is not clear."""
    sides = [shapely.union_all(faces[of]) for of in (of_one, ~of_one)]
    for side in sides:
        shapely.prepare(side)
    few, many = sorted((np.count_nonzero(shapely.contains_xy(side, *on_land.T)), k) for k, side in enumerate(sides))
    return sides[few[1]] if few[0] < _MOST_FLOODED * many[0] else None


# ---------------------------------------------------------------- areas

# Corners along the northern and southern side of a rectangle of longitude and latitude, which is bent.
_SIDE: Final = 16


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
    def shores(self) -> Any:
        """The outlines of all areas, in straight pieces of two squares of the ground at most."""
        lines = shapely.boundary(np.array(self.areas, object))
        return segments_of(shapely.segmentize(lines, 2.0 * GROUND_CELL), GRID)

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
    spread = [np.inf if row < shapes.seas else _WATER_LEVEL_SPREAD for row in range(len(shapes.areas))]
    levels = np.array([_level(area, height, most) for area, most in zip(shapes.areas, spread, strict=True)])
    row, at = shapely.STRtree(shapely.points(beside[:, :2])).query(
        np.array(shapes.areas, object), "dwithin", distance=_AT_SHORE
    )
    z = beside[at, 2] - _WATER_BELOW_ROADS
    most = np.full(len(levels), np.inf)
    if (row < shapes.seas).any():
        # There is one sea, and models without heights on it know cliffs alone.
        most[: shapes.seas] = np.percentile(z[row < shapes.seas], 10)
    kept = (row >= shapes.seas) & (z > levels[row] - _MOST_LOWERED)
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
    count = max(int((high - low) / _WATER_SAMPLE), 8)
    out: FloatArray = low + (high - low) * (np.arange(count) + 0.5) / count
    return out
