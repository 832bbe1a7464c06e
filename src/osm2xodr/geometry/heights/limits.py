"""Elastic limits: on grades of roads, on tilts of junctions, and on the clearance between layers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import pose, runs
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
from osm2xodr.geometry.heights.problem import ProfileProblem, end_spans, fast_spans, span_at, span_sides
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.speeds import driven_speeds, span_speeds
from osm2xodr.geometry.heights.stiffness import Beams, deflection_stiffness, rotation_stiffness
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# How much stiffer a limit is than the road it bends. Stiffer ones take more steps to settle.
_STIFFNESS_RATIO: Final = 60.0
# The same of the firm limit on grades: it must hold against the largest forces of the others.
_FIRM_STIFFNESS_RATIO: Final = 240.0
# Clearances are at their largest force where they are short by this, m: less than what is reported.
_CLEARANCE_SLACK: Final = 0.1
# Layers are doubted where the clearance is less than this share of what it should be.
_FAR_SHORT: Final = 0.5
# Largest forces of the limits by class on grades and tilts, in moments that turn a road by 1: beyond them they yield.
_GRADE_CAP: Final = 1.5
_TILT_CAP: Final = 3.0
_CROSS_SLOPE_CAP: Final = 6.0
_NO_CAP: Final = np.inf
# How much stiffer the limit across arms is where the plane is the surface of their carriageways.
_CARRIED_STIFFER: Final = 1000.0
# Positions in an element at which its grade is limited: by class where it is usual for the element, firmly all along.
_CLASS_LIMIT_AT: Final = (0.25, 0.75)
_FIRM_LIMIT_AT: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
# The same of its curvature, which is linear in between.
_CURVATURE_LIMIT_AT: Final = (0.0, 1.0)
# How far behind such an end, as shares of the element, cars may be faster than there: a bend or a limit ends there.
_SPEED_AT: Final = (0.0, 0.1, 0.25, 0.5)
# Directions, from 0 to less than pi, in which the tilt of a junction is limited.
_TILT_DIRECTIONS: Final = 4
# From the edge of a carriageway to the middle of its outer lane, and the shortest path between lanes of two arms, m.
_EDGE_TO_LANE: Final = 1.6
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
    cap: float,
    ratio: float = _STIFFNESS_RATIO,
    about: FloatArray | float = 0.0,
) -> Limits:
    """Return own bounds on how far values are from `about`; `cap` is the largest force in units of the stiffness."""
    own = np.ones(len(bound), bool)
    return Limits(rows, about - bound, about + bound, ratio * stiffness, cap * stiffness, own, *_nowhere(len(bound)))


def _nowhere(count: int) -> tuple[IntArray, IntArray]:
    """Return place and order of limits that are no clearances."""
    return np.full(count, -1, np.int64), np.full(count, int(Order.FIRM), np.int64)


def limit_grades(network: Network, limit: FloatArray, beams: Beams) -> list[Limits]:
    """Return the elastic limits by class, (E,), and the firm one for all, on grades of elements."""
    elements = network.elements
    u = np.tile(_FIRM_LIMIT_AT, len(elements.h))
    e = np.repeat(np.arange(len(elements.h), dtype=np.int64), len(_FIRM_LIMIT_AT))
    rows = network.in_unknowns(network.knot_rows(e, u, hermite_slope))
    k = rotation_stiffness(beams.density, beams.flexibility)[e]
    inner = np.flatnonzero(np.isin(u, _CLASS_LIMIT_AT))
    return [
        _within(rows[inner], defaults.GRADE_SLACK * limit[e[inner]], k[inner], _GRADE_CAP),
        _within(rows, np.full(len(e), defaults.GRADE_MAX), k, _NO_CAP, _FIRM_STIFFNESS_RATIO),
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
    return _within(rows, bound, (elements.h / beams.flexibility)[e], _NO_CAP)


def limit_tilts(
    network: Network, limit: FloatArray, density: FloatArray, superelevation: FloatArray | None = None
) -> list[Limits]:
    """Return the limits on junctions' planes: tilt by class and firm, and the grade between neighbouring arms.

    `limit`, (R, 2), is the largest grade by class at each road's ends, `density`, (J,), the usual weight of the
    observations per metre of road, 1/m³. `superelevation`, (R, 2), rad, is that at their ends; 0 if left out.
    """
    problem, junctions = network.problem, network.unknowns.junctions
    columns = network.unknowns.to_knots.shape[1]
    stiffness = rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)
    bound = np.full(junctions, defaults.JUNCTION_TILT_MAX / defaults.GRADE_SLACK)
    at = problem.end_junction
    np.minimum.at(bound, at[at >= 0], limit[at >= 0])
    angle = np.pi * np.arange(_TILT_DIRECTIONS) / _TILT_DIRECTIONS
    j = np.repeat(np.arange(junctions, dtype=np.int64), _TILT_DIRECTIONS)
    weights = np.column_stack([np.tile(np.cos(angle), junctions), np.tile(np.sin(angle), junctions)])
    tilt = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), weights, columns)
    limits = [
        _within(tilt, defaults.GRADE_SLACK * bound[j], stiffness[j], _TILT_CAP),
        _within(tilt, np.full(len(j), defaults.JUNCTION_TILT_MAX), stiffness[j], _NO_CAP),
    ]
    ends = _look_at_ends(problem)
    j, rise = _neighbouring_arms(ends)
    rows = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), rise, columns)
    limits.append(_within(rows, np.full(len(j), defaults.JUNCTION_STEP_MAX), stiffness[j], _NO_CAP))
    across = np.zeros(len(ends.junction)) if superelevation is None else np.tan(superelevation.ravel())
    return [*limits, *_limit_cross_slopes(ends, stiffness, columns, across)]


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


def _limit_cross_slopes(ends: _Ends, stiffness: FloatArray, columns: int, slope: FloatArray) -> list[Limits]:
    """Return the limits on the tilt of junctions' planes across their arms: elastic, and firm between neighbours.

    Roads have a cross slope, (2 R,), where they end, as a rule 0, so connecting roads have to twist by what the plane
    is tilted otherwise. Arms beside each other come together as one carriageway, and neither can lie above the other.
    Where they keep their crossfall they are one surface, which the plane is.
    """
    arm = np.flatnonzero(ends.junction >= 0)
    across = np.column_stack([-np.sin(ends.hdg[arm]), np.cos(ends.hdg[arm])])
    bound = np.where(ends.fast[arm], defaults.FAST_CROSS_SLOPE_MAX, defaults.CROSS_SLOPE_MAX)
    bound = np.minimum(bound, defaults.CROSS_STEP_MAX / np.maximum(ends.half[arm], _SHORTEST_PATH))
    j, slope = ends.junction[arm], slope[arm]
    carried = slope != 0.0
    bound = np.where(carried, np.minimum(bound, defaults.CARRIED_CROSS_SLOPE_MAX), bound)
    rows = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), across, columns)
    firm = _cross_slope_beside(ends)[arm]
    beside = np.flatnonzero(np.isfinite(firm))
    return [
        _within(rows, bound, np.where(carried, _CARRIED_STIFFER, 1.0) * stiffness[j], _CROSS_SLOPE_CAP, about=slope),
        _within(rows[beside], firm[beside], stiffness[j[beside]], _NO_CAP, about=slope[beside]),
    ]


def _cross_slope_beside(ends: _Ends) -> FloatArray:
    """Return the tilt across each road end, (2 R,), with which it meets the one beside it; infinite where none is."""
    a, b, hdg, half = ends.a, ends.b, ends.hdg, ends.half
    x, y = ends.x - ends.middle * np.sin(hdg), ends.y + ends.middle * np.cos(hdg)
    out_of_junction = hdg + np.where(np.arange(len(hdg)) % 2 == 0, 0.0, np.pi)
    cos, sin = np.cos(hdg[a]), np.sin(hdg[a])
    along, across = (x[b] - x[a]) * cos + (y[b] - y[a]) * sin, np.abs((y[b] - y[a]) * cos - (x[b] - x[a]) * sin)
    near = (across - half[a] - half[b] < defaults.BESIDE_GAP) & (np.abs(along) < defaults.BESIDE_LENGTH)
    near &= np.cos(out_of_junction[a] - out_of_junction[b]) > np.cos(defaults.BESIDE_ANGLE)
    limit = np.full(len(hdg), np.inf)
    step = defaults.JUNCTION_EDGE_STEP_MAX / np.maximum(across[near], _SHORTEST_PATH)
    for end in (a[near], b[near]):
        np.minimum.at(limit, end, np.minimum(step, defaults.FAST_CROSS_SLOPE_MAX))
    return limit


def _neighbouring_arms(ends: _Ends) -> tuple[IntArray, FloatArray]:
    """Return pairs of arms that are nearer to each other than their middles: junction, and offset / distance.

    The plane's gradient times the second, (n, 2), is the grade between the nearest lanes of both arms, at most
    `JUNCTION_STEP_MAX`. The distance is less than that of the lanes where less is allowed.
    """
    a, b, x, y, half, middle = ends.a, ends.b, ends.x, ends.y, ends.half, ends.middle
    nx, ny = -np.sin(ends.hdg), np.cos(ends.hdg)

    def reach(p: IntArray, q: IntArray, edge: float) -> FloatArray:
        """Return the distance from the outer lanes of p, `edge` inside of its edges, to the row of those of q."""
        best = np.full(len(p), np.inf)
        width_p, width_q = (np.maximum(half[k] - edge, 0.0) for k in (p, q))
        for side in (-1.0, 1.0):
            t = middle[p] + side * width_p
            dx, dy = x[p] + t * nx[p] - x[q], y[p] + t * ny[p] - y[q]
            t = np.clip(dx * nx[q] + dy * ny[q], middle[q] - width_q, middle[q] + width_q)
            best = np.minimum(best, np.hypot(dx - t * nx[q], dy - t * ny[q]))
        return best

    lanes, gap = (np.minimum(reach(a, b, edge), reach(b, a, edge)) for edge in (_EDGE_TO_LANE, 0.0))
    allowed = defaults.JUNCTION_EDGE_STEP_MAX + defaults.JUNCTION_STEP_MAX * gap
    allowed = np.where(gap < defaults.JUNCTION_EDGES_NEAR, allowed, np.inf)
    distance = np.minimum(np.maximum(lanes, _SHORTEST_PATH), allowed / defaults.JUNCTION_STEP_MAX)
    offset = np.column_stack([x[a] - x[b], y[a] - y[b]])
    near = np.hypot(*offset.T) > distance
    return ends.junction[a[near]], offset[near] / distance[near, None]


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


def limit_tunnels(network: Network, reading: Reading, beams: Beams, floating: BoolArray, mean: float) -> Limits:
    """Return the elastic limits that keep tunnels below the ground of their samples, less the mean, m.

    `floating`, (R,), are roads that no measured ground holds: the height of their own ground is all that is known.
    """
    samples, elements = network.samples, network.elements
    inside = (elements.structure == Structure.TUNNEL) & ~floating[elements.road]
    at = np.flatnonzero(inside[samples.element] & reading.measured)
    element = samples.element[at]
    rows = network.in_unknowns(network.knot_rows(element, samples.u[at], hermite))
    k = beams.density[element] * samples.ds[at]
    low, own = np.full(len(at), -np.inf), np.zeros(len(at), bool)
    ground, cap = reading.z[at] - mean, defaults.TUNNEL_PUSH * k
    return Limits(rows, low, ground, _STIFFNESS_RATIO * k, cap, own, *_nowhere(len(at)))


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
