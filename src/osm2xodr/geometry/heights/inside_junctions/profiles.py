"""Heights and superelevation of connecting roads: their junction's surface along them, in few records.

Height, grade and superelevation at both ends are those of the roads that are touched, exactly; most of these are
level across. Superelevation changes no faster than a car can follow. Formulas: docs/method/heights.md.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import arctan2, cosine, end_curvature, lengths, pose, profile_of, sine, slope_of
from osm2xodr.geometry.defaults import CONNECTOR_STEEP
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.inside_junctions.easing import ease_profiles, largest_acceleration
from osm2xodr.geometry.heights.inside_junctions.spline_fit import fit_records
from osm2xodr.geometry.heights.inside_junctions.surface import Stations, junction_surfaces, surface_heights
from osm2xodr.geometry.heights.limits import connector_speeds, fastest_around
from osm2xodr.geometry.heights.problem import (
    ConnectorProblem,
    ProfileProblem,
    ProfileSolution,
    at_junctions,
    end_spans,
    fast_spans,
)
from osm2xodr.geometry.heights.records import either_profile, level_profile, only_curves, spread_curves
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.system import record

# Shorter connecting roads count as this long, and narrower ones as this wide on either side, m: keeps quotients
# finite.
_SHORTEST: Final = 1e-6
_NARROWEST: Final = 0.5
# Largest slope of superelevation where connecting roads begin and end, rad/m. A choice: tight turns on steep slopes
# have it, and no car rocks worse.
_LARGEST_END_TWIST: Final = 0.04
# Least length of a lane beside that of the reference line: keeps quotients finite in bends that fold.
_LEAST_LENGTH_SHARE: Final = 0.1


def end_state(
    solution: ProfileSolution, end: IntArray, t: FloatArray, leaving: bool
) -> tuple[FloatArray, FloatArray]:
    """Return height at t, m, and grade, along the connecting road, of the road ends it comes from or goes to."""
    z, grade = solution.end_z.ravel()[end], solution.end_grade.ravel()[end]
    if solution.end_superelevation is not None:
        z = z + t * sine(solution.end_superelevation.ravel()[end])
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

    Height, grade and superelevation at both ends are those of the roads where these are touched. The superelevation
    has slope 0 at both ends and follows the cross slope of the junction's surface in between. Roads that stay almost
    level across have none. `solution` has the heights of the roads of `problem`.
    """
    uneven = _uneven(problem, solution)[connectors.junction]
    level = _level_profiles(connectors, solution)
    if not uneven.any():
        return level
    if uneven.all():
        return _uneven_profiles(problem, connectors, solution)
    row = np.flatnonzero(uneven)
    own = _uneven_profiles(problem, connectors.chosen(row), solution)
    elevation, superelevation = (spread_curves(profile, row, len(uneven)) for profile in own)
    return either_profile(elevation, level[0]), superelevation


def _uneven(problem: ProfileProblem, solution: ProfileSolution) -> BoolArray:
    """Return the junctions whose arms are not all level at one height, (J,)."""
    junction, out = problem.end_junction.ravel(), solution.junction_plane[:, 1:].any(axis=1)
    end = np.flatnonzero(junction >= 0)
    rise = solution.end_z.ravel()[end] != np.round(
        solution.junction_plane[junction[end], 0], defaults.RECORD_DECIMALS
    )
    out[junction[end[rise | (solution.end_grade.ravel()[end] != 0.0)]]] = True
    return np.asarray(out)


def _uneven_profiles(
    problem: ProfileProblem, connectors: ConnectorProblem, solution: ProfileSolution
) -> tuple[CubicProfile, CubicProfile]:
    """Return the profiles of connecting roads on surfaces that are not level."""
    along = _sample(connectors)
    x, y, hdg = pose(connectors.plan_view, along.curve, along.s)
    junction, cos, sin = connectors.junction[along.curve], cosine(hdg), sine(hdg)

    def lay(more: Stations | None = None) -> tuple[_LaidHeights, FloatArray]:
        """Return the heights on surfaces that pass some more places, and the surfaces' slope across."""
        surfaces = junction_surfaces(problem, connectors, solution, more)
        z, gx, gy = surface_heights(surfaces, junction, x, y)
        heights = _lay_heights(along, problem, connectors, solution, z, gx * cos + gy * sin)
        return heights, gy * cos - gx * sin

    heights, cross = lay()
    moved = _largest(along.start, np.abs(heights.z - heights.on_surface)) > defaults.CONNECTOR_TOLERANCE
    if moved.any():
        at = np.flatnonzero(moved[along.curve] & along.inner_quarters())
        heights, cross = lay(Stations(junction[at], x[at], y[at], hdg[at], heights.z[at], heights.grade[at]))
    return heights.records(along), _fit_superelevation(along, problem, connectors, solution, cross)


def _level_profiles(connectors: ConnectorProblem, solution: ProfileSolution) -> tuple[CubicProfile, CubicProfile]:
    """Return the profiles of connecting roads in a level world."""
    z = solution.end_z.ravel()[connectors.start_end]
    return level_profile(z), profile_of([()] * len(z))


@record(eq=False)
class _Along:
    """Samples of C connecting roads at equal intervals from end to end."""

    length: FloatArray  # (C,) m
    start: IntArray  # (C + 1,) Index of each road's first sample
    curve: IntArray  # (n,) Road of each sample
    s: FloatArray  # (n,) m

    def inner_quarters(self) -> BoolArray:
        """Return which samples lie at quarters of the length, but for the ends, (n,)."""
        count = np.diff(self.start)[self.curve]
        rank = np.arange(len(self.s)) - self.start[self.curve]
        return np.asarray((rank % ((count - 1) // 4) == 0) & (rank > 0) & (rank < count - 1))

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


@record(eq=False)
class _LaidHeights:
    """Heights of connecting roads at samples, (n,)."""

    on_surface: FloatArray  # As the surface of the junction has them, m
    z: FloatArray  # As they are, m
    grade: FloatArray

    def records(self, along: _Along) -> CubicProfile:
        tolerance = np.full(len(along.length), defaults.CONNECTOR_TOLERANCE)
        return fit_records(
            along.start, along.length, self.z, self.grade, tolerance, defaults.CONNECTOR_GRADE_TOLERANCE
        )


def _lay_heights(
    along: _Along,
    problem: ProfileProblem,
    connectors: ConnectorProblem,
    solution: ProfileSolution,
    z: FloatArray,
    grade: FloatArray,
) -> _LaidHeights:
    """Return the heights of connecting roads from height, m, and grade of the surface along them, (n,)."""
    first, last = along.start[:-1], along.start[1:] - 1
    z0, g0 = end_state(solution, connectors.start_end, connectors.start_t, leaving=True)
    z1, g1 = end_state(solution, connectors.end_end, connectors.end_t, leaving=False)
    g0 = _grade_along_lane(problem, connectors.start_end, connectors.start_t, g0)
    g1 = _grade_along_lane(problem, connectors.end_end, connectors.end_t, g1)
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
    grade = np.where(plain[along.curve], plain_grade, grade)
    grade[first], grade[last] = g0, g1
    on_surface = z.copy()
    _ease(along, problem, connectors, z, grade)
    return _LaidHeights(on_surface, z, grade)


def _ease(
    along: _Along, problem: ProfileProblem, connectors: ConnectorProblem, z: FloatArray, grade: FloatArray
) -> None:
    """Ease heights, m, and grades, both (n,), in place, of connecting roads that would throw a car."""
    posted = connector_speeds(problem, connectors.start_end, connectors.end_end)[along.curve]
    felt = largest_acceleration(along.start, along.s, posted, z, grade)
    # Bends only make cars slower: few roads are left to look at.
    hard = felt > defaults.VERTICAL_ACCELERATION_MAX
    at = np.flatnonzero(hard[along.curve])
    s, curve = along.s[at], along.curve[at]
    start = np.r_[0, np.cumsum(np.diff(along.start)[hard])].astype(np.int64)
    speed = fastest_around(connectors.plan_view, curve, s, posted[at])
    z[at], grade[at] = ease_profiles(start, s, speed, z[at], grade[at], CONNECTOR_STEEP)


def _grade_along_lane(problem: ProfileProblem, end: IntArray, t: FloatArray, grade: FloatArray) -> FloatArray:
    """Return the grade of lanes at t, m, of road ends, from that of the reference line, all (C,).

    A lane inside of a bend climbs as much over less length: z' / (1 - k t). Readers that go by reference lines see
    what is changed as a kink, which stays below `LANE_GRADE_STEP_MAX`.
    """
    plan = problem.plan_view
    both = np.column_stack([plan.curvature[plan.start[:-1]], end_curvature(plan, plan.start[1:] - 1)])
    curvature = both.ravel()[end]
    along = grade / np.maximum(1.0 - curvature * t, _LEAST_LENGTH_SHARE)
    step = defaults.LANE_GRADE_STEP_MAX
    return np.asarray(np.clip(along, grade - step, grade + step))


def _fit_superelevation(
    along: _Along,
    problem: ProfileProblem,
    connectors: ConnectorProblem,
    solution: ProfileSolution,
    cross: FloatArray,
) -> CubicProfile:
    """Return the superelevation of connecting roads from the cross slope of the surface along them, (n,)."""
    first, last = along.start[:-1], along.start[1:] - 1
    zero = np.zeros(len(along.length))
    ends = _end_superelevation(solution, connectors)
    reach = np.minimum(along.length, defaults.CONNECTOR_END_REACH)
    begin, end = slope_of(ends)
    cross = cross + along.blend(reach, (begin - cross[first], zero, end - cross[last], zero))[0]
    cross[first], cross[last] = begin, end
    most, at_ends = _largest_twist(problem, connectors), _end_twist(connectors, solution, ends)
    superelevation = _limit_twist(along, arctan2(cross, 1.0), most, ends)
    superelevation[first], superelevation[last] = ends
    tolerance = defaults.CONNECTOR_EDGE_TOLERANCE / np.maximum(connectors.half_width, _NARROWEST)
    tilted = (_largest(along.start, np.abs(superelevation)) > tolerance) | ends.any(axis=0)
    twist = _differences(along, superelevation)
    twist[first], twist[last] = at_ends
    records = fit_records(
        along.start, along.length, superelevation, twist, tolerance, defaults.CONNECTOR_TWIST_TOLERANCE
    )
    return only_curves(records, tilted)


def _end_superelevation(solution: ProfileSolution, connectors: ConnectorProblem) -> FloatArray:
    """Return the superelevation at the start and at the end of connecting roads, seen along them, (2, C), rad."""
    if solution.end_superelevation is None:
        return np.zeros((2, len(connectors.junction)))
    of_end = solution.end_superelevation.ravel()
    begin, end = of_end[connectors.start_end], of_end[connectors.end_end]
    return np.stack(
        [np.where(connectors.start_end % 2 == 1, begin, -begin), np.where(connectors.end_end % 2 == 0, end, -end)]
    )


def _end_twist(connectors: ConnectorProblem, solution: ProfileSolution, ends: FloatArray) -> FloatArray:
    """Return the slope of the superelevation, `ends` (2, C), at both ends of connecting roads, (2, C), rad/m.

    Where they keep the crossfall of their arms their lanes lie beside them: with a bend that begins at once, of
    curvature k, a lane at t keeps its grade z' = (z' + t χ') / (1 - k t) with χ' = -k z'.
    """
    plan = connectors.plan_view
    bend = np.stack([plan.curvature[plan.start[:-1]], end_curvature(plan, plan.start[1:] - 1)])
    sides = ((connectors.start_end, connectors.start_t, True), (connectors.end_end, connectors.end_t, False))
    grade = np.stack([end_state(solution, end, t, leaving)[1] for end, t, leaving in sides])
    return np.clip(np.where(ends != 0.0, -bend * grade, 0.0), -_LARGEST_END_TWIST, _LARGEST_END_TWIST)


def _largest_twist(problem: ProfileProblem, connectors: ConnectorProblem) -> FloatArray:
    """Return the largest change of superelevation of connecting roads, rad/m, (C,).

    Less between fast roads, more where a road turns on the plane between warped arms.
    """
    fast = fast_spans(problem)[end_spans(problem).ravel()]
    both = fast[connectors.start_end] & fast[connectors.end_end]
    usual = np.where(both, defaults.FAST_TWIST_MAX, defaults.TWIST_MAX)
    return np.where(at_junctions(problem.warped, connectors.junction), defaults.TURNING_TWIST_MAX, usual)


def _limit_twist(along: _Along, value: FloatArray, largest: FloatArray, ends: FloatArray) -> FloatArray:
    """Return superelevation, rad, (n,), that changes by at most `largest`, rad/m, (C,), and is `ends` (2, C) there.

    Half-way between the largest such function below the values and the least above them.
    """
    out = np.empty_like(value)
    count = np.diff(along.start)
    for n in np.unique(count).tolist():
        group = np.flatnonzero(count == n)
        at = along.start[group][:, None] + np.arange(n)
        ramp = largest[group, None] * along.s[at]
        low, high = value[at], value[at]
        low = np.minimum.accumulate(low - ramp, axis=1) + ramp
        low = np.minimum.accumulate((low + ramp)[:, ::-1], axis=1)[:, ::-1] - ramp
        high = np.maximum.accumulate(high + ramp, axis=1) - ramp
        high = np.maximum.accumulate((high - ramp)[:, ::-1], axis=1)[:, ::-1] + ramp
        rest, (begin, end) = ramp[:, -1:] - ramp, ends[:, group, None]
        least, most = np.maximum(begin - ramp, end - rest), np.minimum(begin + ramp, end + rest)
        out[at] = np.clip(0.5 * (low + high), least, most)
    return out


def _differences(along: _Along, value: FloatArray) -> FloatArray:
    """Return the slope of values at samples, (n,), from those on both sides; at the ends 0."""
    out = np.zeros(len(value))
    inner = np.setdiff1d(np.arange(len(value)), np.r_[along.start[:-1], along.start[1:] - 1])
    out[inner] = (value[inner + 1] - value[inner - 1]) / (along.s[inner + 1] - along.s[inner - 1])
    return out
