"""Heights, cross slopes and lane offsets, and the surface that they make."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import cubic_value
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space.blocks import in_blocks
from osm2xodr.opendrive.space.curves import pose
from osm2xodr.opendrive.tables import OpenDrive


@in_blocks
def elevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return z of reference lines at s, m; 0 where a road has no elevation, as OpenDRIVE defines it."""
    return cubic_value(file.elevation, road, s, before=before)


@in_blocks
def grade(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the rise of reference lines per metre of s."""
    return cubic_value(file.elevation, road, s, order=1, before=before)


@in_blocks
def superelevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the roll of road surfaces about their reference lines at s, rad; positive where the left is higher."""
    return cubic_value(file.superelevation, road, s, before=before)


@in_blocks
def lane_offset(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return t of centre lanes at s, m."""
    return cubic_value(file.lane_offset, road, s, before=before)


def surface_points(
    file: OpenDrive,
    road: IntArray,
    s: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
    *,
    before: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at s, t of roads and h above their surface, m.

    The t axis is level and square to the reference line's projection, rolled by the superelevation; h is square to
    both. ``<shape>`` records of lateral profiles are left out. `before` asks for the limit from the left.
    """
    x, y, hdg = pose(file, road, s, before=before)
    z = elevation(file, road, s, before=before)
    roll = superelevation(file, road, s, before=before)
    return points_beside(x, y, z, hdg, roll, t, h)


def points_beside(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    hdg: FloatArray,
    roll: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at t, h beside points of reference lines; see `surface_points`."""
    # An infinite roll, as of damaged files, is unknown.
    roll = np.where(np.isfinite(roll), roll, np.nan)
    cos, sin = np.cos(roll), np.sin(roll)
    across = t * cos - h * sin
    return x - np.sin(hdg) * across, y + np.cos(hdg) * across, z + t * sin + h * cos
