"""Water: its areas and their levels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
import shapely

from osm2xodr.exporting.scene.arrangement import area_of, polygons_of, segments_of
from osm2xodr.exporting.scene.ground.covers import Height
from osm2xodr.exporting.scene.ground.defaults import (
    AT_SHORE,
    GROUND_CELL,
    MOST_LOWERED,
    WATER_BELOW_ROADS,
    WATER_LEVEL_SPREAD,
    WATER_REACH,
    WATER_SAMPLE,
)
from osm2xodr.exporting.scene.ground.open_water import closed_water, sea_of
from osm2xodr.exporting.scene.model import GRID
from osm2xodr.model import FloatArray, IntArray, Water
from osm2xodr.opendrive import Frame

# Corners along the northern and southern side of a rectangle of longitude and latitude, which is bent.
_SIDE: Final = 16
# How far shores in files without bounds lie within the rectangle to whose sides they go, m.
_MARGIN: Final = 50.0


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
