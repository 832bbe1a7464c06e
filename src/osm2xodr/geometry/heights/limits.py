"""Elastic limits on grades, tilts of junctions and clearances, and how fast traffic drives along curves."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import heading_at, lengths, pose, wrapped
from osm2xodr.geometry.defaults import GRADE_MAX
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.crossings import Crossings
from osm2xodr.geometry.heights.elements import Network, hermite, hermite_curvature, hermite_slope, rows_matrix
from osm2xodr.geometry.heights.observations import earthwork_samples
from osm2xodr.geometry.heights.problem import ProfileProblem, class_values, end_spans, span_at
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.stiffness import Beams, deflection_stiffness, ground_grades, rotation_stiffness
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, Structure
from osm2xodr.system import record

# Speed where no limit is known, and the most where there is none, m/s: 50 and 130 km/h.
_UNKNOWN: Final = 50.0 / 3.6
_FASTEST: Final = 130.0 / 3.6
# Curvature of a bend is taken over the wheelbase of a car, m. Shorter curves count as the second length: keeps
# quotients finite.
WHEELBASE: Final = 2.7
_SHORTEST: Final = 1.0
# Where the middle of a car is beside a place, in wheelbases, when the fastest one around is looked for.
_CAR_AT: Final = (-0.5, -0.3, -0.15, 0.0, 0.15, 0.3, 0.5)
# Bends wider than 1000 km are straight, 1/m: keeps quotients finite.
_STRAIGHT: Final = 1e-6

# How much stiffer a limit is than the road it bends. Stiffer ones take more steps to settle.
STIFFNESS_RATIO: Final = 60.0
# The same of the firm limit on grades: it must hold against the largest forces of the others.
FIRM_STIFFNESS_RATIO: Final = 240.0
# Clearances are at their largest force where they are short by this, m: less than what is reported.
_CLEARANCE_SLACK: Final = 0.1
# Positions in an element at which its grade is limited: by class where it is usual for the element, firmly all along.
_CLASS_LIMIT_AT: Final = (0.25, 0.75)
_FIRM_LIMIT_AT: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
# The same of its curvature, which is linear in between.
_CURVATURE_LIMIT_AT: Final = (0.0, 1.0)
# How far behind such an end, as shares of the element, cars may be faster than there: a bend or a limit ends there.
_SPEED_AT: Final = (0.0, 0.1, 0.25, 0.5)


def span_speeds(problem: ProfileProblem) -> FloatArray:
    """Return the speed that traffic may drive on each span, (K,), m/s."""
    if problem.span_speed is None:
        return np.full(len(problem.span_s), _UNKNOWN)
    return np.fmin(np.where(np.isnan(problem.span_speed), _UNKNOWN, problem.span_speed), _FASTEST)


def connector_speeds(problem: ProfileProblem, entry: IntArray, exit_: IntArray) -> FloatArray:
    """Return the speed limits between road ends, (n,), m/s: the lower ones of both."""
    at = span_speeds(problem)[end_spans(problem).ravel()]
    return np.asarray(np.minimum(at[entry], at[exit_]))


def fastest_around(plan: PlanView, curve: IntArray, s: FloatArray, posted: FloatArray) -> FloatArray:
    """Return the largest speed, (n,), m/s, of cars whose axles are on both sides of s of curves.

    Where bends in opposite directions follow each other the speed of `driven_speeds` rises for less than a metre.
    """
    length = lengths(plan, curve)
    around = (np.clip(s + at * WHEELBASE, 0.0, length) for at in _CAR_AT)
    return np.asarray(np.max([driven_speeds(plan, curve, place, posted) for place in around], axis=0))


def driven_speeds(plan: PlanView, curve: IntArray, s: FloatArray, posted: FloatArray) -> FloatArray:
    """Return the speed at s of curves with a posted speed, all (n,): less in bends than that, m/s.

    v² / R is at most `LATERAL_ACCELERATION`.
    """
    length = lengths(plan, curve)
    begin, end = (np.clip(s + side * WHEELBASE, 0.0, length) for side in (-0.5, 0.5))
    turn = wrapped(heading_at(plan, curve, end) - heading_at(plan, curve, begin))
    curvature = np.abs(turn) / np.maximum(end - begin, _SHORTEST)
    return np.minimum(posted, np.sqrt(defaults.LATERAL_ACCELERATION / np.maximum(curvature, _STRAIGHT)))


@record(eq=False)
class Limits:
    """Elastic bounds on linear functions of the unknowns."""

    rows: sp.csr_matrix  # (m, N) The functions
    # (m,) Their bounds; infinite where there is none
    low: FloatArray
    high: FloatArray
    stiffness: FloatArray  # (m,) Force per excess
    cap: FloatArray  # (m,) Largest force: what pulls harder wins. Infinite where the bound must hold.
    own: BoolArray  # (m,) Whether a road or junction has it by itself; robust weights are set under these alone

    def own_only(self) -> Limits:
        """Return them with those against other roads made void."""
        return replace(self, low=np.where(self.own, self.low, -np.inf), high=np.where(self.own, self.high, np.inf))

    def excess(self, value: FloatArray, index: IntArray | slice = slice(None)) -> FloatArray:
        """Return by how much the values of some functions are beyond their bounds, with its sign."""
        out: FloatArray = value - np.clip(value, self.low[index], self.high[index])
        return out

    def force(self, value: FloatArray, index: IntArray | slice = slice(None)) -> FloatArray:
        """Return the force with which the values of some functions are pushed back."""
        cap = self.cap[index]
        out: FloatArray = np.clip(self.stiffness[index] * self.excess(value, index), -cap, cap)
        return out


def within(
    rows: sp.csr_matrix,
    bound: FloatArray,
    stiffness: FloatArray,
    cap: FloatArray,
    about: FloatArray | float = 0.0,
) -> Limits:
    """Return own bounds on how far values are from `about`; `cap` is the largest force."""
    own = np.ones(len(bound), bool)
    return Limits(rows, about - bound, about + bound, stiffness, cap, own)


def limit_grades(
    network: Network, reading: Reading, limit: FloatArray, known: BoolArray, beams: Beams
) -> list[Limits]:
    """Return the elastic limits by class, (E,), and the firm one for all, on grades of elements.

    Where bare ground is steeper than a class usually is, streets are as well, but for those whose limits the user has
    set: `known`, (E,).
    """
    elements = network.elements
    u = np.tile(_FIRM_LIMIT_AT, len(elements.h))
    e = np.repeat(np.arange(len(elements.h), dtype=np.int64), len(_FIRM_LIMIT_AT))
    rows = network.in_unknowns(network.knot_rows(e, u, hermite_slope))
    k = rotation_stiffness(beams.density, beams.flexibility)
    # A force that is the same all along a slope moves the road at its ends alone, which carry it over this length.
    lift = deflection_stiffness(beams.density, beams.flexibility) * elements.h
    whole = beams.density * lengths(network.problem.plan_view)[elements.road] * elements.h
    inner = np.flatnonzero(np.isin(u, _CLASS_LIMIT_AT))
    of, cap = e[inner], np.where(known, defaults.FIRM_PUSH, defaults.GRADE_PUSH) * lift / len(_CLASS_LIMIT_AT)
    ground = np.where(known, 0.0, ground_grades(network, reading))
    bound = np.maximum(defaults.GRADE_SLACK * limit, np.minimum(ground, GRADE_MAX))
    firm = defaults.FIRM_PUSH * np.maximum(lift, whole) / len(_FIRM_LIMIT_AT)
    return [
        within(rows[inner], bound[of], STIFFNESS_RATIO * k[of], cap[of]),
        within(rows, np.full(len(e), GRADE_MAX), FIRM_STIFFNESS_RATIO * k[e], firm[e]),
    ]


def limit_curvatures(network: Network, beams: Beams) -> Limits:
    """Return the firm limit on the curvature of elements' heights: a car at the posted speed must not be thrown."""
    elements = network.elements
    u = np.tile(_CURVATURE_LIMIT_AT, len(elements.h))
    e = np.repeat(np.arange(len(elements.h), dtype=np.int64), len(_CURVATURE_LIMIT_AT))
    rows = network.in_unknowns(network.knot_rows(e, u, hermite_curvature))
    posted, bound = span_speeds(network.problem), np.full(len(e), np.inf)
    for share in _SPEED_AT:
        s = elements.s[e] + np.abs(u - share) * elements.h[e]
        span = span_at(network.problem, elements.road[e], s)
        speed = driven_speeds(network.problem.plan_view, elements.road[e], s, posted[span])
        # Curvature that falls to 0 at the other end has come down to that much there.
        bound = np.minimum(bound, defaults.VERTICAL_ACCELERATION_MAX / speed**2 / (1.0 - share))
    bend = elements.h / beams.flexibility
    # The moment of ground that is off by so much over the length that the road gives way over.
    cap = defaults.FIRM_PUSH * np.sqrt(beams.density / beams.flexibility) * elements.h / len(_CURVATURE_LIMIT_AT)
    return within(rows, bound, STIFFNESS_RATIO * bend[e], cap[e])


def deepest_cuts(network: Network, reading: Reading, at: IntArray) -> FloatArray:
    """Return how far roads of their class may lie from the ground at some samples, (n,), m: as sure as it is."""
    most = class_values(network.problem, defaults.CUT_AND_FILL, defaults.CUT_AND_FILL_OTHER)
    span = network.elements.span[network.samples.element[at]]
    return np.asarray(most[span] + defaults.CUT_AND_FILL_SIGMAS * reading.sigma[at])


def limit_cut_and_fill(network: Network, reading: Reading, mean: float) -> Limits:
    """Return the limits on how far roads lie from the ground, whose heights are less the mean, m.

    What the elevation model does not show counts for neither side, and no ground near structures.
    """
    samples = network.samples
    at = np.flatnonzero(earthwork_samples(network, reading))
    rows = network.in_unknowns(network.knot_rows(samples.element[at], samples.u[at], hermite))
    bound = deepest_cuts(network, reading, at)
    k = reading.density[at] * samples.ds[at]
    return within(rows, bound, STIFFNESS_RATIO * k, defaults.CUT_AND_FILL_PUSH * k, about=reading.z[at] - mean)


def limit_clearances(network: Network, crossings: Crossings, beams: Beams, sigma: FloatArray) -> Limits:
    """Return the elastic limits on the height of upper carriageways above lower ones.

    `sigma`, (crossings,), is the standard error of the elevation model's heights, m.
    """
    rows = _height_rows(network, crossings.upper, crossings.upper_s) - _height_rows(
        network, crossings.lower, crossings.lower_s
    )
    below = _elements_of(network, crossings.lower, crossings.lower_s)
    k = deflection_stiffness(beams.density[below], beams.flexibility[below])
    push = np.clip(defaults.CLEARANCE_PUSH_SIGMAS * sigma, defaults.CLEARANCE_PUSH_MIN, defaults.CLEARANCE_PUSH_MAX)
    if crossings.known_by is not None:
        push = np.where(crossings.known_by != 0, defaults.CLEARANCE_PUSH_MAX, push)
    high, own = np.full(len(k), np.inf), np.zeros(len(k), bool)
    stiffness = np.maximum(STIFFNESS_RATIO, push / _CLEARANCE_SLACK) * k
    return Limits(rows, crossings.clearance, high, stiffness, push * k, own)


def limit_meetings(network: Network, meets: Crossings, beams: Beams) -> Limits:
    """Return the elastic limits that keep carriageways level that cross right beside where they meet."""
    rows = _height_rows(network, meets.upper, meets.upper_s) - _height_rows(network, meets.lower, meets.lower_s)
    below = _elements_of(network, meets.lower, meets.lower_s)
    k = deflection_stiffness(beams.density[below], beams.flexibility[below])
    bound, own = np.full(len(k), defaults.MEETING_STEP_MAX), np.zeros(len(k), bool)
    return Limits(rows, -bound, bound, STIFFNESS_RATIO * k, defaults.MEETING_PUSH * k, own)


def limit_structures(network: Network, reading: Reading, beams: Beams, floating: BoolArray, mean: float) -> Limits:
    """Return the elastic limits that keep tunnels below the ground of their samples and bridges above it.

    The ground is less the mean, m. Bridges may lie below it by its standard error. `floating`, (R,), are roads that
    no measured ground holds: the height of their own ground is all that is known.
    """
    samples, elements = network.samples, network.elements
    structure = elements.structure[samples.element]
    held = reading.measured & ~floating[elements.road[samples.element]]
    at = np.flatnonzero(
        held & ((structure == Structure.TUNNEL) | ((structure == Structure.BRIDGE) & ~reading.covered))
    )
    element, tunnel = samples.element[at], structure[at] == Structure.TUNNEL
    rows = network.in_unknowns(network.knot_rows(element, samples.u[at], hermite))
    k = beams.density[element] * samples.ds[at]
    ground, own = reading.z[at] - mean, np.zeros(len(at), bool)
    low = np.where(tunnel, -np.inf, ground - reading.sigma[at])
    high, cap = np.where(tunnel, ground, np.inf), defaults.STRUCTURE_PUSH * k
    return Limits(rows, low, high, STIFFNESS_RATIO * k, cap, own)


def limit_known(network: Network, beams: Beams, mean: float) -> Limits:
    """Return the limits that hold roads, and the planes of junctions, at the heights that the user knows.

    They are less the mean, m. As all limits on heights they yield to the firm ones on grades.
    """
    known, columns = network.problem.known, network.unknowns.to_knots.shape[1]
    if known is None or not len(known.z):
        none = np.zeros(0)
        return Limits(sp.csr_matrix((0, columns)), none, none, none, none, np.zeros(0, bool))
    on, inside = np.flatnonzero(known.road >= 0), np.flatnonzero(known.road < 0)
    element, u = network.place(known.road[on], known.s[on])
    roads = network.in_unknowns(network.knot_rows(element, u, hermite))
    weights = np.column_stack([np.ones(len(inside)), known.offset[inside]])
    planes = rows_matrix(3 * known.junction[inside][:, None] + np.arange(3), weights, columns)
    order = np.argsort(np.concatenate([on, inside]), kind="stable")
    # A junction is as stiff as its first arm.
    first = [int(np.argmax(network.problem.end_junction.ravel() == j)) for j in known.junction[inside].tolist()]
    arms = network.elements.end_elements.ravel()[np.array(first, np.int64)]
    at = np.concatenate([element, arms])[order]
    k = deflection_stiffness(beams.density[at], beams.flexibility[at])
    rows, z = sp.csr_matrix(sp.vstack([roads, planes], format="csr")[order]), known.z - mean
    own, cap = np.ones(len(z), bool), defaults.FIRM_PUSH * k
    return Limits(rows, z, z, FIRM_STIFFNESS_RATIO * k, cap, own)


def _height_rows(network: Network, curve: IntArray, s: FloatArray) -> sp.csr_matrix:
    """Return the rows over the unknowns, (n, N), that give the height at s of roads and connecting roads.

    Connecting roads lie on their junction's plane, but for what they give to arms that are level across.
    """
    problem, connectors, roads = network.problem, network.problem.connectors, len(network.problem.end_junction)
    plain, inside = np.flatnonzero(curve < roads), np.flatnonzero(curve >= roads)
    size = network.unknowns.to_knots.shape[1]
    blocks = [network.in_unknowns(network.knot_rows(*network.place(curve[plain], s[plain]), hermite))]
    if connectors is not None and len(inside):
        road = curve[inside] - roads
        x, y, _ = pose(connectors.plan_view, road, s[inside])
        j = connectors.junction[road]
        weights = np.column_stack([np.ones(len(j)), x - problem.junction_xy[j, 0], y - problem.junction_xy[j, 1]])
        blocks.append(rows_matrix(3 * j[:, None] + np.arange(3), weights, size))
    order = np.argsort(np.concatenate([plain, inside]), kind="stable")
    return sp.csr_matrix(sp.vstack(blocks, format="csr")[order])


def _elements_of(network: Network, curve: IntArray, s: FloatArray) -> IntArray:
    """Return the element that roads have at s, and for connecting roads the one that they begin at, (n,)."""
    connectors, roads = network.problem.connectors, len(network.problem.end_junction)
    out = np.zeros(len(curve), np.int64)
    plain = curve < roads
    out[plain], _ = network.place(curve[plain], s[plain])
    if connectors is not None:
        start_end = connectors.start_end[curve[~plain] - roads]
        out[~plain] = network.elements.end_elements.ravel()[start_end]
    return out
