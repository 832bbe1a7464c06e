"""Stiffness of the network: roads bend, more where the land does; bridges are drawn straight, junctions level."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import cosine, exp, hypot, lengths, log, pose, runs, sine, wrapped
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import (
    Elements,
    Network,
    assemble,
    bending_matrices,
    element_at,
    end_poses,
    on_plane,
    rows_matrix,
    tension_matrices,
)
from osm2xodr.geometry.heights.problem import ProfileProblem, curve_spans, end_spans, fast_spans
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure
from osm2xodr.system import record

# Distance between the three heights whose second difference shows the ground's curvature, m: several cells of fine
# models, and less than a hill.
_LAG: Final = 30.0
# The grade of the ground is taken over this length, m: streets follow no shorter one. A choice.
_GRADE_WINDOW: Final = 50.0
# Shorter windows count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1.0
# Curvature is averaged over squares of this size, m, with at least so many places. Choices: a quarter of a town.
_SQUARE: Final = 400.0
_FEWEST: Final = 20
# Median of the square of a normal deviate: averages must not follow walls.
_MEDIAN_SQUARE: Final = 0.4549

# A structure goes on over a junction where the cosine of the angle between two arms is below this (30 degrees).
_STRAIGHT_ON: Final = -0.866
# Road ends nearer to the middle of their junction count as this far from it, m: keeps the matrices well conditioned.
# Those that are farther away count as the second: beside other arms they are no more free than there.
_SHORTEST_SPOKE: Final = 1.0
_LONGEST_SPOKE: Final = 25.0
# How much stiffer fast roads are within junctions.
_FAST_STIFFER: Final = 100.0
# Bridges above each other that are counted: four levels are few.
_MOST_ABOVE: Final = 3


def road_flexibility(network: Network, reading: Reading, usual: FloatArray) -> FloatArray:
    """Return the flexibility of roads, (E,), 1/m, from that of their class on plains, `usual`, (E,), 1/m.

    Relief multiplies it. On ground that rises across the road by m, a bend of curvature k has the vertical curvature
    m k, which is no bend of the ground.
    """
    elements, at = network.elements, network.samples.element
    plan_view = network.problem.plan_view
    begin, end = (pose(plan_view, elements.road, s)[2] for s in (elements.s, elements.s + elements.h))
    curvature = wrapped(end - begin) / elements.h
    count = np.maximum(np.bincount(at, minlength=len(elements.h)), 1)
    across = np.bincount(at, reading.across, len(elements.h)) / count
    return np.asarray(usual * _relief_factor(network, reading) + (across * curvature) ** 2 * elements.h)


def estimated_elements(network: Network, reading: Reading) -> BoolArray:
    """Return the elements whose ground was estimated from coarse cells, (E,)."""
    known = network.samples.element[np.isfinite(reading.log_relief)]
    return np.asarray(np.bincount(known, minlength=len(network.elements.h)) > 0)


def ground_grades(network: Network, reading: Reading) -> FloatArray:
    """Return the size of the grade of bare ground along each element, over `_GRADE_WINDOW` at most, (E,).

    0 on structures, and where the ground is not measured.
    """
    elements, samples = network.elements, network.samples
    if not len(samples.s):
        return np.zeros(len(elements.h))
    place, road = _one_axis(network), elements.road[samples.element]
    first, last = (np.searchsorted(road, road, side=side) for side in ("left", "right"))
    begin = np.maximum(samples.s - 0.5 * _GRADE_WINDOW, samples.s[first])
    end = np.minimum(samples.s + 0.5 * _GRADE_WINDOW, samples.s[last - 1])
    rise = (np.interp(place - samples.s + s, place, reading.z) for s in (end, begin))
    grade = np.abs(next(rise) - next(rise)) / np.maximum(end - begin, _SHORTEST)
    bare = reading.measured & ~reading.covered & (elements.structure[samples.element] == Structure.GROUND)
    out = np.zeros(len(elements.h))
    np.maximum.at(out, samples.element[bare], grade[bare])
    return out


def _one_axis(network: Network) -> FloatArray:
    """Return the places of samples along an axis on which roads follow each other, (n,), m."""
    length = lengths(network.problem.plan_view)
    origin = np.cumsum(length + 1.0) - length
    return np.asarray(origin[network.elements.road[network.samples.element]] + network.samples.s)


def _relief_factor(network: Network, reading: Reading) -> FloatArray:
    """Return the factor on the flexibility of elements that the relief around calls for, 1 at least, (E,)."""
    at, elements = network.samples.element, len(network.elements.h)
    # Along a line through relief of spectrum A / k⁴ curvature has the density A k / 4.
    log_density = reading.log_relief + log(defaults.RELIEF_WAVE / 4.0)
    log_density = np.where(np.isfinite(log_density), log_density, _log_curvature(network, reading))
    known = np.isfinite(log_density)
    count = np.bincount(at[known], minlength=elements)
    mean = np.bincount(at[known], log_density[known], elements) / np.maximum(count, 1)
    quotient = np.where(count > 0, mean - log(defaults.ROAD_FLEXIBILITY), 0.0)
    return np.asarray(exp(defaults.RELIEF_SHARE * np.maximum(quotient, 0.0)))


def _log_curvature(network: Network, reading: Reading) -> FloatArray:
    """Return the logarithm of the density of the ground's curvature along roads, 1/m, around samples, (n,).

    NaN where too little bare ground is measured. White curvature of density q gives second differences over a
    distance L the variance 2/3 q L³, and errors of heights six times their own.
    """
    samples, road = network.samples, network.elements.road[network.samples.element]
    length = lengths(network.problem.plan_view)
    place = _one_axis(network)
    bare = reading.measured & ~reading.covered
    inside = (samples.s > _LAG) & (samples.s < length[road] - _LAG) & bare
    at = np.flatnonzero(inside)
    out = np.full(len(place), np.nan)
    if not len(at):
        return out
    z = [np.interp(place[at] + step, place, reading.z) for step in (-_LAG, 0.0, _LAG)]
    square = (z[0] - 2.0 * z[1] + z[2]) ** 2
    tile = np.floor(np.column_stack([samples.x, samples.y]) / _SQUARE).astype(np.int64)
    key = (tile[:, 0] - tile[:, 0].min()) * (np.ptp(tile[:, 1]) + 1) + tile[:, 1] - tile[:, 1].min()
    for one in np.unique(key[at]).tolist():
        here = key[at] == one
        if here.sum() < _FEWEST:
            continue
        variance = (
            float(np.median(square[here])) / _MEDIAN_SQUARE - 6.0 * float(np.median(reading.sigma[at][here])) ** 2
        )
        if variance > 0.0:
            out[key == one] = log(variance / (2.0 / 3.0 * (_LAG * _LAG * _LAG)))
    return out


@record(eq=False)
class Beams:
    """Elements as beams on an elastic foundation, which the observed heights are."""

    flexibility: FloatArray  # (E,) q: the road's share of the penalty on z''² is 1 / q, 1/m
    density: FloatArray  # (E,) w: usual weight of the observed heights per metre of road, 1/m³


def rotation_stiffness(density: FloatArray, q: FloatArray | float) -> FloatArray:
    """Return the moment that turns the hinged end of a beam on an elastic foundation by 1: √2 (w / q³)^(1/4)."""
    return np.asarray(np.sqrt(2.0) * np.sqrt(np.sqrt(density / (np.asarray(q) * q * q))))


def deflection_stiffness(density: FloatArray, q: FloatArray) -> FloatArray:
    """Return the force that lifts a long beam on an elastic foundation by 1 m: 2 √2 (w³ / q)^(1/4)."""
    return np.asarray(2.0 * np.sqrt(2.0) * np.sqrt(np.sqrt(density * density * density / np.asarray(q))))


@record(eq=False)
class Chains:
    """Bridges and tunnels, each as one chain of elements over all roads that it consists of."""

    chain: IntArray  # (E,) Chain of each element, -1 on the ground
    sign: FloatArray  # (E,) 1 where the element's road runs along its chain, -1 where against it
    loose: BoolArray  # (chains,) Whether a chain has an end that nothing holds, as a tunnel that the map's edge cuts


def find_chains(problem: ProfileProblem, elements: Elements) -> Chains:
    """Join structures that follow each other along roads, over links between roads and straight over junctions.

    A junction is part of a structure if all its arms are.
    """
    on = elements.structure != Structure.GROUND
    same_road = np.r_[False, (elements.road[1:] == elements.road[:-1]) & on[1:] & on[:-1]]
    run = np.where(on, np.cumsum(on & ~same_road) - 1, -1)
    total = int(run.max(initial=-1)) + 1
    # The run at each road end, if the road's first or last element is a structure.
    end_run = run[elements.end_elements].ravel()
    junction = problem.end_junction.ravel()
    link = np.where(junction < 0, problem.end_link.ravel(), _opposite_arms(problem, end_run >= 0))
    neighbours: list[list[tuple[int, float]]] = [[] for _ in range(total)]
    loose_run = np.zeros(total, bool)
    for end in np.flatnonzero(end_run >= 0):
        other = int(link[end])
        if other >= 0 and end_run[other] >= 0:
            neighbours[end_run[end]].append((int(end_run[other]), -1.0 if (end - other) % 2 == 0 else 1.0))
        elif other < 0 and junction[end] < 0:
            loose_run[end_run[end]] = True
    chain_of, sign_of = _join_runs(neighbours)
    loose = np.zeros(int(chain_of.max(initial=-1)) + 1, bool)
    loose[chain_of[loose_run]] = True
    # One more for elements on the ground, whose run is -1.
    return Chains(np.r_[chain_of, -1][run], np.r_[sign_of, 1.0][run], loose)


def bridges_above(network: Network, chains: Chains, crossings: Crossings) -> IntArray:
    """Return how many bridges lie one above the other over that which each element belongs to, (E,): 3 at most."""
    problem, elements, roads = network.problem, network.elements, len(network.problem.end_junction)
    structure, chain = [], []
    for curve, s in ((crossings.upper, crossings.upper_s), (crossings.lower, crossings.lower_s)):
        structure.append(problem.span_structure[curve_spans(problem, curve, s)])
        own = chains.chain[element_at(elements, np.minimum(curve, roads - 1), s)]
        chain.append(np.where(curve < roads, own, -1))
    decks = (structure[0] == Structure.BRIDGE) & (structure[1] == Structure.BRIDGE) & (chain[1] >= 0)
    upper, lower = chain[0][decks], chain[1][decks]
    # Elements on the ground, and connecting roads, have the last one's number, -1.
    above = np.zeros(len(chains.loose) + 1, np.int64)
    for level in range(1, _MOST_ABOVE + 1):
        above[lower[above[upper] == level - 1]] = level
    return above[chains.chain]


def _opposite_arms(problem: ProfileProblem, on: BoolArray) -> IntArray:
    """Return the road end that goes straight on from each one over a junction on a structure, (2 R,); -1 for none.

    `on`, (2 R,), says which road ends are on structures.
    """
    junction = problem.end_junction.ravel()
    grounded = np.zeros(len(problem.junction_xy), bool)
    grounded[junction[(junction >= 0) & ~on]] = True
    ends = np.flatnonzero((junction >= 0) & ~np.append(grounded, True)[junction])
    out = np.full(len(junction), -1, np.int64)
    if not len(ends):
        return out
    hdg = end_poses(problem)[2]
    away = hdg + np.where(np.arange(len(hdg)) % 2 == 0, 0.0, np.pi)
    order = ends[np.argsort(junction[ends], kind="stable")]
    count = np.bincount(junction[order], minlength=len(problem.junction_xy))[junction[order]]
    first = np.searchsorted(junction[order], junction[order])
    a, b = np.repeat(order, count), order[runs(first, count)]
    turn = cosine(away[a] - away[b])
    straight = np.flatnonzero((a < b) & (turn < _STRAIGHT_ON))
    # The straightest first; each end goes on once.
    for k in straight[np.argsort(turn[straight], kind="stable")].tolist():
        if out[a[k]] < 0 and out[b[k]] < 0:
            out[a[k]], out[b[k]] = b[k], a[k]
    return out


def _join_runs(neighbours: list[list[tuple[int, float]]]) -> tuple[IntArray, FloatArray]:
    """Return chain and direction, 1 or -1, of runs; neighbours are (run, -1 if both run against each other)."""
    chain = np.full(len(neighbours), -1, np.int64)
    sign = np.ones(len(neighbours))
    count = 0
    for seed in range(len(neighbours)):
        if chain[seed] >= 0:
            continue
        chain[seed] = count
        count += 1
        stack = [seed]
        while stack:
            here = stack.pop()
            for there, turn in neighbours[here]:
                if chain[there] < 0:
                    chain[there], sign[there] = chain[seed], sign[here] * turn
                    stack.append(there)
    return chain, sign


def network_stiffness(
    network: Network, chains: Chains, flexibility: FloatArray, leveling: FloatArray | float = 0.0
) -> sp.csr_matrix:
    """Return the quadratic part of the objective that no observation has; the chains' mean grades come last.

    `flexibility` is q of each element, (E,), 1/m, and `leveling`, (E,), 1/m, the tension toward level of those on the
    ground.
    """
    elements, unknowns = network.elements, network.unknowns
    taut = 1.0 / (defaults.ROAD_FLEXIBILITY * defaults.STRUCTURE_TENSION_LENGTH**2)
    tension = np.where(elements.structure != Structure.GROUND, taut, leveling)
    matrices = bending_matrices(elements.h) / flexibility[:, None, None]
    matrices = matrices + tension_matrices(elements.h) * tension[:, None, None]
    p = unknowns.to_knots
    matrix = p.T @ assemble(elements, matrices) @ p
    diagonal = np.zeros(p.shape[1])
    diagonal[: 3 * unknowns.junctions].reshape(-1, 3)[:, 1:] = 1.0 / defaults.JUNCTION_TILT_SIGMA**2
    matrix = matrix + sp.diags(diagonal) + _spokes(network, flexibility)
    if len(chains.loose):
        coupling, own = _chord_coupling(network, chains, tension)
        matrix = sp.bmat([[matrix, coupling], [coupling.T, own]])
    return sp.csr_matrix(matrix)


def arm_deviations(network: Network) -> tuple[IntArray, FloatArray, sp.csr_matrix, sp.csr_matrix]:
    """Return by how much road ends at junctions may leave their junction's plane, as rows over the unknowns, (A, N).

    The ends, (A,), how far they are from the junction's origin, m, and the rows for heights and for grades, the
    latter out of the junction.
    """
    problem, unknowns = network.problem, network.unknowns
    junction = problem.end_junction.ravel()
    end = np.flatnonzero((junction >= 0) & ~on_plane(problem))
    x, y, hdg = (value[end] for value in end_poses(problem))
    j, knot = junction[end], network.elements.end_knots.ravel()[end]
    dx, dy = x - problem.junction_xy[j, 0], y - problem.junction_xy[j, 1]
    out = np.where(end % 2 == 0, 1.0, -1.0)
    size = unknowns.to_knots.shape[1]
    plane = 3 * j[:, None] + np.arange(3)
    height = unknowns.to_knots[2 * knot] - rows_matrix(plane, np.column_stack([np.ones(len(j)), dx, dy]), size)
    along = np.column_stack([np.zeros(len(j)), cosine(hdg), sine(hdg)])
    grade = sp.diags(out) @ (unknowns.to_knots[2 * knot + 1] - rows_matrix(plane, along, size))
    return end, hypot(dx, dy), sp.csr_matrix(height), sp.csr_matrix(grade)


def _spokes(network: Network, flexibility: FloatArray) -> sp.csr_matrix:
    """Return the stiffness of the ways from road ends to the middles of their junctions, (N, N).

    Between its end and the middle a road is a beam as it is before, which bends away from the junction's plane.
    """
    end, distance, height, grade = arm_deviations(network)
    d = np.clip(distance, _SHORTEST_SPOKE, _LONGEST_SPOKE)
    stiff = 1.0 / flexibility[network.elements.end_elements.ravel()[end]]
    # Fast roads come together on one plane, as their carriageways do.
    fast = fast_spans(network.problem)[end_spans(network.problem).ravel()[end]]
    stiff = np.where(fast, _FAST_STIFFER, 1.0) * stiff
    mixed = height.T @ sp.diags(-6.0 * stiff / (d * d)) @ grade
    own = height.T @ sp.diags(12.0 * stiff / (d * d * d)) @ height + grade.T @ sp.diags(4.0 * stiff / d) @ grade
    return sp.csr_matrix(own + mixed + mixed.T)


def _chord_coupling(network: Network, chains: Chains, tension: FloatArray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Return the terms that turn the tension, (E,), of chains toward their own chord instead of toward level.

    Each chain that is held at both ends has one more unknown m, its mean grade. Tension times the integral of
    (z' - m)² is the plain tension plus the terms in m that are returned: the coupling (N, chains) with the other
    unknowns and the diagonal (chains, chains).
    """
    elements, to_knots, count = network.elements, network.unknowns.to_knots, len(chains.loose)
    held = np.flatnonzero((chains.chain >= 0) & ~np.r_[chains.loose, True][chains.chain])
    chain, tau, pull, knot = chains.chain[held], tension[held], (chains.sign * tension)[held], elements.knot[held]
    rows, cols = np.r_[2 * knot, 2 * (knot + 1)], np.r_[chain, chain]
    in_knots = sp.coo_matrix((np.r_[pull, -pull], (rows, cols)), (to_knots.shape[0], count)).tocsr()
    diagonal = np.bincount(chain, tau * elements.h[held], count).astype(np.float64)
    # A loose chain's mean grade plays no part; 1 keeps it determinate.
    diagonal[diagonal == 0] = 1.0
    return (to_knots.T @ in_knots).tocsr(), sp.csr_matrix(sp.diags(diagonal))
