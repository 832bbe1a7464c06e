"""What the ground makes of roads: tunnels that none covers, and roads below it that no tunnel was said to be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from osm2xodr.exporting.scene.ground.defaults import COVERED, DEEPEST_CUT, STACK_REACH, STACKED, TUNNEL_COVER
from osm2xodr.exporting.scene.ground.planar import planar_edges
from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.model import BoolArray, FloatArray, IntArray

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


# ---------------------------------------------------------------- covers

Height = Callable[[FloatArray, FloatArray], FloatArray]


def settled(surface: RoadSurface, height: Height | None) -> tuple[RoadSurface, BoolArray]:
    """Return the surface with the levels that the ground allows, and which triangles (n,) are passages.

    `height` gives the elevation model's heights at inertial x, y (n,), m, NaN where it has none. Passages through
    buildings and galleries are tunnels in OpenDRIVE, but no ground covers them: they lie on it. Junctions in tunnels
    have no tunnel in OpenDRIVE: roads at portals that are deep below the ground all over are in them. What lies over
    another road on the ground is a bridge.
    """
    level, passage = surface.level.copy(), np.zeros(len(surface.faces), np.bool_)
    if height is not None:
        passage = passages(surface, height)
        level[passage] = int(Level.GROUND)
        level[buried(surface, height)] = int(Level.TUNNEL)
    level[stacked(surface, level == Level.GROUND)] = int(Level.BRIDGE)
    return replace(surface, level=level), passage


def passages(surface: RoadSurface, height: Height) -> BoolArray:
    """Return which triangles belong to tunnels above which the ground is not where it would have to be, (n,).

    Tunnels of several roads that touch are judged as one, by their mean.
    """
    rows, group, depth = _groups(surface, Level.TUNNEL, height)
    corners = surface.vertices[surface.faces[rows]]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.where(np.isfinite(depth), np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 0.0)
    total = np.bincount(group, weights=area)
    mean = np.bincount(group, weights=area * np.nan_to_num(depth)) / np.maximum(total, 1e-9)
    out = np.zeros(len(surface.faces), np.bool_)
    out[rows] = ((mean < COVERED) & (total > 0.0))[group]
    return out


def buried(surface: RoadSurface, height: Height) -> BoolArray:
    """Return which triangles on the ground belong to roads at tunnels that lie as deep all over, (n,)."""
    rows, group, depth = _groups(surface, Level.GROUND, height)
    portals = _portals(surface, rows, group)
    # Where the ground is not known nothing is deep.
    high, lower = (
        np.bincount(group[~(depth > least)], minlength=len(portals)) > 0 for least in (TUNNEL_COVER, DEEPEST_CUT)
    )
    out = np.zeros(len(surface.faces), np.bool_)
    # A road in a cutting may lead into one tunnel, and on out of the file.
    out[rows] = ((~high & (portals > 1)) | (~lower & (portals > 0)))[group]
    return out


def _portals(surface: RoadSurface, rows: IntArray, group: IntArray) -> IntArray:
    """Return how many portals of tunnels each group of triangles on the ground has."""
    count = len(surface.vertices)
    tunnel = surface.faces[surface.level == Level.TUNNEL]
    there = tunnel.ravel() * count + np.roll(tunnel, -1, axis=1).ravel()
    start, end = surface.faces[rows].ravel(), np.roll(surface.faces[rows], -1, axis=1).ravel()
    shared = np.isin(end * count + start, there)
    # Steps at kerbs do not part a portal.
    place = np.unique(surface.vertices[:, :2], axis=0, return_inverse=True)[1].ravel()
    start, end = place[start[shared]], place[end[shared]]
    links = coo_matrix((np.ones(len(start)), (start, end)), shape=(count, count))
    portal = connected_components(links, directed=False)[1][start]
    found = np.unique(np.column_stack([np.repeat(group, 3)[shared], portal]), axis=0)
    return np.bincount(found[:, 0], minlength=int(group.max(initial=-1)) + 1)


def _groups(surface: RoadSurface, level: Level, height: Height) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the triangles of a level, the group of those that touch, and how far below the ground each is, m."""
    rows = np.flatnonzero(surface.level == level)
    faces, count = surface.faces[rows], len(surface.vertices)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    of = connected_components(links, directed=False)[1][faces[:, 0]]
    group = np.unique(of, return_inverse=True)[1].astype(np.int64)
    middle = surface.vertices[faces].mean(1)
    return rows, group, height(middle[:, 0], middle[:, 1]) - middle[:, 2]
