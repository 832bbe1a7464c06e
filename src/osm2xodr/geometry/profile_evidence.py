"""What is known about the heights of roads: the ground, tags, and carriageways that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr import defaults
from osm2xodr.geometry.ground_trend import read_ground
from osm2xodr.geometry.profile_problem import ProfileProblem
from osm2xodr.geometry.profile_solver import Observations
from osm2xodr.geometry.profile_structures import portal_distance
from osm2xodr.geometry.profile_system import (
    Elements,
    Samples,
    Unknowns,
    components,
    element_dofs,
    hermite,
    rows_matrix,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure, Surface

# Keeps travel along carriageways of different names apart when neighbours are looked for, m.
_NAME_DISTANCE = 1e5


@dataclass(frozen=True, slots=True)
class Scale:
    """Lengths and errors that the solve is scaled by, all m.

    Parameters
    ----------
    cell
        Cell size of the elevation model.
    sigma
        Standard error of its heights.
    correlation
        Length over which its errors are correlated.
    knot_spacing, sample_spacing
        Longest element, and distance between samples.
    position_error
        How far a road may lie beside where OSM has it, as the elevation model sees it.
    """

    cell: float
    sigma: float
    correlation: float
    knot_spacing: float
    sample_spacing: float
    position_error: float

    @property
    def is_coarse(self) -> bool:
        """Whether the ground has to be estimated from the cells around a road."""
        return self.cell >= defaults.COARSE_CELL


def scale_of(surface: Surface) -> Scale:
    """Return the scale that belongs to a surface."""
    cell = surface.cell_size
    return Scale(
        cell=cell,
        sigma=max(surface.sigma, defaults.HEIGHT_SIGMA_MIN),
        correlation=max(defaults.NOISE_LENGTH_MIN, defaults.NOISE_LENGTH_CELLS * cell),
        knot_spacing=next(spacing for least, spacing in defaults.KNOT_SPACING if cell >= least),
        sample_spacing=min(
            max(cell / defaults.SAMPLES_PER_CELL, defaults.SAMPLE_SPACING_MIN), defaults.SAMPLE_SPACING_MAX
        ),
        position_error=defaults.POSITION_ERROR + defaults.POSITION_ERROR_CELLS * cell,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """The ground at places.

    Parameters
    ----------
    z, surface_z : (n,)
        Height to go by, and what the surface itself says, m.
    sigma, correlation : (n,)
        Standard error of z and length over which it is correlated, m.
    measured : (n,)
        Whether the surface has heights there.
    """

    z: FloatArray
    surface_z: FloatArray
    sigma: FloatArray
    correlation: FloatArray
    measured: BoolArray

    @property
    def density(self) -> FloatArray:
        """Weight per metre of road, 1/m³."""
        return 1.0 / (self.correlation * self.sigma**2)

    def with_guesses(self) -> Reading:
        """Return the reading with large errors where nothing is measured."""
        return Reading(
            self.z,
            self.surface_z,
            np.where(self.measured, self.sigma, defaults.GUESS_SIGMA),
            np.where(self.measured, self.correlation, defaults.GUESS_LENGTH),
            self.measured,
        )

    def part(self, index: slice) -> Reading:
        """Return the reading at some of the places."""
        return Reading(
            self.z[index], self.surface_z[index], self.sigma[index], self.correlation[index], self.measured[index]
        )


def _read(surface: Surface, x: FloatArray, y: FloatArray, scale: Scale, smoothing: float) -> Reading:
    """Read the surface, or the ground estimated from it where its cells are coarse."""
    surface_z, measured = surface.heights(x, y)
    n = len(x)
    sigma, correlation = np.full(n, scale.sigma), np.full(n, scale.correlation)
    if not scale.is_coarse:
        return Reading(surface_z, surface_z, sigma, correlation, measured).with_guesses()
    ground = read_ground(surface, x, y, smoothing)
    known = np.isfinite(ground.z)
    return Reading(
        np.where(known, ground.z, surface_z),
        surface_z,
        np.where(known, np.maximum(ground.sigma, defaults.HEIGHT_SIGMA_MIN), sigma),
        np.where(known, np.maximum(ground.correlation, scale.correlation), correlation),
        measured,
    ).with_guesses()


def read_heights(
    surface: Surface, samples: Samples, junction_xy: FloatArray, scale: Scale, smoothing: float
) -> tuple[Reading, Reading]:
    """Read the ground at the samples and at the junctions' origins.

    The standard error at the samples has a part for the road's position: what the ground rises across the road
    over that distance.
    """
    aside = max(2.0, 0.5 * scale.cell)
    nx, ny = -np.sin(samples.hdg) * aside, np.cos(samples.hdg) * aside
    n = len(samples.x)
    x = np.concatenate([samples.x, samples.x + nx, samples.x - nx, junction_xy[:, 0]])
    y = np.concatenate([samples.y, samples.y + ny, samples.y - ny, junction_xy[:, 1]])
    everywhere = _read(surface, x, y, scale, smoothing)
    middle, left, right = (everywhere.part(slice(k * n, (k + 1) * n)) for k in range(3))
    slope = np.where(left.measured & right.measured, (left.z - right.z) / (2 * aside), 0.0)
    sigma = np.hypot(middle.sigma, slope * scale.position_error)
    reading = Reading(middle.z, middle.surface_z, sigma, middle.correlation, middle.measured)
    return reading, everywhere.part(slice(3 * n, None))


def height_weights(
    problem: ProfileProblem,
    elements: Elements,
    unknowns: Unknowns,
    samples: Samples,
    reading: Reading,
    scale: Scale,
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
    near = distance < max(defaults.PORTAL_LENGTH, 0.5 * scale.cell)
    factor = np.where(on, 0.0, np.where(near, defaults.PORTAL_WEIGHT, 1.0))
    component = components(problem, unknowns)
    count = int(component.max(initial=-1)) + 1
    holds = np.bincount(component[elements.road[e]], weights=factor * reading.measured * weight, minlength=count) > 0
    guess = samples.ds / (defaults.GUESS_LENGTH * defaults.GUESS_SIGMA**2)
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


def twin_evidence(
    problem: ProfileProblem, elements: Elements, unknowns: Unknowns, samples: Samples, scale: Scale
) -> Observations:
    """Return that the two carriageways of one street are level with each other where they run side by side."""
    a, b = _twins(problem, elements, samples)
    size = unknowns.to_knots.shape[0]
    rows = [
        rows_matrix(
            element_dofs(elements, samples.element[k]), hermite(samples.u[k], elements.h[samples.element[k]]), size
        )
        for k in (a, b)
    ]
    sigma = np.full(len(a), defaults.TWIN_SIGMA)
    weight = samples.ds[a] / (scale.correlation * sigma**2)
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
