"""From a file of OpenDRIVE to what is drawn of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from osm2xodr.curves import runs
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import (
    ABSENT,
    OpenDrive,
    elevation,
    grade,
    lane_borders,
    lane_offset,
    pose,
    sample_roads,
    section_at,
    superelevation,
)
from osm2xodr.viewing.scene import Scene


def make_scene(file: OpenDrive, tolerance: float, step: float) -> Scene:
    """Sample all roads, and all borders of their lanes.

    Parameters
    ----------
    file
        The network. Roads that cannot be drawn (no plan view, no lane section, unreadable numbers) have no strips.
    tolerance, step
        As for `osm2xodr.opendrive.space.sample_roads`, m.
    """
    road, s, section, is_end = _stations(file, tolerance, step)
    strip_first = np.flatnonzero(np.diff(section, prepend=ABSENT) != 0)
    strip_section = section[strip_first]
    station_start = np.append(strip_first, len(s)).astype(np.int64)
    lane, lane_start, left_lanes = _lanes(file, strip_section)
    x, y, heading = _both(pose, file, road, s, is_end)
    (z,) = _both(elevation, file, road, s, is_end)
    (roll,) = _both(superelevation, file, road, s, is_end)
    (slope,) = _both(grade, file, road, s, is_end)
    border = _borders(file, s, is_end, station_start, lane, lane_start, left_lanes, road)
    centre_rows = np.flatnonzero(file.lanes.id == 0)
    of_section = np.full(len(file.sections.s), -1)
    of_section[file.lanes.section[centre_rows][::-1]] = centre_rows[::-1]
    return Scene(
        strip_road=file.sections.road[strip_section],
        strip_section=strip_section,
        station_start=station_start,
        lane_start=lane_start,
        s=s,
        x=x,
        y=y,
        z=z,
        heading=heading,
        roll=np.nan_to_num(roll),
        grade=slope,
        ground=np.full(len(s), np.nan),
        border=border,
        lane=lane,
        centre=of_section[strip_section],
    )


def _stations(file: OpenDrive, tolerance: float, step: float) -> tuple[IntArray, FloatArray, IntArray, BoolArray]:
    """Return road, s and lane section of all stations, and which are the end of a section that another one follows.

    Where a section begins there are two stations: the end of the one before it and its own first.
    """
    found = sample_roads(file, tolerance, step)
    drawn = np.isfinite(found.x) & np.isfinite(found.y) & np.isfinite(found.hdg)
    road, s = found.road[drawn], found.s[drawn]
    section = section_at(file, road, s)
    known = section != ABSENT
    road, s, section = road[known], s[known], section[known]
    # Row k is followed by another section of the same road: that one's first station ends its own section as well.
    ends = np.flatnonzero((road[1:] == road[:-1]) & (section[1:] != section[:-1]))
    at = np.concatenate((np.arange(len(s)), ends + 1))
    owner = np.concatenate((section, section[ends]))
    is_end = np.concatenate((np.zeros(len(s), np.bool_), np.ones(len(ends), np.bool_)))
    order = np.lexsort((is_end, s[at], owner))
    at, owner, is_end = at[order], owner[order], is_end[order]
    # A section of a single station has no surface.
    count = np.bincount(owner, minlength=len(file.sections.s))
    kept = count[owner] > 1
    return road[at[kept]], s[at[kept]], owner[kept], is_end[kept]


def _both(
    function: Callable[..., Any], file: OpenDrive, road: IntArray, s: FloatArray, before: BoolArray
) -> list[FloatArray]:
    """Evaluate something at stations, from the left where they are ends."""
    after = function(file, road, s)
    columns = list(after) if isinstance(after, tuple) else [after]
    left = function(file, road[before], s[before], before=True)
    for column, values in zip(columns, left if isinstance(left, tuple) else (left,), strict=True):
        column[before] = values
    return columns


def _lanes(file: OpenDrive, section: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the lanes of sections from left to right without centre lanes.

    Also where each section's begin, and how many of them are left of the centre.
    """
    ids = file.lanes.id
    first, last = file.lanes.start[section], file.lanes.start[section + 1]
    count = last - first
    row = runs(first, count)
    strip = np.repeat(np.arange(len(section)), count)
    kept = (ids[row] != 0) & (ids[row] != ABSENT)
    row, strip = row[kept], strip[kept]
    lane_start = np.searchsorted(strip, np.arange(len(section) + 1)).astype(np.int64)
    left = np.bincount(strip[ids[row] > 0], minlength=len(section))
    return row, lane_start, left.astype(np.int64)


def _borders(
    file: OpenDrive,
    s: FloatArray,
    is_end: BoolArray,
    station_start: IntArray,
    lane: IntArray,
    lane_start: IntArray,
    left_lanes: IntArray,
    road: IntArray,
) -> FloatArray:
    """Return t of all borders: strip after strip, station after station, from left to right."""
    stations, lanes = np.diff(station_start), np.diff(lane_start)
    borders = np.repeat(lanes + 1, stations)
    strip = np.repeat(np.arange(len(lanes)), stations)
    begin = np.cumsum(borders) - borders
    station = np.repeat(np.arange(len(s)), borders)
    rank = np.arange(len(station)) - begin[station]
    left = left_lanes[strip[station]]
    out = np.empty(len(station))
    centre = rank == left
    out[centre] = _both(lane_offset, file, road, s, is_end)[0]
    # Left of the centre border k is the outer one of lane k, right of it of lane k - 1.
    side = np.flatnonzero(~centre)
    which = lane[lane_start[strip[station[side]]] + rank[side] - (rank[side] > left[side])]
    at, ends = s[station[side]], is_end[station[side]]
    outer = lane_borders(file, which, at)[1]
    outer[ends] = lane_borders(file, which[ends], at[ends], before=True)[1]
    out[side] = outer
    return out
