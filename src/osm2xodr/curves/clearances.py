"""Places where carriageways that do not meet lie over each other with little room between them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from osm2xodr.curves.overlaps import overlap_depths, overlapping_pairs
from osm2xodr.curves.point_tree import PointTree
from osm2xodr.curves.ragged import runs, sorted_unique, unique_inverse
from osm2xodr.curves.trigonometry import sine
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import record

# Length of the pieces that carriageways are to be cut into, m.
CLEARANCE_STEP: Final = 4.0
# Pairs of pieces that are measured at once; some 500 bytes each are needed on the way.
_BLOCK: Final = 1 << 16
# Pieces reach into each other by this at least, m: more than the error of widths.
_DEPTH: Final = 0.3
# Surfaces closer than this are one, m: more than a kerb.
_ONE_SURFACE: Final = 0.3
# Connecting roads of one junction count as one surface within this height, m. Only saves time.
_LEVEL: Final = 1.0
# One road passes over itself at stations so far apart, m.
_LOOP: Final = 30.0
# Roads that meet may share their surface so far from where they meet if they run at more than this angle, m and the
# sine of 15 degrees; along each other they may do so anywhere.
_NEAR_END: Final = 40.0
_ACROSS: Final = 0.26
# Pairs of pieces of one place follow each other within this distance, m. Places are so far apart, m.
_GAP: Final = 10.0
_PLACE: Final = 40.0


@record(eq=False)
class Stations:
    """Carriageways at stations of roads, in the order of roads and of s."""

    road: IntArray  # (n,)
    s: FloatArray  # (n,) m
    hdg: FloatArray  # (n,) rad
    # (n, 3) x, y, z of the right and the left edge, m
    right: FloatArray
    left: FloatArray


@record(eq=False)
class RoadGraph:
    """Which roads meet."""

    length: FloatArray  # (R,) m
    inside: BoolArray  # (R,) Whether a road lies in a junction
    # (R, 2) Junctions that a road leads to with its ends, twice the one that it lies in; below 0 where there is none
    junction: IntArray
    # (links,) Roads that touch each other
    link_from: IntArray
    link_to: IntArray


@record(eq=False)
class ClosePlaces:
    """Places at which two roads come too close."""

    # (n,) Roads, and where along them, m
    road: IntArray
    s: FloatArray
    other: IntArray
    other_s: FloatArray
    height: FloatArray  # (n,) From one to the other, m


def close_places(stations: Iterable[Stations], graph: RoadGraph, least: float) -> ClosePlaces:
    """Return where carriageways lie over each other with less than the least height between them, m.

    The `stations` come in blocks of whole roads, each of which is needed once: they are large.
    Surfaces closer than 0.3 m are one: that is right where the roads are kin, joined or of one junction, and within
    40 m of their ends where they cross. Kin that are one surface beside the place (a ramp that climbs away) are no
    clearance. Of places within 40 m of each other the one with the least height is returned; the lowest come first.
    """
    pieces, kin = _cut(stations), _Kin(graph)
    pairs = _find(pieces, kin, len(graph.length))
    low = _worst(pieces, kin, graph.length, pairs)
    low = low[pairs.height[low] < least]
    place = pieces.corners[pairs.i[low]].mean(axis=1)
    low = low[_apart(place, pairs.height[low])]
    i, j = pairs.i[low], pairs.j[low]
    return ClosePlaces(pieces.road[i], pieces.s[i], pieces.road[j], pieces.s[j], pairs.height[low])


@record(eq=False)
class _Pieces:
    """Carriageways as quadrilaterals."""

    road: IntArray  # (n,)
    # (n,) Where its middle is along its road, height there, m; heading, rad
    s: FloatArray
    z: FloatArray
    hdg: FloatArray
    corners: FloatArray  # (n, 4, 2) m


@record(eq=False)
class _Overlaps:
    """Pairs of pieces that lie over each other."""

    # (m,) Pieces; the road of the first is not after that of the second
    i: IntArray
    j: IntArray
    key: IntArray  # (m,) Number of the pair of roads
    height: FloatArray  # (m,) From one to the other, m
    depth: FloatArray  # (m,) How far they reach into each other, m


def _cut(stations: Iterable[Stations]) -> _Pieces:
    """Return the pieces between stations that follow each other."""
    return _Pieces(*map(np.concatenate, zip(*map(_cut_block, stations), strict=True)))


def _cut_block(stations: Stations) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the columns of the pieces of some roads."""
    road, s = stations.road, stations.s
    first = np.flatnonzero((road[1:] == road[:-1]) & (np.diff(s) < 2 * CLEARANCE_STEP))
    right, left, then = stations.right, stations.left, first + 1
    sides = ((right, first), (left, first), (left, then), (right, then))
    corners = np.stack([side[at, :2] for side, at in sides], axis=1)
    z = np.stack([side[at, 2] for side, at in sides], axis=1).mean(axis=1)
    return road[first], 0.5 * (s[first] + s[then]), z, stations.hdg[first], corners


class _Kin:
    """Which roads meet."""

    def __init__(self, graph: RoadGraph) -> None:
        n = len(graph.length)
        self.inside, self.junction = graph.inside, graph.junction[:, 0]
        self._junction = graph.junction
        # Pairs of roads as numbers, both ways.
        self._roads = n
        self._linked = sorted_unique([graph.link_from * n + graph.link_to, graph.link_to * n + graph.link_from])
        one, third = self._linked // n, self._linked % n
        many = np.bincount(one, minlength=n)
        other = third[runs((np.cumsum(many) - many)[third], many[third])]
        self._through = sorted_unique(np.repeat(one, many[third]) * n + other)

    def together(self, a: IntArray, b: IntArray) -> BoolArray:
        """Whether roads, (n,), lie in one junction or are linked to each other."""
        one = self.inside[a] & self.inside[b] & (self._junction[a, 0] == self._junction[b, 0])
        return np.asarray(one | _among(a * self._roads + b, self._linked))

    def meet(self, a: IntArray, b: IntArray) -> BoolArray:
        """Whether roads, (n,), share a junction, or are linked to each other or to a third one."""
        shared = np.zeros(len(a), bool)
        for k in (0, 1):
            for m in (0, 1):
                shared |= (self._junction[a, k] == self._junction[b, m]) & (self._junction[a, k] >= 0)
        pair = a * self._roads + b
        return np.asarray(shared | _among(pair, self._linked) | _among(pair, self._through))


def _among(values: IntArray, known: IntArray) -> BoolArray:
    """Say which values, (n,), are among known ones, ascending."""
    at = np.searchsorted(known, values)
    return np.asarray(known[np.minimum(at, len(known) - 1)] == values) if len(known) else np.zeros(len(values), bool)


def _find(pieces: _Pieces, kin: _Kin, roads: int) -> _Overlaps:
    """Return the pairs of pieces that lie over each other, but for those of roads that meet, where they are level.

    Pairs whose roads are one surface anywhere right where they are joined are left out: a ramp that climbs away.
    """
    i, j = overlapping_pairs(pieces.corners, np.ones(len(pieces.s), bool), _joined_groups(pieces, kin))
    far = (pieces.road[i] != pieces.road[j]) | (np.abs(pieces.s[i] - pieces.s[j]) > _LOOP)
    i, j = i[far], j[far]
    height = np.abs(pieces.z[i] - pieces.z[j])
    key = pieces.road[i] * roads + pieces.road[j]
    names, pair = unique_inverse(key)
    joined = kin.together(names // roads, names % roads)[pair] & (height < _ONE_SURFACE)
    rest = np.flatnonzero(~joined)
    depth = _depths(pieces, i[rest], j[rest])
    rest, depth = rest[depth > _DEPTH], depth[depth > _DEPTH]
    # What is joined is measured only where it matters.
    ask = np.flatnonzero(joined & np.isin(pair, pair[rest]))
    level = ask[_depths(pieces, i[ask], j[ask]) > 0.0]
    ramp = np.isin(pair[rest], pair[level])
    rest, depth = rest[~ramp], depth[~ramp]
    return _Overlaps(i[rest], j[rest], key[rest], height[rest], depth)


def _depths(pieces: _Pieces, i: IntArray, j: IntArray) -> FloatArray:
    """Return by how much pairs of pieces reach into each other, (n,), m; block by block, which saves memory."""
    out = np.empty(len(i))
    for first in range(0, len(i), _BLOCK):
        at = slice(first, first + _BLOCK)
        out[at] = overlap_depths(pieces.corners[i[at]], pieces.corners[j[at]])
    return out


def _joined_groups(pieces: _Pieces, kin: _Kin) -> IntArray:
    """Return groups of pieces, (n,), none of which are too close: a stretch of a road, a level of a junction."""
    if not len(pieces.s):
        return np.zeros(0, np.int64)
    stretch = (pieces.s / _LOOP).astype(np.int64)
    level = (np.nan_to_num(pieces.z - np.nanmin(pieces.z)) / _LEVEL).astype(np.int64)
    inside = -1 - (kin.junction[pieces.road] * (level.max() + 1) + level)
    return np.where(kin.inside[pieces.road], inside, pieces.road * (stretch.max() + 1) + stretch)


def _worst(pieces: _Pieces, kin: _Kin, length: FloatArray, pairs: _Overlaps) -> IntArray:
    """Return for each place that two roads share the pair that is closest, if they have to be apart there."""
    order = np.lexsort((pieces.s[pairs.i], pairs.key))
    new = (np.diff(pairs.key[order], prepend=-1) != 0) | (np.diff(pieces.s[pairs.i[order]], prepend=0.0) > _GAP)
    group = np.cumsum(new) - 1
    by_height = order[np.lexsort((pairs.height[order], group))]
    by_depth = order[np.lexsort((-pairs.depth[order], group))]
    first = np.flatnonzero(np.diff(np.sort(group), prepend=-1))
    low, deep = by_height[first], by_depth[first]
    across = np.abs(sine(pieces.hdg[pairs.i[deep]] - pieces.hdg[pairs.j[deep]])) > _ACROSS

    def from_end(piece: IntArray) -> FloatArray:
        road, s = pieces.road[piece], pieces.s[piece]
        return np.where(kin.inside[road], 0.0, np.minimum(s, length[road] - s))

    a, b = pieces.road[pairs.i[low]], pieces.road[pairs.j[low]]
    near = np.maximum(from_end(pairs.i[low]), from_end(pairs.j[low])) < _NEAR_END
    one_surface = pairs.height[low] < _ONE_SURFACE
    excused = kin.meet(a, b) & (~across | near) & one_surface
    out: IntArray = low[~excused]
    return out


def _apart(place: FloatArray, height: FloatArray) -> IntArray:
    """Return the rows of places, (n, 2), m, that are apart from each other, the lowest of those that are not."""
    tree, free, out = PointTree(place), np.ones(len(place), bool), []
    for k in np.argsort(height, kind="stable").tolist():
        if free[k]:
            free[tree.within(place[None, k], _PLACE)[1]] = False
            out.append(k)
    return np.array(out, np.int64)
