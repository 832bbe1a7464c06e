"""Lanes across the road: which there are, where their borders are, and how high they lie."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from osm2xodr.curves import cubic_value, find_record, runs
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space.curves import in_blocks, pose
from osm2xodr.opendrive.tables import ABSENT, OpenDrive


@in_blocks
def elevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return z of reference lines at s, m; 0 where a road has no elevation, as OpenDRIVE defines it."""
    return cubic_value(file.elevation, road, s, before=before)


@in_blocks
def grade(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the rise of reference lines per metre of s."""
    return cubic_value(file.elevation, road, s, order=1, before=before)


@in_blocks
def superelevation(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the roll of road surfaces about their reference lines at s, rad; positive where the left is higher."""
    return cubic_value(file.superelevation, road, s, before=before)


@in_blocks
def lane_offset(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return t of centre lanes at s, m."""
    return cubic_value(file.lane_offset, road, s, before=before)


def surface_points(
    file: OpenDrive,
    road: IntArray,
    s: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
    *,
    before: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at s, t of roads and h above their surface, m.

    The t axis is level and square to the reference line's projection, rolled by the superelevation; h is square to
    both. ``<shape>`` records of lateral profiles are left out. `before` asks for the limit from the left.
    """
    x, y, hdg = pose(file, road, s, before=before)
    z = elevation(file, road, s, before=before)
    roll = superelevation(file, road, s, before=before)
    return points_beside(x, y, z, hdg, roll, t, h)


def points_beside(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    hdg: FloatArray,
    roll: FloatArray,
    t: FloatArray,
    h: FloatArray | float = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z of points at t, h beside points of reference lines; see `surface_points`."""
    # An infinite roll, as of damaged files, is unknown.
    roll = np.where(np.isfinite(roll), roll, np.nan)
    cos, sin = np.cos(roll), np.sin(roll)
    across = t * cos - h * sin
    return x - np.sin(hdg) * across, y + np.cos(hdg) * across, z + t * sin + h * cos


@dataclass(frozen=True, eq=False)
class LaneRanks:
    """The lanes of all sections, counted from the centre outwards."""

    # (sections,) Row of the lane next to the centre on either side, if there is one
    left: IntArray
    right: IntArray
    # (sections,) Lanes on either side
    left_count: IntArray
    right_count: IntArray
    # (lanes,) 1 for lanes next to the centre, and so on; 0 for centre lanes, -1 for lanes whose id is unreadable
    rank: IntArray


_CACHE: WeakKeyDictionary[OpenDrive, LaneRanks] = WeakKeyDictionary()


def lane_ranks(file: OpenDrive) -> LaneRanks:
    """Count the lanes of every section from the centre outwards; done once, then remembered."""
    if file in _CACHE:
        return _CACHE[file]
    lanes = file.lanes
    sections = len(lanes.start) - 1
    known = lanes.id != ABSENT
    left_count = np.bincount(lanes.section[lanes.id > 0], minlength=sections)
    centres = np.bincount(lanes.section[lanes.id == 0], minlength=sections)
    right_count = np.bincount(lanes.section[known & (lanes.id < 0)], minlength=sections)
    left = lanes.start[:-1] + left_count - 1
    right, row = left + 1 + centres, np.arange(len(lanes.id))
    rank = np.where(lanes.id > 0, left[lanes.section] - row + 1, row - right[lanes.section] + 1)
    rank[lanes.id == 0], rank[~known] = 0, -1
    found = _CACHE[file] = LaneRanks(left, right, left_count, right_count, rank)
    return found


def lane_borders(
    file: OpenDrive, lanes: IntArray, s: FloatArray, *, before: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return t of the inner and outer borders of lanes (rows of `OpenDrive.lanes`) at s of their roads, each (n,), m.

    Each lane is evaluated in its own section, even where s lies beyond it. Widths add up from the lane offset
    outwards. A lane without widths has its ``<border>``, which counts from the lane offset, too; one without either
    has no width. Lanes whose id is unreadable give NaN. `before` asks for the limit from the left.
    """
    return _borders((file, lane_ranks(file)), lanes, s, before=before)


@in_blocks
def _borders(
    counted: tuple[OpenDrive, LaneRanks], lanes: IntArray, s: FloatArray, *, before: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the borders of lanes of a file whose lanes were counted; see `lane_borders`."""
    file, ranks = counted
    table = file.lanes
    section = table.section[lanes]
    rank = ranks.rank[lanes]
    is_left = table.id[lanes] > 0
    ds = s - file.sections.s[section]
    middle = lane_offset(file, file.sections.road[section], s, before=before)
    inner, outer = middle.copy(), middle.copy()
    for step in range(int(rank.max(initial=0))):
        at = np.flatnonzero(rank > step)
        lane = np.where(is_left[at], ranks.left[section[at]] - step, ranks.right[section[at]] + step)
        width = cubic_value(table.width, lane, ds[at], before=before)
        inner[at] = outer[at]
        beyond = outer[at] + np.where(is_left[at], width, -width)
        bare = np.flatnonzero(
            (table.width.start[lane + 1] == table.width.start[lane])
            & (table.border.start[lane + 1] > table.border.start[lane])
        )
        if len(bare):
            beyond[bare] = middle[at[bare]] + cubic_value(table.border, lane[bare], ds[at[bare]], before=before)
        outer[at] = beyond
    inner[rank < 0] = outer[rank < 0] = np.nan
    return inner, outer


def lane_middles(file: OpenDrive, lanes: IntArray, s: FloatArray) -> FloatArray:
    """Return t of the middles of lanes at s of their roads, (n,), m; NaN for `ABSENT` ones."""
    out = np.full(len(s), np.nan)
    has = np.flatnonzero(lanes != ABSENT)
    inner, outer = lane_borders(file, lanes[has], s[has])
    out[has] = 0.5 * (inner + outer)
    return out


@in_blocks
def section_at(file: OpenDrive, road: IntArray, s: FloatArray, *, before: bool = False) -> IntArray:
    """Return the lane sections at s of roads, (n,): rows of `OpenDrive.sections`; `ABSENT` where a road has none."""
    start = file.sections.start
    out = np.full(len(s), ABSENT)
    has = np.flatnonzero(start[road + 1] > start[road])
    if len(has):
        out[has] = find_record(start, file.sections.s, road[has], s[has], before=before)
    return out


def speed_limits(file: OpenDrive) -> FloatArray:
    """Return the speed limits of all lanes, (lanes,), m/s: their own, or else that of their road where they begin.

    NaN is unknown, infinite without a limit.
    """
    lanes, sections, types = file.lanes, file.sections, file.types
    road, s = sections.road[lanes.section], sections.s[lanes.section]
    out = lanes.speed.copy()
    asks = np.flatnonzero(np.isnan(out) & (types.start[road + 1] > types.start[road]) & np.isfinite(s))
    out[asks] = types.speed[find_record(types.start, types.s, road[asks], s[asks])]
    return out


def lanes_of(file: OpenDrive, section: IntArray) -> tuple[IntArray, IntArray]:
    """Return all lanes of sections (n,), or `ABSENT`: the index into `section` and the row of each lane."""
    known = np.flatnonzero(section != ABSENT)
    first = file.lanes.start[section[known]]
    count = file.lanes.start[section[known] + 1] - first
    return np.repeat(known, count), runs(first, count)


def outermost_lanes(file: OpenDrive, section: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the outermost lanes of sections (n,), side by side: the index into `section` and the row of each lane."""
    known = np.flatnonzero(section != ABSENT)
    ranks = lane_ranks(file)
    for count, first, sign in ((ranks.left_count, ranks.left, -1), (ranks.right_count, ranks.right, 1)):
        has = known[count[section[known]] > 0]
        yield has, first[section[has]] + sign * (count[section[has]] - 1)
