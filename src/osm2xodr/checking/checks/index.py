"""The lanes of a file by section and id, and which of them cars drive on in which direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.checking.findings import Place
from osm2xodr.curves import unique_first
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, OpenDrive

# Types of lanes that cars may be on, of all versions of the standard.
_DRIVING_TEXT: Final = (
    "driving entry exit onRamp offRamp connectingRamp slipLane bidirectional mwyEntry mwyExit bus taxi HOV shared"
)
_DRIVING_TYPES: Final = frozenset(_DRIVING_TEXT.split())
# Lane ids beyond this, either way, are not looked up: no road has so many lanes.
_LARGEST_ID: Final = 1 << 20


@dataclass(frozen=True)
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
