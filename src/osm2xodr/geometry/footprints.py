"""How far each arm of a junction lies under its other arms: where roads must end for their areas to be apart."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.curves import wrapped
from osm2xodr.geometry.street_ends import StreetEnds, outward_pose
from osm2xodr.model import FloatArray, IntArray

# Stations along an arm at which its edges are tested, m: close where arms cross squarely, wider where they part
# at acute angles.
_NEAR = np.arange(0.0, 16.1, 0.5)
_FAR = np.concatenate([np.arange(0.0, 16.0, 0.5), np.arange(16.0, 40.0, 1.0), np.arange(40.0, 101.0, 2.0)])
_PAIRS_AT_ONCE = 1500
_GAP_BETWEEN_EDGES = 0.3
_FIRST_ENTRY = 12.0


def footprints(ends: StreetEnds, arms: list[list[int]]) -> tuple[FloatArray, FloatArray]:
    """Return how much of each arm its junction needs at least, and with kerbs at its corners, (ends,), m.

    Parameters
    ----------
    ends
        All street ends.
    arms
        The street ends of each junction. Ends that are in none get 0.
    """
    pairs = np.array([pair for group in arms for pair in permutations(group, 2)], np.int64).reshape(-1, 2)
    bare = np.zeros(len(ends.length))
    wished = np.zeros(len(ends.length))
    if not len(pairs):
        return bare, wished
    i, j = pairs.T
    cover, across = _covered(ends, i, j, _NEAR)
    long = np.maximum(cover, across) >= _NEAR[-1] - 1.0
    if long.any():
        cover[long], across[long] = _covered(ends, i[long], j[long], _FAR)
    # Two arms of one junction on different layers pass over each other: neither ends for the other.
    apart = (ends.layer[i] != ends.layer[j]) & (ends.node[i] != ends.node[j])
    kerb = np.where(apart, 0.0, _kerb(ends, i, j))
    for end, length in ((i, cover), (j, across)):
        needed = np.where(apart, 0.0, np.minimum(length, ends.reach[end]))
        np.maximum.at(bare, end, needed)
        np.maximum.at(wished, end, needed + kerb)
    used = np.unique(i)
    bare[used] += defaults.ARM_CLEARANCE
    wished[used] += defaults.ARM_CLEARANCE
    return bare, wished


def _kerb(ends: StreetEnds, i: IntArray, j: IntArray) -> FloatArray:
    """Return what a rounded corner between two arms takes of each, m."""
    angle = np.abs(wrapped(ends.hdg[i] - ends.hdg[j]))
    turned = (ends.enters[i] & ends.leaves[j]) | (ends.enters[j] & ends.leaves[i])
    radius = np.minimum(ends.kerb[i], ends.kerb[j])
    tangent = np.minimum(radius / np.tan(np.maximum(angle, 0.1) / 2), defaults.KERB_TANGENT_MAX)
    corner = turned & (angle > np.deg2rad(25.0)) & (angle < np.deg2rad(160.0))
    out: FloatArray = np.where(corner, tangent, 0.0)
    return out


def _covered(ends: StreetEnds, i: IntArray, j: IntArray, stations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return up to which distance along arms i, and along arms j, the edges of i lie on j, (pairs,), m."""
    cover, across = np.zeros(len(i)), np.zeros(len(i))
    for lo in range(0, len(i), _PAIRS_AT_ONCE):
        part = slice(lo, lo + _PAIRS_AT_ONCE)
        cover[part], across[part] = _covered_part(ends, i[part], j[part], stations)
    return cover, across


def _samples(ends: StreetEnds, end: IntArray, stations: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and outward heading at stations along ends, (ends, stations); a short street is drawn on."""
    shape = (len(end), len(stations))
    u = np.broadcast_to(stations, shape)
    on_street = np.minimum(u, ends.length[end][:, None])
    x, y, hdg = (
        value.reshape(shape) for value in outward_pose(ends, np.repeat(end, len(stations)), on_street.ravel())
    )
    beyond = u - on_street
    return x + beyond * np.cos(hdg), y + beyond * np.sin(hdg), hdg


def _covered_part(ends: StreetEnds, i: IntArray, j: IntArray, stations: FloatArray) -> tuple[FloatArray, FloatArray]:
    xi, yi, hi = _samples(ends, i, stations)
    xj, yj, hj = _samples(ends, j, stations)
    cos, sin = np.cos(hj), np.sin(hj)
    cover, across = np.zeros(len(i)), np.zeros(len(i))
    rows = np.arange(len(i))[:, None]
    for edge in (ends.left[i], ends.right[i]):
        px = xi - edge[:, None] * np.sin(hi)
        py = yi + edge[:, None] * np.cos(hi)
        near = ((px[:, :, None] - xj[:, None, :]) ** 2 + (py[:, :, None] - yj[:, None, :]) ** 2).argmin(2)
        dx, dy = px - xj[rows, near], py - yj[rows, near]
        ds = dx * cos[rows, near] + dy * sin[rows, near]
        dt = dy * cos[rows, near] - dx * sin[rows, near]
        outside = np.maximum(dt - ends.left[j][:, None], ends.right[j][:, None] - dt) - _GAP_BETWEEN_EDGES
        behind = ((near == 0) & (ds < -1e-6)) | ((near == len(stations) - 1) & (ds > 1.0))
        outside = np.where(behind, np.maximum(outside, 0.1), outside)
        here = _end_of_first_run(outside, stations)
        last = np.searchsorted(stations, here, side="right") - 1
        there = np.where(here > 0, stations[near[rows[:, 0], last]], 0.0)
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
    out: FloatArray = np.where(touched, np.where(stays, stations[-1], where), 0.0)
    return out
