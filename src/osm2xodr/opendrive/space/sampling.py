"""Stations along all roads, dense enough that chords stay close to every border."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import ranks, runs
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.space.curves import curvature, pose
from osm2xodr.opendrive.space.lanes import lane_borders, lane_ranks, section_at
from osm2xodr.opendrive.space.profiles import cubic
from osm2xodr.opendrive.tables import OpenDrive

# Most chords of one record: a damaged file must not fill the memory. At 0.1 m each they make 1 km.
_SAMPLE_MOST: Final = 10_000

# Stations closer together than this are one, m.
SAME: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Stations:
    """Points of reference lines, road by road in ascending s.

    Roads without plan view, without a positive length or with unreadable numbers in it have none.
    """

    start: IntArray  # (roads + 1,) Index of each road's first station
    road: IntArray  # (n,) Index of each station's road
    # (n,) m
    s: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    # (n,) Heading and superelevation, rad
    hdg: FloatArray
    roll: FloatArray


def sample_roads(file: OpenDrive, tolerance: float = SAMPLE_TOLERANCE, step: float = SAMPLE_STEP) -> Stations:
    """Sample all roads at once.

    Every start of a record and of a lane section is a station, and both ends of each road are.

    Parameters
    ----------
    file
        The network.
    tolerance
        How far the chords of the reference line, of the lanes' borders and of their heights may lie from the curves,
        m.
    step
        Longest chord along the reference line, m.
    """
    road, s = _breaks(file)
    follows = road[1:] == road[:-1]
    piece = np.flatnonzero(follows)
    low, high = s[piece], s[piece + 1]
    count = _chords(file, road[piece], low, high, tolerance, step)
    # Each break is a station, and so are the inner points of the piece that it begins.
    repeat = np.ones(len(s), np.int64)
    repeat[piece] = count
    length = np.zeros(len(s))
    length[piece] = (high - low) / count
    inside = ranks(repeat)
    at = np.repeat(s, repeat) + inside * np.repeat(length, repeat)
    owner = np.repeat(road, repeat)
    x, y, hdg = pose(file, owner, at)
    z = cubic(file.elevation, owner, at)
    roll = cubic(file.superelevation, owner, at)
    start = np.searchsorted(owner, np.arange(len(file.roads.id) + 1)).astype(np.int64)
    return Stations(start, owner, at, x, y, z, hdg, roll)


def _breaks(file: OpenDrive) -> tuple[IntArray, FloatArray]:
    """Return roads and s of all places where something begins or a road ends, in order."""
    roads = np.arange(len(file.roads.id))
    length = file.roads.length
    sections = file.sections
    lane_road, lane_s = sections.road[file.lanes.section], sections.s[file.lanes.section]
    tables = [
        (roads, np.zeros(len(roads))),
        (roads, length),
        (np.repeat(roads, np.diff(file.plan_view.start)), file.plan_view.s),
        *(
            (np.repeat(roads, np.diff(profile.start)), profile.s)
            for profile in (file.elevation, file.superelevation, file.lane_offset)
        ),
        (sections.road, sections.s),
        *(
            (lane_road[owner], lane_s[owner] + profile.s)
            for profile in (file.lanes.width, file.lanes.border)
            for owner in [np.repeat(np.arange(len(lane_s)), np.diff(profile.start))]
        ),
    ]
    road = np.concatenate([table[0] for table in tables])
    s = np.concatenate([table[1] for table in tables])
    usable = np.isfinite(length) & (length > SAME) & (np.diff(file.plan_view.start) > 0)
    with np.errstate(invalid="ignore"):
        kept = usable[road] & (s >= 0) & (s <= length[road])
    # The road's own ends are the last word on what is too close to them.
    near_end = kept & (s > length[road] - SAME)
    s = np.where(near_end, length[road], s)
    road, s = road[kept], s[kept]
    order = np.lexsort((s, road))
    road, s = road[order], s[order]
    new = np.ones(len(s), np.bool_)
    new[1:] = (road[1:] != road[:-1]) | (np.diff(s) > SAME)
    return road[new], s[new]


def _chords(
    file: OpenDrive, road: IntArray, low: FloatArray, high: FloatArray, tolerance: float, step: float
) -> IntArray:
    """Return into how many chords each piece between breaks is cut, (pieces,).

    The sagitta of a chord of length L on a curve of second derivative k is k L² / 8. A border at t to the outside of
    a bend of curvature k is longer by 1 + |k t|.
    """
    if not len(road):
        return np.zeros(0, np.int64)
    middle = 0.5 * (low + high)
    reach = _reach(file, road, middle)
    bend = np.zeros(len(road))
    fall = np.zeros(len(road))
    for s, before in ((low, False), (middle, False), (high, True)):
        bend = np.fmax(bend, np.abs(curvature(file, road, s, before=before)))
        rise = np.abs(cubic(file.elevation, road, s, order=2, before=before))
        roll = np.abs(cubic(file.superelevation, road, s, order=2, before=before))
        fall = np.fmax(fall, rise + reach * roll)
    sideways = _sideways(file, road, low, high)
    second = np.fmax(bend * (1 + bend * reach) + sideways, fall)
    # Within what a number can be: damaged records may bend without end.
    longest = np.fmin(np.sqrt(8 * tolerance / np.clip(second, 1e-12, 1e12)), step)
    chords: IntArray = np.clip(np.ceil((high - low) / longest - SAME), 1, _SAMPLE_MOST).astype(np.int64)
    return chords


def _reach(file: OpenDrive, road: IntArray, s: FloatArray) -> FloatArray:
    """Return the greatest distance of any lane from the reference line at s of roads, (n,), m."""
    out = np.zeros(len(s))
    section = section_at(file, road, s)
    known = np.flatnonzero(section >= 0)
    ranks = lane_ranks(file)
    for count, first, sign in ((ranks.left_count, ranks.left, -1), (ranks.right_count, ranks.right, 1)):
        has = known[count[section[known]] > 0]
        lane = first[section[has]] + sign * (count[section[has]] - 1)
        _, outer = lane_borders(file, lane, s[has])
        out[has] = np.fmax(out[has], np.abs(outer))
    return out


def _sideways(file: OpenDrive, road: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return a bound of the second derivative of all borders' t between low and high of roads, (n,), 1/m."""
    out = np.fmax(
        np.abs(cubic(file.lane_offset, road, low, order=2)),
        np.abs(cubic(file.lane_offset, road, high, order=2, before=True)),
    )
    section = section_at(file, road, 0.5 * (low + high))
    known = np.flatnonzero(section >= 0)
    first = file.lanes.start[section[known]]
    count = file.lanes.start[section[known] + 1] - first
    place = np.repeat(known, count)
    lane = runs(first, count)
    for profile in (file.lanes.width, file.lanes.border):
        bent = _bent(profile)[lane]
        at, which = place[bent], lane[bent]
        begin = file.sections.s[section[at]]
        most = np.fmax(
            np.abs(cubic(profile, which, low[at] - begin, order=2)),
            np.abs(cubic(profile, which, high[at] - begin, order=2, before=True)),
        )
        np.add.at(out, at, np.nan_to_num(most))
    return np.nan_to_num(out)


def _bent(profile: CubicProfile) -> BoolArray:
    """Return which curves have records that are not straight, (curves,)."""
    out = np.zeros(len(profile.start) - 1, np.bool_)
    owner = np.repeat(np.arange(len(out)), np.diff(profile.start))
    out[owner[(profile.c != 0) | (profile.d != 0)]] = True
    return out
