"""Where one road passes over another: bridges and tunnels by their layers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, pose, ranks
from osm2xodr.geometry.defaults import PARALLEL_SINE
from osm2xodr.geometry.heights.defaults import CLEARANCE, CLEARANCE_OTHER
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# Roads are taken as chords of at most this length where crossings are looked for, m, in a grid of such cells, m.
_CHORD: Final = 12.0
_CELL: Final = 24.0
# Size of the table that rules out most chords far from structures by a hash of their cells: bounds its memory.
_HASHES: Final = 1 << 20
# Roads that meet at a node do not cross there, however their layers are tagged: within this distance of it, m.
_NEAR_NODE: Final = 25.0
# Width that carriageways one above the other share at least, m: with less they rather lie side by side.
_SHARED_WIDTH: Final = 1.5
# Shorter chords count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Places where one road passes over another without meeting it."""

    # (n,) Roads, and where along them, m
    upper: IntArray
    upper_s: FloatArray
    lower: IntArray
    lower_s: FloatArray
    clearance: FloatArray  # (n,) Height wanted from road to road, by the class of the lower one, m


@dataclass(frozen=True, slots=True, eq=False)
class _Chords:
    """All roads as straight chords, in the order of roads and of s."""

    road: IntArray  # (n,)
    # (n,) Where each begins, and its length along the road, m
    s: FloatArray
    step: FloatArray
    box: FloatArray  # (n, 4) x, y of its start and of its end, m
    span: IntArray  # (n,) Span at its middle, and its structure and layer
    structure: IntArray
    layer: IntArray


def _cut_chords(problem: ProfileProblem) -> _Chords:
    length = lengths(problem.plan_view)
    count = np.maximum(1, np.ceil(length / _CHORD)).astype(np.int64)
    road = np.repeat(np.arange(len(length), dtype=np.int64), count)
    step = (length / count)[road]
    s = ranks(count) * step
    # A chord ends where the next one of its road begins.
    every = np.arange(len(length), dtype=np.int64)
    x, y, _ = pose(problem.plan_view, np.concatenate([road, every]), np.concatenate([s, length]))
    end = np.arange(1, len(road) + 1)
    end[np.cumsum(count) - 1] = len(road) + every
    box = np.column_stack([x[: len(road)], y[: len(road)], x[end], y[end]])
    span = span_at(problem, road, s + 0.5 * step)
    return _Chords(road, s, step, box, span, problem.span_structure[span], problem.span_layer[span])


def _pairs_in_cells(box: FloatArray, probe: IntArray) -> tuple[IntArray, IntArray]:
    """Return pairs (probe, chord) whose bounding boxes share a cell of the grid, each once."""
    lo = np.floor(np.minimum(box[:, :2], box[:, 2:]) / _CELL).astype(np.int64)
    hi = np.floor(np.maximum(box[:, :2], box[:, 2:]) / _CELL).astype(np.int64)
    lo, hi = lo - lo.min(0), hi - lo.min(0)
    stride = int(hi[:, 0].max()) + 2
    corners = np.stack([lo[:, 0] + stride * lo[:, 1], hi[:, 0] + stride * lo[:, 1],
                        lo[:, 0] + stride * hi[:, 1], hi[:, 0] + stride * hi[:, 1]])  # fmt: skip
    asked = corners[:, probe].ravel()
    # Few cells are asked for: a part of their number rules out most others.
    wanted = np.zeros(_HASHES, bool)
    wanted[asked % _HASHES] = True
    chord = np.flatnonzero(wanted[corners % _HASHES].any(axis=0))
    cell, chord = corners[:, chord].ravel(), np.tile(chord, 4)
    order = np.argsort(cell, kind="stable")
    cell, chord = cell[order], chord[order]
    left, right = np.searchsorted(cell, asked, "left"), np.searchsorted(cell, asked, "right")
    size = right - left
    index = np.repeat(left - np.cumsum(size) + size, size) + np.arange(int(size.sum()))
    code = np.unique(np.repeat(np.tile(probe, 4), size) * len(box) + chord[index])
    return code // len(box), code % len(box)


def find_crossings(problem: ProfileProblem, end_node: IntArray) -> Crossings:
    """Find where a bridge passes over another road, or a tunnel under one, by their layers.

    `end_node`, (2 R,), is the node that each road end lies at.
    """
    chords = _cut_chords(problem)
    road, s, step, structure, layer = chords.road, chords.s, chords.step, chords.structure, chords.layer
    probe = np.flatnonzero(structure != Structure.GROUND)
    if not len(probe):
        none, nowhere = np.zeros(0, np.int64), np.zeros(0)
        return Crossings(none, nowhere, none, nowhere, nowhere)
    a, b = _pairs_in_cells(chords.box, probe)
    # Bridges above something, and tunnels below it.
    passes = np.where(layer[a] > layer[b], structure[a] == Structure.BRIDGE, structure[a] == Structure.TUNNEL)
    passes &= layer[a] != layer[b]
    a, b = a[passes], b[passes]
    cross, at_a, at_b = _intersections(chords.box, a, b)
    above, along = _on_top_of_each_other(problem, end_node, chords, a, b)
    above &= ~cross
    at_a, at_b = np.where(above, 0.5, at_a), np.where(above, along, at_b)
    cross |= above
    a, b, at_a, at_b = a[cross], b[cross], at_a[cross], at_b[cross]
    sa, sb = s[a] + at_a * step[a], s[b] + at_b * step[b]
    apart = ~_meet_nearby(problem, end_node, road[a], sa, road[b], sb)
    a, b, sa, sb = a[apart], b[apart], sa[apart], sb[apart]
    over = layer[a] > layer[b]
    upper, lower = np.where(over, road[a], road[b]), np.where(over, road[b], road[a])
    upper_s, lower_s = np.where(over, sa, sb), np.where(over, sb, sa)
    # Two structures find each other twice.
    key = np.column_stack([upper, lower, np.round(upper_s, 3), np.round(lower_s, 3)])
    once = np.sort(np.unique(key, axis=0, return_index=True)[1])
    upper, upper_s, lower, lower_s = (value[once] for value in (upper, upper_s, lower, lower_s))
    highway = [problem.span_highway[k] for k in span_at(problem, lower, lower_s).tolist()]
    clearance = np.array([CLEARANCE.get(name, CLEARANCE_OTHER) for name in highway], np.float64)
    return Crossings(upper, upper_s, lower, lower_s, clearance)


def _intersections(box: FloatArray, a: IntArray, b: IntArray) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Say which pairs of chords cross, and where, as shares of both chords."""
    u, v = box[a, 2:] - box[a, :2], box[b, 2:] - box[b, :2]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    d = box[b, :2] - box[a, :2]
    with np.errstate(divide="ignore", invalid="ignore"):
        at_a = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / cross
        at_b = (d[:, 0] * u[:, 1] - d[:, 1] * u[:, 0]) / cross
    return (at_a >= 0) & (at_a < 1) & (at_b >= 0) & (at_b < 1), at_a, at_b


def _on_top_of_each_other(
    problem: ProfileProblem, end_node: IntArray, chords: _Chords, a: IntArray, b: IntArray
) -> tuple[BoolArray, FloatArray]:
    """Say for pairs of chords whether they run one above the other (double decks), and where on b the middle of a is.

    Away from its ends a structure may also lie over a part only of what runs along it; near them that might follow
    from guessed widths alone. Roads that meet at a node are left out: a ramp comes down onto the road beside it.
    """
    box = chords.box
    u, v = box[a, 2:] - box[a, :2], box[b, 2:] - box[b, :2]
    off = box[a, :2] + 0.5 * u - box[b, :2]
    long = np.maximum(np.hypot(*v.T), _SHORTEST)
    along = (off * v).sum(axis=1) / long**2
    aside = np.abs(off[:, 0] * v[:, 1] - off[:, 1] * v[:, 0]) / long
    sine = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (np.maximum(np.hypot(*u.T), _SHORTEST) * long)
    if problem.span_width is None:
        return np.zeros(len(a), bool), along
    one, other = problem.span_width[chords.span[a]], problem.span_width[chords.span[b]]
    inner = _within_structure(chords)[a]
    shared = np.where(inner, 0.5 * (one + other) - _SHARED_WIDTH, 0.5 * np.minimum(one, other))
    anywhere = np.zeros(len(a))
    meet = _meet_nearby(problem, end_node, chords.road[a], anywhere, chords.road[b], anywhere, near=np.inf)
    out: BoolArray = (along >= 0) & (along < 1) & (aside < shared) & (sine < PARALLEL_SINE) & ~meet
    return out, along


def _within_structure(chords: _Chords) -> BoolArray:
    """Return which chords lie on a structure and farther than `_NEAR_NODE` from where it or its road ends."""
    road, s, structure = chords.road, chords.s, chords.structure
    border = np.r_[True, (road[1:] != road[:-1]) | (structure[1:] != structure[:-1]), True]
    first = np.flatnonzero(border[:-1])
    run = np.cumsum(border[:-1]) - 1
    last = np.r_[first[1:], len(road)] - 1
    on = structure != Structure.GROUND
    out: BoolArray = on & (s - s[first][run] > _NEAR_NODE) & (s[last][run] - s > _NEAR_NODE)
    return out


def _meet_nearby(
    problem: ProfileProblem,
    end_node: IntArray,
    a: IntArray,
    sa: FloatArray,
    b: IntArray,
    sb: FloatArray,
    near: float = _NEAR_NODE,
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
