"""How far each arm of a junction is covered by the other arms: where roads must end for their areas to be apart."""

from __future__ import annotations

from functools import partial
from itertools import pairwise, permutations
from typing import Final

import numpy as np

from osm2xodr.curves import blocks, cosine, sine, slope_of, sorted_unique, unique_inverse, wrapped
from osm2xodr.geometry.defaults import PARALLEL_SINE
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.nearest_places import nearest_places
from osm2xodr.geometry.plan_view import StreetEnds, outward_pose
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.system import map_parallel

# Stations along an arm at which its edges are tested, m: close where arms cross squarely, wider where they part
# at acute angles.
_NEAR_STATIONS: Final = np.arange(0.0, 16.1, 0.5)
_FAR_STATIONS: Final = np.concatenate(
    [np.arange(0.0, 16.0, 0.5), np.arange(16.0, 40.0, 1.0), np.arange(40.0, 101.0, 2.0)]
)
# Edges that end this near to the last station, m, or farther out, are looked at again along the farther ones.
_NEAR_THE_LAST: Final = 1.0
# Numbers of stations after which pairs that need no more are left out.
_STATIONS_BEFORE_A_LOOK: Final = (10, 25)
# Edges count as apart from this distance on, m. A choice.
_GAP_BETWEEN_EDGES: Final = 0.3
# Arms that run along each other lie side by side up to here, m, where one of them has come to another level: widths
# are not known better.
_OVERLAP_OF_LEVELS: Final = 0.2
# Nearer to the node than this, m, no height is won: all levels are one there.
_LEVELS_PART_FROM: Final = 25.0
# An edge that has not reached the other arm up to here, m, never does: arms that come close again farther out are
# other places. A choice.
_FIRST_ENTRY: Final = 12.0
# Between these angles of two arms, rad (25 and 160 degrees), a turn from one to the other has a kerb. A choice.
_LEAST_CORNER: Final = np.deg2rad(25.0)
_LARGEST_CORNER: Final = np.deg2rad(160.0)
# Pairs that are worked out at once: as many as the processor's cache holds.
_PAIRS_AT_ONCE: Final = 1500
# And so many by a process: enough to be worth a copy of it.
_PAIRS_PER_SHARE: Final = 9000


def footprints(ends: StreetEnds, arms: list[list[int]], jobs: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return how much of each arm its junction needs at least, and with kerbs at its corners, (ends,), m.

    `arms` are the street ends of each junction; ends of no junction get 0. `jobs` processes work on it.
    """
    pairs = np.array([pair for group in arms for pair in permutations(group, 2)], np.int64).reshape(-1, 2)
    bare, wished = np.zeros(len(ends.length)), np.zeros(len(ends.length))
    if not len(pairs):
        return bare, wished
    i, j = pairs.T
    cover, across = _covered(ends, i, j, _NEAR_STATIONS, jobs)
    long = np.maximum(cover, across) >= _NEAR_STATIONS[-1] - _NEAR_THE_LAST
    if long.any():
        cover[long], across[long] = _covered(ends, i[long], j[long], _FAR_STATIONS, jobs)
    # Two arms of one junction on different layers pass over each other: neither ends for the other.
    apart = (ends.layer[i] != ends.layer[j]) & (ends.node[i] != ends.node[j])
    kerb = np.where(apart, 0.0, _kerb(ends, i, j))
    for end, length in ((i, cover), (j, across)):
        needed = np.where(apart, 0.0, np.minimum(length, ends.reach[end]))
        np.maximum.at(bare, end, needed)
        np.maximum.at(wished, end, needed + kerb)
    used = sorted_unique(i)
    bare[used] += defaults.ARM_CLEARANCE
    wished[used] += defaults.ARM_CLEARANCE
    return bare, wished


def _kerb(ends: StreetEnds, i: IntArray, j: IntArray) -> FloatArray:
    """Return what a rounded corner between two arms takes of each, its tangent r / tan(angle / 2), (pairs,), m."""
    angle = np.abs(wrapped(ends.hdg[i] - ends.hdg[j]))
    turned = (ends.enters[i] & ends.leaves[j]) | (ends.enters[j] & ends.leaves[i])
    radius = np.minimum(ends.kerb[i], ends.kerb[j])
    tangent = np.minimum(radius / slope_of(np.maximum(angle, 0.1) / 2), defaults.KERB_TANGENT_MAX)
    corner = turned & (angle > _LEAST_CORNER) & (angle < _LARGEST_CORNER)
    return np.where(corner, tangent, 0.0)


def _covered(
    ends: StreetEnds, i: IntArray, j: IntArray, stations: FloatArray, jobs: int
) -> tuple[FloatArray, FloatArray]:
    """Return up to which distance along arms i, and along arms j, the edges of i lie on j, (pairs,), m."""
    shares = blocks(len(i), _PAIRS_PER_SHARE)
    found = map_parallel(partial(_covered_share, ends, i, j, stations), list(shares), jobs)
    cover, across = map(np.concatenate, zip(*found, strict=True))
    return cover, across


def _covered_share(
    ends: StreetEnds, i: IntArray, j: IntArray, stations: FloatArray, share: slice
) -> tuple[FloatArray, FloatArray]:
    """Return what `_covered` does, for some of the pairs."""
    i, j = i[share], j[share]
    cover, across = np.zeros(len(i)), np.zeros(len(i))
    for part in blocks(len(i), _PAIRS_AT_ONCE):
        cover[part], across[part] = _covered_part(ends, i[part], j[part], stations)
    return cover, across


def _samples(ends: StreetEnds, end: IntArray, stations: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and outward heading at stations along ends, (ends, stations); short streets are extended."""
    shape = (len(end), len(stations))
    u = np.broadcast_to(stations, shape)
    on_street = np.minimum(u, ends.length[end][:, None])
    x, y, hdg = (
        value.reshape(shape) for value in outward_pose(ends, np.repeat(end, len(stations)), on_street.ravel())
    )
    beyond = u - on_street
    return x + beyond * cosine(hdg), y + beyond * sine(hdg), hdg


def _covered_part(ends: StreetEnds, i: IntArray, j: IntArray, stations: FloatArray) -> tuple[FloatArray, FloatArray]:
    used, number = unique_inverse(np.concatenate([i, j]))
    one, other = number[: len(i)], number[len(i) :]
    x, y, hdg = _samples(ends, used, stations)
    cos, sin = cosine(hdg), sine(hdg)
    level = ends.levels(np.repeat(used, len(stations)), np.tile(stations, len(used))).reshape(x.shape)
    changed = (level != level[:, :1]) & (stations > _LEVELS_PART_FROM)
    cover, across = np.zeros(len(i)), np.zeros(len(i))
    for edge in (ends.left[used], ends.right[used]):
        px, py = x - edge[:, None] * sin, y + edge[:, None] * cos
        near = np.zeros((len(i), len(stations)), np.int64)
        outside = np.full(near.shape, np.inf)
        todo = np.arange(len(i))
        # Most edges have soon left the other arm: stations farther away are left out.
        for lo, hi in pairwise((0, *_STATIONS_BEFORE_A_LOOK, len(stations))):
            a, b = one[todo], other[todo]
            qx, qy = px[a, lo:hi], py[a, lo:hi]
            found = np.zeros(qx.shape, np.int64)
            nearest_places(qx, qy, x[b], y[b], found)
            at = b[:, None], found
            dx, dy = qx - x[at], qy - y[at]
            ds = dx * cos[at] + dy * sin[at]
            dt = dy * cos[at] - dx * sin[at]
            apart = (level[a, lo:hi] != level[at]) & (changed[a, lo:hi] | changed[at])
            apart &= np.abs(sin[a, lo:hi] * cos[at] - cos[a, lo:hi] * sin[at]) < PARALLEL_SINE
            gap = np.where(apart, -_OVERLAP_OF_LEVELS, _GAP_BETWEEN_EDGES)
            off = np.maximum(dt - ends.left[j[todo], None], ends.right[j[todo], None] - dt) - gap
            behind = ((found == 0) & (ds < -1e-6)) | ((found == len(stations) - 1) & (ds > 1.0))
            near[todo, lo:hi] = found
            outside[todo, lo:hi] = np.where(behind, np.maximum(off, 0.1), off)
            inside = outside[todo, :hi] < 0
            may_enter = ~inside.any(1) & (hi < len(stations) and stations[hi] <= _FIRST_ENTRY)
            todo = todo[may_enter | inside[:, -1]]
        here = _end_of_first_run(outside, stations)
        last = np.searchsorted(stations, here, side="right") - 1
        there = np.where(here > 0, stations[near[np.arange(len(i)), last]], 0.0)
        cover, across = np.maximum(cover, here), np.maximum(across, there)
    return cover, across


def _end_of_first_run(outside: FloatArray, stations: FloatArray) -> FloatArray:
    """Return where each row first turns from inside (negative) to outside, 0 where none is inside near its start."""
    inside = outside < 0
    first = inside.argmax(1)
    touched = inside.any(1) & (stations[first] <= _FIRST_ENTRY)
    later = np.arange(len(stations)) >= first[:, None]
    leave = (~inside & later).argmax(1)
    stays = ~(~inside & later).any(1)
    rows = np.arange(len(outside))
    before = np.maximum(leave - 1, 0)
    lower, upper = outside[rows, before], outside[rows, leave]
    share = np.clip(-lower / np.maximum(upper - lower, 1e-9), 0.0, 1.0)
    where = stations[before] + share * (stations[leave] - stations[before])
    return np.where(touched, np.where(stays, stations[-1], where), 0.0)
