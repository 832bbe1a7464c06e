"""Lanes of a whole file by section and id, and which of them cars drive on in which direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.checking.findings import Place
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive

# Types of lanes that cars may be on, of all versions of the standard.
DRIVING_TYPES: Final = frozenset(
    {
        "driving",
        "entry",
        "exit",
        "onRamp",
        "offRamp",
        "connectingRamp",
        "slipLane",
        "bidirectional",
        "mwyEntry",
        "mwyExit",
        "bus",
        "taxi",
        "HOV",
        "shared",
    }
)
# No road has so many lanes: ids beyond are looked for in vain.
_MOST = 1 << 20


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
    _keys: IntArray
    _rows: IntArray

    def find(self, section: IntArray, lane_id: IntArray) -> IntArray:
        """Return the row of lanes by section and id, (n,); -1 where there is none."""
        sought = _key(section, lane_id)
        if not len(self._keys):
            return np.full(len(sought), -1, np.int64)
        at = np.minimum(np.searchsorted(self._keys, sought), len(self._keys) - 1)
        good = (self._keys[at] == sought) & (section >= 0) & (np.abs(lane_id) < _MOST)
        return np.where(good, self._rows[at], -1)

    def end_section(self, road: IntArray, end: IntArray) -> IntArray:
        """Return the section at an end (`End`) of roads, (n,)."""
        return np.where(end == 0, self.first[road], self.last[road])


def lane_index(drive: OpenDrive) -> LaneIndex:
    """Return the index of a file's lanes."""
    lanes, sections = drive.lanes, drive.sections
    road = sections.road[lanes.section]
    driving = np.array([kind in DRIVING_TYPES for kind in lanes.type], bool) & (lanes.id != 0) & (lanes.id != ABSENT)
    both = np.array([kind == "bidirectional" for kind in lanes.type], bool)
    both |= np.array([word == "both" for word in lanes.direction], bool)
    # Version 1.8 can turn the traffic of a lane round.
    turned = np.array([word == "reversed" for word in lanes.direction], bool)
    forward = ((lanes.id < 0) != drive.roads.left_hand[road]) != turned
    has = sections.start[1:] > sections.start[:-1]
    keys = _key(lanes.section, lanes.id)
    # Of lanes with one id the first is kept.
    unique, rows = np.unique(keys, return_index=True)
    return LaneIndex(
        road,
        driving,
        forward,
        both,
        np.where(has, sections.start[:-1], -1),
        np.where(has, sections.start[1:] - 1, -1),
        unique,
        rows,
    )


def lane_place(drive: OpenDrive, lanes: LaneIndex, row: IntArray) -> Place:
    """Return where lanes are, for findings."""
    table = drive.lanes
    return {
        "road": lanes.road[row],
        "lane": table.id[row],
        "s": drive.sections.s[table.section[row]],
        "line": table.line[row],
    }


def _key(section: IntArray, lane_id: IntArray) -> IntArray:
    """Return one number for a section and a lane id."""
    bounded = np.where(np.abs(np.maximum(lane_id, -_MOST)) < _MOST, lane_id, -_MOST)
    return np.asarray(section * (2 * _MOST) + bounded + _MOST, np.int64)
