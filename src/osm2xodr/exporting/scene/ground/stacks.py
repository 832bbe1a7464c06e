"""Roads that lie over others without a bridge, as where a bridge in the file is too short: they become bridges."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.defaults import STACK_REACH, STACKED
from osm2xodr.exporting.scene.ground.planar import planar_edges
from osm2xodr.exporting.scene.model import RoadSurface
from osm2xodr.model import BoolArray, FloatArray

# Triangles share a place if they do so over more than this, m²: less comes of rounding.
_LEAST_SHARED = 1e-6


def stacked(surface: RoadSurface, ground: BoolArray) -> BoolArray:
    """Return which triangles (n,) lie over others, of those (n,) that are said to be on the ground.

    They are looked for where edges of roads cross at different heights.
    """
    out = np.zeros(len(surface.faces), np.bool_)
    places = _crossings(surface, ground)
    if not len(places):
        return out
    corners = surface.vertices[surface.faces]
    middle = corners.mean(1)
    away, _ = cKDTree(places).query(middle[:, :2], distance_upper_bound=STACK_REACH)
    rows = np.flatnonzero(ground & np.isfinite(away) & (_normal(corners)[:, 2] > _LEAST_SHARED))
    shapes = shapely.polygons(corners[rows][:, :, :2])
    one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    later = one < other
    one, other = one[later], other[later]
    # Those of one road share corners.
    faces = surface.faces[rows]
    apart = ~(faces[one][:, :, None] == faces[other][:, None]).any((1, 2))
    one, other = one[apart], other[apart]
    shared = shapely.intersection(shapes[one], shapes[other])
    real = shapely.area(shared) > _LEAST_SHARED
    one, other = rows[one[real]], rows[other[real]]
    at = shapely.get_coordinates(shapely.centroid(shared[real])).reshape(-1, 2)
    above = _heights(corners[one], at) - _heights(corners[other], at)
    out[one[above > STACKED]] = True
    out[other[above < -STACKED]] = True
    return _with_steps(surface, ground, out)


def _with_steps(surface: RoadSurface, ground: BoolArray, above: BoolArray) -> BoolArray:
    """Return triangles (n,) with the steps between them; steps to triangles that stay on the ground stay there."""
    places = np.unique(surface.vertices[:, :2], axis=0, return_inverse=True)[1].ravel()
    corners = places[surface.faces]
    upright = (corners == np.roll(corners, -1, axis=1)).any(1)
    rows = np.flatnonzero(ground & upright)
    count = len(surface.vertices)
    # The edges in plan of steps: both triangles of a step have the same one.
    low, high = corners[rows].min(1), corners[rows].max(1)
    key = low * count + high
    starts, ends = corners, np.roll(corners, -1, axis=1)
    edges = np.minimum(starts, ends) * count + np.maximum(starts, ends)
    out = above.copy()
    out[rows] = np.isin(key, edges[above]) & ~np.isin(key, edges[ground & ~above & ~upright])
    return out


def _crossings(surface: RoadSurface, ground: BoolArray) -> FloatArray:
    """Return x, y where edges of roads on the ground cross at different heights, (n, 2), m."""
    faces = surface.faces[ground]
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = len(surface.vertices)
    rim = ~np.isin(start * count + end, end * count + start)
    edges = np.column_stack([start[rim], end[rim]])
    flat = (surface.vertices[edges[:, 0], :2] == surface.vertices[edges[:, 1], :2]).all(1)
    points, _, _ = planar_edges(surface.vertices, edges[~flat])
    more = points[count:]
    order = np.lexsort((more[:, 1], more[:, 0]))
    more = more[order]
    same = (more[1:, :2] == more[:-1, :2]).all(1) & (np.abs(np.diff(more[:, 2])) > STACKED)
    out: FloatArray = more[1:][same][:, :2]
    return out


def _normal(corners: FloatArray) -> FloatArray:
    out: FloatArray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return out


def _heights(corners: FloatArray, at: FloatArray) -> FloatArray:
    """Return the heights of triangles (n, 3, 3) at x, y (n, 2), m, on them."""
    normal, off = _normal(corners), at - corners[:, 0, :2]
    plane = corners[:, 0, 2] - (normal[:, :2] * off).sum(1) / normal[:, 2]
    # Planes of slivers lean anyhow.
    out: FloatArray = np.clip(plane, corners[:, :, 2].min(1), corners[:, :, 2].max(1))
    return out
