"""Surfaces of junctions: one smooth surface each, that all connecting roads of the junction are cut from.

Most roads are level across. Where one ends at a junction whose plane is tilted across it, the plane alone would leave
a step at every lane that does not lie on the reference line. The surface is therefore the plane plus the smoothest
function that has the arm's own cross slope at the end of each arm and its own grade along it: Hermite interpolation
by radial functions r³ (Duchon 1977; Wendland 2005), which may pass by what is given by a little. Where a connecting
road on it would throw a car, the surface is laid along what that road is eased to. Two connecting roads that cross
have one height there, because both take it from the same surface. Formulas: docs/method/heights.md.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import Table, cosine, hypot, owners, runs, sine, slope_of, solve_dense
from osm2xodr.geometry.heights.elements import end_poses
from osm2xodr.geometry.heights.problem import ConnectorProblem, ProfileProblem, ProfileSolution
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.system import record

# Pairs of places and stations that are treated at once: bounds the memory.
_CHUNK: Final = 400_000
# Stations across an arm's end where its level is given, as shares of the width that connecting roads touch.
_STATIONS: Final = (0.0, 0.5, 1.0)
# Unit of length of the kernel, m: about the size of a junction, which keeps the systems well conditioned.
_UNIT: Final = 10.0
# How far the surface may pass by what is given, as a variance beside that of the surface over one unit of length:
# heights and grades. Arms that all but touch contradict each other.

_HEIGHT_SLACK: Final = 0.01
_GRADE_SLACK: Final = 0.05
# Narrower arms count as this wide on either side, m.
_NARROWEST: Final = 0.5


@record(eq=False)
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
    # (A,) What the road has more than the plane: height, m, slope across, and grade along +s
    height: FloatArray
    tilt: FloatArray
    grade: FloatArray


@record(eq=False)
class JunctionSurfaces:
    """One surface for each junction: its plane, and a sum of kernels about stations at its arms."""

    plane: FloatArray  # (J, 3)
    origin: FloatArray  # (J, 2)
    start: IntArray  # (J + 1,) Index of each junction's first station
    # (M,) Stations: where, and the heading of their arms
    x: FloatArray
    y: FloatArray
    cos: FloatArray
    sin: FloatArray
    # (M,) Weights of the kernel and of its derivative along the arm
    height_weight: FloatArray
    grade_weight: FloatArray
    linear: FloatArray  # (J, 3) What is added to the plane: height and gradient


def _collect_arms(problem: ProfileProblem, connectors: ConnectorProblem, solution: ProfileSolution) -> _Arms:
    junction = problem.end_junction.ravel()
    low, high = np.zeros((2, len(junction)))
    driven = slice(None) if connectors.beside is None else ~connectors.beside
    half_width = connectors.half_width[driven]
    for end, t in ((connectors.start_end, connectors.start_t), (connectors.end_end, connectors.end_t)):
        np.minimum.at(low, end[driven], t[driven] - half_width)
        np.maximum.at(high, end[driven], t[driven] + half_width)
    used = np.flatnonzero(np.isin(junction, connectors.junction))
    order = used[np.argsort(junction[used], kind="stable")]
    start = np.searchsorted(junction[order], np.arange(len(problem.junction_xy) + 1)).astype(np.int64)
    x, y, hdg = (value[order] for value in end_poses(problem))
    plane, origin = solution.junction_plane[junction[order]], problem.junction_xy[junction[order]]
    rise = plane[:, 1] * (x - origin[:, 0]) + plane[:, 2] * (y - origin[:, 1])
    height = solution.end_z.ravel()[order] - plane[:, 0] - rise
    tilt = sine(hdg) * plane[:, 1] - cosine(hdg) * plane[:, 2]
    if solution.end_superelevation is not None:
        tilt = tilt + slope_of(solution.end_superelevation.ravel()[order])
    grade = solution.end_grade.ravel()[order] - cosine(hdg) * plane[:, 1] - sine(hdg) * plane[:, 2]
    low, high = np.minimum(low[order], -_NARROWEST), np.maximum(high[order], _NARROWEST)
    return _Arms(start, x, y, hdg, low, high, height, tilt, grade)


@record(eq=False)
class Stations(Table):
    """Places with a heading that surfaces of junctions pass with a height and a grade along it."""

    junction: IntArray  # (n,)
    # (n,) m, and rad
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    # (n,) m, and rise per metre
    height: FloatArray
    grade: FloatArray


def junction_surfaces(
    problem: ProfileProblem, connectors: ConnectorProblem, solution: ProfileSolution, more: Stations | None = None
) -> JunctionSurfaces:
    """Return the smoothest surfaces that slope across as each arm does and keep its grade along it.

    Those of junctions without a connecting road are the planes alone.

    Parameters
    ----------
    problem, solution
        The roads that end at junctions, and their heights.
    connectors
        Connecting roads: an arm is level over the width that they touch.
    more
        What the surfaces pass besides arms.
    """
    planes, origin = solution.junction_plane, problem.junction_xy
    stations = _stations_at_arms(_collect_arms(problem, connectors, solution))
    if more is not None:
        stations = stations.joined(_beyond_planes(more, planes, origin))
        stations = stations.chosen(np.argsort(stations.junction, kind="stable"))
    x, y, cos, sin = stations.x, stations.y, cosine(stations.hdg), sine(stations.hdg)
    height, grade = stations.height, stations.grade
    start = np.searchsorted(stations.junction, np.arange(len(planes) + 1)).astype(np.int64)
    height_weight, grade_weight = np.zeros((2, len(x)))
    linear = np.zeros_like(planes)
    count = np.diff(start)
    for n in np.unique(count[count > 0]).tolist():
        group = np.flatnonzero(count == n)
        at = start[group][:, None] + np.arange(n)
        dx, dy = (v[at] - origin[group, k, None] for k, v in enumerate((x, y)))
        weights = _solve_kernels(dx / _UNIT, dy / _UNIT, cos[at], sin[at], height[at], grade[at])
        height_weight[at], grade_weight[at] = weights[:, :n], weights[:, n : 2 * n]
        linear[group] = weights[:, 2 * n :] / [1.0, _UNIT, _UNIT]
    return JunctionSurfaces(planes, origin, start, x, y, cos, sin, height_weight, grade_weight, linear)


def _stations_at_arms(arms: _Arms) -> Stations:
    """Return the stations across the ends of arms; heights and grades are those beyond the planes'."""
    share = np.array(_STATIONS)
    t = arms.low[:, None] + (arms.high - arms.low)[:, None] * share
    cos, sin = cosine(arms.hdg)[:, None], sine(arms.hdg)[:, None]
    junction = np.repeat(owners(arms.start), len(share))
    hdg, grade = np.repeat(arms.hdg, len(share)), np.repeat(arms.grade, len(share))
    x, y, height = arms.x[:, None] - sin * t, arms.y[:, None] + cos * t, arms.height[:, None] + arms.tilt[:, None] * t
    return Stations(junction, x.ravel(), y.ravel(), hdg, height.ravel(), grade)


def _beyond_planes(stations: Stations, planes: FloatArray, origin: FloatArray) -> Stations:
    """Return stations less the height and the grade of their junctions' planes, (J, 3), about origins (J, 2)."""
    z, gx, gy = planes[stations.junction].T
    dx, dy = (np.column_stack([stations.x, stations.y]) - origin[stations.junction]).T
    grade = gx * cosine(stations.hdg) + gy * sine(stations.hdg)
    return replace(stations, height=stations.height - z - gx * dx - gy * dy, grade=stations.grade - grade)


def _solve_kernels(
    x: FloatArray, y: FloatArray, cos: FloatArray, sin: FloatArray, height: FloatArray, grade: FloatArray
) -> FloatArray:
    """Return the weights, (j, 2 n + 3), of surfaces that have heights and grades at stations, all (j, n)."""
    junctions, n = x.shape
    dx, dy = x[:, :, None] - x[:, None, :], y[:, :, None] - y[:, None, :]
    r = hypot(dx, dy)
    here = dx * cos[:, :, None] + dy * sin[:, :, None]
    there = dx * cos[:, None, :] + dy * sin[:, None, :]
    turn = cos[:, :, None] * cos[:, None, :] + sin[:, :, None] * sin[:, None, :]
    matrix = np.zeros((junctions, 2 * n + 3, 2 * n + 3))
    matrix[:, :n, :n] = r * r * r + _HEIGHT_SLACK * np.eye(n)
    matrix[:, :n, n : 2 * n] = -3.0 * r * there
    matrix[:, n : 2 * n, :n] = 3.0 * r * here
    matrix[:, n : 2 * n, n : 2 * n] = -3.0 * (r * turn + here * there / np.where(r > 0, r, 1.0))
    matrix[:, n : 2 * n, n : 2 * n] += _GRADE_SLACK * np.eye(n)
    linear = np.stack([np.ones_like(x), x, y], axis=2)
    slope = np.stack([np.zeros_like(x), cos, sin], axis=2)
    matrix[:, : 2 * n, 2 * n :] = np.concatenate([linear, slope], axis=1)
    matrix[:, 2 * n :, : 2 * n] = matrix[:, : 2 * n, 2 * n :].swapaxes(1, 2)
    right = np.zeros((junctions, 2 * n + 3, 1))
    right[:, :n, 0], right[:, n : 2 * n, 0] = height, grade * _UNIT
    return np.asarray(solve_dense(matrix, right)[:, :, 0])


def surface_heights(
    surfaces: JunctionSurfaces, junction: IntArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return height, m, and gradient (d/dx, d/dy) of the surfaces of junctions (n,) at places x, y, m, all (n,)."""
    count = surfaces.start[junction + 1] - surfaces.start[junction]
    pairs = np.cumsum(count)
    cuts = np.searchsorted(pairs, np.arange(_CHUNK, int(pairs[-1]) if len(pairs) else 0, _CHUNK))
    out = np.zeros((3, len(x)))
    for a, b in itertools.pairwise(np.unique(np.r_[0, cuts, len(x)])):
        out[:, a:b] = _some_heights(surfaces, junction[a:b], count[a:b], x[a:b], y[a:b])
    return out[0], out[1], out[2]


def _some_heights(
    surfaces: JunctionSurfaces, junction: IntArray, count: IntArray, x: FloatArray, y: FloatArray
) -> FloatArray:
    """Return height and gradient, (3, n)."""
    plane = surfaces.plane[junction] + surfaces.linear[junction]
    dx, dy = x - surfaces.origin[junction, 0], y - surfaces.origin[junction, 1]
    z = plane[:, 0] + plane[:, 1] * dx + plane[:, 2] * dy
    place, k = np.repeat(np.arange(len(x)), count), runs(surfaces.start[junction], count)
    dx, dy = (x[place] - surfaces.x[k]) / _UNIT, (y[place] - surfaces.y[k]) / _UNIT
    r, along = hypot(dx, dy), surfaces.cos[k] * dx + surfaces.sin[k] * dy
    height, grade = 3.0 * surfaces.height_weight[k], -3.0 * surfaces.grade_weight[k]
    # Of r³ and of its derivative along the arm, 3 r a.
    radial = height * r + grade * along / np.where(r > 0, r, 1.0)

    def total(value: FloatArray) -> FloatArray:
        return np.bincount(place, value, len(x)).astype(np.float64)

    gx, gy = total(radial * dx + grade * r * surfaces.cos[k]), total(radial * dy + grade * r * surfaces.sin[k])
    z = z + total(r * (height * r * r / 3.0 + grade * along))
    return np.stack([z, plane[:, 1] + gx / _UNIT, plane[:, 2] + gy / _UNIT])
