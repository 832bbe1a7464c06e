"""Where lines across streets meet kerbs and the outlines of carriageways; flat arrays over all streets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import Table, blocks, join_tables, ranks, repeated, sorted_unique
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.osmParsing.defaults import KERB_REACH

# Kerbs are part of an edge where their headings differ from the street's by at most this, degrees. A choice: less
# than what corners of junctions and heads of bays turn by.
_ALONG_DEG: Final = 20.0
# Areas with a slit of at most this between them are one, m. A choice: mappers draw to within decimetres.
_SLIT_MAX: Final = 0.3
# Length of the parts into which segments are divided, m: well below the reach.
_PART: Final = 5.0
# And the largest number of them: no kerb is straight for 2 km, and of a mistake that long a few parts may be missed.
_PARTS_MAX: Final = 400


@dataclass(frozen=True, slots=True, eq=False)
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


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """Places on streets with the line across the street there."""

    place: FloatArray  # (n, 2) Local x, y, m
    along: FloatArray  # (n, 2) Unit vectors along the street
    layer: IntArray  # (n,)


@dataclass(frozen=True, slots=True, eq=False)
class Crossings(Table):
    """Places where the lines across streets meet segments, in ascending station and t."""

    station: IntArray  # (n,)
    owner: IntArray  # (n,) Number of the line that the segment is of
    t: FloatArray  # (n,) To the left of the street, m
    along: BoolArray  # (n,) Whether the segment runs along the street


def find_crossings(stations: Stations, segments: Segments) -> Crossings:
    """Return where the lines across streets meet segments of the same layer within `KERB_REACH`."""
    tree = cKDTree(stations.place)
    every = join_tables(_crossings(stations, tree, segments.chosen(rows)) for rows in blocks(len(segments.owner)))
    return every.chosen(np.lexsort((every.owner, every.t, every.station)))


def _crossings(stations: Stations, tree: cKDTree, segments: Segments) -> Crossings:
    """Return where the lines across streets meet segments, in any order; `tree` has the places of the stations."""
    step = segments.end - segments.start
    length = np.hypot(step[:, 0], step[:, 1])
    parts = np.clip(np.ceil(length / _PART), 1.0, _PARTS_MAX).astype(np.int64)
    segment = repeated(parts)
    share = (ranks(parts) + 0.5) / parts[segment]
    middle = segments.start[segment] + share[:, None] * step[segment]
    reach = float(np.hypot(KERB_REACH, _PART))
    near = tree.sparse_distance_matrix(cKDTree(middle), reach, output_type="ndarray")
    # Several parts of a segment may lie near a station.
    pairs = sorted_unique(near["i"].astype(np.int64) * len(parts) + segment[near["j"]])
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
    along = np.abs(other_ahead[row] - one_ahead[row]) >= np.cos(np.radians(_ALONG_DEG)) * length[of]
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
