"""Which parts of roads lie above others, as bridges do: what lies below is drawn before them."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import blocks, overlap_depths, overlapping_pairs
from osm2xodr.furniture_shapes import LEVEL_APART
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.viewing.scene import Scene

# Parts reach into each other by this at least, m: more than chords of bends that lie side by side.
_DEPTH: Final = 0.2
# More decks than any interchange has; ramps that wind up over themselves would have any number. A choice.
_MOST_LEVELS: Final = 8


class Parts:
    """The parts of strips between stations, with the levels on which they lie.

    A part is named by the station at which it begins; the last station of a strip has none.
    """

    def __init__(self, scene: Scene) -> None:
        x, y, z = scene.border_places()
        count = scene.strip_borders[scene.station_strip]
        left = np.concatenate([[0], np.cumsum(count)[:-1]]).astype(np.int64)
        right = left + count - 1
        last = np.zeros(len(scene.s), bool)
        last[scene.station_start[1:] - 1] = True
        at = np.flatnonzero(~last)
        corner = np.stack([left[at], right[at], right[at + 1], left[at + 1]], axis=1)
        corners, height = np.stack([x[corner], y[corner]], axis=2), np.nan_to_num(z)[corner].mean(axis=1)
        known = np.isfinite(corners).all(axis=(1, 2))
        self._at, self._corners, self._z = at[known], corners[known], height[known]
        self.level = np.zeros(len(scene.s), np.int64)
        self.level[self._at] = self._levels(scene.station_strip[self._at])
        self._road = scene.station_road[self._at]
        self._low, self._high = self._corners.min(axis=1), self._corners.max(axis=1)

    def _levels(self, strip: IntArray) -> IntArray:
        """Return on how many levels each part lies above others; parts that overlap at one height share theirs."""
        level = np.zeros(len(strip), np.int64)
        if not len(strip) or np.ptp(self._z) < LEVEL_APART:
            return level
        i, j = overlapping_pairs(self._corners, np.ones(len(strip), bool), strip)
        off = self._z[j] - self._z[i]
        apart = np.flatnonzero(np.abs(off) > LEVEL_APART)
        apart = apart[self._overlap(i[apart], j[apart])]
        over, under = np.where(off[apart] > 0, j[apart], i[apart]), np.where(off[apart] > 0, i[apart], j[apart])
        beside = np.flatnonzero((np.abs(off) <= LEVEL_APART) & ~((strip[i] == strip[j]) & (j - i == 1)))
        beside = beside[self._near(i[beside], j[beside], over)]
        beside = beside[self._overlap(i[beside], j[beside])]
        one, other = i[beside], j[beside]
        for _ in range(_MOST_LEVELS):
            before = level.copy()
            np.maximum.at(level, over, level[under] + 1)
            highest = np.maximum(level[one], level[other])
            np.maximum.at(level, one, highest)
            np.maximum.at(level, other, highest)
            if (level == before).all():
                break
        return level

    def _near(self, i: IntArray, j: IntArray, over: IntArray) -> BoolArray:
        """Say which pairs hang together with parts that lie above others."""
        reached = np.zeros(len(self._z), bool)
        reached[over] = True
        for _ in range(_MOST_LEVELS):
            reached[i[reached[j]]] = reached[j[reached[i]]] = True
        out: BoolArray = reached[i] & reached[j]
        return out

    def _overlap(self, i: IntArray, j: IntArray) -> BoolArray:
        """Say which pairs of parts reach into each other, block by block, which saves memory."""
        out = np.zeros(len(i), bool)
        for rows in blocks(len(i)):
            out[rows] = overlap_depths(self._corners[i[rows]], self._corners[j[rows]]) > _DEPTH
        return out

    def above(self, places: FloatArray, z: float, road: int) -> int | None:
        """Return the lowest level of what lies over places, (n, 2), m, above z, m, save one road; None: nothing."""
        low, high = places.min(axis=0), places.max(axis=0)
        near = (self._low <= high).all(axis=1) & (self._high >= low).all(axis=1)
        rows = np.flatnonzero(near & (self._z > z) & (self._road != road))
        inside = (self._low[rows, None] <= places).all(axis=2) & (self._high[rows, None] >= places).all(axis=2)
        levels = self.level[self._at[rows[inside.any(axis=1)]]]
        return int(levels.min()) if len(levels) else None
