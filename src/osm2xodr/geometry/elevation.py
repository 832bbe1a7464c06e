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

from osm2xodr import defaults
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.curves import lengths
from osm2xodr.geometry.junction_surface import connector_profiles
from osm2xodr.geometry.profile_evidence import (
    Reading,
    height_evidence,
    height_weights,
    incline_evidence,
    junction_evidence,
    read_heights,
    scale_of,
    twin_evidence,
)
from osm2xodr.geometry.profile_limits import (
    clearance_limits,
    grade_limits,
    tilt_limits,
)
from osm2xodr.geometry.profile_output import thin_records
from osm2xodr.geometry.profile_problem import ConnectorProblem, ElevationOptions, ProfileProblem, ProfileSolution
from osm2xodr.geometry.profile_report import Outcome, element_grades, report, statistics
from osm2xodr.geometry.profile_solver import Robust, joined_limits, joined_observations, solve_network
from osm2xodr.geometry.profile_structures import chord_coupling, find_chains, find_crossings
from osm2xodr.geometry.profile_system import (
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
from osm2xodr.model import CubicProfile, FloatArray, IntArray, Structure, Surface

__all__ = [
    "ConnectorProblem",
    "ElevationOptions",
    "ProfileProblem",
    "ProfileSolution",
    "connector_profiles",
    "solve_profiles",
]

# Residuals beyond three standard errors lose weight, above and below alike: canopy and roofs have been dealt with.
_ROBUST = Robust(3.0, 3.0)


def solve_profiles(
    problem: ProfileProblem,
    surface: Surface,
    diagnostics: Diagnostics,
    options: ElevationOptions | None = None,
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

    Raises
    ------
    ValueError
        `problem.end_link` is not symmetric.
    """
    options = options or ElevationOptions()
    problem = problem if options.structures else _without_structures(problem)
    scale = scale_of(surface)
    elements = build_elements(problem, scale.knot_spacing)
    samples = build_samples(problem, elements, scale.sample_spacing)
    reading, at_junctions = read_heights(surface, samples, problem.junction_xy, scale, options.smoothing**4)
    level = np.concatenate([reading.z, at_junctions.z])
    if not len(elements.h) or (scale.cell == 0 and np.ptp(level) == 0):
        return _level(problem, float(level[0]) if len(level) else 0.0)

    unknowns = number_unknowns(problem, elements)
    weight, floating = height_weights(problem, elements, unknowns, samples, reading, scale)
    mean = float(np.mean(reading.z[reading.measured] if reading.measured.any() else reading.z))
    evidence = [
        height_evidence(elements, unknowns, samples, reading, weight, mean),
        junction_evidence(unknowns, at_junctions, mean),
        incline_evidence(problem, elements, unknowns),
    ]
    if scale.is_coarse:
        evidence.append(twin_evidence(problem, elements, unknowns, samples, scale))
    limit = _class_values(problem, options.grade_limit, defaults.GRADE_LIMIT_OTHER)
    factor = _class_values(problem, defaults.FLEXIBILITY_FACTOR, 1.0) / options.smoothing**4
    q = defaults.ROAD_FLEXIBILITY * factor[elements.span]
    density = _typical_density(reading)
    crossings = find_crossings(problem, unknowns.end_node)
    inner = [
        *grade_limits(elements, unknowns, limit[elements.span], q, density),
        *tilt_limits(problem, unknowns, limit[_end_spans(problem)], defaults.ROAD_FLEXIBILITY, density),
    ]
    apart = clearance_limits(elements, unknowns, crossings, q, density, scale.sigma)
    stiffness = _stiffness(problem, elements, unknowns, q)
    columns = stiffness.shape[0]
    x, _ = solve_network(
        stiffness,
        joined_observations(evidence, columns),
        joined_limits(inner, columns),
        joined_limits([*inner, apart], columns),
        _ROBUST,
    )

    x = x[: unknowns.to_knots.shape[1]]
    x[unknowns.z_columns] += mean
    knots = (unknowns.to_knots @ x).reshape(-1, 2)
    planes = x[: 3 * len(problem.junction_xy)].reshape(-1, 3).copy()
    outcome = Outcome(
        z=evidence[0].rows @ x,
        reading=reading,
        floating=floating,
        grade=element_grades(elements, knots),
        limit=limit[elements.span],
        crossings=crossings,
        clearance=apart.rows @ x,
        tilt=np.hypot(planes[:, 1], planes[:, 2]),
    )
    report(problem, elements, samples, outcome, diagnostics)
    return _solution(elements, knots, planes, statistics(elements, samples, outcome))


def _without_structures(problem: ProfileProblem) -> ProfileProblem:
    """Return the problem with all roads on the ground."""
    none = np.zeros_like(problem.span_structure)
    return replace(problem, span_structure=none, span_layer=none)


def _typical_density(reading: Reading) -> float:
    """Return the weight per metre of road that is usual where something is measured, 1/m³."""
    density = reading.density
    return float(np.median(density[reading.measured] if reading.measured.any() else density))


def _class_values(problem: ProfileProblem, table: Mapping[str, float], other: float) -> FloatArray:
    """Return a table's value for each span's class, (K,)."""
    return np.array([table.get(highway, other) for highway in problem.span_highway], np.float64)


def _end_spans(problem: ProfileProblem) -> IntArray:
    """Return the spans at both ends of each road, (R, 2)."""
    return np.column_stack([problem.span_start[:-1], problem.span_start[1:] - 1])


def _stiffness(problem: ProfileProblem, elements: Elements, unknowns: Unknowns, q: FloatArray) -> sp.csr_matrix:
    """Return bending, tension of structures and level junctions, with the chains' unknowns behind the others."""
    tension = np.where(
        elements.structure != Structure.GROUND,
        1.0 / (defaults.ROAD_FLEXIBILITY * defaults.STRUCTURE_TENSION_LENGTH**2),
        0.0,
    )
    matrices = bending(elements.h) / q[:, None, None] + stretching(elements.h) * tension[:, None, None]
    p = unknowns.to_knots
    matrix = p.T @ assemble(element_dofs(elements), matrices, p.shape[0]) @ p
    junctions = len(problem.junction_xy)
    diagonal = np.zeros(p.shape[1])
    diagonal[: 3 * junctions].reshape(-1, 3)[:, 1:] = 1.0 / defaults.JUNCTION_TILT_SIGMA**2
    matrix = matrix + sp.diags(diagonal)
    chains = find_chains(problem, elements)
    if len(chains.loose):
        coupling, own = chord_coupling(elements, chains, tension, unknowns)
        matrix = sp.bmat([[matrix, coupling], [coupling.T, own]])
    return sp.csr_matrix(matrix)


def _solution(
    elements: Elements, knots: FloatArray, planes: FloatArray, figures: dict[str, float]
) -> ProfileSolution:
    """Return the solution from z and g at the knots."""
    profile = thin_records(elements.knot_start, elements.knot_s, knots[:, 0].copy(), knots[:, 1].copy())
    ends = np.stack([knots[elements.knot_start[:-1]], knots[elements.knot_start[1:] - 1]], axis=1)
    return ProfileSolution(profile, planes, ends[:, :, 0].copy(), ends[:, :, 1].copy(), figures)


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
