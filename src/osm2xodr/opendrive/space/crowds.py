"""Files with more roads on each other than can be compared: it takes the square of their number."""

from __future__ import annotations

from typing import Final, NoReturn

import numpy as np

from osm2xodr.curves import ranks, repeated, unique_rows
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.space.curves import pose
from osm2xodr.opendrive.space.lanes import lane_borders, outermost_lanes, section_at
from osm2xodr.opendrive.tables import OpenDrive

# Pieces of this length of all roads are counted in cells of this size, m.
_STEP: Final = 4.0
_CELL: Final = 12.0
# The sum of the squares of their numbers, or that for each record of the plan view if it is larger, is what is
# compared at most. Choices: of 20 files of this program and 4 of another one the densest has 51 for each record.
_CROWD: Final = 2e6
_CROWD_EACH: Final = 300.0
# Most cells at all, likewise: the same files have up to 8 for each record.
_CELLS: Final = 3e6
_CELLS_EACH: Final = 1e3
# Places farther away than this are left out, m: they come from damaged numbers.
_FARTHEST: Final = 1e9


def refuse_crowds(file: OpenDrive) -> None:
    """Raise `InputError`, with the road, where too many roads lie on each other, or they cover too much."""
    length = np.maximum(np.nan_to_num(file.roads.length), 0.0)
    count = np.where(np.diff(file.plan_view.start) > 0, np.ceil(length / _STEP), 0.0).astype(np.int64)
    road = repeated(count)
    s = (ranks(count) + 0.5) * np.repeat(length / np.maximum(count, 1), count)
    x, y, hdg = pose(file, road, s)
    low, high = np.zeros(len(s)), np.zeros(len(s))
    for has, lane in outermost_lanes(file, section_at(file, road, s)):
        _, outer = lane_borders(file, lane, s[has])
        low[has], high[has] = np.fmin(low[has], outer), np.fmax(high[has], outer)
    good = (np.abs(x) < _FARTHEST) & (np.abs(y) < _FARTHEST) & np.isfinite(hdg)
    across = np.where(good, np.maximum(np.ceil((high - low) / _CELL), 1.0), 0.0).astype(np.int64)
    records = len(file.plan_view.s)
    if across.sum() > max(_CELLS, _CELLS_EACH * records):
        _refuse(file, road, s, int(across.argmax()), "roads cover too large an area to compare them, most")
    of = repeated(across)
    t = low[of] + (ranks(across) + 0.5) * ((high - low) / np.maximum(across, 1))[of]
    places = x[of] - np.sin(hdg[of]) * t, y[of] + np.cos(hdg[of]) * t
    cells = unique_rows(np.column_stack([np.floor(axis / _CELL).astype(np.int64) for axis in places]))
    if float((cells.counts.astype(np.float64) ** 2).sum()) > max(_CROWD, _CROWD_EACH * records):
        worst = int(of[cells.first[cells.counts.argmax()]])
        _refuse(file, road, s, worst, "too many roads lie on each other to compare them, most")


def _refuse(file: OpenDrive, road: IntArray, s: FloatArray, row: int, words: str) -> NoReturn:
    place = f"road {file.roads.id[int(road[row])]!r}, s = {s[row]:.0f} m"
    raise InputError(f"{file.path}: {words} at {place}; look at the file there, or choose a part of it")
