"""Stations along all roads, so dense that chords stay close to every border, and lanes as ribbons between these."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cubic_value, owners, ranks, runs, starts
from osm2xodr.defaults import SAMPLE_STEP, SAMPLE_TOLERANCE
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive.space.positions import (
    LaneRanks,
    curvature,
    lane_borders,
    lane_offset,
    lane_ranks,
    lanes_of,
    outermost_lanes,
    points_beside,
    pose,
    section_at,
)
from osm2xodr.opendrive.tables import ABSENT, OpenDrive
from osm2xodr.system import record

# Most chords of one record, so that a damaged file does not fill the memory. At 0.1 m each they make 1 km.
_MOST_CHORDS: Final = 10_000
# Stations closer together than this are one, m.
SAME: Final = 1e-6


@record(eq=False)
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


@record(eq=False)
class Ribbons:
    """The borders of all lanes as lines in space, and which of them bound each lane.

    A section has one border more than lanes beside the centre, from left to right; all its borders have a point at
    the same stations. Sections shorter than a micrometre, or of roads without stations, have no borders.
    """

    start: IntArray  # (borders + 1,) Index of each border's first point
    section: IntArray  # (borders,) Row of the section that a border belongs to
    station: IntArray  # (points,) Row of `Stations` beside which each point lies
    # (points,) m
    t: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    # (lanes,) Borders of each lane; `ABSENT` for centre lanes and where a section has none
    left: IntArray
    right: IntArray


def lane_ribbons(file: OpenDrive, stations: Stations) -> Ribbons:
    """Return the borders of all lanes of a file at the stations of `sample_roads`; lane heights are left out."""
    first, count = _stations_of_sections(file, stations)
    lanes = lane_ranks(file)
    borders = np.where(count > 0, lanes.left_count + lanes.right_count + 1, 0)
    border_start = starts(borders)
    section, rank = owners(border_start), ranks(borders)
    # The lane whose outer border each one is; the border in the centre belongs to no lane.
    lane = np.full(len(section), ABSENT)
    behind = rank - lanes.left_count[section]
    lane[behind < 0] = (file.lanes.start[section] + rank)[behind < 0]
    lane[behind > 0] = (lanes.right[section] + behind - 1)[behind > 0]
    start = starts(count[section])
    border = owners(start)
    station = runs(first[section], count[section])
    last = station == (first + count - 1)[section[border]]
    t = _border_t(file, stations, section[border], lane[border], station, last)
    columns = stations.x, stations.y, stations.z, stations.hdg, stations.roll
    x, y, z, hdg, roll = (column[station] for column in columns)
    points = points_beside(x, y, z, hdg, roll, t)
    return Ribbons(start, section, station, t, *points, *_bounds(file, lanes, border_start, count))


def _stations_of_sections(file: OpenDrive, stations: Stations) -> tuple[IntArray, IntArray]:
    """Return the first station of each section and how many there are, 0 where there are fewer than two."""
    sections = file.sections
    # One ascending key for all roads: stations of a road are finite and at least 0.
    span = float(np.max(stations.s, initial=0.0)) + 2.0
    keys = stations.road * span + stations.s
    # Rounding of the keys.
    slack = max(SAME, 4 * float(np.finfo(np.float64).eps) * span * len(stations.start))
    bounds = []
    for s, beyond in ((sections.s, -slack), (sections.end, slack)):
        at = np.clip(np.nan_to_num(s, nan=-1.0), -1.0, span - 1.0)
        row = np.searchsorted(keys, sections.road * span + at + beyond).astype(np.int64)
        bounds.append(np.clip(row, stations.start[sections.road], stations.start[sections.road + 1]))
    points = bounds[1] - bounds[0]
    return bounds[0], np.where(points >= 2, points, 0)


def _border_t(
    file: OpenDrive, stations: Stations, section: IntArray, lane: IntArray, station: IntArray, last: BoolArray
) -> FloatArray:
    """Return t of borders at stations: the limit from the left at the last one of their section."""
    s = stations.s[station]
    road = file.sections.road[section]
    out = np.empty(len(s))
    for before in (False, True):
        centre = np.flatnonzero((lane == ABSENT) & (last == before))
        out[centre] = lane_offset(file, road[centre], s[centre], before=before)
        other = np.flatnonzero((lane != ABSENT) & (last == before))
        _, out[other] = lane_borders(file, lane[other], s[other], before=before)
    return out


def _bounds(file: OpenDrive, ranked: LaneRanks, border_start: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """Return the borders to the left and right of each lane."""
    section, rank = file.lanes.section, ranked.rank
    outer = border_start[section] + ranked.left_count[section] + np.where(file.lanes.id > 0, -rank, rank)
    inner = outer + np.where(file.lanes.id > 0, 1, -1)
    left, right = np.minimum(inner, outer), np.maximum(inner, outer)
    missing = (rank <= 0) | (count[section] == 0)
    left[missing] = right[missing] = ABSENT
    return left, right
