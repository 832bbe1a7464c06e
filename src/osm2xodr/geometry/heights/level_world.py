"""Heights of roads on a world of one height: that height, but where junctions lie on the crossfall of their arms."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import lengths
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.problem import ProfileProblem, ProfileSolution
from osm2xodr.geometry.heights.records import (
    Knots,
    either_profile,
    hermite_records,
    level_profile,
    spread_curves,
)
from osm2xodr.model import CubicProfile, FloatArray


def level_solution(problem: ProfileProblem, z: float, superelevation: FloatArray) -> ProfileSolution:
    """Return the heights of roads on an exactly level surface at z, m.

    `superelevation`, (R, 2), rad, is that at ends of roads. Where it is not 0 at a junction, the reference lines of
    its arms lie on one plane that falls as their carriageways do, up to some decimetres above or below z.
    """
    roads = len(problem.end_junction)
    planes = np.tile([z, 0.0, 0.0], (len(problem.junction_xy), 1))
    end_z, end_grade = np.full((roads, 2), z), np.zeros((roads, 2))
    elevation = level_profile(np.full(roads, z))
    tilted = np.flatnonzero((superelevation != 0.0).ravel() & (problem.end_junction.ravel() >= 0))
    if len(tilted):
        x, y, hdg = (value[tilted] for value in end_poses(problem))
        j, slope = problem.end_junction.ravel()[tilted], np.tan(superelevation.ravel()[tilted])
        # Least squares: across each arm the plane has its slope, along it none.
        count = np.maximum(np.bincount(j, minlength=len(planes)), 1)
        planes[:, 1] = np.bincount(j, -slope * np.sin(hdg), len(planes)) / count
        planes[:, 2] = np.bincount(j, slope * np.cos(hdg), len(planes)) / count
        gx, gy = planes[j, 1], planes[j, 2]
        rise = gx * (x - problem.junction_xy[j, 0]) + gy * (y - problem.junction_xy[j, 1])
        end_z.ravel()[tilted] = np.round(z + rise, defaults.RECORD_DECIMALS)
        end_grade.ravel()[tilted] = np.round(gx * np.cos(hdg) + gy * np.sin(hdg), defaults.RECORD_SLOPE_DECIMALS)
        row = np.unique(tilted // 2)
        profile = _between(lengths(problem.plan_view)[row], z, end_z[row], end_grade[row])
        elevation = either_profile(spread_curves(profile, row, roads), elevation)
    return ProfileSolution(elevation, planes, end_z, end_grade, end_superelevation=superelevation)


def _between(length: FloatArray, z: float, end_z: FloatArray, end_grade: FloatArray) -> CubicProfile:
    """Return the heights of roads, (n,), with those at their ends, (n, 2): level at z between if they are long."""
    reach = defaults.LEVEL_AGAIN
    long = length > 3 * reach
    s = np.column_stack([np.zeros(len(length)), np.full(len(length), reach), length - reach, length])
    value, slope = np.full(s.shape, z), np.zeros(s.shape)
    value[:, [0, 3]], slope[:, [0, 3]] = end_z, end_grade
    keep = np.ones(s.shape, bool)
    keep[~long, 1:3] = False
    start = np.concatenate([[0], np.cumsum(keep.sum(axis=1))]).astype(np.int64)
    return hermite_records(Knots(start, s[keep], value[keep], slope[keep]))
