"""Heights of roads on a world of one height.

They have that height, but where junctions lie on the crossfall of their arms, and where bridges and tunnels lead over
or under other roads: these and the ramps to them are solved as elsewhere, and all other roads keep out of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, cosine, lengths, sine, slope_of
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Network, end_poses
from osm2xodr.geometry.heights.problem import Pins, ProfileProblem, ProfileSolution, chosen_junctions, chosen_roads
from osm2xodr.geometry.heights.records import (
    Knots,
    either_profile,
    hermite_records,
    level_profile,
    spread_curves,
)
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray, Structure, SurfaceQuality
from osm2xodr.system import record

# Roads farther than this from all structures do not cross any, m: beyond the longest ways through junctions, whose
# arms these are.
_NEAR_STRUCTURE: Final = 200.0


@record
class LevelGround:
    """Level ground that ramps may leave as they may leave that of an elevation model."""

    z: float  # m
    cell_size: float = defaults.LEVEL_CELL
    sigma: float = defaults.LEVEL_SIGMA

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return its height, m, for local x, y (n,), m, and that it is measured."""
        return np.full(len(x), self.z), np.ones(len(x), bool)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return that the height at local x, y (n,), m, is measured."""
        return np.ones(len(x), bool)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how much heights at local x, y (n,), m, count."""
        size = len(x)
        return SurfaceQuality(np.full(size, self.cell_size), np.full(size, self.sigma), np.zeros(size, np.bool_))


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
        j, slope = problem.end_junction.ravel()[tilted], slope_of(superelevation.ravel()[tilted])
        # Least squares: across each arm the plane has its slope, along it none.
        count = np.maximum(np.bincount(j, minlength=len(planes)), 1)
        planes[:, 1] = np.bincount(j, -slope * sine(hdg), len(planes)) / count
        planes[:, 2] = np.bincount(j, slope * cosine(hdg), len(planes)) / count
        gx, gy = planes[j, 1], planes[j, 2]
        rise = gx * (x - problem.junction_xy[j, 0]) + gy * (y - problem.junction_xy[j, 1])
        end_z.ravel()[tilted] = np.round(z + rise, defaults.RECORD_DECIMALS)
        end_grade.ravel()[tilted] = np.round(gx * cosine(hdg) + gy * sine(hdg), defaults.RECORD_SLOPE_DECIMALS)
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


def roads_near_structures(network: Network) -> IntArray:
    """Return the roads that bridges, tunnels and other layers may lead over or under, ascending."""
    elements, samples = network.elements, network.samples
    apart = (elements.structure != Structure.GROUND) | (network.problem.span_layer[elements.span] != 0)
    at = apart[samples.element]
    return _roads_within(network, np.column_stack([samples.x[at], samples.y[at]]), _NEAR_STRUCTURE)


def ramp_roads(network: Network, crossings: FloatArray, z: float) -> IntArray:
    """Return the roads that need not keep to the height z of the world, m, ascending.

    They lie within the reach of ramps to `crossings`, (n, 2), m, where one road passes over another, or are held to
    another height.
    """
    pins, near = network.problem.pins, _roads_within(network, crossings, defaults.RAMP_REACH)
    held = near[:0] if pins is None else pins.road[np.isfinite(pins.z) & ((pins.z != z) | (pins.grade != 0.0))]
    return np.asarray(np.union1d(near, held))


def _roads_within(network: Network, places: FloatArray, reach: float) -> IntArray:
    """Return the roads that come within a distance of one of the places, (n, 2), all m, ascending."""
    if not len(places):
        return np.zeros(0, np.int64)
    samples = network.samples
    _, near = PointTree(places).nearest(np.column_stack([samples.x, samples.y]), reach)
    return np.asarray(np.unique(network.elements.road[samples.element[near >= 0]]))


def ramp_problem(network: Network, roads: IntArray, level: ProfileSolution) -> tuple[ProfileProblem, Pins]:
    """Return the problem of those roads alone, and their ends where others go on, which keep the level solution."""
    problem = network.problem
    own = np.zeros(len(problem.end_junction), bool)
    own[roads] = True
    node = network.unknowns.end_node.reshape(-1, 2)
    # Whether a road that keeps the level meets there.
    others = np.bincount(node[~own].ravel(), minlength=int(node.max()) + 1) > 0
    row, end = np.nonzero(others[node[roads]])
    part = chosen_roads(problem, roads)
    s = np.where(end == 0, 0.0, lengths(part.plan_view)[row])
    ends = Pins(row, s, level.end_z[roads[row], end], level.end_grade[roads[row], end])
    # Tags of heights and grades contradict a level world.
    part = replace(
        part, span_grade=np.full(len(part.span_s), np.nan), known=None, ele_road=None, ele_s=None, ele_z=None
    )
    return replace(part, pins=_joined(ends, problem.pins, roads)), ends


def _joined(ends: Pins, pins: Pins | None, roads: IntArray) -> Pins:
    """Return pins at ends of some roads, and the others that these have."""
    if pins is None:
        return ends
    on = np.flatnonzero(np.isin(pins.road, roads))
    return Pins(
        np.concatenate([ends.road, np.searchsorted(roads, pins.road[on])]),
        *(np.concatenate([getattr(ends, name), getattr(pins, name)[on]]) for name in ("s", "z", "grade")),
    )


def with_ramps(
    problem: ProfileProblem, roads: IntArray, level: ProfileSolution, ramps: ProfileSolution, ends: Pins
) -> ProfileSolution:
    """Return the level solution with the heights of `ramp_problem`, whose `ends` keep the level, on some roads."""
    profile = spread_curves(ramps.elevation, roads, len(problem.end_junction))
    end_z, end_grade, planes = level.end_z.copy(), level.end_grade.copy(), level.junction_plane.copy()
    pinned = roads[ends.road], np.where(ends.s > 0.0, 1, 0)
    held = end_z[pinned], end_grade[pinned]
    end_z[roads], end_grade[roads] = ramps.end_z, ramps.end_grade
    end_z[pinned], end_grade[pinned] = held
    junctions = chosen_junctions(problem, roads)
    inner = np.ones(len(problem.junction_xy), bool)
    at = problem.end_junction[pinned]
    inner[at[at >= 0]] = False
    planes[junctions] = np.where(inner[junctions, None], ramps.junction_plane, planes[junctions])
    return replace(
        level,
        elevation=either_profile(profile, level.elevation),
        junction_plane=planes,
        end_z=end_z,
        end_grade=end_grade,
        statistics=ramps.statistics,
        report=ramps.report,
    )
