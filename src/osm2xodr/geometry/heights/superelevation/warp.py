"""Arms of junctions that are warped: where they end they follow the plane of their junction also across.

A street on a hillside keeps its grade through its junctions. The end of a side street there takes the grade of the
street that it joins as its cross slope, which runs out along it. Formulas: docs/method/heights.md.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import arctan2, cosine, hypot, lengths, profile_of, sine, smooth_cubic
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.limits import span_speeds
from osm2xodr.geometry.heights.problem import ProfileProblem, at_junctions, end_spans, span_sides
from osm2xodr.model import BoolArray, Cubic, CubicProfile, FloatArray, Surface

# The slope of the ground at a junction is that between places so far to either side of it, m: beyond what the noise
# of coarse models makes of level ground. Flatter ones have nothing to warp. Choices: 3 % lift a lane's middle by
# 5 cm.
_REACH: Final = 40.0
_LEAST_SLOPE: Final = 0.03
# A smooth step is steepest in its middle, by this times its mean.
_STEEPEST: Final = 1.5


def sloping_junctions(problem: ProfileProblem, surface: Surface) -> BoolArray:
    """Return the junctions on ground with a slope, (J,)."""
    x, y = problem.junction_xy.T
    if not len(x) or surface.cell_size == 0.0:
        return np.zeros(len(x), bool)
    steps = ((_REACH, 0.0), (-_REACH, 0.0), (0.0, _REACH), (0.0, -_REACH))
    east, west, north, south = (surface.heights(x + dx, y + dy)[0] for dx, dy in steps)
    return np.asarray(hypot(east - west, north - south) > 2.0 * _REACH * _LEAST_SLOPE)


def longest_warp(problem: ProfileProblem) -> FloatArray:
    """Return by how much the cross slope of roads may change from end to end, (R,), rad: in a smooth step."""
    length, fall = lengths(problem.plan_view), _fall(problem)
    return np.asarray(np.minimum(defaults.TWIST_MAX * length / _STEEPEST, length**2 / fall))


def _fall(problem: ProfileProblem) -> FloatArray:
    """Return the square of the length of a smooth step of cross slope, m², by its height, rad, for each road, (R,).

    So that the outer lane climbs with `WARP_ACCELERATION` at the posted speed: a step bends most at its ends, by 6
    times its height over the square of its length.
    """
    span = end_spans(problem)
    half, middle = span_sides(problem)
    lever = (np.abs(middle) + half)[span].max(axis=1)
    return np.asarray(6.0 * lever * span_speeds(problem)[span].max(axis=1) ** 2 / defaults.WARP_ACCELERATION)


def warp_ends(problem: ProfileProblem, planes: FloatArray) -> FloatArray:
    """Return the superelevation of roads where they end at warped junctions, (R, 2), rad: that of the planes, (J, 3).

    As far as it can run out along the road.
    """
    junction = problem.end_junction
    if problem.warped is None or not problem.warped.any():
        return np.zeros(junction.shape)
    hdg = end_poses(problem)[2].reshape(junction.shape)
    at = at_junctions(problem.warped, junction)
    gx, gy = planes[junction, 1], planes[junction, 2]
    slope = np.where(at, np.clip(cosine(hdg) * gy - sine(hdg) * gx, -defaults.WARP_MAX, defaults.WARP_MAX), 0.0)
    most, change = longest_warp(problem), slope[:, 1] - slope[:, 0]
    excess = change - np.clip(change, -most, most)
    # Ends that are not warped stay as they are.
    count = np.maximum(at.sum(axis=1), 1)
    slope += np.where(at, np.column_stack([excess, -excess]) / count[:, None], 0.0)
    return np.asarray(np.round(arctan2(slope, 1.0), defaults.RECORD_DECIMALS))


def warp_profiles(problem: ProfileProblem, ends: FloatArray) -> CubicProfile | None:
    """Return the superelevation of roads between these ends, (R, 2), rad, R curves; None where all are level."""
    warped = np.flatnonzero(ends.any(axis=1))
    if not len(warped):
        return None
    out: list[tuple[Cubic, ...]] = [()] * len(ends)
    run_off = np.maximum(
        _STEEPEST * np.abs(ends) / defaults.TWIST_MAX, np.sqrt(_fall(problem)[:, None] * np.abs(ends))
    )
    length = lengths(problem.plan_view)
    for road in warped.tolist():
        out[road] = _between(float(length[road]), ends[road].tolist(), run_off[road].tolist())
    return profile_of(out)


def _between(length: float, ends: list[float], run_off: list[float]) -> tuple[Cubic, ...]:
    """Return smooth steps from the value at the start of a road to 0 and on to that at its end, or to that at once.

    The first, if there is room, take `run_off`, m.
    """
    (begin, end), (first, last) = ends, run_off
    if first + last >= length:
        return (smooth_cubic(0.0, length, begin, end),)
    cubics = [smooth_cubic(0.0, first, begin, 0.0)] if begin else []
    cubics.append(Cubic(first, 0.0))
    if end:
        cubics.append(smooth_cubic(length - last, last, 0.0, end))
    return tuple(cubics)
