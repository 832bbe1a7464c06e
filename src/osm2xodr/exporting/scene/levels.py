"""What the ground makes of roads: tunnels that none covers, and roads below it that no tunnel was said to be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import connected_groups, unique_inverse
from osm2xodr.exporting.scene.meshes import clusters, places_of
from osm2xodr.exporting.scene.model import GRID, TUNNEL_COVER, Level, RoadSurface
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Tunnels whose road lies less than this below the ground, m, are passages or galleries: half of their opening, as
# elevation models may be off by some metres.
_COVERED: Final = 2.5
# Roads that lie more than this above another one are on a bridge, m: less comes of chords and cross slopes.
# A choice.
_STACKED: Final = 0.5
# Roads that begin at a portal and lie deeper than this all over are in the tunnel, m: cuttings are not. A choice.
_DEEPEST_CUT: Final = 15.0


def stacked(surface: RoadSurface, ground: BoolArray) -> BoolArray:
    """Return which triangles (n,) lie over others, of those (n,) that are said to be on the ground.

    Triangles above each other have the same places; steps go with the triangles at both of their sides.
    """
    places = places_of(surface.vertices[:, :2], GRID)[0]
    corners, z = places[surface.faces], surface.vertices[surface.faces, 2].mean(1)
    upright = (corners == np.roll(corners, -1, axis=1)).any(1)
    rows = np.flatnonzero(ground & ~upright)
    count = len(places)
    three = np.sort(corners[rows], axis=1)
    of_two = np.unique(three[:, 0] * count + three[:, 1], return_inverse=True)[1]
    key = np.unique(of_two * count + three[:, 2], return_inverse=True)[1]
    low = np.full(int(key.max(initial=-1)) + 1, np.inf)
    np.minimum.at(low, key, z[rows])
    out = np.zeros(len(surface.faces), np.bool_)
    out[rows] = z[rows] > low[key] + _STACKED
    # With those that touch them: between the foot of a bridge and the road below there is ground.
    out[rows] |= np.isin(surface.faces[rows], surface.faces[out]).any(1)
    # Edges in plan at heights: those of the triangles at the sides of steps, and of the steps themselves.
    ends = np.roll(corners, -1, axis=1)
    edges = (np.minimum(corners, ends) * count + np.maximum(corners, ends))[rows].ravel()
    height = surface.vertices[surface.faces[rows], 2]
    steps = np.flatnonzero(ground & upright)
    own = corners[steps].min(1) * count + corners[steps].max(1)
    at = 0.5 * (height + np.roll(height, -1, axis=1)).ravel()
    edge = clusters(np.concatenate([edges, own]), np.concatenate([at, z[steps]]), _STACKED)
    above, below = (
        np.bincount(edge[: len(at)], np.repeat(side[rows], 3), edge.max(initial=0) + 1) for side in (out, ~out)
    )
    out[steps] = ((above > 0) & (below == 0))[edge[len(at) :]]
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
    out[rows] = ((mean < _COVERED) & (total > 0.0))[group]
    return out


def buried(surface: RoadSurface, height: Height) -> BoolArray:
    """Return which triangles on the ground belong to roads at tunnels that lie as deep all over, (n,)."""
    rows, group, depth = _groups(surface, Level.GROUND, height)
    portals = _portals(surface, rows, group)
    # Where the ground is not known nothing is deep.
    high, lower = (
        np.bincount(group[~(depth > least)], minlength=len(portals)) > 0 for least in (TUNNEL_COVER, _DEEPEST_CUT)
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
    portal = connected_groups(count, start, end)[start]
    found = np.unique(np.column_stack([np.repeat(group, 3)[shared], portal]), axis=0)
    return np.bincount(found[:, 0], minlength=int(group.max(initial=-1)) + 1)


def _groups(surface: RoadSurface, level: Level, height: Height) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the triangles of a level, the group of those that touch, and how far below the ground each is, m."""
    rows = np.flatnonzero(surface.level == level)
    faces, count = surface.faces[rows], len(surface.vertices)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    group = unique_inverse(connected_groups(count, *ends.T)[faces[:, 0]])[1]
    middle = surface.vertices[faces].mean(1)
    return rows, group, height(middle[:, 0], middle[:, 1]) - middle[:, 2]
