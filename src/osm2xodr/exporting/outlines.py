"""Outlines of objects in space."""

from __future__ import annotations

import math

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.opendrive import Furniture, OpenDrive, pose, surface_points


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
