"""Bridges and tunnels in the network solve: chains of structures as one, and clearance where layers cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from osm2xodr.curves import lengths, pose, ranks
from osm2xodr.geometry.defaults import PARALLEL_SINE
from osm2xodr.geometry.heights.defaults import CLEARANCE, CLEARANCE_OTHER
from osm2xodr.geometry.heights.elements import Elements, Unknowns
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# Roads are taken as chords of at most this length where crossings are looked for, m, in a grid of such cells.
CHORD = 12.0
CELL = 24.0
_HASHES = 1 << 20
# Roads that meet at a node do not cross there, however their layers are tagged: within this distance of it, m.
NEAR_NODE = 25.0
# Width that carriageways one above the other share at least, m: below it they rather lie side by side.
SHARED_WIDTH = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Chains:
    """Rows of bridges and tunnels, each as one."""

    chain: IntArray  # (E,) Chain of each element, -1 on the ground
    sign: FloatArray  # (E,) 1 where the element's road runs along its chain, -1 where against it
    loose: BoolArray  # (chains,) Whether a chain ends where nothing holds it, as a tunnel that the map's edge cuts


def find_chains(problem: ProfileProblem, elements: Elements) -> Chains:
    """Join structures that follow each other along roads and over links between roads."""
    on = elements.structure != Structure.GROUND
    same_road = np.r_[False, (elements.road[1:] == elements.road[:-1]) & on[1:] & on[:-1]]
    run = np.where(on, np.cumsum(on & ~same_road) - 1, -1)
    runs = int(run.max(initial=-1)) + 1
    roads = len(problem.end_junction)
    # The run at each road end, if the road's first or last element is a structure.
    first = elements.knot_start[:-1] - np.arange(roads)
    last = elements.knot_start[1:] - 2 - np.arange(roads)
    end_run = np.column_stack([run[first], run[last]]).ravel()
    link = np.where(problem.end_junction.ravel() < 0, problem.end_link.ravel(), -1)
    neighbours: list[list[tuple[int, float]]] = [[] for _ in range(runs)]
    loose_run = np.zeros(runs, bool)
    for end in np.flatnonzero(end_run >= 0):
        other = int(link[end])
        if other >= 0 and end_run[other] >= 0:
            neighbours[end_run[end]].append((int(end_run[other]), -1.0 if (end - other) % 2 == 0 else 1.0))
        elif other < 0 and problem.end_junction.ravel()[end] < 0:
            loose_run[end_run[end]] = True
    chain_of = np.full(runs, -1, np.int64)
    sign_of = np.ones(runs)
    count = 0
    for seed in range(runs):
        if chain_of[seed] >= 0:
            continue
        chain_of[seed] = count
        stack = [seed]
        while stack:
            here = stack.pop()
            for there, turn in neighbours[here]:
                if chain_of[there] < 0:
                    chain_of[there] = count
                    sign_of[there] = sign_of[here] * turn
                    stack.append(there)
        count += 1
    loose = np.zeros(count, bool)
    loose[chain_of[loose_run]] = True
    chain = np.where(on, chain_of[run], -1) if runs else np.full(len(on), -1, np.int64)
    sign = np.where(on, sign_of[run], 1.0) if runs else np.ones(len(on))
    return Chains(chain, sign, loose)


def chord_coupling(
    elements: Elements, chains: Chains, tension: FloatArray, unknowns: Unknowns
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Return what makes the tension of chains one toward their own chord instead of toward level.

    Each chain that is held at both ends gets one more unknown m, its mean grade. Tension times the integral of
    (z' - m)² is the plain tension plus the terms of m that are returned: the coupling (N, M) with the other
    unknowns and the diagonal (M, M).

    Parameters
    ----------
    tension : (E,)
        Strength of the tension, 0 on the ground.
    """
    count = len(chains.loose)
    held = np.flatnonzero((chains.chain >= 0) & ~np.r_[chains.loose, True][chains.chain])
    chain, sign, tau = chains.chain[held], chains.sign[held], tension[held]
    knot = elements.knot[held]
    rows = np.r_[2 * knot, 2 * (knot + 1)]
    values = np.r_[sign * tau, -sign * tau]
    size = unknowns.to_knots.shape[0]
    in_knots = sp.coo_matrix((values, (rows, np.r_[chain, chain])), (size, count)).tocsr()
    diagonal = np.bincount(chain, tau * elements.h[held], count).astype(np.float64)
    diagonal[diagonal == 0] = 1.0
    return (unknowns.to_knots.T @ in_knots).tocsr(), sp.csr_matrix(sp.diags(diagonal))


def portal_distance(problem: ProfileProblem, elements: Elements, end_node: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for each element how far the nearest structure is from its start and from its end along its road.

    A structure that begins at the node where a road ends counts as well. Infinite where there is none.
    """
    on = elements.structure != Structure.GROUND
    count = len(on)
    roads = len(problem.end_junction)
    first = elements.knot_start[:-1] - np.arange(roads)
    last = elements.knot_start[1:] - 2 - np.arange(roads)
    nodes = int(end_node.max(initial=-1)) + 1
    touched = np.zeros(nodes, bool)
    ends = np.column_stack([on[first], on[last]]).ravel()
    touched[end_node[ends]] = True
    start_touched, end_touched = touched[end_node[0::2]], touched[end_node[1::2]]

    s0, s1 = elements.s, elements.s + elements.h
    behind = np.where(on, s1, -np.inf)
    behind[first] = np.maximum(behind[first], np.where(start_touched & ~on[first], 0.0, -np.inf))
    ahead = np.where(on, s0, np.inf)
    length = s1[last]
    ahead[last] = np.minimum(ahead[last], np.where(end_touched & ~on[last], length[elements.road[last]], np.inf))
    # The last place behind and the first ahead, road by road: an offset per road keeps roads apart.
    reach = float(s1.max(initial=0.0)) + 1.0
    shift = elements.road * (4.0 * reach)
    before = np.where(np.isfinite(behind), behind + shift, -np.inf)
    after = np.where(np.isfinite(ahead), ahead + shift, np.inf)
    before = np.maximum.accumulate(before) - shift if count else before
    after = np.minimum.accumulate(after[::-1])[::-1] - shift if count else after
    before = np.where(before < -reach, -np.inf, before)
    after = np.where(after > 2 * reach, np.inf, after)
    return s0 - before, after - s1


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Places where one road passes over another without meeting it."""

    # upper, lower: (n,) Roads
    upper: IntArray
    # upper_s, lower_s: (n,) Where, m
    upper_s: FloatArray
    lower: IntArray
    lower_s: FloatArray
    clearance: FloatArray  # (n,) Height that there should be from road to road, by the class of the lower one, m


def _chords(problem: ProfileProblem) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Return road, s at the start, step of s, and end points (n, 4) of chords along all roads."""
    length = lengths(problem.plan_view)
    count = np.maximum(1, np.ceil(length / CHORD)).astype(np.int64)
    road = np.repeat(np.arange(len(length), dtype=np.int64), count)
    within = ranks(count)
    step = (length / count)[road]
    s = within * step
    # A chord ends where the next one of its road begins.
    every = np.arange(len(length), dtype=np.int64)
    x, y, _ = pose(problem.plan_view, np.concatenate([road, every]), np.concatenate([s, length]))
    end = np.arange(1, len(road) + 1)
    end[np.cumsum(count) - 1] = len(road) + every
    return road, s, step, np.column_stack([x[: len(road)], y[: len(road)], x[end], y[end]])


def _pairs_in_cells(box: FloatArray, probe: IntArray) -> tuple[IntArray, IntArray]:
    """Return pairs (probe, chord) whose bounding boxes share a cell of the grid, each once."""
    lo = np.floor(np.minimum(box[:, :2], box[:, 2:]) / CELL).astype(np.int64)
    hi = np.floor(np.maximum(box[:, :2], box[:, 2:]) / CELL).astype(np.int64)
    lo, hi = lo - lo.min(0), hi - lo.min(0)
    stride = int(hi[:, 0].max()) + 2
    corners = np.stack([lo[:, 0] + stride * lo[:, 1], hi[:, 0] + stride * lo[:, 1],
                        lo[:, 0] + stride * hi[:, 1], hi[:, 0] + stride * hi[:, 1]])  # fmt: skip
    asked = corners[:, probe].ravel()
    # Few cells are asked for; most others are told apart from them by a part of their number.
    wanted = np.zeros(_HASHES, bool)
    wanted[asked % _HASHES] = True
    chord = np.flatnonzero(wanted[corners % _HASHES].any(axis=0))
    cell, chord = corners[:, chord].ravel(), np.tile(chord, 4)
    order = np.argsort(cell, kind="stable")
    cell, chord = cell[order], chord[order]
    who = np.tile(probe, 4)
    left, right = np.searchsorted(cell, asked, "left"), np.searchsorted(cell, asked, "right")
    size = right - left
    index = np.repeat(left - np.cumsum(size) + size, size) + np.arange(int(size.sum()))
    code = np.unique(np.repeat(who, size) * len(box) + chord[index])
    return code // len(box), code % len(box)


def find_crossings(problem: ProfileProblem, end_node: IntArray) -> Crossings:
    """Find where a bridge passes over another road, or a tunnel under one, by their layers."""
    road, s, step, box = _chords(problem)
    span = span_at(problem, road, s + 0.5 * step)
    structure, layer = problem.span_structure[span], problem.span_layer[span]
    probe = np.flatnonzero(structure != Structure.GROUND)
    empty = np.zeros(0, np.int64)
    if not len(probe):
        return Crossings(empty, np.zeros(0), empty, np.zeros(0), np.zeros(0))
    a, b = _pairs_in_cells(box, probe)
    over = layer[a] > layer[b]
    apart = (layer[a] != layer[b]) & np.where(
        over, structure[a] == Structure.BRIDGE, structure[a] == Structure.TUNNEL
    )
    a, b = a[apart], b[apart]
    p, q = box[a, :2], box[b, :2]
    u, v = box[a, 2:] - p, box[b, 2:] - q
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    d = q - p
    with np.errstate(divide="ignore", invalid="ignore"):
        ta = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / cross
        tb = (d[:, 0] * u[:, 1] - d[:, 1] * u[:, 0]) / cross
    hit = (ta >= 0) & (ta < 1) & (tb >= 0) & (tb < 1)
    inner = _within_structure(road, s, step, structure)
    above, along = _on_top_of_each_other(problem, end_node, road, span, box, inner, a, b)
    above &= ~hit
    ta, tb = np.where(above, 0.5, ta), np.where(above, along, tb)
    hit |= above
    a, b, ta, tb = a[hit], b[hit], ta[hit], tb[hit]
    sa, sb = s[a] + ta * step[a], s[b] + tb * step[b]
    apart = ~_meet_nearby(problem, end_node, road[a], sa, road[b], sb)
    over = layer[a] > layer[b]
    a, b, sa, sb, over = a[apart], b[apart], sa[apart], sb[apart], over[apart]
    upper, lower = np.where(over, road[a], road[b]), np.where(over, road[b], road[a])
    upper_s, lower_s = np.where(over, sa, sb), np.where(over, sb, sa)
    # Two structures find each other twice.
    key = np.column_stack([upper, lower, np.round(upper_s, 3), np.round(lower_s, 3)])
    unique = np.unique(key, axis=0, return_index=True)[1]
    unique.sort()
    upper, upper_s, lower, lower_s = (value[unique] for value in (upper, upper_s, lower, lower_s))
    highway = [problem.span_highway[k] for k in span_at(problem, lower, lower_s).tolist()]
    clearance = np.array([CLEARANCE.get(name, CLEARANCE_OTHER) for name in highway], np.float64)
    return Crossings(upper, upper_s, lower, lower_s, clearance)


def _on_top_of_each_other(
    problem: ProfileProblem,
    end_node: IntArray,
    road: IntArray,
    span: IntArray,
    box: FloatArray,
    inner: BoolArray,
    a: IntArray,
    b: IntArray,
) -> tuple[BoolArray, FloatArray]:
    """Say for pairs of chords whether they run one above the other (double decks), and where on b the middle of a is.

    Away from its ends a structure may also lie over a part only of what runs along it; near them the widths that are
    guessed could make it do so. Roads that meet at a node are left out: a ramp comes down onto the road that it runs
    along.
    """
    u, v = box[a, 2:] - box[a, :2], box[b, 2:] - box[b, :2]
    off = box[a, :2] + 0.5 * u - box[b, :2]
    long = np.maximum(np.hypot(*v.T), 1e-9)
    along = (off * v).sum(axis=1) / long**2
    aside = np.abs(off[:, 0] * v[:, 1] - off[:, 1] * v[:, 0]) / long
    sine = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (np.maximum(np.hypot(*u.T), 1e-9) * long)
    if problem.span_width is None:
        return np.zeros(len(a), bool), along
    one, other = problem.span_width[span[a]], problem.span_width[span[b]]
    shared = np.where(inner[a], 0.5 * (one + other) - SHARED_WIDTH, 0.5 * np.minimum(one, other))
    anywhere = np.zeros(len(a))
    meet = _meet_nearby(problem, end_node, road[a], anywhere, road[b], anywhere, near=np.inf)
    out: BoolArray = (along >= 0) & (along < 1) & (aside < shared) & (sine < PARALLEL_SINE) & ~meet
    return out, along


def _within_structure(road: IntArray, s: FloatArray, step: FloatArray, structure: IntArray) -> BoolArray:
    """Return which chords lie on a structure and farther than NEAR_NODE from where it or its road ends."""
    on = structure != Structure.GROUND
    border = np.r_[True, (road[1:] != road[:-1]) | (structure[1:] != structure[:-1]), True]
    first = np.flatnonzero(border[:-1])
    run = np.cumsum(border[:-1]) - 1
    last = np.r_[first[1:], len(road)] - 1
    out: BoolArray = on & (s - s[first][run] > NEAR_NODE) & (s[last][run] - s > NEAR_NODE)
    return out


def _meet_nearby(
    problem: ProfileProblem,
    end_node: IntArray,
    a: IntArray,
    sa: FloatArray,
    b: IntArray,
    sb: FloatArray,
    near: float = NEAR_NODE,
) -> BoolArray:
    """Return whether roads a and b share a node near both places, m, or are the same place of one road."""
    length = lengths(problem.plan_view)
    out: BoolArray = (a == b) & (np.abs(sa - sb) < 2 * near)
    for i in (0, 1):
        for j in (0, 1):
            da = np.where(i == 0, sa, length[a] - sa)
            db = np.where(j == 0, sb, length[b] - sb)
            out |= (end_node[2 * a + i] == end_node[2 * b + j]) & (da < near) & (db < near)
    return out
