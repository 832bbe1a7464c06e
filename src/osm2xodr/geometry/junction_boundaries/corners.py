"""What bounds a junction between one arm and the next: the edge of one connecting road, or of two that cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import hypot, ranks, repeated, unique_first
from osm2xodr.geometry.junction_boundaries import defaults
from osm2xodr.geometry.junction_boundaries.arms import Arms
from osm2xodr.geometry.junction_boundaries.edges import Edges, edge_lines
from osm2xodr.geometry.junction_boundaries.lines import crossings, near_segments, products
from osm2xodr.model import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Pieces of edges, in the order of arms and counter-clockwise behind each of them, (n,)."""

    arm: IntArray
    edge: IntArray  # Number of the edge, as of `Edges`
    # s where they begin and end, m
    begin: FloatArray
    end: FloatArray
    gap: FloatArray  # (arms,) Distance between the ends of pieces that should meet, m

    def replaced(self, arms: IntArray, other: Pieces) -> Pieces:
        """Return pieces in which those behind some arms are others."""
        keep = ~np.isin(self.arm, arms)
        arm = np.concatenate([self.arm[keep], other.arm])
        order = np.argsort(arm, kind="stable")
        edge, begin, end = (
            np.concatenate([getattr(self, k)[keep], getattr(other, k)])[order] for k in ("edge", "begin", "end")
        )
        gap = self.gap.copy()
        gap[arms] = other.gap[arms]
        return Pieces(arm[order], edge, begin, end, gap)


def first_edges(arms: Arms) -> tuple[IntArray, IntArray, BoolArray]:
    """Return the edges that bound junctions where they leave an arm and reach the next, and which are the same."""
    near = defaults.SAME_EDGE
    leaves = arms.left >= arms.outer_left[arms.arm] - near
    arrives = arms.right <= arms.outer_right[arms.arm] + near
    # The other end of each connecting road, and how many arms farther counter-clockwise that lies.
    other = np.arange(len(arms.arm)) ^ 1
    count = arms.count[arms.arm]
    ahead = (arms.rank[arms.arm[other]] - arms.rank[arms.arm]) % count
    back = np.where(ahead == 0, count, count - ahead)
    ahead = np.where(ahead == 0, count, ahead)
    direct = leaves & arrives[other] & (arms.arm[other] == arms.following[arms.arm])
    # The outermost ones: those that lead to the nearest arm, then those that reach farthest aside.
    first = _best(arms, leaves, (arms.left - arms.right[other], -ahead, direct))
    second = _best(arms, arrives, (arms.left[other] - arms.right, -back))[arms.following]
    along = direct[first]
    # An edge has the number of the end that it leaves with the junction on its left.
    return first, np.where(along, first, second ^ 1), along


def _best(arms: Arms, good: BoolArray, keys: tuple[FloatArray | IntArray | BoolArray, ...]) -> IntArray:
    """Return for each arm the end with the greatest keys, the last one first, of those that are good, (arms,)."""
    rounded = [np.round(np.asarray(key, float), 1) for key in keys]
    order = np.lexsort((-np.arange(len(good)), *rounded, good, arms.arm))
    return np.asarray(order[np.searchsorted(arms.arm[order], np.arange(len(arms.road)), side="right") - 1])


def find_pieces(arms: Arms, edges: Edges) -> Pieces:
    """Return what bounds junctions between neighbouring arms: one edge, or one and another that it meets."""
    first, second, along = first_edges(arms)
    split = np.flatnonzero(~along)
    leave, join, gap = np.zeros((3, len(first)))
    leave[split], join[split], gap[split] = _meetings(first[split], second[split], edges)
    count = np.where(along, 1, 2)
    arm = repeated(count)
    last = ranks(count) > 0
    edge = np.where(last, second[arm], first[arm])
    length = edges.length[edge // 2]
    whole = np.where(edge % 2 == 0, length, 0.0)
    begin = np.where(last, join[arm], length - whole)
    return Pieces(arm, edge, begin, np.where(last | along[arm], whole, leave[arm]), gap)


def _meetings(first: IntArray, second: IntArray, edges: Edges) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where edges meet others, s on either, and their distance there, (n,), m: the first crossing on the way.

    Those that do not cross meet where they are nearest.
    """
    one, other = edge_lines(edges, first), edge_lines(edges, second)
    every = np.arange(len(first))
    a, b, pair = near_segments(one, other, every, every)
    u, v, _ = crossings(one, other, a, b)
    rows = np.flatnonzero(~np.isnan(u))
    rows = rows[np.lexsort((a[rows] + u[rows], pair[rows]))]
    crossing, best = unique_first(pair[rows])
    best = rows[best]
    leave, join, distance = np.zeros((3, len(first)))
    leave[crossing], join[crossing] = one.between(a[best], u[best]), other.between(b[best], v[best])
    apart = np.setdiff1d(every, crossing)
    a, b, pair = products(one.start[apart], one.start[apart + 1], other.start[apart], other.start[apart + 1])
    between = hypot(*(other.xy[b] - one.xy[a]).T)
    nearest = np.lexsort((a, between, pair))
    nearest = nearest[unique_first(pair[nearest])[1]]
    leave[apart], join[apart], distance[apart] = one.s[a[nearest]], other.s[b[nearest]], between[nearest]
    return leave, join, distance
