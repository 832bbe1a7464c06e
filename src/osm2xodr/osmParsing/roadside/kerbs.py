"""Where the edges of carriageways are, by the kerbs that OSM maps along them.

Kerbs are lines (``barrier=kerb``) or the outlines of areas (``area:highway``). They are looked for on both sides of
points along each way; what these say holds for the whole way, as a tag would. Ways of one street whose kerbs hardly
differ get the same ones, so that its lanes do not shift at each of them.

Lines across all streets are met with kerbs and outlines at once, in flat arrays.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence, Set as AbstractSet
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.curves import (
    PointTree,
    Table,
    blocks,
    cosine,
    hypot,
    join_tables,
    owners,
    ranks,
    repeated,
    sorted_unique,
    starts,
    sum_before,
    unique_first,
)
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.defaults import BESIDE_SPACING, KERB_REACH, KERB_RETURN_LENGTH, KERBS_SCATTER
from osm2xodr.osmParsing.file import RawNodes, RawWay
from osm2xodr.osmParsing.roadside.reach import LineSamples, near_each_other, sample_lines
from osm2xodr.osmParsing.roadside.things import is_carriageway_area, is_kerb
from osm2xodr.osmParsing.tags import Kerbs, Tags, ends_of_streets, layer_of, street_of, structure_of
from osm2xodr.system import record

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
_WITHOUT_RETURNS: Final = frozenset({"service", "track"})
# Kerbs are part of an edge where their headings differ from the street's by at most this, degrees. A choice: less
# than what corners of junctions and heads of bays turn by.
_ALONG_DEG: Final = 20.0
# Areas with a slit of at most this between them are one, m. A choice: mappers draw to within decimetres.
_SLIT_MAX: Final = 0.3
# Length of the parts into which segments are divided, m: well below the reach.
_PART: Final = 5.0
# And the largest number of them: no kerb is straight for 2 km, and of a mistake that long a few parts may be missed.
_PARTS_MAX: Final = 400

# Carriageways whose widths, and whose middles, differ by no more than this, m, are one. A choice: kerbs are drawn no
# better than to a quarter of a metre on both sides.
SAME_CARRIAGEWAY: Final = 0.5
# Distances and middles have so many digits, m: kerbs are drawn no better, and ways of a street become alike.
_DIGITS: Final = 1


@dataclass(frozen=True, eq=False)
class WayPieces:
    """Ways, cut into pieces where they meet."""

    points: FloatArray  # (n, 2) Local x, y of the nodes, piece after piece, m
    node: IntArray  # (n,) Number of each node
    count: IntArray  # (m,) Number of nodes of each piece
    way: IntArray  # (m,) Index of the way of each piece

    @cached_property
    def samples(self) -> LineSamples:
        """Points along all pieces, at most `BESIDE_SPACING` apart."""
        return sample_lines(self.points, self.count, BESIDE_SPACING)

    @cached_property
    def piece_of_sample(self) -> IntArray:
        """The piece that each of them is on."""
        return owners(starts(self.count))[self.samples.node]

    def way_lengths(self, ways: int) -> FloatArray:
        """Return the lengths of so many ways, (ways,), m."""
        step = hypot(*np.diff(self.points, axis=0).T)
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
    lines = segments_of([way for way in beside if is_kerb(way.tags)], nodes, points)
    outlines = segments_of([way for way in beside if is_carriageway_area(way.tags)], nodes, points)
    if not len(lines.start) and not len(outlines.start):
        return {}
    usable = np.array([item.id not in without and item.tags.get("service") not in _WITHOUT_KERBS for item in ways])
    along = stations_near(
        ways, pieces, usable, np.concatenate([lines.start, lines.end, outlines.start, outlines.end])
    )
    if along is None:
        return {}
    count = len(along.way)
    left, right = covered_edges(find_crossings(along.stations, outlines), count)
    nearest_left, nearest_right = nearest_edges(find_crossings(along.stations, lines), count)
    uncovered = np.isnan(left) & np.isnan(right)
    left, right = np.where(uncovered, nearest_left, left), np.where(uncovered, nearest_right, right)
    along.forget_beyond(left, right)
    found = _of_ways(along.points, along.way, left, right)
    return even_out(ways, found, pieces.way_lengths(len(ways)))


@record(eq=False)
class StationsOfWays:
    """Places along ways, and what crosses the lines across them there."""

    stations: Stations
    way: IntArray  # (n,) Index of the way of each
    points: IntArray  # (ways,) Number of all points along each way, used or not
    streets: Crossings  # Where these lines meet streets other than the own one

    def forget_beyond(self, left: FloatArray, right: FloatArray) -> None:
        """Forget edges of stations, t, (n,), m, that lie beyond another street."""
        at = self.streets.station
        for edge, t in ((left, self.streets.t), (right, -self.streets.t)):
            edge[at[(t >= 0.0) & (t < np.abs(edge[at]))]] = np.nan


def stations_near(
    ways: Sequence[RawWay], pieces: WayPieces, usable: BoolArray, ends: FloatArray
) -> StationsOfWays | None:
    """Return places along the `usable` ways, (ways,), near `ends` (n, 2), m, and off the mouths of other streets."""
    samples, piece = pieces.samples, pieces.piece_of_sample
    way = pieces.way[piece]
    near = near_each_other(samples.points, ends, 2.0 * KERB_REACH)[0]
    used = np.flatnonzero(near & usable[way] & ~_in_kerb_returns(ways, pieces))
    if not len(used):
        return None
    layers, with_near = np.zeros(len(ways), np.int64), sorted_unique(way[near])
    layers[with_near] = [_layer(ways[index].tags) for index in with_near.tolist()]
    stations = Stations(samples.points[used], samples.along[used], layers[way[used]])
    half = 0.5 * samples.length[near][:, None] * samples.along[near]
    start, end = samples.points[near] - half, samples.points[near] + half
    met = find_crossings(stations, Segments(start, end, piece[near], layers[way[near]]))
    own = (np.abs(met.t) < _OWN_LINE) & (piece[used][met.station] == met.owner)
    return StationsOfWays(stations, way[used], np.bincount(way, minlength=len(ways)), met.chosen(~own))


def _layer(tags: Tags) -> int:
    return layer_of(tags, structure_of(tags), [])


def segments_of(ways: Sequence[RawWay], nodes: RawNodes, points: FloatArray) -> Segments:
    """Return the segments of ways all of whose nodes are known."""
    found, layers = [], []
    for way in ways:
        refs = np.asarray(way.refs, np.int64)
        row = np.minimum(np.searchsorted(nodes.ids, refs), len(nodes.ids) - 1)
        if len(refs) > 1 and (nodes.ids[row] == refs).all() and np.isfinite(points[row]).all():
            found.append(points[row])
            layers.append(_layer(way.tags))
    return Segments.of_lines(found, layers)


def _in_kerb_returns(ways: Sequence[RawWay], pieces: WayPieces) -> BoolArray:
    """Return which samples of ways lie within `KERB_RETURN_LENGTH` of where three streets meet, (n,)."""
    samples, piece = pieces.samples, pieces.piece_of_sample
    last = np.cumsum(pieces.count) - 1
    ends = np.column_stack([pieces.node[last - pieces.count + 1], pieces.node[last]])
    with_returns = np.array([way.tags["highway"] not in _WITHOUT_RETURNS for way in ways], np.bool_)[pieces.way]
    meeting = np.bincount(ends[with_returns].ravel(), minlength=int(ends.max(initial=0)) + 1) > 2
    begin = starts(np.bincount(piece, minlength=len(pieces.count)))
    before = sum_before(samples.length, begin) + 0.5 * samples.length
    total = np.bincount(piece, samples.length, len(pieces.count))
    start, end = meeting[ends[piece]].T
    out: BoolArray = (start & (before < KERB_RETURN_LENGTH)) | (end & (total[piece] - before < KERB_RETURN_LENGTH))
    return out


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
        width, lateral = (_agreed(values, least) for values in (left[rows] - right[rows], left[rows] + right[rows]))
        if width is not None and lateral is not None:
            out[number] = kerbs_about(width, lateral / 2.0)
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


@record(eq=False)
class Segments(Table):
    """Straight segments of lines."""

    start: FloatArray  # (n, 2) Local x, y, m
    end: FloatArray  # (n, 2)
    owner: IntArray  # (n,) Number of the line
    layer: IntArray  # (n,)

    @classmethod
    def of_lines(cls, lines: Sequence[FloatArray], layers: Sequence[int]) -> Segments:
        """Return the segments of lines of points (n, 2), m, each with its layer."""
        count = np.array([len(line) - 1 for line in lines], np.int64)
        none = np.zeros((0, 2))
        owner = repeated(count)
        start, end = (np.concatenate([none, *(line[some] for line in lines)]) for some in (slice(-1), slice(1, None)))
        return cls(start, end, owner, np.array(layers, np.int64)[owner] if len(lines) else owner)


@record(eq=False)
class Stations:
    """Places on streets with the line across the street there."""

    place: FloatArray  # (n, 2) Local x, y, m
    along: FloatArray  # (n, 2) Unit vectors along the street
    layer: IntArray  # (n,)


@record(eq=False)
class Crossings(Table):
    """Places where the lines across streets meet segments, in ascending station and t."""

    station: IntArray  # (n,)
    owner: IntArray  # (n,) Number of the line that the segment is of
    t: FloatArray  # (n,) To the left of the street, m
    along: BoolArray  # (n,) Whether the segment runs along the street


def find_crossings(stations: Stations, segments: Segments) -> Crossings:
    """Return where the lines across streets meet segments of the same layer within `KERB_REACH`."""
    tree = PointTree(stations.place)
    every = join_tables(
        _crossings(stations, tree, segments.chosen(rows)) for rows in blocks(max(len(segments.owner), 1))
    )
    return every.chosen(np.lexsort((every.owner, every.t, every.station)))


def _crossings(stations: Stations, tree: PointTree, segments: Segments) -> Crossings:
    """Return where the lines across streets meet segments, in any order; `tree` has the places of the stations."""
    step = segments.end - segments.start
    length = hypot(step[:, 0], step[:, 1])
    parts = np.clip(np.ceil(length / _PART), 1.0, _PARTS_MAX).astype(np.int64)
    segment = repeated(parts)
    share = (ranks(parts) + 0.5) / parts[segment]
    middle = segments.start[segment] + share[:, None] * step[segment]
    reach = float(hypot(KERB_REACH, _PART))
    at_part, station = tree.within(middle, reach)
    # Several parts of a segment may lie near a station.
    pairs = sorted_unique(station * len(parts) + segment[at_part])
    at, of = pairs // len(parts), pairs % len(parts)
    same = stations.layer[at] == segments.layer[of]
    at, of = at[same], of[same]
    ahead, left = stations.along[at], stations.along[at][:, ::-1] * (-1.0, 1.0)
    one, other = segments.start[of] - stations.place[at], segments.end[of] - stations.place[at]
    one_ahead, other_ahead = (one * ahead).sum(axis=1), (other * ahead).sum(axis=1)
    # Half open, so that a node between two segments counts once.
    row = np.flatnonzero((one_ahead < 0.0) != (other_ahead < 0.0))
    at, of, left, one, other = at[row], of[row], left[row], one[row], other[row]
    share = one_ahead[row] / (one_ahead[row] - other_ahead[row])
    t = ((one + share[:, None] * (other - one)) * left).sum(axis=1)
    along = np.abs(other_ahead[row] - one_ahead[row]) >= cosine(np.radians(_ALONG_DEG)) * length[of]
    return Crossings(at, segments.owner[of], t, along).chosen(np.abs(t) <= KERB_REACH)


def nearest_edges(crossings: Crossings, count: int) -> tuple[FloatArray, FloatArray]:
    """Return t of the nearest line on the left and the right of each station, (count,), m.

    It is NaN where there is none, or where it does not run along.
    """
    out = np.full((2, count), np.nan)
    first = np.searchsorted(crossings.station, np.arange(count))
    left = crossings.t > 0.0
    # Those on the right come before those on the left.
    middle = first + np.bincount(crossings.station[~left], minlength=count)
    after = np.append(first[1:], len(crossings.t))
    for side, row, there in ((0, middle, middle < after), (1, middle - 1, middle > first)):
        at = np.flatnonzero(there)
        at = at[crossings.along[row[at]]]
        out[side, at] = crossings.t[row[at]]
    return out[0], out[1]


def covered_edges(crossings: Crossings, count: int) -> tuple[FloatArray, FloatArray]:
    """Return t of the left and right edge of the areas that cover each station, together, (count,), m.

    The crossings are those of closed outlines. It is NaN where none covers the station, where a part of an outline
    is out of reach, and where an edge does not run along.
    """
    order = np.lexsort((crossings.t, crossings.owner, crossings.station))
    station, owner = crossings.station[order], crossings.owner[order]
    begins = np.ones(len(order), np.bool_)
    begins[1:] = (station[1:] != station[:-1]) | (owner[1:] != owner[:-1])
    sizes = np.diff(np.append(np.flatnonzero(begins), len(order)))
    # From the right to the left each outline is entered and left in turns.
    enters = ranks(sizes) % 2 == 0
    broken = np.isin(station, station[begins][sizes % 2 == 1])
    order, station, enters = order[~broken], station[~broken], enters[~broken]
    # Slits close if each area is wider by half of one.
    t = crossings.t[order] + np.where(enters, -0.5, 0.5) * _SLIT_MAX
    again = np.lexsort((~enters, t, station))
    station, enters, t, along = station[again], enters[again], t[again], crossings.along[order[again]]
    depth = np.cumsum(np.where(enters, 1, -1))
    row = np.flatnonzero(np.where(enters, depth == 1, depth == 0))
    right, left = row[0::2], row[1::2]
    covers = (t[right] < 0.0) & (t[left] > 0.0)
    out = np.full((2, count), np.nan)
    for side, edge, inwards in ((0, left[covers], -0.5), (1, right[covers], 0.5)):
        edge = edge[along[edge]]
        out[side, station[edge]] = t[edge] + inwards * _SLIT_MAX
    return out[0], out[1]


def kerbs_about(width: float, middle: float) -> Kerbs:
    """Return kerbs by their distance and the t of their middle, m, rounded as they are drawn."""
    apart, lateral = round(width, _DIGITS), round(middle, _DIGITS)
    return Kerbs(lateral + apart / 2.0, lateral - apart / 2.0)


def even_out(ways: Sequence[RawWay], kerbs: Mapping[int, Kerbs], lengths: FloatArray) -> dict[int, Kerbs]:
    """Return kerbs along ways, by index, each with the means of those before and behind it that hardly differ.

    `lengths` (ways,) are those of the ways, m.
    """
    out = dict(kerbs)
    chosen = [way for way, item in kerbs.items() if item.apart is not None]
    for chain in street_chains(ways, [street_of(way.tags) for way in ways], chosen):
        first = 0
        for last in range(1, len(chain) + 1):
            if last < len(chain) and _alike([_seen(kerbs[way], along) for way, along in chain[first : last + 1]]):
                continue
            run = chain[first:last]
            first = last
            if len(run) > 1:
                seen = [_seen(kerbs[way], along) for way, along in run]
                left, right = np.average(seen, axis=0, weights=[lengths[way] for way, _ in run]).tolist()
                for way, along in run:
                    out[way] = kerbs_about(left - right, (left + right) / 2.0 if along else -(left + right) / 2.0)
    return out


def _seen(kerbs: Kerbs, along: bool) -> tuple[float, float]:
    """Return t of both kerbs as seen along or against the way, m."""
    assert kerbs.left is not None
    assert kerbs.right is not None
    return (kerbs.left, kerbs.right) if along else (-kerbs.right, -kerbs.left)


def _alike(edges: Sequence[tuple[float, float]]) -> bool:
    widths = [left - right for left, right in edges]
    middles = [(left + right) / 2.0 for left, right in edges]
    return max(max(widths) - min(widths), max(middles) - min(middles)) <= SAME_CARRIAGEWAY + 1e-9


def street_chains(
    ways: Sequence[RawWay], streets: Sequence[tuple[str, ...] | None], chosen: Collection[int]
) -> Iterator[list[tuple[int, bool]]]:
    """Yield chosen ways (by index) of one street, one behind the other, each with whether it runs along the chain.

    `streets` are those of the ways, as `street_of` has them. A street continues at a node where exactly two of its
    ways end.
    """
    among, done = frozenset(chosen), set[int]()
    wanted = {streets[way] for way in among}
    streets = [street if street in wanted else None for street in streets]
    meeting = ends_of_streets(ways, streets)

    def following(way: int, along: bool) -> tuple[int, bool] | None:
        street = streets[way]
        at = meeting.get((ways[way].refs[-1 if along else 0], street), []) if street is not None else []
        others = [other for other in at if other[0] != way]
        return others[0] if len(at) == 2 and len(others) == 1 and others[0][0] in among else None

    for index in sorted(among):
        if index in done:
            continue
        # To the end of the chain, and from there back.
        start, seen = (index, False), {index}
        while (ahead := following(*start)) is not None and ahead[0] not in seen:
            start = ahead
            seen.add(ahead[0])
        chain = [(start[0], not start[1])]
        done.add(start[0])
        while (ahead := following(*chain[-1])) is not None and ahead[0] not in done:
            chain.append(ahead)
            done.add(ahead[0])
        yield chain
