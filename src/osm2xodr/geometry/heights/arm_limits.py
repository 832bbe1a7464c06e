"""Elastic limits at junctions: on tilts, steps between arms, and what connecting roads between these need."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import cosine, hypot, lengths, pose, runs, sine, slope_of
from osm2xodr.geometry.defaults import GRADE_MAX
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Network, end_poses, hermite, rows_matrix
from osm2xodr.geometry.heights.limits import (
    FIRM_STIFFNESS_RATIO,
    STIFFNESS_RATIO,
    Limits,
    connector_speeds,
    driven_speeds,
    within,
)
from osm2xodr.geometry.heights.problem import (
    ConnectorProblem,
    ProfileProblem,
    at_junctions,
    end_spans,
    fast_spans,
    span_sides,
)
from osm2xodr.geometry.heights.stiffness import rotation_stiffness
from osm2xodr.geometry.heights.superelevation import longest_warp
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# How much stiffer the limit across arms is where the plane is the surface of their carriageways.
_CARRIED_STIFFER: Final = 1000.0
# The shortest path between lanes of two arms, m.
_SHORTEST_PATH: Final = 0.4
# Places at which is looked for where two paths part, as shares of the shorter one.
_PARTING_STEPS: Final = 12
# The share of their largest twist that paths take up to there. A choice: bends of the surface take the rest.
_PARTING_TWIST: Final = 0.5


def limit_arms(
    network: Network, density: FloatArray, sigma: FloatArray, superelevation: FloatArray | None = None
) -> list[Limits]:
    """Return the limits between the arms of junctions: twist, grades from arm to arm, and steps beside each other.

    `density`, (J,), is the usual weight of the observations per metre of road, 1/m³, `superelevation`, (R, 2), rad,
    that at ends of roads; 0 if left out.
    """
    ends = _look_at_ends(network.problem)
    across = np.zeros(len(ends.junction)) if superelevation is None else slope_of(superelevation.ravel())
    return [
        *_limit_twist(network, ends, density, sigma, across),
        *_limit_paths(network, ends, density),
        _limit_steps(network, ends, density, across),
    ]


def _moment(density: FloatArray, push: FloatArray | float) -> FloatArray:
    """Return the largest moment that tilts a junction: that of ground which is off by `push`, m, under its arms."""
    return np.asarray(push * np.sqrt(2.0 * density / defaults.ROAD_FLEXIBILITY))


@record(eq=False)
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
    warped: BoolArray  # (2 R,) Whether they may be warped
    # (pairs,) Ends at the same junction
    a: IntArray
    b: IntArray


def _look_at_ends(problem: ProfileProblem) -> _Ends:
    junction, span = problem.end_junction.ravel(), end_spans(problem).ravel()
    half, middle = (side[span] for side in span_sides(problem))
    pairs = _arm_pairs(junction, len(problem.junction_xy))
    fast, warped = fast_spans(problem)[span], at_junctions(problem.warped, junction)
    return _Ends(junction, *end_poses(problem), half, middle, fast, warped, *pairs)


def _tilt_rows(j: IntArray, weights: FloatArray, columns: int) -> sp.csr_matrix:
    """Return rows over the unknowns of which each is the gradient of a junction's plane times weights, (n, 2)."""
    return rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), weights, columns)


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
    across = np.column_stack([-sine(ends.hdg), cosine(ends.hdg)])
    rows = _tilt_rows(j, across[arm], columns)
    k = rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)
    usual = _moment(density, defaults.USUAL_PUSH_SIGMAS * sigma)
    bound = np.where(ends.fast[arm], defaults.FAST_CROSS_SLOPE_MAX, defaults.CROSS_SLOPE_MAX)
    bound = np.minimum(bound, defaults.CROSS_STEP_MAX / np.maximum(ends.half[arm], _SHORTEST_PATH))
    cap = _moment(density, defaults.LEVEL_ARM_PUSH)[j]
    # Arms that come together as one carriageway are level with each other, not only where they end.
    step = _step_beside(ends)[arm]
    beside = np.isfinite(step)
    bound = np.minimum(bound, step)
    cap = np.where(beside, _moment(density, defaults.FIRM_PUSH)[j], cap)
    warped, most = ends.warped[arm], np.repeat(longest_warp(problem), 2)
    both = ends.warped & ends.warped[np.arange(len(ends.warped)) ^ 1]
    own = np.where(both, defaults.WARP_MAX, np.minimum(defaults.WARP_MAX, most))
    own = np.where(beside, np.minimum(own[arm], defaults.CROSS_SLOPE_MAX), own[arm])
    bound, cap = np.where(warped, own, bound), np.where(warped & ~beside, usual[j], cap)
    carried = slope != 0.0
    bound = np.where(carried, defaults.CARRIED_CROSS_SLOPE_MAX, bound)
    stiffness = STIFFNESS_RATIO * np.where(carried, _CARRIED_STIFFER, 1.0) * k[j]
    single = within(rows, bound, stiffness, np.where(carried, np.inf, cap), about=slope)
    first = 2 * np.flatnonzero(both[0::2])
    a, b = ends.junction[first], ends.junction[first + 1]
    dofs = np.column_stack([3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2])
    rows = rows_matrix(dofs, np.column_stack([across[first], -across[first + 1]]), columns)
    change = within(rows, most[first], STIFFNESS_RATIO * k[a], usual[a])
    rows, j, length = _turning_twist(problem, across, ends.warped)
    caps = ((defaults.TWIST_MAX, usual), (defaults.TURNING_TWIST_MAX, _moment(density, defaults.FIRM_PUSH)))
    turning = [within(rows, most * length, STIFFNESS_RATIO * k[j], cap[j]) for most, cap in caps]
    return [single, change, *turning]


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
    return _tilt_rows(j, turned, columns), j, lengths(connectors.plan_view)[row]


def _driven(connectors: ConnectorProblem) -> BoolArray:
    """Return which connecting roads are carriageways, (C,)."""
    return np.ones(len(connectors.junction), bool) if connectors.beside is None else ~connectors.beside


@record(eq=False)
class _Paths:
    """Carriageways through junctions, and the rows over the unknowns that give their lanes' ends."""

    row: IntArray  # (n,) The connecting roads
    junction: IntArray  # (n,)
    length: FloatArray  # (n,) m
    # (n, N) Height, and grade along the path, where it begins and ends
    z0: sp.csr_matrix
    g0: sp.csr_matrix
    z1: sp.csr_matrix
    g1: sp.csr_matrix

    def heights(self, at: IntArray, s: FloatArray) -> sp.csr_matrix:
        """Return the rows of the heights at s, m, of some paths: of the cubics between their ends."""
        weights = hermite(s / self.length[at], self.length[at]).T
        rows = (self.z0, self.g0, self.z1, self.g1)
        return sp.csr_matrix(sum(sp.diags(w) @ value[at] for w, value in zip(weights, rows, strict=True)))


def _look_at_paths(network: Network, ends: _Ends, connectors: ConnectorProblem) -> _Paths:
    columns = network.unknowns.to_knots.shape[1]
    row = np.flatnonzero(_driven(connectors))
    entry, exit_, j = connectors.start_end[row], connectors.end_end[row], connectors.junction[row]
    length = np.maximum(lengths(connectors.plan_view)[row], _SHORTEST_PATH)
    knot, size = network.elements.end_knots.ravel(), network.unknowns.to_knots.shape[0]

    def at(end: IntArray, along: FloatArray, t: FloatArray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        one = np.ones((len(end), 1))
        height = network.in_unknowns(rows_matrix(2 * knot[end][:, None], one, size))
        grade = network.in_unknowns(rows_matrix(2 * knot[end][:, None] + 1, along[:, None], size))
        lever = np.where(ends.warped[end], t, 0.0)[:, None]
        across = np.asarray(lever * np.column_stack([-sine(ends.hdg[end]), cosine(ends.hdg[end])]), np.float64)
        return height + _tilt_rows(j, across, columns), grade

    begin = at(entry, np.where(entry % 2 == 1, 1.0, -1.0), connectors.start_t[row])
    return _Paths(row, j, length, *begin, *at(exit_, np.where(exit_ % 2 == 0, 1.0, -1.0), connectors.end_t[row]))


def _limit_paths(network: Network, ends: _Ends, density: FloatArray) -> list[Limits]:
    """Return the limits on connecting roads, which are about cubics between both ends of their lanes.

    Firm ones on their grade half-way and on their curvature at both ends, where cars are fastest, and one on the
    slope between them where they part.
    """
    connectors = network.problem.connectors
    if connectors is None:
        return []
    paths = _look_at_paths(network, ends, connectors)
    row, j, length = paths.row, paths.junction, paths.length
    mean, g0, g1 = sp.diags(1.0 / length) @ (paths.z1 - paths.z0), paths.g0, paths.g1
    k, cap = rotation_stiffness(density, defaults.ROAD_FLEXIBILITY), _moment(density, defaults.FIRM_PUSH)
    middle = sp.csr_matrix(1.5 * mean - 0.25 * (g0 + g1))
    out = [within(middle, np.full(len(row), GRADE_MAX), STIFFNESS_RATIO * k[j], cap[j])]
    posted = connector_speeds(network.problem, connectors.start_end[row], connectors.end_end[row])
    for rows, s in ((6.0 * mean - 4.0 * g0 - 2.0 * g1, 0.0 * length), (6.0 * mean - 2.0 * g0 - 4.0 * g1, length)):
        bound = defaults.VERTICAL_ACCELERATION_MAX / driven_speeds(connectors.plan_view, row, s, posted) ** 2
        # In units of grades, as what is stiff is a road that is turned.
        bent = sp.csr_matrix(0.25 * rows)
        out.append(within(bent, 0.25 * length * bound, STIFFNESS_RATIO * k[j], cap[j]))
    return [*out, _limit_partings(network.problem, connectors, paths, k, _moment(density, defaults.PARTING_PUSH))]


def _limit_partings(
    problem: ProfileProblem, connectors: ConnectorProblem, paths: _Paths, k: FloatArray, cap: FloatArray
) -> Limits:
    """Return the limits on the slope between paths where they part: what they twist to there.

    At junctions with warped arms beyond that of their plane. `k` and `cap`, (J,), are stiffness and largest moment.
    """
    a, b, s_a, s_b = _partings(connectors, paths)
    j = paths.junction[a]
    (xa, ya, _), (xb, yb, _) = (pose(connectors.plan_view, paths.row[i], s) for i, s in ((a, s_a), (b, s_b)))
    dx, dy = xa - xb, ya - yb
    apart = hypot(dx, dy)
    rows = paths.heights(a, s_a) - paths.heights(b, s_b)
    tilt = -np.column_stack([dx, dy]) * at_junctions(problem.warped, j)[:, None]
    rows = sp.diags(1.0 / apart) @ (rows + _tilt_rows(j, tilt, rows.shape[1]))
    reach = np.min([s_a, paths.length[a] - s_a, s_b, paths.length[b] - s_b], axis=0)
    bound = np.maximum(defaults.CROSS_SLOPE_MAX, _PARTING_TWIST * defaults.TWIST_MAX * reach)
    return within(sp.csr_matrix(rows), bound, STIFFNESS_RATIO * k[j], cap[j])


def _partings(connectors: ConnectorProblem, paths: _Paths) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return pairs of paths from or to the same arm, and the places along both where their lanes part, m.

    Only those that begin, or end, on each other.
    """
    half, share = connectors.half_width[paths.row], np.arange(_PARTING_STEPS + 1) / _PARTING_STEPS
    found = []
    for end, from_start in ((connectors.start_end[paths.row], True), (connectors.end_end[paths.row], False)):
        a, b = _arm_pairs(end, int(end.max(initial=-1)) + 1)
        s = np.minimum(paths.length[a], paths.length[b])[:, None] * share
        s_a, s_b = (s if from_start else paths.length[path][:, None] - s for path in (a, b))
        (xa, ya, _), (xb, yb, _) = (
            pose(connectors.plan_view, np.repeat(paths.row[path], s.shape[1]), along.ravel())
            for path, along in ((a, s_a), (b, s_b))
        )
        beyond = hypot(xa - xb, ya - yb).reshape(s.shape) >= (half[a] + half[b])[:, None]
        at = np.argmax(beyond, axis=1)
        keep = np.flatnonzero(beyond.any(axis=1) & (at > 0))
        found.append((a[keep], b[keep], s_a[keep, at[keep]], s_b[keep, at[keep]]))
    a, b, s_a, s_b = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return a, b, s_a, s_b


def _limit_steps(network: Network, ends: _Ends, density: FloatArray, slope: FloatArray) -> Limits:
    """Return the limits on steps between arms that come together as one carriageway."""
    knot, size = network.elements.end_knots.ravel(), network.unknowns.to_knots.shape[0]
    a, b, along, across = _arms_beside(ends)
    dofs = np.column_stack([2 * knot[b], 2 * knot[a], 2 * knot[a] + 1])
    rows = network.in_unknowns(rows_matrix(dofs, np.column_stack([np.ones(len(a)), -np.ones(len(a)), -along]), size))
    tilt = np.column_stack([-sine(ends.hdg[a]), cosine(ends.hdg[a])]) * across[:, None]
    tilt = np.where(ends.warped[a][:, None], -tilt, 0.0)
    far, j = np.maximum(np.abs(across), _SHORTEST_PATH), ends.junction[a]
    rows = rows + _tilt_rows(j, tilt, rows.shape[1])
    bound = np.minimum(defaults.JUNCTION_EDGE_STEP_MAX / far, defaults.FAST_CROSS_SLOPE_MAX)
    stiffness = FIRM_STIFFNESS_RATIO * rotation_stiffness(density, defaults.ROAD_FLEXIBILITY)[j]
    about, cap = slope[a] * across / far, _moment(density, defaults.FIRM_PUSH)[j]
    return within(sp.csr_matrix(sp.diags(1.0 / far) @ rows), bound, stiffness, cap, about=about)


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
    x, y = ends.x - ends.middle * sine(hdg), ends.y + ends.middle * cosine(hdg)
    out_of_junction = hdg + np.where(np.arange(len(hdg)) % 2 == 0, 0.0, np.pi)
    cos, sin = cosine(hdg[a]), sine(hdg[a])

    def apart(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        dx, dy = x[b] - x[a], y[b] - y[a]
        return dx * cos + dy * sin, dy * cos - dx * sin

    along, across = apart(x, y)
    near = (np.abs(across) - half[a] - half[b] < defaults.BESIDE_GAP) & (np.abs(along) < defaults.BESIDE_LENGTH)
    near &= cosine(out_of_junction[a] - out_of_junction[b]) > cosine(defaults.BESIDE_ANGLE)
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
