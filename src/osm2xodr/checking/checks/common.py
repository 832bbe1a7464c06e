"""What several checks measure with: the lanes of a file by section and id, and which of them cars drive on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.checking.findings import RULES, Findings, Place
from osm2xodr.curves import owners, repeated, unique_first, wrapped
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, Furniture, OpenDrive, pose
from osm2xodr.system import record

# Types of lanes that cars may be on, of all versions of the standard.
_DRIVING_TEXT: Final = (
    "driving entry exit onRamp offRamp connectingRamp slipLane bidirectional mwyEntry mwyExit bus taxi HOV shared"
)
_DRIVING_TYPES: Final = frozenset(_DRIVING_TEXT.split())
# Lane ids beyond this, either way, are not looked up: no road has so many lanes.
_LARGEST_ID: Final = 1 << 20


@record
class LaneIndex:
    """Lanes by section and id."""

    road: IntArray  # (lanes,) Index of each lane's road
    driving: BoolArray  # (lanes,) Whether cars drive on it; never the centre lane
    forward: BoolArray  # (lanes,) Whether traffic runs along s
    both_ways: BoolArray  # (lanes,) Whether traffic runs both ways
    # (roads,) First and last section of each road; -1 without one
    first: IntArray
    last: IntArray
    # (lanes,) Sorted keys of sections and lane ids, and the row of each
    _keys: IntArray
    _rows: IntArray

    def find(self, section: IntArray, lane_id: IntArray) -> IntArray:
        """Return the row of lanes by section and id, (n,); -1 where there is none."""
        sought = _key(section, lane_id)
        if not len(self._keys):
            return np.full(len(sought), -1, np.int64)
        at = np.minimum(np.searchsorted(self._keys, sought), len(self._keys) - 1)
        found = (self._keys[at] == sought) & (section >= 0) & (np.abs(lane_id) < _LARGEST_ID)
        return np.where(found, self._rows[at], -1)

    def end_section(self, road: IntArray, end: IntArray | End) -> IntArray:
        """Return the section at an end of roads, (n,)."""
        return np.where(end == End.START, self.first[road], self.last[road])

    def is_outermost(self, section: IntArray, end: End) -> BoolArray:
        """Whether each lane, whose section is given, is in the section at an end of its road, (lanes,)."""
        return np.asarray(self.end_section(self.road, end) == section)


def lane_index(drive: OpenDrive) -> LaneIndex:
    """Return the index of a file's lanes."""
    lanes, sections = drive.lanes, drive.sections
    road = sections.road[lanes.section]
    driving = np.array([kind in _DRIVING_TYPES for kind in lanes.type], bool) & (lanes.id != 0) & (lanes.id != ABSENT)
    both = np.array([kind == "bidirectional" for kind in lanes.type], bool)
    both |= np.array([word == "both" for word in lanes.direction], bool)
    # Version 1.8 can reverse the traffic of a lane.
    reversed_ = np.array([word == "reversed" for word in lanes.direction], bool)
    forward = ((lanes.id < 0) != drive.roads.left_hand[road]) != reversed_
    has = sections.start[1:] > sections.start[:-1]
    # Of lanes with the same id the first is kept.
    keys, rows = unique_first(_key(lanes.section, lanes.id))
    first, last = np.where(has, sections.start[:-1], -1), np.where(has, sections.start[1:] - 1, -1)
    return LaneIndex(road, driving, forward, both, first, last, keys, rows)


def lane_place(drive: OpenDrive, lanes: LaneIndex, row: IntArray, s: FloatArray | None = None) -> Place:
    """Return where lanes are, for findings: at s, or where their sections begin."""
    table = drive.lanes
    at = drive.sections.s[table.section[row]] if s is None else s
    return {"road": lanes.road[row], "lane": table.id[row], "s": at, "line": table.line[row]}


def _key(section: IntArray, lane_id: IntArray) -> IntArray:
    """Return one number for a section and a lane id."""
    bounded = np.where(np.abs(np.maximum(lane_id, -_LARGEST_ID)) < _LARGEST_ID, lane_id, -_LARGEST_ID)
    return np.asarray(section * (2 * _LARGEST_ID) + bounded + _LARGEST_ID, np.int64)


def above(rule: str, value: FloatArray) -> BoolArray:
    """Whether values are above a rule's limit, (n,); never where they are unknown."""
    limit = RULES[rule].limit
    assert limit is not None
    return np.asarray(np.nan_to_num(value, nan=-np.inf) > limit.value)


def first_rows(start: IntArray) -> IntArray:
    """Return the first row of each owner that has rows."""
    return start[:-1][np.diff(start) > 0]


def followers(start: IntArray) -> IntArray:
    """Return the rows that follow another row of the same owner."""
    owner = owners(start)
    return 1 + np.flatnonzero(owner[1:] == owner[:-1])


def end_station(drive: OpenDrive, road: IntArray, end: IntArray | End) -> FloatArray:
    """Return s of ends of roads, (n,), m."""
    return np.where(end == End.END, drive.roads.length[road], 0.0)


def road_place(drive: OpenDrive, road: IntArray, s: FloatArray | None = None) -> Place:
    """Return where roads are, for findings: at s, or as a whole."""
    place: Place = {"road": road, "line": drive.roads.line[road]}
    return place if s is None else {**place, "s": s}


def record_poses(drive: OpenDrive, row: IntArray, ds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y (m) and heading (rad) at ds of plan-view records, whatever s they state, (n,)."""
    plan = drive.plan_view
    alone = dataclasses.replace(plan, start=np.arange(len(plan.s) + 1), s=np.zeros(len(plan.s)))
    return pose(dataclasses.replace(drive, plan_view=alone), row, ds)


def record_ends(profile: CubicProfile, row: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return value and slope of the cubics of records where the next record begins, (n,)."""
    ds = profile.s[row + 1] - profile.s[row]
    a, b, c, d = profile.a[row], profile.b[row], profile.c[row], profile.d[row]
    return a + ds * (b + ds * (c + ds * d)), b + ds * (2 * c + 3 * ds * d)


def spans(profile: CubicProfile, length: FloatArray) -> FloatArray:
    """Return how far each record holds, (records,), m: to the next one, or to the end of its curve.

    `length` is that of each curve, (curves,), m.
    """
    end = length[owners(profile.start)]
    follows = followers(profile.start)
    end[follows - 1] = profile.s[follows]
    return np.asarray(np.maximum(np.nan_to_num(end - profile.s), 0.0))


def worst_of(group: IntArray, value: FloatArray) -> IntArray:
    """Return the row with the largest value of each group, in order of the groups."""
    order = np.argsort(group, kind="stable")
    begin = np.flatnonzero(np.diff(group[order], prepend=group[order[:1]] - 1))
    if not len(begin):
        return order
    sorted_, size = value[order], np.diff(np.append(begin, len(order)))
    largest = np.repeat(np.fmax.reduceat(sorted_, begin), size)
    # Of groups whose values are all unknown the first row.
    best = np.flatnonzero((sorted_ == largest) | np.isnan(largest))
    of = repeated(size)[best]
    return np.asarray(order[best[np.diff(of, prepend=-1) > 0]], np.int64)


def degrees(turn: FloatArray) -> FloatArray:
    """Return the size of turns (rad) in degrees, from 0 to 180."""
    return np.asarray(np.degrees(np.abs(wrapped(turn))))


def add_furniture(
    rule: str,
    items: Sequence[Furniture],
    findings: Findings,
    other: Sequence[str] = "",
    value: Sequence[float] | None = None,
) -> None:
    """Add findings about signals and objects."""
    findings.add(
        rule,
        road=[item.road for item in items],
        s=[item.s for item in items],
        value=value,
        line=[item.line for item in items],
        other=other,
    )
