"""How far each arm of a junction is covered by the other arms: where roads must end for their areas to be apart."""

from __future__ import annotations

from functools import partial
from itertools import permutations
from typing import Final

import numpy as np

from osm2xodr.curves import blocks, cosine_sine, slope_of, sorted_unique, unique_inverse, wrapped
from osm2xodr.geometry.junctions import defaults
from osm2xodr.geometry.junctions.covered_edges import cover_edges
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
# Between these angles of two arms, rad (25 and 160 degrees), a turn from one to the other has a kerb. A choice.
_LEAST_CORNER: Final = np.deg2rad(25.0)
_LARGEST_CORNER: Final = np.deg2rad(160.0)
# So many pairs are worked on by a process: enough to be worth a copy of it.
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
    used, number = unique_inverse(np.concatenate([i, j]))
    poses, out = _samples(ends, used, stations), np.empty((2, len(i)))
    level = ends.levels(np.repeat(used, len(stations)), np.tile(stations, len(used)))
    level = level.reshape(poses.shape[1:])
    cover_edges(number[: len(i)], number[len(i) :], stations, poses, level, ends.left[used], ends.right[used], out)
    return out[0], out[1]


def _samples(ends: StreetEnds, end: IntArray, stations: FloatArray) -> FloatArray:
    """Return x, y, cosine and sine of outward headings along ends, (4, ends, stations), beyond short streets, too."""
    shape = (len(end), len(stations))
    u = np.broadcast_to(stations, shape)
    on_street = np.minimum(u, ends.length[end][:, None])
    x, y, hdg = (
        value.reshape(shape) for value in outward_pose(ends, np.repeat(end, len(stations)), on_street.ravel())
    )
    beyond = u - on_street
    cos, sin = cosine_sine(hdg)
    return np.stack([x + beyond * cos, y + beyond * sin, cos, sin])
