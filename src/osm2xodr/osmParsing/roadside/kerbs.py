"""Where the edges of carriageways are, by the kerbs that OSM maps along them.

Kerbs are lines (``barrier=kerb``) or the outlines of areas (``area:highway``). They are looked for on both sides of
points along each way; what these say holds for the whole way, as a tag would.
"""

from __future__ import annotations

from collections.abc import Sequence, Set as AbstractSet
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import owners, sorted_unique, starts, sum_before, unique_first
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.defaults import BESIDE_SPACING, KERB_REACH, KERBS_SCATTER, MOUTH_LENGTH
from osm2xodr.osmParsing.file import RawNodes, RawWay
from osm2xodr.osmParsing.roadside.even_kerbs import even_out, kerbs_about
from osm2xodr.osmParsing.roadside.kerb_crossings import (
    Crossings,
    Segments,
    Stations,
    covered_edges,
    find_crossings,
    nearest_edges,
)
from osm2xodr.osmParsing.roadside.reach import LineSamples, near_each_other, sample_lines
from osm2xodr.osmParsing.roadside.tags import is_carriageway_area, is_kerb
from osm2xodr.osmParsing.tags import Kerbs, Tags, layer_of, structure_of

# Least number of points along a way at which kerbs are found. A choice: 20 m of street.
_POINTS_MIN: Final = 4
# Least share of a way's points. Of 317 ways in Berlin the first quarter tells the width of the rest to 0.10 m (mean)
# and its middle to 0.20; by their tags these are off by 1.28 and 0.45.
_SHARE_MIN: Final = 0.2
# A way does not cross its own line beside it nearer than this, m.
_OWN_LINE: Final = 0.1
# Kerbs beside aisles of car parks stand beyond the bays.
_WITHOUT_KERBS: Final = frozenset({"parking_aisle"})
# Classes of ways whose mouths do not interrupt the kerbs of the streets that they join.
_WITHOUT_MOUTHS: Final = frozenset({"service", "track"})


@dataclass(frozen=True, slots=True, eq=False)
class WayPieces:
    """Ways, cut into pieces where they meet."""

    points: FloatArray  # (n, 2) Local x, y of the nodes, piece after piece, m
    node: IntArray  # (n,) Number of each node
    count: IntArray  # (m,) Number of nodes of each piece
    way: IntArray  # (m,) Index of the way of each piece

    def way_lengths(self, ways: int) -> FloatArray:
        """Return the lengths of so many ways, (ways,), m."""
        step = np.hypot(*np.diff(self.points, axis=0).T)
        last = np.cumsum(self.count) - 1
        step[last[:-1]] = 0.0  # From one piece to the next
        length = np.add.reduceat(np.append(step, 0.0), last - self.count + 1)
        return np.bincount(self.way, length, ways).astype(np.float64)


def kerbs_along(
    ways: Sequence[RawWay],
    pieces: WayPieces,
    beside: Sequence[RawWay],
    nodes: RawNodes,
    points: FloatArray,
    without: AbstractSet[int],
) -> dict[int, Kerbs]:
    """Return the kerbs that are mapped along ways, by index of the way.

    `pieces` are those of the `ways`; `beside` other ways, among them kerbs; `points` (k, 2) the local x, y of the
    `nodes`, m. Ways whose OSM id is in `without` are left out.
    """
    lines = _segments([way for way in beside if is_kerb(way.tags)], nodes, points)
    outlines = _segments([way for way in beside if is_carriageway_area(way.tags)], nodes, points)
    if not len(lines.start) and not len(outlines.start):
        return {}
    samples = sample_lines(pieces.points, pieces.count, BESIDE_SPACING)
    piece = owners(starts(pieces.count))[samples.node]
    way = pieces.way[piece]
    told = np.array([item.id not in without and item.tags.get("service") not in _WITHOUT_KERBS for item in ways])
    ends = np.concatenate([lines.start, lines.end, outlines.start, outlines.end])
    near = near_each_other(samples.points, ends, 2.0 * KERB_REACH)[0]
    used = np.flatnonzero(near & told[way] & ~_in_mouths(ways, pieces, samples, piece))
    if not len(used):
        return {}
    layers, with_kerbs = np.zeros(len(ways), np.int64), sorted_unique(way[near])
    layers[with_kerbs] = [_layer(ways[index].tags) for index in with_kerbs.tolist()]
    stations = Stations(samples.points[used], samples.along[used], layers[way[used]])
    left, right = covered_edges(find_crossings(stations, outlines), len(used))
    nearest_left, nearest_right = nearest_edges(find_crossings(stations, lines), len(used))
    uncovered = np.isnan(left) & np.isnan(right)
    left, right = np.where(uncovered, nearest_left, left), np.where(uncovered, nearest_right, right)
    half = 0.5 * samples.length[near][:, None] * samples.along[near]
    start, end = samples.points[near] - half, samples.points[near] + half
    others = find_crossings(stations, Segments(start, end, piece[near], layers[way[near]]))
    _forget_beyond(others, piece[used], left, right)
    found = _of_ways(np.bincount(way, minlength=len(ways)), way[used], left, right)
    return even_out(ways, found, pieces.way_lengths(len(ways)))


def _layer(tags: Tags) -> int:
    return layer_of(tags, structure_of(tags), [])


def _segments(kerbs: Sequence[RawWay], nodes: RawNodes, points: FloatArray) -> Segments:
    """Return the segments of kerbs all of whose nodes are known."""
    found, layers = [], []
    for way in kerbs:
        refs = np.asarray(way.refs, np.int64)
        row = np.minimum(np.searchsorted(nodes.ids, refs), len(nodes.ids) - 1)
        if len(refs) > 1 and (nodes.ids[row] == refs).all() and np.isfinite(points[row]).all():
            found.append(points[row])
            layers.append(_layer(way.tags))
    return Segments.of_lines(found, layers)


def _in_mouths(ways: Sequence[RawWay], pieces: WayPieces, samples: LineSamples, piece: IntArray) -> BoolArray:
    """Return which points along ways lie within `MOUTH_LENGTH` of where three streets meet, (n,)."""
    last = np.cumsum(pieces.count) - 1
    ends = np.column_stack([pieces.node[last - pieces.count + 1], pieces.node[last]])
    with_mouths = np.array([way.tags["highway"] not in _WITHOUT_MOUTHS for way in ways], np.bool_)[pieces.way]
    meeting = np.bincount(ends[with_mouths].ravel(), minlength=int(ends.max(initial=0)) + 1) > 2
    begin = starts(np.bincount(piece, minlength=len(pieces.count)))
    before = sum_before(samples.length, begin) + 0.5 * samples.length
    total = np.bincount(piece, samples.length, len(pieces.count))
    start, end = meeting[ends[piece]].T
    out: BoolArray = (start & (before < MOUTH_LENGTH)) | (end & (total[piece] - before < MOUTH_LENGTH))
    return out


def _forget_beyond(others: Crossings, piece: IntArray, left: FloatArray, right: FloatArray) -> None:
    """Forget edges of stations, t, (n,), m, that lie beyond another street; `piece` (n,) are the stations' own."""
    own = (np.abs(others.t) < _OWN_LINE) & (piece[others.station] == others.owner)
    for edge, t in ((left, others.t), (right, -others.t)):
        between = ~own & (t >= 0.0) & (t < np.abs(edge[others.station]))
        edge[others.station[between]] = np.nan


def _of_ways(points: IntArray, way: IntArray, left: FloatArray, right: FloatArray) -> dict[int, Kerbs]:
    """Return the kerbs of each way by what points along it say: t of the left and right edge, (n,), m.

    `points` (ways,) is the number of all points along each way.
    """
    out: dict[int, Kerbs] = {}
    known = np.isfinite(left) | np.isfinite(right)
    order = np.flatnonzero(known)[np.argsort(way[known], kind="stable")]
    numbers, first = unique_first(way[order])
    for number, rows in zip(numbers.tolist(), np.split(order, first[1:]) if len(first) else (), strict=True):
        least = max(_POINTS_MIN, _SHARE_MIN * float(points[number]))
        width, aside = (_agreed(values, least) for values in (left[rows] - right[rows], left[rows] + right[rows]))
        if width is not None and aside is not None:
            out[number] = kerbs_about(width, aside / 2.0)
            continue
        one, other = _agreed(left[rows], least), _agreed(right[rows], least)
        # Both, but not at the same places, tell no width.
        if (one is None) != (other is None):
            out[number] = Kerbs(*(None if edge is None else round(edge, 1) for edge in (one, other)))
    return out


def _agreed(values: FloatArray, least: float) -> float | None:
    """Return the median of the values that are known if there are enough of them, and they agree."""
    values = values[np.isfinite(values)]
    if len(values) < least:
        return None
    low, middle, high = np.quantile(values, (0.25, 0.5, 0.75)).tolist()
    return float(middle) if high - low <= KERBS_SCATTER else None
