"""Heights of a road network: one sparse least-squares solve for all roads and junctions together.

The roads are elastic beams on springs, the heights of the ground, and meet at junctions on common planes; what they
must not do bends them with elastic force. `solve_profiles` finds the roads' heights, `connector_profiles` those of
the roads that connect them within junctions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import lengths, pose
from osm2xodr.defaults import GRADE_LIMIT_OTHER
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.canopy import keep_ground
from osm2xodr.geometry.heights.elements import (
    Elements,
    Unknowns,
    assemble,
    bending,
    build_elements,
    build_samples,
    element_dofs,
    number_unknowns,
    stretching,
)
from osm2xodr.geometry.heights.ground import Ground, estimate_ground
from osm2xodr.geometry.heights.junction_surface import connector_profiles
from osm2xodr.geometry.heights.limits import clearance_limits, grade_limits, tilt_limits
from osm2xodr.geometry.heights.observations import (
    ele_evidence,
    height_evidence,
    height_weights,
    incline_evidence,
    junction_evidence,
    pin_evidence,
    twin_evidence,
)
from osm2xodr.geometry.heights.problem import ConnectorProblem, ElevationOptions, ProfileProblem, ProfileSolution
from osm2xodr.geometry.heights.readings import read_heights, road_spacing, typical_density
from osm2xodr.geometry.heights.records import thin_records, with_knots
from osm2xodr.geometry.heights.report import Outcome, element_grades, report
from osm2xodr.geometry.heights.solver import (
    Robust,
    Stage,
    joined_limits,
    joined_observations,
    see_through,
    solve_network,
)
from osm2xodr.geometry.heights.structures import Chains, chord_coupling, find_chains, find_crossings
from osm2xodr.geometry.heights.superelevation import road_superelevation
from osm2xodr.geometry.heights.tables import elevation_report, figures
from osm2xodr.model import BoolArray, CubicProfile, ElevationReport, FloatArray, IntArray, Structure, Surface
from osm2xodr.system import release_memory

__all__ = [
    "ConnectorProblem",
    "ElevationOptions",
    "Ground",
    "ProfileProblem",
    "ProfileSolution",
    "connector_profiles",
    "ground_around",
    "solve_profiles",
]

# Residuals beyond so many standard errors lose weight.
OUTLIER_SIGMAS = 3.0


def ground_around(
    surface: Surface,
    x: FloatArray,
    y: FloatArray,
    options: ElevationOptions | None = None,
    origin: tuple[float, float] | None = None,
) -> Ground:
    """Estimate the ground around where roads are expected, for `solve_profiles`.

    Parameters
    ----------
    surface
        Height of the ground.
    x, y : (n,)
        Points along all streets, local, m; at most a few hundred metres apart.
    options
        The user's choices.
    origin
        Where the windows' lattice begins, local, m: the same for areas side by side. None for where it needs the
        fewest windows.
    """
    factor = _roughness_factor(options or ElevationOptions())
    return estimate_ground(surface, x, y, factor, defaults.GROUND_REACH, origin)


def solve_profiles(
    problem: ProfileProblem,
    surface: Surface,
    diagnostics: Diagnostics,
    options: ElevationOptions | None = None,
    ground: Ground | None = None,
) -> ProfileSolution:
    """Find the heights of all roads and junctions.

    Parameters
    ----------
    problem
        The roads.
    surface
        Height of the ground.
    diagnostics
        Where guesses and unmet limits are told.
    options
        The user's choices.
    ground
        What `estimate_ground` found with the same choices around where the roads were expected. It saves time only:
        what lacks is estimated here.

    Raises
    ------
    ValueError
        `problem.end_link` is not symmetric, or the ground was estimated with another smoothing.
    """
    options = options or ElevationOptions()
    problem = problem if options.structures else _without_structures(problem)
    spacing = road_spacing(problem, surface)
    elements = build_elements(problem, spacing.knots)
    samples = build_samples(problem, elements, spacing.samples)
    ground = ground or Ground(_roughness_factor(options))
    if ground.smoothing != _roughness_factor(options):
        raise ValueError("the ground must be estimated with the smoothing that the roads are")
    reading, at_junctions = read_heights(surface, samples, problem.junction_xy, ground)
    level = np.concatenate([reading.z, at_junctions.z])
    if not len(elements.h) or (not reading.cell.any() and np.ptp(level) == 0):
        return _level(problem, float(level[0]) if len(level) else 0.0)

    unknowns = number_unknowns(problem, elements)
    weight, floating = height_weights(problem, elements, unknowns, samples, reading)
    mean = float(np.mean(reading.z[reading.measured] if reading.measured.any() else reading.z))
    limit = _class_values(problem, options.grade_limit, GRADE_LIMIT_OTHER)
    factor = _class_values(problem, defaults.FLEXIBILITY_FACTOR, 1.0) / options.smoothing**4
    q = defaults.ROAD_FLEXIBILITY * factor[elements.span]
    density = typical_density(reading, spacing.cell)[elements.road]
    crossings = find_crossings(problem, unknowns.end_node)
    sigma = surface.quality(*pose(problem.plan_view, crossings.lower, crossings.lower_s)[:2]).sigma
    apart = clearance_limits(elements, unknowns, crossings, q, density, sigma)
    chains = find_chains(problem, elements)
    stiffness = _stiffness(elements, unknowns, chains, q)
    columns = stiffness.shape[0]
    release_memory()
    pins = pin_evidence(problem, elements, unknowns, mean)
    # What these are made of is as large as they are, and is let go at once.
    observations = joined_observations(
        [
            height_evidence(elements, unknowns, samples, reading, weight, mean),
            junction_evidence(unknowns, at_junctions, mean),
            incline_evidence(problem, elements, unknowns),
            ele_evidence(problem, elements, unknowns, mean),
            twin_evidence(problem, elements, unknowns, samples, reading),
            pins,
        ],
        columns,
    )
    limits = joined_limits(
        [
            *grade_limits(elements, unknowns, limit[elements.span], q, density),
            *tilt_limits(
                problem,
                unknowns,
                limit[_end_spans(problem)],
                defaults.ROAD_FLEXIBILITY,
                typical_density(reading, at_junctions.cell),
            ),
            apart,
        ],
        columns,
    )
    covered = np.zeros(len(observations.z), bool)
    covered[: len(level)] = np.concatenate([reading.covered, at_junctions.covered])
    robust, first = _robust(covered, len(pins.z)), np.ones(len(covered))
    if covered.any():
        stages = _stages(elements, unknowns, chains, q, density)
        first[covered] = see_through(stages, observations, robust)[covered]
        robust = keep_ground(robust, first, covered, elements.road[samples.element], samples.s, reading.z)
    release_memory()
    solved = solve_network(stiffness, observations, limits, len(limits.low) - len(apart.low), robust, first)
    del observations, limits
    release_memory()

    x = solved.x[: unknowns.to_knots.shape[1]]
    x[unknowns.z_columns] += mean
    knots = (unknowns.to_knots @ x).reshape(-1, 2)
    planes = x[: 3 * len(problem.junction_xy)].reshape(-1, 3).copy()
    outcome = Outcome(
        z=solved.z[: len(samples.s)] + mean,
        reading=reading,
        floating=floating,
        grade=element_grades(elements, knots),
        limit=limit[elements.span],
        crossings=crossings,
        clearance=apart.rows @ x,
        chain=chains.chain,
        tilt=np.hypot(planes[:, 1], planes[:, 2]),
    )
    report(problem, elements, samples, outcome, diagnostics)
    told = elevation_report(problem, elements, samples, outcome)
    solution = _solution(problem, elements, knots, planes, figures(elements, outcome, told), told)
    if not options.superelevation:
        return solution
    return replace(solution, superelevation=road_superelevation(problem, elements, samples, surface, diagnostics))


def _roughness_factor(options: ElevationOptions) -> float:
    """Return the factor on the penalty on roughness: lengths go with its fourth root."""
    return options.smoothing**4


def _without_structures(problem: ProfileProblem) -> ProfileProblem:
    """Return the problem with all roads on the ground."""
    none = np.zeros_like(problem.span_structure)
    return replace(problem, span_structure=none, span_layer=none)


def _class_values(problem: ProfileProblem, table: Mapping[str, float], other: float) -> FloatArray:
    """Return a table's value for each span's class, (K,)."""
    return np.array([table.get(highway, other) for highway in problem.span_highway], np.float64)


def _end_spans(problem: ProfileProblem) -> IntArray:
    """Return the spans at both ends of each road, (R, 2)."""
    return np.column_stack([problem.span_start[:-1], problem.span_start[1:] - 1])


def _robust(covered: BoolArray, pins: int) -> Robust:
    """Return how observations lose weight, (n,): below and above alike, unless they may stand on the ground.

    The last ones, pins, lose none.
    """
    above = np.where(covered, defaults.COVERED_ABOVE, OUTLIER_SIGMAS)
    below = np.where(covered, defaults.COVERED_BELOW, OUTLIER_SIGMAS)
    above[len(covered) - pins :] = below[len(covered) - pins :] = np.inf
    return Robust(above, below)


def _stages(
    elements: Elements, unknowns: Unknowns, chains: Chains, q: FloatArray, density: FloatArray
) -> list[Stage]:
    """Return the networks, from the stiffest on, that see through canopy and roofs.

    A beam on an elastic foundation gives way over (1 / (density q))^(1/4).
    """
    return [
        Stage(_stiffness(elements, unknowns, chains, np.minimum(q, 1.0 / (density * length**4))), tolerance)
        for length, tolerance in defaults.COVERED_STAGES
    ]


def _stiffness(elements: Elements, unknowns: Unknowns, chains: Chains, q: FloatArray) -> sp.csr_matrix:
    """Return bending, tension of structures and level junctions, with the chains' unknowns behind the others."""
    tension = np.where(
        elements.structure != Structure.GROUND,
        1.0 / (defaults.ROAD_FLEXIBILITY * defaults.STRUCTURE_TENSION_LENGTH**2),
        0.0,
    )
    matrices = bending(elements.h) / q[:, None, None] + stretching(elements.h) * tension[:, None, None]
    p = unknowns.to_knots
    matrix = p.T @ assemble(element_dofs(elements), matrices, p.shape[0]) @ p
    diagonal = np.zeros(p.shape[1])
    diagonal[: 3 * unknowns.junctions].reshape(-1, 3)[:, 1:] = 1.0 / defaults.JUNCTION_TILT_SIGMA**2
    matrix = matrix + sp.diags(diagonal)
    if len(chains.loose):
        coupling, own = chord_coupling(elements, chains, tension, unknowns)
        matrix = sp.bmat([[matrix, coupling], [coupling.T, own]])
    return sp.csr_matrix(matrix)


def _solution(
    problem: ProfileProblem,
    elements: Elements,
    knots: FloatArray,
    planes: FloatArray,
    statistics: dict[str, float],
    told: ElevationReport,
) -> ProfileSolution:
    """Return the solution from z and g at the knots."""
    # Ends that touch round alike: they have the same numbers.
    knots = np.column_stack(
        [np.round(knots[:, 0], defaults.PROFILE_DECIMALS), np.round(knots[:, 1], defaults.PROFILE_SLOPE_DECIMALS)]
    )
    z, grade = knots[:, 0].copy(), knots[:, 1].copy()
    if problem.pins is None:
        profile = thin_records(elements.knot_start, elements.knot_s, z, grade)
    else:
        start, s, z, grade, held = with_knots(elements.knot_start, elements.knot_s, z, grade, problem.pins)
        profile = thin_records(start, s, z, grade, held=held)
    ends = np.stack([knots[elements.knot_start[:-1]], knots[elements.knot_start[1:] - 1]], axis=1)
    return ProfileSolution(profile, planes, ends[:, :, 0].copy(), ends[:, :, 1].copy(), statistics, told)


def _level(problem: ProfileProblem, z: float) -> ProfileSolution:
    """Return the solution on an exactly level surface."""
    length = lengths(problem.plan_view)
    roads = len(length)
    start = np.arange(roads + 1, dtype=np.int64)
    zero = np.zeros(roads)
    planes = np.zeros((len(problem.junction_xy), 3))
    planes[:, 0] = z
    profile = CubicProfile(start, zero, np.full(roads, z), zero, zero, zero)
    return ProfileSolution(profile, planes, np.full((roads, 2), z), np.zeros((roads, 2)))
