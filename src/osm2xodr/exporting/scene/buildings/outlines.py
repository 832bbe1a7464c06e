"""The areas of buildings: repaired, without those of their parts, and cut where roads run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from osm2xodr.exporting.scene.arrangement import area_of, polygons_of
from osm2xodr.exporting.scene.buildings.defaults import AREA_LEAST, LOST_SHARE, PARTS_SHARE, PASSAGE
from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.model import BoolArray, Building, FloatArray, IntArray
from osm2xodr.opendrive import Frame


@dataclass(frozen=True, eq=False)
class Footprint:
    """What is left of a building's outline."""

    row: int  # Of the building
    whole: Any  # A polygon: the outline itself
    areas: Any  # What of it stands on the ground
    # What of it hangs above passages, and the lowest height there, m
    above: tuple[tuple[Any, float], ...]


class _Roads:
    """The roads on the ground, as triangles."""

    def __init__(self, surface: RoadSurface, passage: BoolArray) -> None:
        rows = np.flatnonzero((surface.level == Level.GROUND) | passage)
        self._corners = surface.vertices[surface.faces[rows]]
        shapes = shapely.polygons(self._corners[:, :, :2])
        flat = shapely.area(shapes) > 0.0
        self._shapes, self._corners, self._passage = shapes[flat], self._corners[flat], passage[rows][flat]
        self._tree = shapely.STRtree(self._shapes)

    def at(self, areas: Sequence[Any]) -> tuple[IntArray, IntArray]:
        """Return pairs of areas and triangles that share a place."""
        area, road = self._tree.query(areas, predicate="intersects")
        order = np.lexsort((road, area))
        return area[order], road[order]

    def cut(self, area: Any, rows: IntArray) -> tuple[Any, tuple[tuple[Any, float], ...]]:
        """Return what of an area lies on no road, and what of it lies above passages, with its lowest height, m."""
        taken = shapely.union_all(self._shapes[rows])
        left = shapely.difference(area, taken)
        inside = rows[self._passage[rows]]
        if not len(inside):
            return left, ()
        over = shapely.intersection(area, shapely.union_all(self._shapes[inside]))
        return left, ((over, float(self._corners[inside][..., 2].max()) + PASSAGE),)


def footprints_of(
    buildings: Sequence[Building],
    frame: Frame,
    surface: RoadSurface,
    passage: BoolArray,
    found: defaultdict[str, list[str]],
) -> list[Footprint]:
    """Return what stands of buildings; `found` gets the ids of those ``repaired``, ``clipped`` and ``on_roads``.

    Outlines whose parts cover them stand for nothing.
    """
    rows, outlines = _outlines(buildings, frame, found)
    if not rows:
        return []
    outlines = _without_parts(buildings, rows, outlines)
    roads = _Roads(surface, passage)
    area, road = roads.at(outlines)
    first = np.searchsorted(area, np.arange(len(outlines) + 1))
    out = []
    for k, (row, outline) in enumerate(zip(rows, outlines, strict=True)):
        whole = float(shapely.area(outline))
        if whole < AREA_LEAST:
            continue
        near = road[first[k] : first[k + 1]]
        left, above = roads.cut(outline, near) if len(near) else (outline, ())
        lost = whole - float(shapely.area(left)) - sum(float(shapely.area(over)) for over, _ in above)
        osm_id = buildings[row].osm_id
        hangs = bool(buildings[row].min_height or buildings[row].min_level)
        if lost > LOST_SHARE * whole and not hangs:
            found["on_roads"].append(osm_id)
            continue
        if lost > AREA_LEAST:
            found["clipped"].append(osm_id)
        out.append(Footprint(row, outline, _large(left), tuple((_large(over), z) for over, z in above)))
    return out


def _outlines(
    buildings: Sequence[Building], frame: Frame, found: defaultdict[str, list[str]]
) -> tuple[list[int], list[Any]]:
    """Return polygons of inertial x, y, and the row of the building of each."""
    if not buildings:
        return [], []
    rings = [ring for building in buildings for ring in (building.outline, *building.holes)]
    lon, lat = np.concatenate(rings).T
    xy = np.column_stack(frame.to_inertial(lon, lat))
    ends = np.cumsum([len(ring) for ring in rings])
    places = iter(np.split(xy, ends[:-1]))
    rows, shapes = list[int](), list[Any]()
    for row, building in enumerate(buildings):
        own = [next(places) for _ in range(1 + len(building.holes))]
        if not all(np.isfinite(ring).all() for ring in own):
            continue
        shape, repaired = area_of(own[0], own[1:])
        if repaired:
            found["repaired"].append(building.osm_id)
        parts = polygons_of(shape)
        rows += [row] * len(parts)
        shapes += list(parts)
    return rows, shapes


def _without_parts(buildings: Sequence[Building], rows: list[int], outlines: list[Any]) -> list[Any]:
    """Return outlines without the areas where parts of the building stand on the ground."""
    parts = [k for k, row in enumerate(rows) if buildings[row].is_part]
    if not parts:
        return outlines
    shapes = np.array([outlines[k] for k in parts])
    tree = shapely.STRtree(shapes)
    out = list(outlines)
    size = shapely.area(shapes)
    for k, row in enumerate(rows):
        if buildings[row].is_part:
            continue
        near = np.sort(tree.query(outlines[k], predicate="intersects"))
        shared = shapely.area(shapely.intersection(shapes[near], outlines[k]))
        own = near[shared > PARTS_SHARE * size[near]]
        if not len(own):
            continue
        covered = shapely.union_all(shapes[own])
        if shapely.area(shapely.intersection(covered, outlines[k])) > PARTS_SHARE * shapely.area(outlines[k]):
            out[k] = shapely.Polygon()
            continue
        stand = [j for j in own if not (buildings[rows[parts[j]]].min_height or buildings[rows[parts[j]]].min_level)]
        out[k] = _largest(shapely.difference(outlines[k], shapely.union_all(shapes[stand])))
    return out


def _large(shape: Any) -> Any:
    """Return the polygons of a shape that are large enough to be seen."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    kept = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & (shapely.area(parts) > AREA_LEAST)
    return shapely.multipolygons(parts[kept])


def _largest(shape: Any) -> Any:
    """Return the largest polygon of a shape: what parts leave of an outline otherwise are slivers."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    area: FloatArray = np.where(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON, shapely.area(parts), -1.0)
    return parts[int(np.argmax(area))] if len(parts) and area.max() > 0.0 else shapely.Polygon()
