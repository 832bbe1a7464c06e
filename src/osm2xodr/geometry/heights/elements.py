"""Roads cut into cubic elements, and the matrices of the network solve.

Every road is a chain of cubic Hermite elements: the unknowns at a knot are its height z and its grade g along +s.
A knot inside a road has unknowns of its own. A road's end that lies at a junction takes both from the junction's
plane, an end that touches another road's end shares them with it. What a road sees is therefore continuous in
height and grade by construction, and so is what passes a junction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import find_record, lengths, pose, ranks
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at, span_roads
from osm2xodr.model import FloatArray, IntArray

# Runs of one structure that are shorter than this are no elements of their own, m: an element's stiffness grows
# with the third power of 1 / length.
SHORTEST_RUN = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """Cubic elements of all roads, in the order of roads and of s."""

    knot_start: IntArray  # (R + 1,) Index of each road's first knot; a road of n elements has n + 1 knots
    # (knots,) Where each knot lies
    knot_s: FloatArray
    knot_road: IntArray
    # (E,) Road, first knot (the second is the next one), span that holds at the middle, and its structure
    road: IntArray
    knot: IntArray
    span: IntArray
    structure: IntArray
    # (E,) Start and length, m
    s: FloatArray
    h: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Places along roads where the surface is read, in the order of elements."""

    element: IntArray  # (n,) Element of each
    u: FloatArray  # (n,) Position within the element, 0 to 1
    # (n,) Position along the road, local position, heading, m and rad
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    ds: FloatArray  # (n,) Length of road that each stands for, m


def _runs(problem: ProfileProblem, length: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return road, start and end of the stretches between changes of structure."""
    road = span_roads(problem)
    first = np.zeros(len(road), bool)
    first[problem.span_start[:-1]] = True
    s = np.where(first, 0.0, problem.span_s)
    changed = np.r_[True, problem.span_structure[1:] != problem.span_structure[:-1]] if len(s) else first
    inside = (s >= SHORTEST_RUN) & (s <= length[road] - SHORTEST_RUN)
    keep = first | (changed & inside)
    road, s, first = road[keep], s[keep], first[keep]
    # What is left may still lie closer than an element to the one before it on the same road.
    keep = first | (np.diff(s, prepend=-np.inf) >= SHORTEST_RUN)
    road, s = road[keep], s[keep]
    ends = np.r_[s[1:], 0.0]
    last = np.r_[road[1:] != road[:-1], True]
    return road, s, np.where(last, length[road], ends)


def build_elements(problem: ProfileProblem, spacing: FloatArray | float) -> Elements:
    """Cut roads into elements of equal length, at most `spacing` (R,), that end where the structure changes."""
    length = np.maximum(lengths(problem.plan_view), 1e-6)
    run_road, run_s, run_end = _runs(problem, length)
    run_length = run_end - run_s
    longest = np.broadcast_to(np.asarray(spacing, np.float64), length.shape)[run_road]
    count = np.maximum(1, np.ceil(run_length / longest - 1e-9)).astype(np.int64)
    run = np.repeat(np.arange(len(count)), count)
    within = ranks(count)
    h = (run_length / count)[run]
    s = run_s[run] + within * h
    road = run_road[run]
    per_road = np.bincount(road, minlength=len(length))
    knot_start = np.r_[0, np.cumsum(per_road + 1)].astype(np.int64)
    # Each road has one knot more than elements, so that knots lag elements by the number of the road.
    knot = np.arange(len(road), dtype=np.int64) + road
    knot_s = np.zeros(knot_start[-1])
    knot_s[knot] = s
    knot_s[knot_start[1:] - 1] = length
    span = span_at(problem, road, s + 0.5 * h)
    return Elements(
        knot_start=knot_start,
        knot_s=knot_s,
        knot_road=np.repeat(np.arange(len(length), dtype=np.int64), per_road + 1),
        road=road,
        knot=knot,
        span=span,
        structure=problem.span_structure[span],
        s=s,
        h=h,
    )


def build_samples(problem: ProfileProblem, elements: Elements, spacing: FloatArray) -> Samples:
    """Spread samples evenly over each element, at most its road's `spacing` (R,) apart."""
    count = np.maximum(1, np.ceil(elements.h / spacing[elements.road] - 1e-9)).astype(np.int64)
    element = np.repeat(np.arange(len(count), dtype=np.int64), count)
    within = ranks(count)
    u = (within + 0.5) / count[element]
    s = elements.s[element] + u * elements.h[element]
    x, y, hdg = pose(problem.plan_view, elements.road[element], s)
    return Samples(element, u, s, x, y, hdg, elements.h[element] / count[element])


def hermite(u: FloatArray, h: FloatArray) -> FloatArray:
    """Return the weights (n, 4) of (z_a, g_a, z_b, g_b) in the height at u of elements of length h."""
    u2, u3 = u * u, u * u * u
    return np.stack([1 - 3 * u2 + 2 * u3, h * (u - 2 * u2 + u3), 3 * u2 - 2 * u3, h * (u3 - u2)], axis=-1)


def hermite_slope(u: FloatArray, h: FloatArray) -> FloatArray:
    """Return the weights (n, 4) of (z_a, g_a, z_b, g_b) in the grade at u of elements of length h."""
    u2 = u * u
    steep = 6 * (u - u2) / h
    return np.stack([-steep, 1 - 4 * u + 3 * u2, steep, 3 * u2 - 2 * u], axis=-1)


def bending(h: FloatArray) -> FloatArray:
    """Return the matrices (n, 4, 4) of the integral of z''² over elements: those of the Euler-Bernoulli beam."""
    one = np.ones_like(h)
    return _symmetric(12 / h**3, 6 / h**2, 4 / h, 2 / h, one)


def stretching(h: FloatArray) -> FloatArray:
    """Return the matrices (n, 4, 4) of the integral of z'² over elements."""
    one = np.ones_like(h)
    return _symmetric(36 / (30 * h), 3 * one / 30, 4 * h / 30, -h / 30, one)


def _symmetric(zz: FloatArray, zg: FloatArray, gg: FloatArray, gh: FloatArray, one: FloatArray) -> FloatArray:
    """Return the matrices of a form that does not see heights, only their difference and the grades."""
    rows = [
        [zz, zg, -zz, zg],
        [zg, gg, -zg, gh],
        [-zz, -zg, zz, -zg],
        [zg, gh, -zg, gg],
    ]
    return np.moveaxis(np.array([[cell * one for cell in row] for row in rows]), -1, 0)


def element_dofs(elements: Elements, element: IntArray | None = None) -> IntArray:
    """Return the indices (n, 4) of (z_a, g_a, z_b, g_b) among the knots' degrees of freedom (z, g per knot)."""
    knot = elements.knot if element is None else elements.knot[element]
    return 2 * knot[:, None] + np.arange(4)


def element_at(elements: Elements, road: IntArray, s: FloatArray) -> IntArray:
    """Return the element that holds s of roads, both (n,)."""
    start = elements.knot_start - np.arange(len(elements.knot_start))
    return find_record(start, elements.s, road, s)


def assemble(dofs: IntArray, matrices: FloatArray, size: int) -> sp.csr_matrix:
    """Add element matrices (n, 4, 4) up over the knots' degrees of freedom."""
    rows = np.broadcast_to(dofs[:, :, None], matrices.shape)
    cols = np.broadcast_to(dofs[:, None, :], matrices.shape)
    return sp.coo_matrix((matrices.ravel(), (rows.ravel(), cols.ravel())), (size, size)).tocsr()


def rows_matrix(dofs: IntArray, weights: FloatArray, size: int) -> sp.csr_matrix:
    """Return the matrix whose n rows hold weights (n, k) at the degrees of freedom dofs (n, k)."""
    n, k = weights.shape
    rows = np.repeat(np.arange(n), k)
    return sp.coo_matrix((weights.ravel(), (rows, dofs.ravel())), (n, size)).tocsr()


@dataclass(frozen=True, slots=True, eq=False)
class Unknowns:
    """How the knots' degrees of freedom follow from the unknowns."""

    to_knots: sp.csr_matrix  # (2 * knots, N) Matrix from unknowns to z and g of every knot
    junctions: int  # Number of junctions; their (z, gx, gy) come first
    z_columns: IntArray  # The unknowns that are heights
    # (2 * R,) Number of the node that each road end lies at: junction j is node j, links and free ends follow
    end_node: IntArray


def end_poses(problem: ProfileProblem) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and the heading along +s of all 2 R road ends."""
    length = lengths(problem.plan_view)
    road = np.repeat(np.arange(len(length), dtype=np.int64), 2)
    s = np.column_stack([np.zeros(len(length)), length]).ravel()
    return pose(problem.plan_view, road, s)


def number_unknowns(problem: ProfileProblem, elements: Elements) -> Unknowns:
    """Give three unknowns (z, gx, gy) to each junction and two (z, g) to each other node and knot."""
    junctions, roads = len(problem.junction_xy), len(problem.end_junction)
    junction, link = problem.end_junction.ravel(), problem.end_link.ravel()
    ends = np.arange(2 * roads, dtype=np.int64)
    linked = (junction < 0) & (link >= 0)
    if linked.any() and not np.array_equal(link[link[linked]], ends[linked]):
        raise ValueError("end_link must be symmetric")
    owner = np.where(linked, np.minimum(ends, link), ends)
    free = np.flatnonzero((junction < 0) & (owner == ends))
    number = np.full(2 * roads, -1, np.int64)
    number[free] = np.arange(len(free))

    inner = np.ones(len(elements.knot_s), bool)
    first, last = elements.knot_start[:-1], elements.knot_start[1:] - 1
    inner[first] = inner[last] = False
    inner_knots = np.flatnonzero(inner)
    base_free = 3 * junctions
    base_inner = base_free + 2 * len(free)
    size = base_inner + 2 * len(inner_knots)

    rows, cols, values = [], [], []

    def put(row: IntArray, col: IntArray, value: FloatArray) -> None:
        rows.append(row)
        cols.append(col)
        values.append(value)

    k = np.arange(len(inner_knots), dtype=np.int64)
    put(2 * inner_knots, base_inner + 2 * k, np.ones(len(k)))
    put(2 * inner_knots + 1, base_inner + 2 * k + 1, np.ones(len(k)))

    end_knot = np.column_stack([first, last]).ravel()
    plain = np.flatnonzero(junction < 0)
    column = base_free + 2 * number[owner[plain]]
    # Along +s the grade of a shared end turns its sign where two starts or two ends touch.
    sign = np.where((owner[plain] != plain) & ((owner[plain] - plain) % 2 == 0), -1.0, 1.0)
    put(2 * end_knot[plain], column, np.ones(len(plain)))
    put(2 * end_knot[plain] + 1, column + 1, sign)

    on = np.flatnonzero(junction >= 0)
    x, y, hdg = end_poses(problem)
    j = junction[on]
    ox, oy = x[on] - problem.junction_xy[j, 0], y[on] - problem.junction_xy[j, 1]
    put(2 * end_knot[on], 3 * j, np.ones(len(on)))
    put(2 * end_knot[on], 3 * j + 1, ox)
    put(2 * end_knot[on], 3 * j + 2, oy)
    put(2 * end_knot[on] + 1, 3 * j + 1, np.cos(hdg[on]))
    put(2 * end_knot[on] + 1, 3 * j + 2, np.sin(hdg[on]))

    to_knots = sp.coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), (2 * len(elements.knot_s), size)
    ).tocsr()
    z_columns = np.r_[
        3 * np.arange(junctions), np.arange(base_free, base_inner, 2), np.arange(base_inner, size, 2)
    ].astype(np.int64)
    end_node = np.where(junction >= 0, junction, junctions + number[owner])
    return Unknowns(to_knots, junctions, z_columns, end_node)


def components(problem: ProfileProblem, unknowns: Unknowns) -> IntArray:
    """Return the number of the connected component of each road, (R,)."""
    roads = len(problem.end_junction)
    nodes = int(unknowns.end_node.max(initial=-1)) + 1
    pairs = unknowns.end_node.reshape(-1, 2)
    graph = sp.coo_matrix((np.ones(roads), (pairs[:, 0], pairs[:, 1])), (nodes, nodes))
    label = sp.csgraph.connected_components(graph, directed=False)[1]
    out: IntArray = np.unique(label[pairs[:, 0]], return_inverse=True)[1].astype(np.int64)
    return out
