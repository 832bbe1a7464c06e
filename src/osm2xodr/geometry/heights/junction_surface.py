"""Heights inside junctions: one smooth surface per junction that all its connecting roads are cut from.

Roads are level across. Where one ends at a junction whose plane is tilted across it, the plane alone would leave a
step at every lane that does not lie on the reference line. The surface here is therefore a blend: near the end of
an arm it is the arm's own continuation (level across, the arm's grade along), elsewhere the junction's plane. The
weights fall with the square of the distance to the line across each arm's end (Shepard's interpolation), so that
value and gradient on that line are the arm's own. A higher power keeps these, too, but goes from one arm to the next
in a steeper step: half-way between two of them the slope is the power times the mean slope. Two connecting roads
that cross have one height there, because both take it from the same surface. Formulas: docs/method/heights.md.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, pose, runs
from osm2xodr.geometry.defaults import CONNECTOR_STEEP
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.problem import ConnectorProblem, ProfileProblem, ProfileSolution
from osm2xodr.geometry.heights.records import only_curves
from osm2xodr.geometry.heights.spline_fit import fit_records
from osm2xodr.model import CubicProfile, FloatArray, IntArray

# Pairs of places and arms that are treated at once: bounds the memory.
_CHUNK: Final = 400_000
# Added to squared distances, m²: keeps weights finite on the line across an arm's end, and slopes where two arms
# almost touch.
_ON_LINE: Final = 0.05
# Shorter connecting roads count as this long, and narrower ones as this wide on either side, m: keeps quotients
# finite.
_SHORTEST: Final = 1e-6
_NARROWEST: Final = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class _Arms:
    """Road ends at junctions, sorted by junction."""

    start: IntArray  # (J + 1,) Index of each junction's first arm
    # (A,) Where the road ends, m, and its heading along +s, rad
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    # (A,) The stretch of t that connecting roads touch, m
    low: FloatArray
    high: FloatArray
    tilt: FloatArray  # (A,) The plane's rise per metre of t


def _collect_arms(problem: ProfileProblem, connectors: ConnectorProblem, solution: ProfileSolution) -> _Arms:
    junction = problem.end_junction.ravel()
    low, high = np.zeros((2, len(junction)))
    driven = slice(None) if connectors.beside is None else ~connectors.beside
    half_width = connectors.half_width[driven]
    for end, t in ((connectors.start_end, connectors.start_t), (connectors.end_end, connectors.end_t)):
        np.minimum.at(low, end[driven], t[driven] - half_width)
        np.maximum.at(high, end[driven], t[driven] + half_width)
    used = np.flatnonzero(junction >= 0)
    order = used[np.argsort(junction[used], kind="stable")]
    start = np.searchsorted(junction[order], np.arange(len(problem.junction_xy) + 1)).astype(np.int64)
    x, y, hdg = (value[order] for value in end_poses(problem))
    plane = solution.junction_plane[junction[order]]
    tilt = -np.sin(hdg) * plane[:, 1] + np.cos(hdg) * plane[:, 2]
    return _Arms(start, x, y, hdg, low[order], high[order], tilt)


def _surface(
    arms: _Arms, planes: FloatArray, origin: FloatArray, junction: IntArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return height and gradient (d/dx, d/dy) of the junctions' surfaces at places, all (n,)."""
    plane = planes[junction]
    z = plane[:, 0] + plane[:, 1] * (x - origin[junction, 0]) + plane[:, 2] * (y - origin[junction, 1])
    count = arms.start[junction + 1] - arms.start[junction]
    place = np.repeat(np.arange(len(x)), count)
    arm = runs(arms.start[junction], count)
    cos, sin = np.cos(arms.hdg[arm]), np.sin(arms.hdg[arm])
    dx, dy = x[place] - arms.x[arm], y[place] - arms.y[arm]
    along, t = cos * dx + sin * dy, cos * dy - sin * dx
    inside = np.clip(t, arms.low[arm], arms.high[arm])
    beyond = t - inside
    square = along * along + beyond * beyond + _ON_LINE
    weight = 1.0 / square
    wx, wy = (-2.0 * weight * weight * d for d in (along * cos - beyond * sin, along * sin + beyond * cos))
    tilt = arms.tilt[arm]
    # Beside the arm its level fades out: a place far to the side does not continue it.
    fade = 1.0 / (1.0 + np.abs(beyond) / defaults.ARM_LEVEL_DISTANCE)
    level = -tilt * (inside + beyond * fade)
    turn = tilt * fade * fade

    def total(value: FloatArray) -> FloatArray:
        return np.bincount(place, value, len(x)).astype(np.float64)

    weights = total(weight) + defaults.JUNCTION_PLANE_DISTANCE**-2
    lift = total(weight * level) / weights
    gap = level - lift[place]
    gx = total(wx * gap + weight * turn * sin) / weights
    gy = total(wy * gap - weight * turn * cos) / weights
    return z + lift, plane[:, 1] + gx, plane[:, 2] + gy


def _surface_in_chunks(
    arms: _Arms, planes: FloatArray, origin: FloatArray, junction: IntArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    pairs = np.cumsum(arms.start[junction + 1] - arms.start[junction])
    cuts = np.searchsorted(pairs, np.arange(_CHUNK, int(pairs[-1]) if len(pairs) else 0, _CHUNK))
    out = np.zeros((3, len(x)))
    for a, b in itertools.pairwise(np.unique(np.r_[0, cuts, len(x)])):
        out[:, a:b] = _surface(arms, planes, origin, junction[a:b], x[a:b], y[a:b])
    return out[0], out[1], out[2]


def end_state(solution: ProfileSolution, end: IntArray, leaving: bool) -> tuple[FloatArray, FloatArray]:
    """Return height and grade, along the connecting road, of the road ends it comes from or goes to."""
    z, grade = solution.end_z.ravel()[end], solution.end_grade.ravel()[end]
    along = (end % 2 == 1) if leaving else (end % 2 == 0)
    return z, np.where(along, grade, -grade)


def _blend(
    s: FloatArray, length: FloatArray, reach: FloatArray, ends: tuple[FloatArray, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return value and slope at s of a function with values and slopes (v0, g0, v1, g1) at the ends of a curve.

    It is the sum of a cubic from each end that comes down to 0, with slope 0, over `reach`, at most the length. Where
    both reach from end to end, their sum is the cubic through both ends.
    """
    values, slopes = [], []
    for way, v, g in ((s, ends[0], ends[1]), (length - s, ends[2], -ends[3])):
        u = np.minimum(way / reach, 1.0)
        u2, u3 = u * u, u * u * u
        values.append(v * (1 - 3 * u2 + 2 * u3) + reach * g * (u - 2 * u2 + u3))
        slopes.append(6 * (u2 - u) * v / reach + g * (1 - 4 * u + 3 * u2))
    return values[0] + values[1], slopes[0] - slopes[1]


def _steepest(start: IntArray, s: FloatArray, z: FloatArray, grade: FloatArray) -> FloatArray:
    """Return the largest grade of each curve at its knots and half-way between them."""
    size = np.abs(grade)
    a = np.setdiff1d(np.arange(len(s)), start[1:] - 1)
    middle = 1.5 * (z[a + 1] - z[a]) / (s[a + 1] - s[a]) - 0.25 * (grade[a] + grade[a + 1])
    size[a] = np.maximum(size[a], np.abs(middle))
    return _largest(start, size)


def _largest(start: IntArray, value: FloatArray) -> FloatArray:
    """Return the largest value at the knots of each curve."""
    return np.asarray(np.maximum.reduceat(value, start[:-1]) if len(start) > 1 else [], np.float64)


def connector_profiles(
    problem: ProfileProblem, connectors: ConnectorProblem, solution: ProfileSolution
) -> tuple[CubicProfile, CubicProfile]:
    """Return elevation and superelevation of connecting roads.

    Height and grade at both ends are those of the roads that are touched. The superelevation is 0 with slope 0 at
    both ends and follows the cross slope of the junction's surface in between. Roads that stay almost level across
    have no superelevation. `solution` has the heights of the roads of `problem`.
    """
    along = _sample(connectors)
    arms = _collect_arms(problem, connectors, solution)
    x, y, hdg = pose(connectors.plan_view, along.curve, along.s)
    junction = connectors.junction[along.curve]
    z, gx, gy = _surface_in_chunks(arms, solution.junction_plane, problem.junction_xy, junction, x, y)
    cos, sin = np.cos(hdg), np.sin(hdg)
    elevation = _fit_elevation(along, connectors, solution, z, gx * cos + gy * sin)
    return elevation, _fit_superelevation(along, connectors, gy * cos - gx * sin)


@dataclass(frozen=True, slots=True, eq=False)
class _Along:
    """Samples of C connecting roads at equal intervals from end to end."""

    length: FloatArray  # (C,) m
    start: IntArray  # (C + 1,) Index of each road's first sample
    curve: IntArray  # (n,) Road of each sample
    s: FloatArray  # (n,) m

    def blend(self, reach: FloatArray, ends: tuple[FloatArray, ...]) -> tuple[FloatArray, FloatArray]:
        """Return `_blend` at the samples, from the reach, m, and the ends of each road, all (C,)."""
        curve = self.curve
        return _blend(self.s, self.length[curve], reach[curve], tuple(value[curve] for value in ends))


def _sample(connectors: ConnectorProblem) -> _Along:
    length = np.maximum(lengths(connectors.plan_view), _SHORTEST)
    quarter = np.maximum(2, np.ceil(length / (4 * defaults.CONNECTOR_SAMPLE_SPACING))).astype(np.int64)
    # A multiple of four intervals, as knots of records are tried at quarters of the length.
    count = 4 * quarter + 1
    start = np.r_[0, np.cumsum(count)].astype(np.int64)
    curve = np.repeat(np.arange(len(length), dtype=np.int64), count)
    u = (np.arange(len(curve)) - start[curve]) / (count[curve] - 1)
    return _Along(length, start, curve, u * length[curve])


def _fit_elevation(
    along: _Along, connectors: ConnectorProblem, solution: ProfileSolution, z: FloatArray, grade: FloatArray
) -> CubicProfile:
    """Return the elevation of connecting roads from height, m, and grade of the surface along them, (n,)."""
    first, last = along.start[:-1], along.start[1:] - 1
    z0, g0 = end_state(solution, connectors.start_end, leaving=True)
    z1, g1 = end_state(solution, connectors.end_end, leaving=False)
    reach = np.minimum(along.length, defaults.CONNECTOR_END_REACH)
    dz, dg = along.blend(reach, (z0 - z[first], g0 - grade[first], z1 - z[last], g1 - grade[last]))
    z, grade = z + dz, grade + dg
    # Where the surface would be too steep, as between ends that almost touch, the straightest way is taken instead.
    plain_z, plain_grade = along.blend(along.length, (z0, g0, z1, g1))
    steep = _steepest(along.start, along.s, z, grade)
    plain_steep = _steepest(along.start, along.s, plain_z, plain_grade)
    plain = (steep > CONNECTOR_STEEP) & (plain_steep < steep)
    z = np.where(plain[along.curve], plain_z, z)
    z[first], z[last] = z0, z1
    tolerance = np.full(len(along.length), defaults.CONNECTOR_TOLERANCE)
    steep = np.where(plain, plain_steep, steep) + defaults.CONNECTOR_GRADE_TOLERANCE
    return fit_records(along.start, along.length, z, np.column_stack([g0, g1]), tolerance, steep)


def _fit_superelevation(along: _Along, connectors: ConnectorProblem, cross: FloatArray) -> CubicProfile:
    """Return the superelevation of connecting roads from the cross slope of the surface along them, (n,)."""
    first, last = along.start[:-1], along.start[1:] - 1
    zero = np.zeros(len(along.length))
    reach = np.minimum(along.length, defaults.CONNECTOR_END_REACH)
    cross = cross + along.blend(reach, (-cross[first], zero, -cross[last], zero))[0]
    cross[first] = cross[last] = 0.0
    superelevation = np.arctan(cross)
    tolerance = defaults.CONNECTOR_EDGE_TOLERANCE / np.maximum(connectors.half_width, _NARROWEST)
    tilted = _largest(along.start, np.abs(superelevation)) > tolerance
    records = fit_records(along.start, along.length, superelevation, np.zeros((len(zero), 2)), tolerance)
    return only_curves(records, tilted)
