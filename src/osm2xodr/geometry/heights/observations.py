"""What is observed about heights: the ground, tags, carriageways of one street, and heights at area borders."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import PointTree, cosine, sine
from osm2xodr.defaults import GUESS_LENGTH, GUESS_SIGMA
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Elements, Network, components, hermite, hermite_slope, rows_matrix
from osm2xodr.geometry.heights.ground import is_coarse
from osm2xodr.geometry.heights.readings import Reading, noise_length
from osm2xodr.geometry.heights.sparse import join_blocks
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure
from osm2xodr.system import record

# No observation keeps less of its weight than this: where all of them stand out, they still hold the road.
FLOOR: Final = 1e-3
# Scale of the robust loss for observations that must not lose weight.
_NEVER: Final = np.inf
# Distance by which carriageways of different names are moved apart when neighbours are looked for, m.
_NAME_DISTANCE: Final = 1e5
# Carriageways run opposite ways where the cosine of the angle between them is below this (25 degrees).
_OPPOSITE: Final = -0.9
# The nearest sample of a road that runs the other way is among this many.
_NEIGHBOURS: Final = 8


class Kind(IntEnum):
    """What a row of observations says."""

    ROAD_HEIGHT = 0  # The ground along a road: one row for each sample, in the order of the samples
    JUNCTION_HEIGHT = 1  # The ground at the origin of a junction
    GRADE = 2  # OSM's ``incline``
    TAGGED_HEIGHT = 3  # OSM's ``ele``
    DIFFERENCE = 4  # Two carriageways of one street are level with each other
    PIN = 5  # Height or grade that a road is held to where areas meet
    CUT_BRIDGE = 6  # The ground where the map's edge cuts a bridge


@record(eq=False)
class Observations:
    """Observed values of linear functions of the unknowns; each row says how far it is to be trusted.

    Units are those of the kind: m for heights, rise per metre for grades.
    """

    rows: sp.csr_matrix  # (n, N) The functions
    value: FloatArray  # (n,) What is observed
    weight: FloatArray  # (n,) Weight of the squared residual
    sigma: FloatArray  # (n,) Standard error of a value: the unit of residuals in the robust loss
    kind: IntArray  # (n,) `Kind`
    # (n,) Scale of the robust loss, in standard errors, for values above and below the solution
    above: FloatArray
    below: FloatArray
    canopy: BoolArray  # (n,) Whether the value may be that of canopy or roofs above the ground
    floor: FloatArray  # (n,) Share of its weight that a row keeps at least

    @property
    def bare(self) -> BoolArray:
        """Which rows are heights of bare ground, (n,)."""
        return np.isin(self.kind, (Kind.ROAD_HEIGHT, Kind.JUNCTION_HEIGHT)) & ~self.canopy

    def robust_factors(self, residual: FloatArray, sigma: FloatArray, *, geman_mcclure: bool) -> FloatArray:
        """Return the factor on each weight that a robust loss gives, (n,): Cauchy's, or its square, Geman-McClure's.

        That of bare ground is Huber's, which is convex: no part of it is ever dropped. The residual, (n,), is
        observed less solved, sigma, (n,), the standard errors to measure it by.
        """
        scale = np.where(residual > 0, self.above, self.below)
        excess = np.abs(residual / (scale * sigma))
        cauchy = 1.0 / (1.0 + excess**2)
        factor = np.where(self.bare, 1.0 / np.maximum(excess, 1.0), cauchy * cauchy if geman_mcclure else cauchy)
        return np.maximum(factor, self.floor)


def _block(
    kind: Kind,
    rows: sp.csr_matrix,
    value: FloatArray,
    weight: FloatArray,
    sigma: FloatArray,
    scale: FloatArray | float = defaults.ROBUST_SCALE,
    canopy: BoolArray | None = None,
) -> Observations:
    """Return observations of one kind; `scale` is that of the robust loss where canopy is out of the question."""
    n = len(value)
    canopy = np.zeros(n, bool) if canopy is None else canopy
    above = np.where(canopy, defaults.CANOPY_SCALE_ABOVE, scale)
    below = np.where(canopy, defaults.CANOPY_SCALE_BELOW, scale)
    kinds, floor = np.full(n, kind, np.int64), np.full(n, FLOOR)
    return Observations(rows, value, weight, sigma, kinds, above, below, canopy, floor)


def _nothing(kind: Kind, network: Network) -> Observations:
    none = np.zeros(0)
    return _block(kind, sp.csr_matrix((0, network.unknowns.to_knots.shape[1])), none, none, none)


def collect_observations(
    network: Network, reading: Reading, at_junctions: Reading, weight: FloatArray, mean: float, unknowns: int
) -> Observations:
    """Return all observations over N unknowns; the arguments are those of the `observe` functions."""
    blocks = [
        observe_ground(network, reading, weight, mean),
        observe_junctions(network, at_junctions, mean),
        observe_inclines(network),
        observe_ele(network, mean),
        observe_dual_carriageways(network, reading),
        observe_pins(network, mean),
        observe_cut_bridges(network, reading, mean),
    ]
    return join_blocks(blocks, unknowns)


def weigh_heights(network: Network, reading: Reading) -> tuple[FloatArray, BoolArray]:
    """Return the weight of each sample's height, 1/m², and which roads no measured ground holds, (R,).

    Structures do not follow the ground, and near their ends the ground is not what the road lies on: abutments and
    portals. A component of the network that nothing holds takes what there is: guesses, the ground above its tunnels.
    """
    elements, samples = network.elements, network.samples
    e = samples.element
    weight = samples.ds * reading.density
    on, distance = _structure_distance(network)
    near = distance < np.maximum(defaults.PORTAL_LENGTH, 0.5 * reading.cell)
    factor = np.where(on, 0.0, np.where(near, defaults.PORTAL_WEIGHT, 1.0))
    component = components(network.unknowns)
    at = component[elements.road[e]]
    holds = np.bincount(at, factor * reading.measured * weight, int(component.max(initial=-1)) + 1) > 0
    guess = samples.ds / (GUESS_LENGTH * GUESS_SIGMA**2)
    return np.where(holds[at], weight * factor, guess), ~holds[component]


def earthwork_samples(network: Network, reading: Reading) -> BoolArray:
    """Return the samples, (n,), where a cut or a fill is as deep as the road is off the measured, bare ground."""
    on, distance = _structure_distance(network)
    away = distance > np.maximum(defaults.EARTHWORK_REACH, 0.5 * reading.cell)
    out: BoolArray = ~on & away & reading.measured & ~reading.covered
    return out


def _structure_distance(network: Network) -> tuple[BoolArray, FloatArray]:
    """Return which samples are on structures, and how far the nearest one is along the road, m, both (n,)."""
    elements, samples = network.elements, network.samples
    e = samples.element
    to_start, to_end = portal_distance(elements, network.unknowns.end_node)
    along = samples.s - elements.s[e]
    distance = np.minimum(to_start[e] + along, to_end[e] + elements.h[e] - along)
    return elements.structure[e] != Structure.GROUND, distance


def portal_distance(elements: Elements, end_node: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for each element how far the nearest structure is from its start and from its end along its road, m.

    A structure that begins at the node where a road ends counts as well. Infinite where there is none.
    """
    on = elements.structure != Structure.GROUND
    first, last = elements.end_elements.T
    touched = np.isin(end_node, end_node[on[elements.end_elements].ravel()])
    s0, s1 = elements.s, elements.s + elements.h
    behind, ahead = np.where(on, s1, -np.inf), np.where(on, s0, np.inf)
    behind[first[touched[0::2] & ~on[first]]] = 0.0
    at_end = last[touched[1::2] & ~on[last]]
    ahead[at_end] = s1[at_end]
    # The last place behind and the first ahead, road by road: an offset per road keeps roads apart.
    reach = float(s1.max(initial=0.0)) + 1.0
    shift = elements.road * (4.0 * reach)
    before = np.maximum.accumulate(behind + shift) - shift
    after = np.minimum.accumulate((ahead + shift)[::-1])[::-1] - shift
    before = np.where(before < -reach, -np.inf, before)
    after = np.where(after > 2 * reach, np.inf, after)
    return s0 - before, after - s1


def observe_ground(network: Network, reading: Reading, weight: FloatArray, mean: float) -> Observations:
    """Observe the ground's heights, less the mean, m, at the samples, which have these weights, 1/m²."""
    rows = network.in_unknowns(network.knot_rows(network.samples.element, network.samples.u, hermite))
    scale = _ground_scale(reading)
    return _block(Kind.ROAD_HEIGHT, rows, reading.z - mean, weight, reading.sigma, scale, reading.covered)


def _ground_scale(reading: Reading) -> FloatArray:
    """Return the scale of the robust loss for the ground's heights, (n,), in standard errors."""
    estimated = np.isfinite(reading.log_relief)
    return np.where(estimated, defaults.ROBUST_SCALE_ESTIMATED, defaults.ROBUST_SCALE)


def observe_junctions(network: Network, reading: Reading, mean: float) -> Observations:
    """Observe the ground's heights, less the mean, m, at the origins of junctions.

    As along roads, not on structures, and hardly at abutments and portals.
    """
    n = len(reading.z)
    columns = 3 * np.arange(n, dtype=np.int64)[:, None]
    rows = rows_matrix(columns, np.ones((n, 1)), network.unknowns.to_knots.shape[1])
    weight = defaults.JUNCTION_LENGTH * reading.density * _ground_at_junctions(network)
    scale = _ground_scale(reading)
    return _block(Kind.JUNCTION_HEIGHT, rows, reading.z - mean, weight, reading.sigma, scale, reading.covered)


def _ground_at_junctions(network: Network) -> FloatArray:
    """Return the share of the ground's weight that holds at each junction, (J,).

    It is 0 where all arms are on bridges or in tunnels, and that of a portal where some are. A component of the
    network that has no road on the ground keeps it.
    """
    problem, elements = network.problem, network.elements
    junction, junctions = problem.end_junction.ravel(), len(problem.junction_xy)
    at = junction >= 0
    on = elements.structure[elements.end_elements].ravel() != Structure.GROUND
    arms = np.bincount(junction[at], minlength=junctions)
    structures = np.bincount(junction[at & on], minlength=junctions)
    share = np.where(structures == 0, 1.0, np.where(structures < arms, defaults.PORTAL_WEIGHT, 0.0))
    component = components(network.unknowns)
    ground = np.zeros(int(component.max(initial=-1)) + 1, bool)
    ground[component[elements.road[elements.structure == Structure.GROUND]]] = True
    of = np.zeros(junctions, np.int64)
    of[junction[at]] = component[np.flatnonzero(at) // 2]
    out: FloatArray = np.where(ground[of], share, 1.0)
    return out


def observe_inclines(network: Network) -> Observations:
    """Observe the grades that OSM's ``incline`` gives, as mean grades of elements."""
    elements = network.elements
    grade = network.problem.span_grade[elements.span]
    used = np.flatnonzero(np.isfinite(grade) & (np.abs(grade) <= defaults.INCLINE_MAX))
    h, knot = elements.h[used], elements.knot[used]
    dofs = np.column_stack([2 * knot, 2 * knot + 2])
    rows = rows_matrix(dofs, np.column_stack([-1 / h, 1 / h]), network.unknowns.to_knots.shape[0])
    sigma = np.full(len(used), defaults.INCLINE_SIGMA)
    weight = h / (defaults.INCLINE_LENGTH * sigma**2)
    return _block(Kind.GRADE, network.in_unknowns(rows), grade[used], weight, sigma)


def observe_ele(network: Network, mean: float) -> Observations:
    """Observe the heights, less the mean, m, of OSM's ``ele``: weak, as datums differ and slips are common."""
    problem = network.problem
    if problem.ele_road is None or problem.ele_s is None or problem.ele_z is None:
        return _nothing(Kind.TAGGED_HEIGHT, network)
    rows = network.knot_rows(*network.place(problem.ele_road, problem.ele_s), hermite)
    sigma = np.full(len(problem.ele_z), defaults.ELE_SIGMA)
    rows, value = network.in_unknowns(rows), problem.ele_z - mean
    return _block(Kind.TAGGED_HEIGHT, rows, value, 1.0 / sigma**2, sigma, scale=defaults.ELE_SCALE)


def observe_pins(network: Network, mean: float) -> Observations:
    """Observe the heights, less the mean, m, and the grades that roads are held to."""
    pins = network.problem.pins
    if pins is None:
        return _nothing(Kind.PIN, network)
    held = np.flatnonzero(np.isfinite(pins.z))
    element, u = network.place(pins.road[held], pins.s[held])
    rows = sp.vstack([network.knot_rows(element, u, weights) for weights in (hermite, hermite_slope)], format="csr")
    sigma = np.repeat([defaults.BORDER_HEIGHT_SIGMA, defaults.BORDER_GRADE_SIGMA], len(held))
    wanted = np.concatenate([pins.z[held] - mean, pins.grade[held]])
    return _block(Kind.PIN, network.in_unknowns(rows), wanted, 1.0 / sigma**2, sigma, scale=_NEVER)


def observe_cut_bridges(network: Network, reading: Reading, mean: float) -> Observations:
    """Observe the ground, less the mean, m, at the free ends of bridges: nothing else keeps them near it."""
    problem, elements, samples = network.problem, network.elements, network.samples
    free = (problem.end_junction < 0) & (problem.end_link < 0)
    free &= elements.structure[elements.end_elements] == Structure.BRIDGE
    end = np.flatnonzero(free)
    first = np.searchsorted(samples.element, elements.end_elements[:, 0], "left")
    last = np.searchsorted(samples.element, elements.end_elements[:, 1], "right") - 1
    sample = np.column_stack([first, last]).ravel()[end]
    end, sample = end[reading.measured[sample]], sample[reading.measured[sample]]
    element = elements.end_elements.ravel()[end]
    rows = network.in_unknowns(network.knot_rows(element, (end % 2).astype(np.float64), hermite))
    sigma = np.maximum(defaults.CUT_BRIDGE_SIGMA, defaults.CUT_BRIDGE_RISE * _lengths_on_structure(elements, end))
    return _block(Kind.CUT_BRIDGE, rows, reading.z[sample] - mean, 1.0 / sigma**2, sigma)


def _lengths_on_structure(elements: Elements, end: IntArray) -> FloatArray:
    """Return how far the structure at some road ends, (n,), goes along their roads, m."""
    out = np.zeros(len(end))
    for k, (road, at_end) in enumerate(zip((end // 2).tolist(), (end % 2).tolist(), strict=True)):
        first, last = elements.end_elements[road].tolist()
        on, h = elements.structure[first : last + 1] != Structure.GROUND, elements.h[first : last + 1]
        step = -1 if at_end else 1
        out[k] = h[::step][np.logical_and.accumulate(on[::step])].sum()
    return out


def observe_dual_carriageways(network: Network, reading: Reading) -> Observations:
    """Observe that the two carriageways of one street are level with each other where they run side by side.

    Only where cells are coarse: finer ones show how the carriageways lie.
    """
    samples = network.samples
    a, b = _opposite_samples(network)
    coarse = is_coarse(reading.cell[a]) & is_coarse(reading.cell[b])
    a, b = a[coarse], b[coarse]
    one, other = (network.knot_rows(samples.element[k], samples.u[k], hermite) for k in (a, b))
    sigma = np.full(len(a), defaults.DUAL_CARRIAGEWAY_SIGMA)
    weight = samples.ds[a] / (noise_length(reading.cell[a]) * sigma**2)
    return _block(Kind.DIFFERENCE, network.in_unknowns(one - other), np.zeros(len(a)), weight, sigma)


def _opposite_samples(network: Network) -> tuple[IntArray, IntArray]:
    """Return pairs of samples that lie beside each other on opposite one-way roads of one name, each once."""
    problem, elements, samples = network.problem, network.elements, network.samples
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
    k = min(_NEIGHBOURS, len(used))
    _, near = PointTree(place).neighbours(place, k, defaults.DUAL_CARRIAGEWAY_DISTANCE)
    found = near >= 0
    opposite = found & (cosine(travel[near] - travel[:, None]) < _OPPOSITE)
    opposite &= problem.span_layer[span[used[near]]] == problem.span_layer[span[used]][:, None]
    offset = place[near, :2] - place[:, None, :2]
    ahead = offset[..., 0] * cosine(travel)[:, None] + offset[..., 1] * sine(travel)[:, None]
    opposite &= np.abs(ahead) < samples.ds[used][:, None]
    row = np.flatnonzero(opposite.any(axis=1))
    a, b = used[row], used[near[row, np.argmax(opposite[row], axis=1)]]
    pairs = np.unique(np.column_stack([np.minimum(a, b), np.maximum(a, b)]), axis=0)
    return pairs[:, 0], pairs[:, 1]
