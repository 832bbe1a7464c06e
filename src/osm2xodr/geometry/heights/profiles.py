"""Heights of a road network: one sparse least-squares problem for all roads and junctions together.

The roads are elastic beams on springs, the heights of the ground, and meet at junctions on common planes; limits bend
them with elastic force. Start reading at `solve_profiles`; the mathematics is in docs/method/heights.md.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
import scipy.sparse as sp

from osm2xodr.defaults import GRADE_LIMIT, GRADE_LIMIT_OTHER
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.arm_limits import limit_arms
from osm2xodr.geometry.heights.canopy import canopy_stages, downweight_canopy, restore_ground
from osm2xodr.geometry.heights.crossings import Crossings, find_crossings
from osm2xodr.geometry.heights.elements import Network, build_elements, build_samples, number_unknowns
from osm2xodr.geometry.heights.ground import Ground, estimate_ground
from osm2xodr.geometry.heights.level_world import (
    LevelGround,
    level_solution,
    ramp_problem,
    ramp_roads,
    roads_near_structures,
    with_ramps,
)
from osm2xodr.geometry.heights.limits import (
    Limits,
    limit_clearances,
    limit_curvatures,
    limit_cut_and_fill,
    limit_grades,
    limit_known,
    limit_meetings,
    limit_structures,
)
from osm2xodr.geometry.heights.newton import solve_network
from osm2xodr.geometry.heights.observations import Kind, Observations, collect_observations, weigh_heights
from osm2xodr.geometry.heights.problem import (
    ProfileProblem,
    ProfileSolution,
    chosen_roads,
    class_values,
)
from osm2xodr.geometry.heights.readings import Reading, read_heights, road_spacing, typical_ground
from osm2xodr.geometry.heights.records import Knots, add_pins, either_profile, thin_records
from osm2xodr.geometry.heights.report import (
    Outcome,
    element_grades,
    report,
    report_known_clearances,
    report_known_heights,
    report_limits,
    statistics,
    tabulate,
)
from osm2xodr.geometry.heights.sparse import join_blocks
from osm2xodr.geometry.heights.stiffness import (
    Beams,
    Chains,
    bridges_above,
    estimated_elements,
    find_chains,
    network_stiffness,
    road_flexibility,
)
from osm2xodr.geometry.heights.superelevation import (
    road_superelevation,
    warp_ends,
    warp_profiles,
)
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import BoolArray, FloatArray, Surface
from osm2xodr.system import record, release_memory


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
    surface, options
        Height of the ground, and the user's choices.
    x, y : (n,)
        Points along all streets, local, m; at most a few hundred metres apart.
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
    problem, surface, options
        The roads, the height of the ground, and the user's choices.
    diagnostics
        Receives guesses and limits that are not met.
    ground
        Result of `ground_around` with the same options. It saves time only: what is missing is estimated here.

    Raises
    ------
    ValueError
        `problem.end_link` is not symmetric, or the ground was estimated with another smoothing.
    """
    options = options or ElevationOptions()
    ground = ground or Ground(_roughness_factor(options))
    if ground.smoothing != _roughness_factor(options):
        raise ValueError("the ground must be estimated with the smoothing that the roads are")
    if not options.structures:
        on_ground = np.zeros_like(problem.span_structure)
        problem = replace(problem, span_structure=on_ground, span_layer=on_ground)
    network, cell = _cut(problem, surface)
    superelevation, across = road_superelevation(network, surface, options.superelevation, diagnostics)
    z = _only_height(network, surface)
    if z is not None:
        solution = _solve_level(network, z, across, options, diagnostics)
    else:
        solved = _solve(network, cell, surface, across, options, ground)
        report(network, solved.outcome, diagnostics)
        report_known_heights(problem, solved.known_z, diagnostics)
        report_known_clearances(problem, solved.outcome.crossings, diagnostics)
        solution = _write_records(network, solved.outcome)
    warp = warp_ends(problem, solution.junction_plane)
    known = [item for item in (superelevation, warp_profiles(problem, warp)) if item is not None]
    found = reduce(either_profile, known) if known else None
    return replace(solution, superelevation=found, end_superelevation=across + warp)


def _cut(problem: ProfileProblem, surface: Surface) -> tuple[Network, FloatArray]:
    """Return roads cut into elements and samples, and the size of the surface's cells along each of them, (R,), m."""
    spacing = road_spacing(problem, surface)
    elements = build_elements(problem, spacing.knots)
    samples = build_samples(problem, elements, spacing.samples)
    return Network(problem, elements, samples, number_unknowns(problem, elements)), spacing.cell


def _only_height(network: Network, surface: Surface) -> float | None:
    """Return the height of all roads if the surface is exact and there is but one, m."""
    samples, junctions = network.samples, network.problem.junction_xy
    if not len(samples.x):
        return 0.0
    if surface.cell_size > 0.0:
        return None
    x, y = np.concatenate([samples.x, junctions[:, 0]]), np.concatenate([samples.y, junctions[:, 1]])
    z = surface.heights(x, y)[0]
    exact = not np.ptp(z) and not surface.quality(x, y).cell_size.any()
    return float(z[0]) if exact else None


def _solve_level(
    network: Network, z: float, across: FloatArray, options: ElevationOptions, diagnostics: Diagnostics
) -> ProfileSolution:
    """Return the heights on a world of one height, m: that, but for what leads over or under other roads."""
    problem = network.problem
    report_known_heights(problem, None, diagnostics)
    level = level_solution(problem, z, across)
    if not len(network.elements.h):
        return level
    near, crossings, places = roads_near_structures(network), None, np.zeros((0, 2))
    if len(near):
        part, _ = _cut(chosen_roads(problem, near), LevelGround(z))
        crossings = find_crossings(part.problem, part.unknowns.end_node)[0]
        places = crossings.xy
    report_known_clearances(problem, crossings, diagnostics)
    roads = ramp_roads(network, places, z)
    if not len(roads):
        return level
    (lifted, ends), surface = ramp_problem(network, roads, level), LevelGround(z)
    ramps, cell = _cut(lifted, surface)
    solved = _solve(ramps, cell, surface, across[roads], options, Ground(_roughness_factor(options)))
    report_limits(ramps, solved.outcome, diagnostics)
    return with_ramps(problem, roads, level, _write_records(ramps, solved.outcome), ends)


@record(eq=False)
class _Solved:
    outcome: Outcome
    known_z: FloatArray  # Heights of the solution where the user knows them, m


def _solve(
    network: Network,
    cell: FloatArray,
    surface: Surface,
    across: FloatArray,
    options: ElevationOptions,
    ground: Ground,
) -> _Solved:
    """Solve for the heights of roads.

    `cell`, (R,), m, is the size of the surface's cells along each of them, and `across`, (R, 2), rad, the
    superelevation at their ends.
    """
    reading, at_junctions = read_heights(surface, network.samples, network.problem.junction_xy, ground)
    model = _build_model(network, reading, at_junctions, options, cell)
    stiffness = model.stiffness(model.beams.flexibility)
    release_memory()
    weight, floating = weigh_heights(network, reading)
    observations = collect_observations(network, reading, at_junctions, weight, model.mean, stiffness.shape[0])
    limits, clearances, known = _collect_limits(model, surface, stiffness.shape[0], across, floating)
    observations, factors = _see_through_canopy(model, observations)
    release_memory()
    solved = solve_network(stiffness, observations, limits, factors)
    road_z = solved.value[observations.kind == Kind.ROAD_HEIGHT] + model.mean
    known_z = known.rows @ solved.x[: known.rows.shape[1]] + model.mean
    # As large as all the rest together, and used up.
    del observations, limits
    release_memory()
    return _Solved(_read_solution(model, solved.x, road_z, floating, clearances), known_z)


def _roughness_factor(options: ElevationOptions) -> float:
    """Return the factor on the penalty on roughness: lengths go with its fourth root."""
    return options.smoothing**4


@record(eq=False)
class _Model:
    """The roads, what the ground is there, and what they are like as beams."""

    network: Network
    reading: Reading  # The ground at the samples
    at_junctions: Reading  # The ground at the junctions' origins
    mean: float  # Mean height of the ground, m; heights are solved less it
    grade_limit: FloatArray  # (K,) Limit of each span's class, rise per metre
    beams: Beams
    chains: Chains
    leveling: FloatArray  # (E,) Tension toward level of elements on the ground, 1/m
    crossings: Crossings
    meets: Crossings  # Where carriageways of two layers cross beside a node that they share

    def stiffness(self, flexibility: FloatArray) -> sp.csr_matrix:
        """Return the stiffness (N, N) of the network with a flexibility (E,), 1/m."""
        return network_stiffness(self.network, self.chains, flexibility, self.leveling)


def _build_model(
    network: Network, reading: Reading, at_junctions: Reading, options: ElevationOptions, cell: FloatArray
) -> _Model:
    """Return the model; `cell` is the size of the elevation model's cells along each road, (R,), m."""
    problem, elements = network.problem, network.elements
    factor = class_values(problem, defaults.FLEXIBILITY_FACTOR, 1.0) / _roughness_factor(options)
    flexibility = road_flexibility(network, reading, defaults.ROAD_FLEXIBILITY * factor[elements.span])
    leveling = np.where(estimated_elements(network, reading), 1.0 / (flexibility * defaults.GRADE_LENGTH**2), 0.0)
    crossings, meets = find_crossings(problem, network.unknowns.end_node)
    chains = find_chains(problem, elements)
    flexibility = flexibility * defaults.LOWER_DECK_FLEXIBILITY ** bridges_above(network, chains, crossings)
    return _Model(
        network,
        reading,
        at_junctions,
        mean=float(np.mean(reading.z[reading.measured] if reading.measured.any() else reading.z)),
        grade_limit=class_values(problem, options.grade_limit, GRADE_LIMIT_OTHER),
        beams=Beams(flexibility, typical_ground(reading, cell)[0][elements.road]),
        chains=chains,
        leveling=leveling,
        crossings=crossings,
        meets=meets,
    )


def _collect_limits(
    model: _Model, surface: Surface, unknowns: int, across: FloatArray, floating: BoolArray
) -> tuple[Limits, Limits, Limits]:
    """Return all limits over N unknowns.

    By themselves as well: those on the heights of upper roads above lower ones, and those that hold known heights.
    `across`, (R, 2), rad, is the superelevation at ends of roads; `floating`, (R,), are those that no measured ground
    holds.
    """
    network, limit, crossings = model.network, model.grade_limit, model.crossings
    clearances = limit_clearances(network, crossings, model.beams, surface.quality(*crossings.xy.T).sigma)
    known = limit_known(network, model.beams, model.mean)
    density, sigma = typical_ground(model.reading, model.at_junctions.cell)
    span = network.elements.span
    usual = limit == class_values(network.problem, GRADE_LIMIT, GRADE_LIMIT_OTHER)
    blocks = [
        *limit_grades(network, model.reading, limit[span], ~usual[span], model.beams),
        limit_curvatures(network, model.beams),
        limit_cut_and_fill(network, model.reading, model.mean),
        *limit_arms(network, density, sigma, across),
        clearances,
        limit_meetings(network, model.meets, model.beams),
        limit_structures(network, model.reading, model.beams, floating, model.mean),
        known,
    ]
    return join_blocks(blocks, unknowns), clearances, known


def _see_through_canopy(model: _Model, observations: Observations) -> tuple[Observations, FloatArray]:
    """Return the observations, and factors (n,) on their weights, small where they show canopy or roofs."""
    if not observations.canopy.any():
        return observations, np.ones(len(observations.value))
    factors = downweight_canopy(list(canopy_stages(model.beams, model.stiffness)), observations)
    samples = model.network.samples
    road = model.network.elements.road[samples.element]
    return restore_ground(observations, factors, road, samples.s, model.reading.z)


def _read_solution(
    model: _Model, x: FloatArray, road_z: FloatArray, floating: BoolArray, clearances: Limits
) -> Outcome:
    """Return the outcome from the unknowns (N,), which are changed, and the heights at the samples, m."""
    network, unknowns = model.network, model.network.unknowns
    x = x[: unknowns.to_knots.shape[1]]
    x[unknowns.z_columns] += model.mean
    knots = (unknowns.to_knots @ x).reshape(-1, 2)
    planes = x[: 3 * unknowns.junctions].reshape(-1, 3).copy()
    grade, limit = element_grades(network.elements, knots), model.grade_limit[network.elements.span]
    between, chain = clearances.rows @ x, model.chains.chain
    return Outcome(road_z, knots, planes, model.reading, floating, grade, limit, model.crossings, between, chain)


def _write_records(network: Network, outcome: Outcome) -> ProfileSolution:
    """Return the solution in few records."""
    elements, pins, knots = network.elements, network.problem.pins, outcome.knots
    # Ends that touch round alike: they have the same numbers.
    z = np.round(knots[:, 0], defaults.RECORD_DECIMALS)
    grade = np.round(knots[:, 1], defaults.RECORD_SLOPE_DECIMALS)
    on_roads, held = Knots(elements.knot_start, elements.knot_s, z, grade), None
    if pins is not None:
        on_roads, held = add_pins(on_roads, pins)
    elevation, end = thin_records(on_roads, held=held), elements.end_knots
    tables = tabulate(network, outcome)
    figures = statistics(elements, outcome, tables)
    return ProfileSolution(elevation, outcome.planes, z[end], grade[end], figures, tables)
