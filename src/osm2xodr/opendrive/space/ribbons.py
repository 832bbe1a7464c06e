"""Lanes as ribbons between borders that neighbours share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import owners, ranks, runs, starts
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive.space.lanes import LaneRanks, lane_borders, lane_ranks
from osm2xodr.opendrive.space.profiles import lane_offset, points_beside
from osm2xodr.opendrive.space.sampling import SAME, Stations
from osm2xodr.opendrive.tables import ABSENT, OpenDrive


@dataclass(frozen=True, eq=False)
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
