"""Outlines of objects, and middles of lanes, in space."""

from __future__ import annotations

import math

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.opendrive import ABSENT, Furniture, OpenDrive, Ribbons, pose, surface_points


def outline_points(
    file: OpenDrive, item: Furniture, corners: FloatArray, local: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the corners of an outline in space, (n,) each; (u, v, z) turn with the object, (s, t, dz) do not."""
    road = np.full(len(corners), item.road)
    if not local:
        return surface_points(file, road, corners[:, 0], corners[:, 1], corners[:, 2])
    one, at = road[:1], np.array([item.s])
    x, y, z = surface_points(file, one, at, np.array([item.t]), 0.0 if math.isnan(item.z_offset) else item.z_offset)
    turn = pose(file, one, at)[2] + (0.0 if math.isnan(item.hdg) else item.hdg)
    u, v, up, _ = corners.T
    return x + np.cos(turn) * u - np.sin(turn) * v, y + np.sin(turn) * u + np.cos(turn) * v, z + up


def middle_lengths(file: OpenDrive, ribbons: Ribbons) -> FloatArray:
    """Return the lengths of the middles of lanes, level, (lanes,), m; NaN where a lane has no place."""
    out = np.full(len(file.lanes.id), np.nan)
    start = ribbons.start.tolist()
    for row in np.flatnonzero(ribbons.left != ABSENT).tolist():
        left, right = (slice(*start[k : k + 2]) for k in (int(ribbons.left[row]), int(ribbons.right[row])))
        x, y = (0.5 * (values[left] + values[right]) for values in (ribbons.x, ribbons.y))
        out[row] = np.hypot(np.diff(x), np.diff(y)).sum()
    return out
