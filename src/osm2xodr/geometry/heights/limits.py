"""Elastic limits: on grades of roads, on tilts of junctions, and on the clearance between layers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import lengths, pose, runs
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.crossings import Crossings, Order, lower_side
from osm2xodr.geometry.heights.elements import (
    Network,
    end_poses,
    hermite,
    hermite_curvature,
    hermite_slope,
    rows_matrix,
)
from osm2xodr.geometry.heights.observations import earthwork_samples
from osm2xodr.geometry.heights.problem import (
    ConnectorProblem,
    ProfileProblem,
    end_spans,
    fast_spans,
    span_at,
    span_sides,
)
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.relief import ground_grades
from osm2xodr.geometry.heights.speeds import driven_speeds, span_speeds
from osm2xodr.geometry.heights.stiffness import Beams, deflection_stiffness, rotation_stiffness
from osm2xodr.geometry.heights.superelevation import longest_warp
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# How much stiffer a limit is than the road it bends. Stiffer ones take more steps to settle.
_STIFFNESS_RATIO: Final = 60.0
# The same of the firm limit on grades: it must hold against the largest forces of the others.
_FIRM_STIFFNESS_RATIO: Final = 240.0
# Clearances are at their largest force where they are short by this, m: less than what is reported.
_CLEARANCE_SLACK: Final = 0.1
# Layers are doubted where the clearance is less than this share of what it should be.
_FAR_SHORT: Final = 0.5
# How much stiffer the limit across arms is where the plane is the surface of their carriageways.
_CARRIED_STIFFER: Final = 1000.0
# Positions in an element at which its grade is limited: by class where it is usual for the element, firmly all along.
_CLASS_LIMIT_AT: Final = (0.25, 0.75)
_FIRM_LIMIT_AT: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
# The same of its curvature, which is linear in between.
_CURVATURE_LIMIT_AT: Final = (0.0, 1.0)
# How far behind such an end, as shares of the element, cars may be faster than there: a bend or a limit ends there.
_SPEED_AT: Final = (0.0, 0.1, 0.25, 0.5)
# The shortest path between lanes of two arms, m.
_SHORTEST_PATH: Final = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Elastic bounds on linear functions of the unknowns."""

    rows: sp.csr_matrix  # (m, N) The functions
    # (m,) Their bounds; infinite where there is none
    low: FloatArray
    high: FloatArray
    stiffness: FloatArray  # (m,) Force per excess
    cap: FloatArray  # (m,) Largest force: what pulls harder wins. Infinite where the bound must hold.
    own: BoolArray  # (m,) Whether a road or junction has it by itself; robust weights are set under these alone
    # (m,) Number of the place where roads pass each other, -1 for other limits, and what says which is above, `Order`
    place: IntArray
    order: IntArray

    def own_only(self) -> Limits:
        """Return them with those against other roads made void."""
        return replace(self, low=np.where(self.own, self.low, -np.inf), high=np.where(self.own, self.high, np.inf))

    def on_their_sides(self, value: FloatArray) -> Limits:
        """Return them with those turned over that have a `value`, (m,), below 0 and may have, place by place."""
        return self._turned_over(lower_side(value, self.place, self.order == Order.OPEN))

    def the_other_way_up(self, place: int) -> Limits:
        """Return them with those of a place turned over."""
        return self._turned_over(self.place == place)

    def contradicted(self, value: FloatArray) -> IntArray:
        """Return the places where layers alone say which is above and a `value`, (m,), is far short, worst first."""
        row = np.flatnonzero((self.order == Order.LAYERS) & (self.place >= 0))
        share = value[row] / self.low[row]
        short = np.flatnonzero(share < _FAR_SHORT)
        places = self.place[row[short[np.argsort(share[short], kind="stable")]]]
        first = np.unique(places, return_index=True)[1]
        return np.asarray(places[np.sort(first)], np.int64)

    def energy(self, value: FloatArray) -> float:
        """Return the energy of all of them at the values of their functions, (m,)."""
        excess, force = np.abs(self.excess(value)), np.abs(self.force(value))
        return float(np.sum(force * excess - 0.5 * force**2 / self.stiffness))

    def _turned_over(self, over: BoolArray) -> Limits:
        return replace(self, low=np.where(over, -self.high, self.low), high=np.where(over, -self.low, self.high))

    def excess(self, value: FloatArray, index: IntArray | slice = slice(None)) -> FloatArray:
        """Return by how much the values of some functions are beyond their bounds, with its sign."""
        out: FloatArray = value - np.clip(value, self.low[index], self.high[index])
        return out

    def force(self, value: FloatArray, index: IntArray | slice = slice(None)) -> FloatArray:
        """Return the force with which the values of some functions are pushed back."""
        cap = self.cap[index]
        out: FloatArray = np.clip(self.stiffness[index] * self.excess(value, index), -cap, cap)
        return out


def _within(
    rows: sp.csr_matrix,
    bound: FloatArray,
    stiffness: FloatArray,
    cap: FloatArray,
    about: FloatArray | float = 0.0,
) -> Limits:
    """Return own bounds on how far values are from `about`; `cap` is the largest force."""
    own = np.ones(len(bound), bool)
    return Limits(rows, about - bound, about + bound, stiffness, cap, own, *_nowhere(len(bound)))


def _nowhere(count: int) -> tuple[IntArray, IntArray]:
    """Return place and order of limits that are no clearances."""
    return np.full(count, -1, np.int64), np.full(count, int(Order.FIRM), np.int64)


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
    bound = np.maximum(defaults.GRADE_SLACK * limit, np.minimum(ground, defaults.GRADE_MAX))
    firm = defaults.FIRM_PUSH * np.maximum(lift, whole) / len(_FIRM_LIMIT_AT)
    return [
        _within(rows[inner], bound[of], _STIFFNESS_RATIO * k[of], cap[of]),
        _within(rows, np.full(len(e), defaults.GRADE_MAX), _FIRM_STIFFNESS_RATIO * k[e], firm[e]),
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
    return _within(rows, bound, _STIFFNESS_RATIO * bend[e], cap[e])


def deepest_cuts(problem: ProfileProblem) -> FloatArray:
    """Return how deep cuts, and how high fills, of roads of each span's class are, (K,), m."""
    names = problem.span_highway
    return np.array([defaults.CUT_AND_FILL.get(name, defaults.CUT_AND_FILL_OTHER) for name in names], np.float64)


def limit_cut_and_fill(network: Network, reading: Reading, beams: Beams, mean: float) -> Limits:
    """Return the limits on how far roads lie from the ground, whose heights are less the mean, m.

    What the elevation model does not show counts for neither side, and no ground near structures.
    """
    samples, elements = network.samples, network.elements
    at = np.flatnonzero(earthwork_samples(network, reading))
    element = samples.element[at]
    rows = network.in_unknowns(network.knot_rows(element, samples.u[at], hermite))
    bound = deepest_cuts(network.problem)[elements.span[element]] + defaults.CUT_AND_FILL_SIGMAS * reading.sigma[at]
    k = reading.density[at] * samples.ds[at]
    return _within(rows, bound, _STIFFNESS_RATIO * k, defaults.CUT_AND_FILL_PUSH * k, about=reading.z[at] - mean)


def limit_arms(
    network: Network, density: FloatArray, sigma: FloatArray, superelevation: FloatArray | None = None
) -> list[Limits]:
    """Return the limits between the arms of junctions: twist, grades from arm to arm, and steps beside each other.

    `density`, (J,), is the usual weight of the observations per metre of road, 1/m³, `superelevation`, (R, 2), rad,
    that at ends of roads; 0 if left out.
    """
    ends = _look_at_ends(network.problem)
    across = np.zeros(len(ends.junction)) if superelevation is None else np.tan(superelevation.ravel())
    return [
        *_limit_twist(network, ends, density, sigma, across),
        *_limit_paths(network, ends, density),
        _limit_steps(network, ends, density, across),
    ]


def _moment(density: FloatArray, push: FloatArray | float) -> FloatArray:
    """Return the largest moment that tilts a junction: that of ground which is off by `push`, m, under its arms."""
    return np.asarray(push * np.sqrt(2.0 * density / defaults.ROAD_FLEXIBILITY))


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """Road ends, and which of them are arms of one junction."""

    junction: IntArray  # (2 R,) Below 0 where there is none
    # (2 R,) Where they lie, m, and their heading along +s, rad
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    # (2 R,) Half the carriageway's width and t of its middle, m
    half: FloatArray
    middle: FloatArray
    fast: BoolArray  # (2 R,) Whether the road is built for speed
    # (pairs,) Ends at the same junction
    a: IntArray
    b: IntArray


def _look_at_ends(problem: ProfileProblem) -> _Ends:
    junction, span = problem.end_junction.ravel(), end_spans(problem).ravel()
    half, middle = (side[span] for side in span_sides(problem))
    pairs = _arm_pairs(junction, len(problem.junction_xy))
    return _Ends(junction, *end_poses(problem), half, middle, fast_spans(problem)[span], *pairs)


def _limit_twist(
    network: Network, ends: _Ends, density: FloatArray, sigma: FloatArray, slope: FloatArray
) -> list[Limits]:
    """Return the limits on the tilt of junctions' planes across their arms.

    Roads have a cross slope, (2 R,), where they end, as a rule 0: the tilt otherwise lifts the edges of their mouths,
    and connecting roads have to twist by it. Warped arms take the tilt over, which has to run out along the road.
    Where arms keep their crossfall the plane is their surface.
    """
    problem, columns = network.problem, network.unknowns.to_knots.shape[1]
    arm = np.flatnonzero(ends.junction >= 0)
    j, slope = ends.junction[arm], slope[arm]
    across = np.column_stack([-np.sin(ends.hdg), np.cos(ends.hdg)])
    rows = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), across[arm], columns)
    k = rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)
    usual = _moment(density, defaults.USUAL_PUSH_SIGMAS * sigma)
    bound = np.where(ends.fast[arm], defaults.FAST_CROSS_SLOPE_MAX, defaults.CROSS_SLOPE_MAX)
    bound = np.minimum(bound, defaults.CROSS_STEP_MAX / np.maximum(ends.half[arm], _SHORTEST_PATH))
    cap = _moment(density, defaults.LEVEL_ARM_PUSH)[j]
    # Arms that come together as one carriageway are level with each other, not only where they end.
    beside = _step_beside(ends)[arm]
    bound = np.minimum(bound, beside)
    cap = np.where(np.isfinite(beside), _moment(density, defaults.FIRM_PUSH)[j], cap)
    warped, most = _warped_ends(problem), np.repeat(longest_warp(problem), 2)
    both = warped & warped[np.arange(len(warped)) ^ 1]
    own = np.where(both, defaults.WARP_MAX, np.minimum(defaults.WARP_MAX, most))
    bound, cap = np.where(warped[arm], own[arm], bound), np.where(warped[arm], usual[j], cap)
    carried = slope != 0.0
    bound = np.where(carried, defaults.CARRIED_CROSS_SLOPE_MAX, bound)
    stiffness = _STIFFNESS_RATIO * np.where(carried, _CARRIED_STIFFER, 1.0) * k[j]
    single = _within(rows, bound, stiffness, np.where(carried, np.inf, cap), about=slope)
    first = 2 * np.flatnonzero(both[0::2])
    a, b = ends.junction[first], ends.junction[first + 1]
    dofs = np.column_stack([3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2])
    rows = rows_matrix(dofs, np.column_stack([across[first], -across[first + 1]]), columns)
    change = _within(rows, most[first], _STIFFNESS_RATIO * k[a], usual[a])
    turns = _turning_twist(problem, across, warped)
    caps = ((defaults.TWIST_MAX, usual), (defaults.TURNING_TWIST_MAX, _moment(density, defaults.FIRM_PUSH)))
    return [single, change, *(_limit_turning_twist(*turns, most, k, cap) for most, cap in caps)]


def _turning_twist(
    problem: ProfileProblem, across: FloatArray, warped: BoolArray
) -> tuple[sp.csr_matrix, IntArray, FloatArray]:
    """Return what connecting roads between warped arms have to twist by, as rows over the unknowns.

    And their junctions and lengths, m.

    `across`, (2 R, 2), are the directions to the left of road ends, `warped`, (2 R,), those that may be warped.
    """
    connectors, columns = problem.connectors, 3 * len(problem.junction_xy)
    if connectors is None:
        return sp.csr_matrix((0, columns)), np.zeros(0, np.int64), np.zeros(0)
    row = np.flatnonzero(warped[connectors.start_end] & _driven(connectors))
    entry, exit_, j = connectors.start_end[row], connectors.end_end[row], connectors.junction[row]
    turned = np.where(exit_ % 2 == 0, 1.0, -1.0)[:, None] * across[exit_]
    turned = turned - np.where(entry % 2 == 1, 1.0, -1.0)[:, None] * across[entry]
    rows = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), turned, columns)
    return rows, j, lengths(connectors.plan_view)[row]


def _limit_turning_twist(
    rows: sp.csr_matrix, j: IntArray, length: FloatArray, most: float, k: FloatArray, cap: FloatArray
) -> Limits:
    """Return the limits on what connecting roads twist by, `most`, rad/m, in the mean, from `_turning_twist`."""
    return _within(rows, most * length, _STIFFNESS_RATIO * k[j], cap[j])


def _driven(connectors: ConnectorProblem) -> BoolArray:
    """Return which connecting roads are carriageways, (C,)."""
    return np.ones(len(connectors.junction), bool) if connectors.beside is None else ~connectors.beside


def _warped_ends(problem: ProfileProblem) -> BoolArray:
    """Return the road ends that may be warped, (2 R,)."""
    junction = problem.end_junction.ravel()
    # Road ends at no junction, whose number is -1, have the last one.
    return np.zeros(len(junction), bool) if problem.warped is None else np.append(problem.warped, False)[junction]


def _limit_paths(network: Network, ends: _Ends, density: FloatArray) -> list[Limits]:
    """Return the firm limits on connecting roads, which are about cubics between both ends of their lanes.

    On their grade half-way, and on their curvature at both ends, where cars are fastest.
    """
    problem, columns = network.problem, network.unknowns.to_knots.shape[1]
    connectors = problem.connectors
    if connectors is None:
        return []
    row = np.flatnonzero(_driven(connectors))
    entry, exit_, j = connectors.start_end[row], connectors.end_end[row], connectors.junction[row]
    length = np.maximum(lengths(connectors.plan_view)[row], _SHORTEST_PATH)
    knot, size = network.elements.end_knots.ravel(), network.unknowns.to_knots.shape[0]

    def at(end: IntArray, along: FloatArray, t: FloatArray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Return the rows of the lane's height and of its grade along the path."""
        one = np.ones((len(end), 1))
        height = network.in_unknowns(rows_matrix(2 * knot[end][:, None], one, size))
        grade = network.in_unknowns(rows_matrix(2 * knot[end][:, None] + 1, along[:, None], size))
        lever = np.where(_warped_ends(problem)[end], t, 0.0)[:, None]
        across = lever * np.column_stack([-np.sin(ends.hdg[end]), np.cos(ends.hdg[end])])
        return height + rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), across, columns), grade

    z0, g0 = at(entry, np.where(entry % 2 == 1, 1.0, -1.0), connectors.start_t[row])
    z1, g1 = at(exit_, np.where(exit_ % 2 == 0, 1.0, -1.0), connectors.end_t[row])
    per = sp.diags(1.0 / length)
    mean = per @ (z1 - z0)
    k, cap = rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)[j], _moment(density, defaults.FIRM_PUSH)[j]
    middle = sp.csr_matrix(1.5 * mean - 0.25 * (g0 + g1))
    out = [_within(middle, np.full(len(row), defaults.GRADE_MAX), _STIFFNESS_RATIO * k, cap)]
    posted = span_speeds(problem)[end_spans(problem).ravel()[entry]]
    for rows, s in ((6.0 * mean - 4.0 * g0 - 2.0 * g1, 0.0 * length), (6.0 * mean - 2.0 * g0 - 4.0 * g1, length)):
        bound = defaults.VERTICAL_ACCELERATION_MAX / driven_speeds(connectors.plan_view, row, s, posted) ** 2
        # In units of grades, as what is stiff is a road that is turned.
        bent = sp.csr_matrix(0.25 * rows)
        out.append(_within(bent, 0.25 * length * bound, _STIFFNESS_RATIO * k, cap))
    return out


def _limit_steps(network: Network, ends: _Ends, density: FloatArray, slope: FloatArray) -> Limits:
    """Return the limits on steps between arms that come together as one carriageway."""
    knot, size = network.elements.end_knots.ravel(), network.unknowns.to_knots.shape[0]
    a, b, along, across = _arms_beside(ends)
    dofs = np.column_stack([2 * knot[b], 2 * knot[a], 2 * knot[a] + 1])
    rows = network.in_unknowns(rows_matrix(dofs, np.column_stack([np.ones(len(a)), -np.ones(len(a)), -along]), size))
    tilt = np.column_stack([-np.sin(ends.hdg[a]), np.cos(ends.hdg[a])]) * across[:, None]
    tilt = np.where(_warped_ends(network.problem)[a][:, None], -tilt, 0.0)
    far, j = np.maximum(np.abs(across), _SHORTEST_PATH), ends.junction[a]
    rows = rows + rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), tilt, rows.shape[1])
    bound = np.minimum(defaults.JUNCTION_EDGE_STEP_MAX / far, defaults.FAST_CROSS_SLOPE_MAX)
    stiffness = _FIRM_STIFFNESS_RATIO * rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)[j]
    about, cap = slope[a] * across / far, _moment(density, defaults.FIRM_PUSH)[j]
    return _within(sp.csr_matrix(sp.diags(1.0 / far) @ rows), bound, stiffness, cap, about=about)


def _step_beside(ends: _Ends) -> FloatArray:
    """Return the tilt with which each road end meets the one beside it, (2 R,); infinite where none is."""
    a, b, _, across = _arms_beside(ends)
    step = defaults.JUNCTION_EDGE_STEP_MAX / np.maximum(np.abs(across), _SHORTEST_PATH)
    out = np.full(len(ends.junction), np.inf)
    for end in (a, b):
        np.minimum.at(out, end, step)
    return out


def _arms_beside(ends: _Ends) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return pairs of arms that come together as one carriageway, and where the second one's end lies.

    How far along the first one's +s and to its left, m.
    """
    a, b, hdg, half = ends.a, ends.b, ends.hdg, ends.half
    x, y = ends.x - ends.middle * np.sin(hdg), ends.y + ends.middle * np.cos(hdg)
    out_of_junction = hdg + np.where(np.arange(len(hdg)) % 2 == 0, 0.0, np.pi)
    cos, sin = np.cos(hdg[a]), np.sin(hdg[a])

    def apart(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        dx, dy = x[b] - x[a], y[b] - y[a]
        return dx * cos + dy * sin, dy * cos - dx * sin

    along, across = apart(x, y)
    near = (np.abs(across) - half[a] - half[b] < defaults.BESIDE_GAP) & (np.abs(along) < defaults.BESIDE_LENGTH)
    near &= np.cos(out_of_junction[a] - out_of_junction[b]) > np.cos(defaults.BESIDE_ANGLE)
    along, across = apart(ends.x, ends.y)
    return a[near], b[near], along[near], across[near]


def _arm_pairs(junction: IntArray, junctions: int) -> tuple[IntArray, IntArray]:
    """Return all pairs of road ends that lie at the same junction, from the junction of each road end."""
    order = np.flatnonzero(junction >= 0)
    order = order[np.argsort(junction[order], kind="stable")]
    at = junction[order]
    count = np.bincount(at, minlength=junctions)
    # Each arm with all arms of its junction; the half with a < b is kept.
    a, b = np.repeat(np.arange(len(order)), count[at]), runs((np.cumsum(count) - count)[at], count[at])
    return order[a[a < b]], order[b[a < b]]


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
    order = _nowhere(len(k))[1] if crossings.order is None else crossings.order
    stiffness = np.maximum(_STIFFNESS_RATIO, push / _CLEARANCE_SLACK) * k
    return Limits(rows, crossings.clearance, high, stiffness, push * k, own, crossings.place, order)


def limit_meetings(network: Network, meets: Crossings, beams: Beams) -> Limits:
    """Return the elastic limits that keep carriageways level that cross right beside where they meet."""
    rows = _height_rows(network, meets.upper, meets.upper_s) - _height_rows(network, meets.lower, meets.lower_s)
    below = _elements_of(network, meets.lower, meets.lower_s)
    k = deflection_stiffness(beams.density[below], beams.flexibility[below])
    bound, own = np.full(len(k), defaults.MEETING_STEP_MAX), np.zeros(len(k), bool)
    return Limits(rows, -bound, bound, _STIFFNESS_RATIO * k, defaults.MEETING_PUSH * k, own, *_nowhere(len(k)))


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
    return Limits(rows, low, high, _STIFFNESS_RATIO * k, cap, own, *_nowhere(len(at)))


def limit_known(network: Network, beams: Beams, mean: float) -> Limits:
    """Return the limits that hold roads, and the planes of junctions, at the heights that the user knows.

    They are less the mean, m. As all limits on heights they yield to the firm ones on grades.
    """
    known, columns = network.problem.known, network.unknowns.to_knots.shape[1]
    if known is None or not len(known.z):
        none = np.zeros(0)
        return Limits(sp.csr_matrix((0, columns)), none, none, none, none, np.zeros(0, bool), *_nowhere(0))
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
    own, cap = np.ones(len(z), bool), defaults.CLEARANCE_PUSH_MAX * k
    return Limits(rows, z, z, _FIRM_STIFFNESS_RATIO * k, cap, own, *_nowhere(len(z)))


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
