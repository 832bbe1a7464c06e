"""Stations along all roads, dense enough that chords stay close to every border."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import cubic_value, owners, ranks
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space.curves import curvature, pose
from osm2xodr.opendrive.space.lanes import lane_borders, lanes_of, outermost_lanes, section_at
from osm2xodr.opendrive.tables import OpenDrive

# Most chords of one record, so that a damaged file does not fill the memory. At 0.1 m each they make 1 km.
_MOST_CHORDS: Final = 10_000
# Stations closer together than this are one, m.
SAME: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Stations:
    """Points of reference lines, road by road in ascending s.

    Roads without a plan view or a positive length, and those with unreadable numbers in the plan view, have none.
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


def sample_roads(
    file: OpenDrive,
    tolerance: float = SAMPLE_TOLERANCE,
    step: float = SAMPLE_STEP,
    more: tuple[IntArray, FloatArray] | None = None,
) -> Stations:
    """Sample all roads at once.

    Stations are the ends of roads, every start of a record or lane section, `more` places (roads and s, (n,) each),
    and so many places between that the chords of reference lines, lane borders and heights lie within `tolerance`,
    m, of the curves and none is longer than `step`, m.
    """
    road, s = _breaks(file, more)
    piece = np.flatnonzero(road[1:] == road[:-1])
    low, high = s[piece], s[piece + 1]
    count = _chords(file, road[piece], low, high, tolerance, step)
    # Each break is a station, and so are the inner points of the piece that it begins.
    repeat, length = np.ones(len(s), np.int64), np.zeros(len(s))
    repeat[piece], length[piece] = count, (high - low) / count
    at = np.repeat(s, repeat) + ranks(repeat) * np.repeat(length, repeat)
    owner = np.repeat(road, repeat)
    x, y, hdg = pose(file, owner, at)
    z = cubic_value(file.elevation, owner, at)
    roll = cubic_value(file.superelevation, owner, at)
    start = np.searchsorted(owner, np.arange(len(file.roads.id) + 1)).astype(np.int64)
    return Stations(start, owner, at, x, y, z, hdg, roll)


def _breaks(file: OpenDrive, more: tuple[IntArray, FloatArray] | None) -> tuple[IntArray, FloatArray]:
    """Return roads and s of all places where a record begins or a road ends, and of `more` places, in order."""
    roads = np.arange(len(file.roads.id))
    length = file.roads.length
    sections = file.sections
    lane_road, lane_s = sections.road[file.lanes.section], sections.s[file.lanes.section]
    tables = [
        (roads, np.zeros(len(roads))),
        (roads, length),
        (owners(file.plan_view.start), file.plan_view.s),
        *((owners(profile.start), profile.s) for profile in (file.elevation, file.superelevation, file.lane_offset)),
        (sections.road, sections.s),
        *(
            (lane_road[owner], lane_s[owner] + profile.s)
            for profile in (file.lanes.width, file.lanes.border)
            for owner in [owners(profile.start)]
        ),
        *([] if more is None else [more]),
    ]
    road = np.concatenate([table[0] for table in tables])
    s = np.concatenate([table[1] for table in tables])
    usable = np.isfinite(length) & (length > SAME) & (np.diff(file.plan_view.start) > 0)
    with np.errstate(invalid="ignore"):
        kept = usable[road] & (s >= 0) & (s <= length[road])
    # The road's end replaces places that are too close to it.
    s = np.where(s > length[road] - SAME, length[road], s)[kept]
    road = road[kept]
    order = np.lexsort((s, road))
    road, s = road[order], s[order]
    new = np.ones(len(s), np.bool_)
    new[1:] = (road[1:] != road[:-1]) | (np.diff(s) > SAME)
    return road[new], s[new]


def _chords(
    file: OpenDrive, road: IntArray, low: FloatArray, high: FloatArray, tolerance: float, step: float
) -> IntArray:
    """Return into how many chords each piece between breaks is cut, (pieces,).

    The sagitta of a chord of length L on a curve of second derivative k is k L² / 8. A border at t on the outside of
    a bend of curvature k is longer by the factor 1 + |k t|.
    """
    if not len(road):
        return np.zeros(0, np.int64)
    middle = 0.5 * (low + high)
    reach = _reach(file, road, middle)
    bend, fall = np.zeros(len(road)), np.zeros(len(road))
    for s, before in ((low, False), (middle, False), (high, True)):
        bend = np.fmax(bend, np.abs(curvature(file, road, s, before=before)))
        rise = np.abs(cubic_value(file.elevation, road, s, order=2, before=before))
        roll = np.abs(cubic_value(file.superelevation, road, s, order=2, before=before))
        fall = np.fmax(fall, rise + reach * roll)
    second = np.fmax(bend * (1 + bend * reach) + _sideways(file, road, low, high), fall)
    # Damaged records may have any second derivative.
    longest = np.fmin(np.sqrt(8 * tolerance / np.clip(second, 1e-12, 1e12)), step)
    out: IntArray = np.clip(np.ceil((high - low) / longest - SAME), 1, _MOST_CHORDS).astype(np.int64)
    return out


def _reach(file: OpenDrive, road: IntArray, s: FloatArray) -> FloatArray:
    """Return the greatest distance of any lane from the reference line at s of roads, (n,), m."""
    out = np.zeros(len(s))
    for has, lane in outermost_lanes(file, section_at(file, road, s)):
        _, outer = lane_borders(file, lane, s[has])
        out[has] = np.fmax(out[has], np.abs(outer))
    return out


def _sideways(file: OpenDrive, road: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return an upper bound of the second derivatives of all borders' t from low to high of roads, (n,), 1/m."""
    out = np.fmax(
        np.abs(cubic_value(file.lane_offset, road, low, order=2)),
        np.abs(cubic_value(file.lane_offset, road, high, order=2, before=True)),
    )
    section = section_at(file, road, 0.5 * (low + high))
    place, lane = lanes_of(file, section)
    for profile in (file.lanes.width, file.lanes.border):
        # Only lanes with records that are not straight.
        curved = np.zeros(len(profile.start) - 1, np.bool_)
        curved[owners(profile.start)[(profile.c != 0) | (profile.d != 0)]] = True
        bent = curved[lane]
        at, which = place[bent], lane[bent]
        begin = file.sections.s[section[at]]
        most = np.fmax(
            np.abs(cubic_value(profile, which, low[at] - begin, order=2)),
            np.abs(cubic_value(profile, which, high[at] - begin, order=2, before=True)),
        )
        np.add.at(out, at, np.nan_to_num(most))
    return np.nan_to_num(out)
