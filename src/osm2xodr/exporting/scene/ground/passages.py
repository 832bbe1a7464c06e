"""Tunnels that no ground covers: passages through buildings, and galleries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from osm2xodr.exporting.scene.ground.building import Height
from osm2xodr.exporting.scene.ground.defaults import COVERED
from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.model import BoolArray


def find_passages(surface: RoadSurface, height: Height) -> BoolArray:
    """Return which triangles belong to tunnels above which the ground is not where it would have to be, (n,).

    `height` gives the elevation model's heights at inertial x, y (n,), m, NaN where it has none. Tunnels of several
    roads that touch are judged as one, by their mean.
    """
    out = np.zeros(len(surface.faces), np.bool_)
    rows = np.flatnonzero(surface.level == Level.TUNNEL)
    if not len(rows):
        return out
    faces = surface.faces[rows]
    count = len(surface.vertices)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    tunnel = connected_components(links, directed=False)[1][faces[:, 0]]
    corners = surface.vertices[faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    middle = corners.mean(1)
    above = height(middle[:, 0], middle[:, 1]) - middle[:, 2]
    area = np.where(np.isfinite(above), np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 0.0)
    total = np.bincount(tunnel, weights=area)
    mean = np.bincount(tunnel, weights=area * np.nan_to_num(above)) / np.maximum(total, 1e-9)
    out[rows] = ((mean < COVERED) & (total > 0.0))[tunnel]
    return out


def on_the_ground(surface: RoadSurface, passage: BoolArray) -> RoadSurface:
    """Return a surface whose passages (triangles, as of `passages`) lie on the ground."""
    return replace(surface, level=np.where(passage, int(Level.GROUND), surface.level))
