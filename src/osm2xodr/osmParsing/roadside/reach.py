"""Points along streets, and which other points lie near them; flat arrays over all streets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    hypot,
    ranks,
    repeated,
    sorted_unique,
    starts,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray, Street, StreetAttributes
from osm2xodr.osmParsing.defaults import BESIDE_SPACING, ROADSIDE_REACH
from osm2xodr.system import record

# Radius of the search around streets, m: more than the reach plus half of any carriageway.
_SEARCH_RADIUS: Final = 48.0
# Cells of the search grid in a row: with cells of 15 m it reaches round the Earth four hundred times.
_CELLS: Final = 2**30


@record(eq=False)
class LineSamples:
    """Points along lines, in the middle of equal parts of their segments."""

    points: FloatArray  # (n, 2) Local x, y, m
    along: FloatArray  # (n, 2) Unit vectors along the line
    length: FloatArray  # (n,) Length of the parts, m
    node: IntArray  # (n,) Index of the node at which the segment begins, counted over all lines


@record(eq=False)
class StreetSamples:
    """Points along all streets."""

    lines: LineSamples  # The points
    piece: IntArray  # (n,) Number of the piece of street that each lies on, counted over all streets
    # (m,) Of each piece: its street, and its index in `Street.pieces`
    street: IntArray
    index: IntArray
    # (m,) Of each piece: t of the outer edges of carriageway and margins, left positive, m
    left: FloatArray
    right: FloatArray

    def piece_lengths(self) -> FloatArray:
        """Return the length of each piece (m,), m."""
        lengths: FloatArray = np.bincount(self.piece, self.lines.length, len(self.street)).astype(np.float64)
        return lengths


def sample_lines(points: FloatArray, counts: IntArray, spacing: float) -> LineSamples:
    """Place points along lines, at most `spacing` apart, m.

    `points` (n, 2) are the nodes of all lines, line after line, m; `counts` (m,) the number of nodes of each.
    """
    last = np.zeros(len(points), np.bool_)
    last[np.cumsum(counts) - 1] = True
    node = np.flatnonzero(~last)
    step = points[node + 1] - points[node]
    length = hypot(step[:, 0], step[:, 1])
    node, step, length = node[length > 0.0], step[length > 0.0], length[length > 0.0]
    parts = np.maximum(np.ceil(length / spacing), 1.0).astype(np.int64)
    segment = repeated(parts)
    number = ranks(parts)
    share = (number + 0.5) / parts[segment]
    return LineSamples(
        points[node[segment]] + share[:, None] * step[segment],
        (step / length[:, None])[segment],
        (length / parts)[segment],
        node[segment],
    )


def sample_streets(streets: Sequence[Street]) -> StreetSamples:
    """Place points along streets, at most `BESIDE_SPACING` apart."""
    counts = np.array([len(street.points) for street in streets], np.int64)
    lines = sample_lines(np.concatenate([street.points for street in streets]), counts, BESIDE_SPACING)
    return with_pieces(lines, streets)


def with_pieces(lines: LineSamples, streets: Sequence[Street]) -> StreetSamples:
    """Assign points along streets to the pieces that they lie on."""
    counts = np.array([len(street.points) for street in streets], np.int64)
    pieces = [len(street.pieces) for street in streets]
    first = np.repeat(starts(counts)[:-1], pieces)
    begin = first + np.array([at for street in streets for at, _ in street.pieces], np.int64)
    edges = np.array([carriageway_edges(attributes) for street in streets for _, attributes in street.pieces])
    index = np.array([k for number in pieces for k in range(number)], np.int64)
    return StreetSamples(
        lines,
        np.searchsorted(begin, lines.node, side="right") - 1,
        repeated(pieces),
        index,
        edges[:, 0],
        edges[:, 1],
    )


def carriageway_edges(attributes: StreetAttributes) -> tuple[float, float]:
    """Return t of the left and right outer edge of carriageway and tagged margins, m."""
    half = 0.5 * sum([lane.width for lane in attributes.lanes_ltr])
    left = attributes.middle_offset + half + sum([strip.width for strip in attributes.margin_left])
    return left, attributes.middle_offset - half - sum([strip.width for strip in attributes.margin_right])


def near_streets(samples: StreetSamples, points: FloatArray) -> BoolArray:
    """Return which points (n, 2) lie within `ROADSIDE_REACH` of a street's edge, (n,)."""
    near = np.isfinite(points).all(axis=1)
    candidates, chosen = near_each_other(points[near], samples.lines.points, _SEARCH_RADIUS)
    near[near] = candidates
    if not chosen.any() or not near.any():
        return np.zeros(len(points), np.bool_)
    distance, number = PointTree(samples.lines.points[chosen]).nearest(points[near], _SEARCH_RADIUS)
    found = number >= 0
    piece = samples.piece[chosen][number[found]]
    half = np.maximum(samples.left[piece], -samples.right[piece])
    found[found] = distance[found] <= ROADSIDE_REACH + half
    near[near] = found
    out: BoolArray = near
    return out


def near_each_other(a: FloatArray, b: FloatArray, reach: float) -> tuple[BoolArray, BoolArray]:
    """Return roughly which of two sets of points, (n, 2) and (m, 2), have a point of the other set within reach, m.

    None is missed, but all points in adjacent cells of that size count.
    """
    cells_a, cells_b = _cells(a, reach), _cells(b, reach)
    b_near: BoolArray = np.isin(cells_b, _with_adjacent(cells_a))
    a_near: BoolArray = np.isin(cells_a, _with_adjacent(cells_b[b_near]))
    return a_near, b_near


def _cells(points: FloatArray, size: float) -> IntArray:
    at = np.floor(points / size).astype(np.int64) + _CELLS // 2
    out: IntArray = at[:, 0] * _CELLS + at[:, 1]
    return out


def _with_adjacent(cells: IntArray) -> IntArray:
    """Return cells and those adjacent to them, ascending."""
    own = sorted_unique(cells)
    return sorted_unique(np.concatenate([own + dx * _CELLS + dy for dx in (-1, 0, 1) for dy in (-1, 0, 1)]))
