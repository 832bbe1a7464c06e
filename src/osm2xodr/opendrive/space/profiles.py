"""Heights, cross slopes and lane offsets, and the surface that they make."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import find_record
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.space.curves import LEFT, pose
from osm2xodr.opendrive.tables import OpenDrive


def cubic(
    profile: CubicProfile, curve: IntArray, s: FloatArray, *, order: int = 0, before: bool = False
) -> FloatArray:
    """Return piecewise cubics or their derivatives at s of curves, (n,); 0 for curves without records.

    Parameters
    ----------
    profile, curve, s
        Which cubics, and where.
    order
        0: the value; 1, 2: its first or second derivative.
    before
        Whether the limit from the left is meant.
    """
    out = np.zeros(len(s))
    has = np.flatnonzero(profile.start[curve + 1] > profile.start[curve])
    if not len(has):
        return out
    at = s[has]
    k = find_record(profile.start, profile.s, curve[has], at - LEFT if before else at)
    ds = at - profile.s[k]
    if order == 0:
        out[has] = profile.a[k] + ds * (profile.b[k] + ds * (profile.c[k] + ds * profile.d[k]))
    elif order == 1:
        out[has] = profile.b[k] + ds * (2 * profile.c[k] + 3 * ds * profile.d[k])
    else:
        out[has] = 2 * profile.c[k] + 6 * ds * profile.d[k]
    return out


def elevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return z of reference lines at s, m; 0 where a road has no elevation, as OpenDRIVE means it."""
    return cubic(file.elevation, road, s, before=before)


def grade(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the rise of reference lines per metre of s."""
    return cubic(file.elevation, road, s, order=1, before=before)


def superelevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the roll of road surfaces about their reference lines at s, rad; positive where the left is higher."""
    return cubic(file.superelevation, road, s, before=before)


def lane_offset(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return t of centre lanes at s, m."""
    return cubic(file.lane_offset, road, s, before=before)


def surface_points(
    file: OpenDrive,
    road: IntArray,
    s: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
    *,
    before: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points on roads, m.

    The t axis is level and square to the reference line's projection, rolled by the superelevation; h is square to
    both. ``<shape>`` records of lateral profiles are not taken in.

    Parameters
    ----------
    file, road, s, t
        Where.
    h
        Height above the surface, m.
    before
        Whether the limit from the left is meant.
    """
    x, y, hdg = pose(file, road, s, before=before)
    z = elevation(file, road, s, before=before)
    roll = superelevation(file, road, s, before=before)
    return rolled(x, y, z, hdg, roll, t, h)


def rolled(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    hdg: FloatArray,
    roll: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points beside points of reference lines; see `surface_points`."""
    # A roll beyond all numbers is unknown.
    roll = np.where(np.isfinite(roll), roll, np.nan)
    cos, sin = np.cos(roll), np.sin(roll)
    across = t * cos - h * sin
    return x - np.sin(hdg) * across, y + np.cos(hdg) * across, z + t * sin + h * cos
