"""What a network of roads must not do in height: too steep, junctions too tilted, layers too close."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import runs
from osm2xodr.geometry.defaults import GRADE_MAX, GRADE_SLACK
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import (
    Elements,
    Unknowns,
    element_at,
    element_dofs,
    end_poses,
    hermite,
    hermite_slope,
    rows_matrix,
)
from osm2xodr.geometry.heights.problem import ProfileProblem
from osm2xodr.geometry.heights.solver import Limits
from osm2xodr.geometry.heights.structures import Crossings
from osm2xodr.model import FloatArray, IntArray

# How much stiffer a limit is than the road it bends. Stiffer ones take more steps to settle.
STIFF = 60.0
# Forces at which limits give way, in those that turn a road by 1.
GRADE_CAP = 1.5
TILT_CAP = 3.0
# Distance of the middle of an outermost lane of usual width (3.2 m) from the carriageway's edge, width of a
# carriageway of which nothing is known, and shortest way through a junction, m.
OUTER_LANE_INSET = 1.6
USUAL_WIDTH = 6.0
SHORTEST_PATH = 0.4


def rotation_stiffness(density: FloatArray | float, q: FloatArray | float) -> FloatArray:
    """Return the moment that turns a beam on an elastic foundation by 1: sqrt(2) (density / q³)^(1/4)."""
    return np.asarray(np.sqrt(2.0) * (density / np.asarray(q) ** 3) ** 0.25)


def deflection_stiffness(density: FloatArray, q: FloatArray | float) -> FloatArray:
    """Return the force that lifts a beam on an elastic foundation by 1 m: 2 sqrt(2) (density³ / q)^(1/4)."""
    return np.asarray(2.0 * np.sqrt(2.0) * (density**3 / np.asarray(q)) ** 0.25)


def _within(rows: sp.csr_matrix, bound: FloatArray, stiffness: FloatArray, cap: float) -> Limits:
    """Return bounds on magnitudes; `cap` is the largest force in units of the stiffness of what is bent."""
    return Limits(rows, -bound, bound, STIFF * stiffness, cap * stiffness)


def grade_limits(
    elements: Elements, unknowns: Unknowns, limit: FloatArray, q: FloatArray, density: FloatArray
) -> list[Limits]:
    """Return the elastic limits by class and the firm one for all.

    Parameters
    ----------
    limit : (E,)
        Largest grade by class.
    q : (E,)
        Flexibility, 1/m.
    density : (E,)
        Usual weight of the observations per metre of road, 1/m³.
    """
    count = len(elements.h)
    u = np.tile([0.0, 0.25, 0.5, 0.75, 1.0], count)
    e = np.repeat(np.arange(count, dtype=np.int64), 5)
    rows = rows_matrix(element_dofs(elements, e), hermite_slope(u, elements.h[e]), unknowns.to_knots.shape[0])
    rows = (rows @ unknowns.to_knots).tocsr()
    k = rotation_stiffness(density, q)[e]
    inner = np.flatnonzero((u == 0.25) | (u == 0.75))
    return [
        _within(rows[inner], GRADE_SLACK * limit[e[inner]], k[inner], GRADE_CAP),
        _within(rows, np.full(len(e), GRADE_MAX), k, np.inf),
    ]


def tilt_limits(
    problem: ProfileProblem, unknowns: Unknowns, limit: FloatArray, q: float, density: FloatArray
) -> list[Limits]:
    """Return limits on the tilt of junctions.

    In no direction may the plane be steeper than the flattest class that ends there allows. And where two road
    ends come close to each other, as carriageways do that part, the paths between their lanes are short: their
    heights may differ by no more than such a path can climb. Where their edges touch, as those of a ring and of the
    arm beside it, cars come to the same place from both: there the two are all but level with each other.

    Parameters
    ----------
    limit : (R, 2)
        Largest grade by class at each road's start and end.
    q
        Flexibility, 1/m.
    density : (J,)
        Usual weight of the observations per metre of road, 1/m³.
    """
    junctions = len(problem.junction_xy)
    columns = unknowns.to_knots.shape[1]
    stiffness = rotation_stiffness(density, q)
    bound = np.full(junctions, defaults.JUNCTION_TILT_MAX / GRADE_SLACK)
    at = problem.end_junction
    np.minimum.at(bound, at[at >= 0], limit[at >= 0])
    angle = np.pi * np.arange(4) / 4
    j = np.repeat(np.arange(junctions, dtype=np.int64), 4)
    weights = np.column_stack([np.tile(np.cos(angle), junctions), np.tile(np.sin(angle), junctions)])
    tilt = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), weights, columns)
    k = stiffness[j]
    limits = [
        _within(tilt, GRADE_SLACK * bound[j], k, TILT_CAP),
        _within(tilt, np.full(len(j), defaults.JUNCTION_TILT_MAX), k, np.inf),
    ]
    j, rise = _close_ends(problem)
    rows = rows_matrix(np.column_stack([3 * j + 1, 3 * j + 2]), rise, columns)
    limits.append(_within(rows, np.full(len(j), defaults.JUNCTION_STEP_MAX), stiffness[j], np.inf))
    return limits


def _close_ends(problem: ProfileProblem) -> tuple[IntArray, FloatArray]:
    """Return pairs of road ends that are nearer sideways than their middles: junction, and offset / distance.

    The plane's gradient times the second is the grade between the nearest lanes of both ends, at most
    `JUNCTION_STEP_MAX`. The distance is less than that of the lanes where less is allowed.
    """
    junction = problem.end_junction.ravel()
    order = np.flatnonzero(junction >= 0)
    order = order[np.argsort(junction[order], kind="stable")]
    count = np.bincount(junction[order], minlength=len(problem.junction_xy))
    first = np.cumsum(count) - count
    # Each arm with all arms of its junction; the half with a < b is kept.
    size = count[junction[order]]
    a = np.repeat(np.arange(len(order)), size)
    b = runs(first[junction[order]], size)
    a, b = order[a[a < b]], order[b[a < b]]
    x, y, hdg = end_poses(problem)
    half, middle = _half_widths(problem)
    nx, ny = -np.sin(hdg), np.cos(hdg)

    def reach(p: IntArray, q: IntArray, edge: float) -> FloatArray:
        """Return the distance from the outer lanes of p, or from its edges, to the row of those of q."""
        best = np.full(len(p), np.inf)
        width_p, width_q = (np.maximum(half[k] - edge, 0.0) for k in (p, q))
        for side in (-1.0, 1.0):
            t = middle[p] + side * width_p
            dx, dy = x[p] + t * nx[p] - x[q], y[p] + t * ny[p] - y[q]
            t = np.clip(dx * nx[q] + dy * ny[q], middle[q] - width_q, middle[q] + width_q)
            best = np.minimum(best, np.hypot(dx - t * nx[q], dy - t * ny[q]))
        return best

    lanes, gap = (np.minimum(reach(a, b, edge), reach(b, a, edge)) for edge in (OUTER_LANE_INSET, 0.0))
    allowed = defaults.JUNCTION_EDGE_STEP_MAX + defaults.JUNCTION_STEP_MAX * gap
    allowed = np.where(gap < defaults.JUNCTION_EDGES_NEAR, allowed, np.inf)
    distance = np.minimum(np.maximum(lanes, SHORTEST_PATH), allowed / defaults.JUNCTION_STEP_MAX)
    offset = np.column_stack([x[a] - x[b], y[a] - y[b]])
    near = np.hypot(offset[:, 0], offset[:, 1]) > distance
    return junction[a[near]], offset[near] / distance[near, None]


def _half_widths(problem: ProfileProblem) -> tuple[FloatArray, FloatArray]:
    """Return half the carriageway's width and t of its middle at each road end, (2 R,), m."""
    ends = np.column_stack([problem.span_start[:-1], problem.span_start[1:] - 1]).ravel()
    width = np.full(len(ends), USUAL_WIDTH) if problem.span_width is None else problem.span_width[ends]
    middle = np.zeros(len(ends)) if problem.span_middle is None else problem.span_middle[ends]
    return 0.5 * width, middle


def clearance_rows(elements: Elements, unknowns: Unknowns, crossings: Crossings) -> sp.csr_matrix:
    """Return the rows that give the height of the upper road above the lower one at each crossing."""
    size = unknowns.to_knots.shape[0]
    parts = []
    for road, s in ((crossings.upper, crossings.upper_s), (crossings.lower, crossings.lower_s)):
        e = element_at(elements, road, s)
        u = (s - elements.s[e]) / elements.h[e]
        parts.append(rows_matrix(element_dofs(elements, e), hermite(u, elements.h[e]), size))
    return sp.csr_matrix((parts[0] - parts[1]) @ unknowns.to_knots)


def clearance_limits(
    elements: Elements,
    unknowns: Unknowns,
    crossings: Crossings,
    q: FloatArray,
    density: FloatArray,
    sigma: FloatArray,
) -> Limits:
    """Return the elastic limits that keep upper roads clear of lower ones.

    Parameters
    ----------
    q, density : (E,)
        Flexibility, 1/m, and usual weight of the observations per metre of road, 1/m³.
    sigma : (crossings,)
        Standard error of the elevation model's heights, m.
    """
    below = element_at(elements, crossings.lower, crossings.lower_s)
    k = deflection_stiffness(density[below], q[below])
    push = np.clip(defaults.CLEARANCE_PUSH_SIGMAS * sigma, defaults.CLEARANCE_PUSH_MIN, defaults.CLEARANCE_PUSH_MAX)
    return Limits(
        clearance_rows(elements, unknowns, crossings),
        crossings.clearance,
        np.full(len(k), np.inf),
        STIFF * k,
        push * k,
    )
