"""What is known about the heights of roads: the ground, tags, and carriageways that belong together."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from osm2xodr.defaults import GUESS_LENGTH, GUESS_SIGMA
from osm2xodr.geometry.defaults import ELE_SIGMA
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import (
    Elements,
    Samples,
    Unknowns,
    components,
    element_at,
    element_dofs,
    hermite,
    hermite_slope,
    rows_matrix,
)
from osm2xodr.geometry.heights.ground import is_coarse
from osm2xodr.geometry.heights.problem import ProfileProblem
from osm2xodr.geometry.heights.readings import Reading, noise_length
from osm2xodr.geometry.heights.solver import Observations
from osm2xodr.geometry.heights.structures import portal_distance
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# Keeps travel along carriageways of different names apart when neighbours are looked for, m.
_NAME_DISTANCE = 1e5


def height_weights(
    problem: ProfileProblem,
    elements: Elements,
    unknowns: Unknowns,
    samples: Samples,
    reading: Reading,
) -> tuple[FloatArray, BoolArray]:
    """Return the weight of each sample's height, 1/m², and which roads no measured ground holds, (R,).

    Structures do not follow the ground, and near their ends the ground is not what the road lies on: abutments and
    portals. A component of the network that nothing holds takes what there is: guesses, the ground above its tunnels.
    """
    e = samples.element
    weight = samples.ds * reading.density
    to_start, to_end = portal_distance(problem, elements, unknowns.end_node)
    along = samples.s - elements.s[e]
    distance = np.minimum(to_start[e] + along, to_end[e] + elements.h[e] - along)
    on = elements.structure[e] != Structure.GROUND
    near = distance < np.maximum(defaults.PORTAL_LENGTH, 0.5 * reading.cell)
    factor = np.where(on, 0.0, np.where(near, defaults.PORTAL_WEIGHT, 1.0))
    component = components(problem, unknowns)
    count = int(component.max(initial=-1)) + 1
    holds = np.bincount(component[elements.road[e]], weights=factor * reading.measured * weight, minlength=count) > 0
    guess = samples.ds / (GUESS_LENGTH * GUESS_SIGMA**2)
    return np.where(holds[component[elements.road[e]]], weight * factor, guess), ~holds[component]


def height_evidence(
    elements: Elements, unknowns: Unknowns, samples: Samples, reading: Reading, weight: FloatArray, mean: float
) -> Observations:
    """Return the ground's heights at the samples, less the mean."""
    e = samples.element
    rows = rows_matrix(element_dofs(elements, e), hermite(samples.u, elements.h[e]), unknowns.to_knots.shape[0])
    return Observations((rows @ unknowns.to_knots).tocsr(), reading.z - mean, weight, reading.sigma)


def junction_evidence(unknowns: Unknowns, reading: Reading, mean: float) -> Observations:
    """Return the ground's heights at the junctions' origins, as much road as a junction of usual size has."""
    n = len(reading.z)
    columns = 3 * np.arange(n, dtype=np.int64)[:, None]
    rows = rows_matrix(columns, np.ones((n, 1)), unknowns.to_knots.shape[1])
    return Observations(rows, reading.z - mean, defaults.JUNCTION_LENGTH * reading.density, reading.sigma)


def incline_evidence(problem: ProfileProblem, elements: Elements, unknowns: Unknowns) -> Observations:
    """Return the grades that OSM's ``incline`` gives, as mean grades of elements."""
    grade = problem.span_grade[elements.span]
    used = np.flatnonzero(np.isfinite(grade) & (np.abs(grade) <= defaults.INCLINE_MAX))
    h = elements.h[used]
    dofs = element_dofs(elements, used)[:, [0, 2]]
    rows = rows_matrix(dofs, np.column_stack([-1 / h, 1 / h]), unknowns.to_knots.shape[0])
    sigma = np.full(len(used), defaults.INCLINE_SIGMA)
    weight = h / (defaults.INCLINE_LENGTH * sigma**2)
    return Observations((rows @ unknowns.to_knots).tocsr(), grade[used], weight, sigma)


def ele_evidence(problem: ProfileProblem, elements: Elements, unknowns: Unknowns, mean: float) -> Observations:
    """Return the heights that OSM's ``ele`` gives, less the mean: weak, and robust against other datums and slips."""
    size = unknowns.to_knots.shape[0]
    if problem.ele_road is None or problem.ele_s is None or problem.ele_z is None:
        none = np.zeros(0)
        return Observations(sp.csr_matrix((0, unknowns.to_knots.shape[1])), none, none, none)
    e = element_at(elements, problem.ele_road, problem.ele_s)
    u = np.clip((problem.ele_s - elements.s[e]) / elements.h[e], 0.0, 1.0)
    rows = rows_matrix(element_dofs(elements, e), hermite(u, elements.h[e]), size)
    sigma = np.full(len(e), ELE_SIGMA)
    weight = 1.0 / sigma**2
    return Observations((rows @ unknowns.to_knots).tocsr(), problem.ele_z - mean, weight, sigma)


def pin_evidence(problem: ProfileProblem, elements: Elements, unknowns: Unknowns, mean: float) -> Observations:
    """Return the heights, less the mean, and grades that roads are held to."""
    size = unknowns.to_knots.shape[0]
    pins = problem.pins
    if pins is None:
        none = np.zeros(0)
        return Observations(sp.csr_matrix((0, unknowns.to_knots.shape[1])), none, none, none)
    held = np.flatnonzero(np.isfinite(pins.z))
    road, s = pins.road[held], pins.s[held]
    e = element_at(elements, road, s)
    u = np.clip((s - elements.s[e]) / elements.h[e], 0.0, 1.0)
    dofs = element_dofs(elements, e)
    rows = sp.vstack(
        [rows_matrix(dofs, weights(u, elements.h[e]), size) for weights in (hermite, hermite_slope)], format="csr"
    )
    sigma = np.repeat([defaults.BORDER_HEIGHT_SIGMA, defaults.BORDER_GRADE_SIGMA], len(e))
    wanted = np.concatenate([pins.z[held] - mean, pins.grade[held]])
    return Observations((rows @ unknowns.to_knots).tocsr(), wanted, 1.0 / sigma**2, sigma)


def twin_evidence(
    problem: ProfileProblem, elements: Elements, unknowns: Unknowns, samples: Samples, reading: Reading
) -> Observations:
    """Return that the two carriageways of one street are level with each other where they run side by side.

    Only where cells are coarse: finer ones show how the carriageways lie.
    """
    a, b = _twins(problem, elements, samples)
    coarse = is_coarse(reading.cell)
    both = coarse[a] & coarse[b]
    a, b = a[both], b[both]
    size = unknowns.to_knots.shape[0]
    rows = [
        rows_matrix(
            element_dofs(elements, samples.element[k]), hermite(samples.u[k], elements.h[samples.element[k]]), size
        )
        for k in (a, b)
    ]
    sigma = np.full(len(a), defaults.TWIN_SIGMA)
    weight = samples.ds[a] / (noise_length(reading.cell[a]) * sigma**2)
    return Observations(((rows[0] - rows[1]) @ unknowns.to_knots).tocsr(), np.zeros(len(a)), weight, sigma)


def _twins(problem: ProfileProblem, elements: Elements, samples: Samples) -> tuple[IntArray, IntArray]:
    """Return pairs of samples that lie beside each other on opposite one-way roads of one name, each once."""
    none = np.zeros(0, np.int64)
    if problem.span_name is None or problem.span_oneway is None:
        return none, none
    span = elements.span[samples.element]
    name, oneway = problem.span_name[span], problem.span_oneway[span]
    ground = elements.structure[samples.element] == Structure.GROUND
    used = np.flatnonzero((name >= 0) & (oneway != 0) & ground)
    if len(used) < 2:
        return none, none
    travel = samples.hdg[used] + np.where(oneway[used] < 0, np.pi, 0.0)
    place = np.column_stack([samples.x[used], samples.y[used], name[used] * _NAME_DISTANCE])
    # The nearest sample of a road that runs the other way is among the first few.
    k = min(8, len(used))
    distance, near = cKDTree(place).query(place, k=k, distance_upper_bound=defaults.TWIN_DISTANCE)
    found = np.isfinite(distance)
    near = np.where(found, near, 0)
    opposite = found & (np.cos(travel[near] - travel[:, None]) < -0.9)
    opposite &= problem.span_layer[span[used[near]]] == problem.span_layer[span[used]][:, None]
    offset = place[near, :2] - place[:, None, :2]
    ahead = offset[..., 0] * np.cos(travel)[:, None] + offset[..., 1] * np.sin(travel)[:, None]
    opposite &= np.abs(ahead) < samples.ds[used][:, None]
    row = np.flatnonzero(opposite.any(axis=1))
    a, b = used[row], used[near[row, np.argmax(opposite[row], axis=1)]]
    pairs = np.unique(np.column_stack([np.minimum(a, b), np.maximum(a, b)]), axis=0)
    return pairs[:, 0], pairs[:, 1]
