"""Roads cut into cubic elements, and how heights and grades follow from the unknowns.

Every road is a chain of cubic Hermite elements with a height z and a grade g along +s at each knot. A knot inside a
road has unknowns of its own. A road end at a junction takes both from the junction's plane; one that touches another
road end shares them with it. Heights and grades are therefore continuous by construction (docs/method/heights.md).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import connected_groups, cosine, find_record, lengths, pose, ranks, sine, unique_inverse
from osm2xodr.geometry.heights.problem import ProfileProblem, at_junctions, span_at, span_roads
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Weights (n, 4) of an element's degrees of freedom at u, (n,), of elements of length h, (n,), m
Weights: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]

# Stretches of bridge, tunnel or ground shorter than this join their neighbour, m: an element's stiffness grows with
# the third power of 1 / length.
_SHORTEST_STRETCH: Final = 1.0
# Shorter roads are cut as if they had this length, m: keeps the matrices finite.
_LEAST_LENGTH: Final = 1e-6
# Elements may exceed the spacing by this share of it, so that rounding does not add one.
_ROUNDING: Final = 1e-9


@record(eq=False)
class Elements:
    """Cubic elements of all roads, in the order of roads and of s."""

    knot_start: IntArray  # (R + 1,) Index of each road's first knot; a road of n elements has n + 1 knots
    knot_s: FloatArray  # (knots,) Where each knot lies along its road, m
    # (E,) Road, first knot (the second is the next one), span that holds at the middle, and its structure
    road: IntArray
    knot: IntArray
    span: IntArray
    structure: IntArray
    # (E,) Start and length, m
    s: FloatArray
    h: FloatArray

    @property
    def end_knots(self) -> IntArray:
        """The first and last knot of each road, (R, 2)."""
        return np.column_stack([self.knot_start[:-1], self.knot_start[1:] - 1])

    @property
    def end_elements(self) -> IntArray:
        """The first and last element of each road, (R, 2)."""
        return self.end_knots - np.arange(len(self.knot_start) - 1)[:, None] - [0, 1]


@record(eq=False)
class Samples:
    """Places along roads where the ground is read, in the order of elements."""

    element: IntArray  # (n,) Element of each
    u: FloatArray  # (n,) Position within the element, 0 to 1
    # (n,) Position along the road, local position, heading, m and rad
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    ds: FloatArray  # (n,) Length of road that each stands for, m


def _stretches(problem: ProfileProblem, length: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return road, start and end of the stretches between changes of structure, m."""
    road = span_roads(problem)
    first = np.zeros(len(road), bool)
    first[problem.span_start[:-1]] = True
    s = np.where(first, 0.0, problem.span_s)
    changed = np.r_[True, problem.span_structure[1:] != problem.span_structure[:-1]] if len(s) else first
    inside = (s >= _SHORTEST_STRETCH) & (s <= length[road] - _SHORTEST_STRETCH)
    keep = first | (changed & inside)
    road, s, first = road[keep], s[keep], first[keep]
    # Two changes may still lie closer to each other than that.
    keep = first | (np.diff(s, prepend=-np.inf) >= _SHORTEST_STRETCH)
    road, s = road[keep], s[keep]
    last = np.r_[road[1:] != road[:-1], True]
    return road, s, np.where(last, length[road], np.r_[s[1:], 0.0])


def build_elements(problem: ProfileProblem, spacing: FloatArray | float) -> Elements:
    """Cut roads into elements of equal length, at most `spacing` (R,), that end where the structure changes."""
    length = np.maximum(lengths(problem.plan_view), _LEAST_LENGTH)
    run_road, run_s, run_end = _stretches(problem, length)
    longest = np.broadcast_to(np.asarray(spacing, np.float64), length.shape)[run_road]
    count = np.maximum(1, np.ceil((run_end - run_s) / longest - _ROUNDING)).astype(np.int64)
    run = np.repeat(np.arange(len(count)), count)
    h = ((run_end - run_s) / count)[run]
    s, road = run_s[run] + ranks(count) * h, run_road[run]
    knot_start = np.r_[0, np.cumsum(np.bincount(road, minlength=len(length)) + 1)].astype(np.int64)
    # Each road has one knot more than elements: an element's first knot is its own number plus that of its road.
    knot = np.arange(len(road), dtype=np.int64) + road
    knot_s = np.zeros(knot_start[-1])
    knot_s[knot] = s
    knot_s[knot_start[1:] - 1] = length
    span = span_at(problem, road, s + 0.5 * h)
    return Elements(knot_start, knot_s, road, knot, span, problem.span_structure[span], s, h)


def build_samples(problem: ProfileProblem, elements: Elements, spacing: FloatArray) -> Samples:
    """Spread samples evenly over each element, at most its road's `spacing` (R,) apart."""
    count = np.maximum(1, np.ceil(elements.h / spacing[elements.road] - _ROUNDING)).astype(np.int64)
    element = np.repeat(np.arange(len(count), dtype=np.int64), count)
    u = (ranks(count) + 0.5) / count[element]
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


def hermite_curvature(u: FloatArray, h: FloatArray) -> FloatArray:
    """Return the weights (n, 4) of (z_a, g_a, z_b, g_b) in the curvature z'' at u of elements of length h."""
    bent = (12 * u - 6) / (h * h)
    return np.stack([bent, (6 * u - 4) / h, -bent, (6 * u - 2) / h], axis=-1)


def bending_matrices(h: FloatArray) -> FloatArray:
    """Return the matrices (n, 4, 4) of the integral of z''² over elements: those of the Euler-Bernoulli beam."""
    return _element_matrices(12 / (h * h * h), 6 / (h * h), 4 / h, 2 / h)


def tension_matrices(h: FloatArray) -> FloatArray:
    """Return the matrices (n, 4, 4) of the integral of z'² over elements."""
    return _element_matrices(36 / (30 * h), np.full_like(h, 3 / 30), 4 * h / 30, -h / 30)


def _element_matrices(zz: FloatArray, zg: FloatArray, gg: FloatArray, gh: FloatArray) -> FloatArray:
    """Return the matrices (n, 4, 4) of a form in the difference of heights and both grades, from its entries (n,)."""
    rows = [[zz, zg, -zz, zg], [zg, gg, -zg, gh], [-zz, -zg, zz, -zg], [zg, gh, -zg, gg]]
    return np.moveaxis(np.array(rows), -1, 0)


def _dofs(knot: IntArray) -> IntArray:
    """Return the indices (n, 4) of (z_a, g_a, z_b, g_b) of elements from these knots on, among z and g per knot."""
    return 2 * knot[:, None] + np.arange(4)


def element_at(elements: Elements, road: IntArray, s: FloatArray) -> IntArray:
    """Return the element that holds s of roads, both (n,)."""
    return find_record(elements.knot_start - np.arange(len(elements.knot_start)), elements.s, road, s)


def assemble(elements: Elements, matrices: FloatArray) -> sp.csr_matrix:
    """Sum element matrices (E, 4, 4) over the knots' degrees of freedom."""
    dofs, size = _dofs(elements.knot), 2 * len(elements.knot_s)
    rows, cols = (np.broadcast_to(index, matrices.shape).ravel() for index in (dofs[:, :, None], dofs[:, None, :]))
    return sp.coo_matrix((matrices.ravel(), (rows, cols)), (size, size)).tocsr()


def rows_matrix(dofs: IntArray, weights: FloatArray, size: int) -> sp.csr_matrix:
    """Return the matrix whose n rows hold weights (n, k) at the degrees of freedom dofs (n, k)."""
    rows = np.repeat(np.arange(len(weights)), weights.shape[1])
    return sp.coo_matrix((weights.ravel(), (rows, dofs.ravel())), (len(weights), size)).tocsr()


@record(eq=False)
class Unknowns:
    """How the knots' degrees of freedom follow from the unknowns."""

    to_knots: sp.csr_matrix  # (2 * knots, N) Matrix from unknowns to z and g of every knot
    junctions: int  # Number of junctions; their (z, gx, gy) come first
    z_columns: IntArray  # The unknowns that are heights
    # (2 * R,) Number of the node that each road end lies at: junction j is node j, links and free ends follow
    end_node: IntArray


@record(eq=False)
class Network:
    """The roads as the solve sees them."""

    problem: ProfileProblem
    elements: Elements
    samples: Samples
    unknowns: Unknowns

    def place(self, road: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the element, and the position in it from 0 to 1, of places s along roads, m, all (n,)."""
        elements, element = self.elements, element_at(self.elements, road, s)
        return element, np.clip((s - elements.s[element]) / elements.h[element], 0.0, 1.0)

    def knot_rows(self, element: IntArray, u: FloatArray, weights: Weights) -> sp.csr_matrix:
        """Return the rows (n, 2 * knots) that give the height (`hermite`) or grade (`hermite_slope`) in elements."""
        values = weights(u, self.elements.h[element])
        return rows_matrix(_dofs(self.elements.knot[element]), values, self.unknowns.to_knots.shape[0])

    def in_unknowns(self, knot_rows: sp.csr_matrix) -> sp.csr_matrix:
        """Return rows over the knots' degrees of freedom, (n, 2 * knots), as rows over the unknowns, (n, N)."""
        return sp.csr_matrix(knot_rows @ self.unknowns.to_knots)


def end_poses(problem: ProfileProblem) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and the heading along +s of all 2 R road ends."""
    length = lengths(problem.plan_view)
    s = np.column_stack([np.zeros(len(length)), length]).ravel()
    return pose(problem.plan_view, np.repeat(np.arange(len(length), dtype=np.int64), 2), s)


def number_unknowns(problem: ProfileProblem, elements: Elements) -> Unknowns:
    """Give three unknowns (z, gx, gy) to each junction and two (z, g) to each other node and knot."""
    junctions, junction = len(problem.junction_xy), problem.end_junction.ravel()
    owner = _end_owners(problem)
    owns = (owner == np.arange(len(owner))) & ~on_plane(problem)
    number = np.cumsum(owns) - 1
    end_knot = elements.end_knots.ravel()
    inner_knots = np.setdiff1d(np.arange(len(elements.knot_s)), end_knot)
    first_free = 3 * junctions
    first_inner = first_free + 2 * int(owns.sum())
    size = first_inner + 2 * len(inner_knots)

    inner = first_inner + 2 * np.arange(len(inner_knots), dtype=np.int64)
    # Where crossfall runs through a junction all arms lie on its plane.
    free = np.flatnonzero(~on_plane(problem))
    ends = first_free + 2 * number[owner[free]]
    # The grade along +s changes its sign where two starts or two ends touch.
    sign = np.where((owner != np.arange(len(owner))) & ((owner - np.arange(len(owner))) % 2 == 0), -1.0, 1.0)[free]
    one = np.ones(len(inner_knots))
    entries = [
        (2 * inner_knots, inner, one),
        (2 * inner_knots + 1, inner + 1, one),
        (2 * end_knot[free], ends, np.ones(len(free))),
        (2 * end_knot[free] + 1, ends + 1, sign),
        *_plane_entries(problem, end_knot),
    ]
    rows, cols, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    to_knots = sp.coo_matrix((values, (rows, cols)), (2 * len(elements.knot_s), size)).tocsr()
    z_columns = np.r_[3 * np.arange(junctions), np.arange(first_free, size, 2)].astype(np.int64)
    return Unknowns(to_knots, junctions, z_columns, np.where(junction >= 0, junction, junctions + number[owner]))


def _end_owners(problem: ProfileProblem) -> IntArray:
    """Return the road end that each road end, (2 R,), shares its unknowns with: the first of two that touch."""
    ends = np.arange(problem.end_link.size, dtype=np.int64)
    link = problem.end_link.ravel()
    linked = (problem.end_junction.ravel() < 0) & (link >= 0)
    if linked.any() and not np.array_equal(link[link[linked]], ends[linked]):
        raise ValueError("end_link must be symmetric")
    return np.where(linked, np.minimum(ends, link), ends)


def on_plane(problem: ProfileProblem) -> BoolArray:
    """Return the road ends that lie on the plane of their junction, (2 R,)."""
    return at_junctions(problem.carried, problem.end_junction.ravel())


def _plane_entries(problem: ProfileProblem, end_knot: IntArray) -> list[tuple[IntArray, IntArray, FloatArray]]:
    """Return rows, columns and values by which road ends follow from the planes that they lie on."""
    on = np.flatnonzero(on_plane(problem))
    x, y, hdg = (value[on] for value in end_poses(problem))
    j, knot = problem.end_junction.ravel()[on], end_knot[on]
    return [
        (2 * knot, 3 * j, np.ones(len(on))),
        (2 * knot, 3 * j + 1, x - problem.junction_xy[j, 0]),
        (2 * knot, 3 * j + 2, y - problem.junction_xy[j, 1]),
        (2 * knot + 1, 3 * j + 1, cosine(hdg)),
        (2 * knot + 1, 3 * j + 2, sine(hdg)),
    ]


def components(unknowns: Unknowns) -> IntArray:
    """Return the number of the connected component of each road, (R,)."""
    nodes = int(unknowns.end_node.max(initial=-1)) + 1
    pairs = unknowns.end_node.reshape(-1, 2)
    return unique_inverse(connected_groups(nodes, *pairs.T)[pairs[:, 0]])[1]
