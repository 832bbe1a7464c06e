"""Lines of points, and where they cross."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import owners, ranks, runs, starts
from osm2xodr.model import FloatArray, IntArray

# Lines are compared in parts of so many segments, whose bounding boxes overlap.
_SEGMENTS: Final = 6


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Lines along roads, in the direction in which their junction lies left of them."""

    start: IntArray  # (lines + 1,) Index of the first point of each line
    s: FloatArray  # (points,) m
    xy: FloatArray  # (points, 2) m

    def between(self, k: IntArray, share: FloatArray) -> FloatArray:
        """Return s at a share of the way from points k to those that follow, (n,), m."""
        return np.asarray(self.s[k] + share * (self.s[k + 1] - self.s[k]))


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """Parts of lines."""

    start: IntArray  # (lines + 1,) Index of each line's first part
    # (parts,) Their first segment and that behind their last, by the index of the point that it begins at
    begin: IntArray
    end: IntArray
    # (parts, 2) Bounding box, m
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, lines: Lines) -> _Parts:
        """Return all parts of lines."""
        count = -(-(np.diff(lines.start) - 1) // _SEGMENTS)
        owner = owners(starts(count))
        begin = lines.start[:-1][owner] + _SEGMENTS * ranks(count)
        end = np.minimum(begin + _SEGMENTS, lines.start[1:][owner] - 1)
        points, first = lines.xy[runs(begin, end + 1 - begin)], starts(end + 1 - begin)[:-1]
        return cls(starts(count), begin, end, np.minimum.reduceat(points, first), np.maximum.reduceat(points, first))


def near_segments(one: Lines, other: Lines, row: IntArray, line: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pairs of segments of lines `row` of one and `line` of the other that may cross.

    Segments are named by the index of the point that they begin at, the third is the index of the pair of lines.
    """
    if not len(row):
        return row, line, row
    p, q = _Parts.of(one), _Parts.of(other)
    a, b, pair = products(p.start[row], p.start[row + 1], q.start[line], q.start[line + 1])
    near = ((p.low[a] <= q.high[b]) & (q.low[b] <= p.high[a])).all(axis=1)
    a, b, pair = a[near], b[near], pair[near]
    i, j, part = products(p.begin[a], p.end[a], q.begin[b], q.end[b])
    return i, j, pair[part]


def products(
    first: IntArray, last: IntArray, other_first: IntArray, other_last: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return all pairs of the numbers of two ranges each, up to before their last, and the ranges' index."""
    count = other_last - other_first
    pairs = (last - first) * count
    owner, rank = owners(starts(pairs)), ranks(pairs)
    return first[owner] + rank // count[owner], other_first[owner] + rank % count[owner], owner


def crossings(one: Lines, other: Lines, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where segments a of one and b of the other cross, as shares of either; NaN where they do not.

    The third is positive where the other one goes over to the left, negative where to the right.
    """
    p, q = one.xy[a], other.xy[b]
    along, across, between = one.xy[a + 1] - p, other.xy[b + 1] - q, q - p
    turned = _cross(along, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = _cross(between, across) / turned, _cross(between, along) / turned
        none = ~((u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0))
    u[none] = np.nan
    return u, v, turned


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
