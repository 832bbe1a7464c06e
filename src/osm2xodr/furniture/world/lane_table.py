"""Where the lanes of roads lie across them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Final

import numpy as np

from osm2xodr.curves import lengths
from osm2xodr.model import Cubic, FloatArray, Lane, LaneSection, LaneType, Road, RoadMap, Rule

# Lanes beyond the kerb or the edge of the pavement; the carriageway lies between the innermost of them.
OFF_CARRIAGEWAY: Final = frozenset({LaneType.SIDEWALK, LaneType.BORDER, LaneType.CURB})


@dataclass(frozen=True, slots=True)
class LaneAt:
    """A lane at one place."""

    id: int
    type: LaneType
    left: float  # t of its left edge, m
    right: float  # t of its right edge, m; less than left

    @property
    def middle(self) -> float:
        """T of its middle, m."""
        return 0.5 * (self.left + self.right)


@dataclass(frozen=True, slots=True)
class _Sides:
    """The lanes left and right of the centre, outwards, and those of them that are part of the carriageway."""

    left: tuple[Lane, ...]
    right: tuple[Lane, ...]
    paved_left: tuple[Lane, ...]
    paved_right: tuple[Lane, ...]

    @classmethod
    def of(cls, section: LaneSection) -> _Sides:
        """Sort the lanes of a section."""
        lanes = sorted(section.lanes, key=lambda lane: abs(lane.id))
        left, right = (tuple(lane for lane in lanes if lane.id * side > 0) for side in (1, -1))
        paved = (tuple(takewhile(lambda lane: lane.type not in OFF_CARRIAGEWAY, side)) for side in (left, right))
        return cls(left, right, *paved)


def lane_ranges(lanes: Iterable[int]) -> tuple[tuple[int, int], ...]:
    """Return lane ids as ascending ranges (first, last) without gaps."""
    out: list[tuple[int, int]] = []
    for lane in sorted(set(lanes)):
        first = out.pop()[0] if out and lane - out[-1][1] == 1 else lane
        out.append((first, lane))
    return tuple(out)


class LaneTable:
    """Looks up lanes by road id and s."""

    def __init__(self, road_map: RoadMap) -> None:
        self._map = road_map
        self._index = {road.id: k for k, road in enumerate(road_map.roads)}
        self._length = lengths(road_map.plan_view).tolist()
        self._sides: dict[int, _Sides] = {}
        offset = road_map.lane_offset
        # As lists, which are faster than arrays for single values.
        self._first = offset.start.tolist()
        self._offset_s = offset.s.tolist()
        self._offsets = np.column_stack([offset.a, offset.b, offset.c, offset.d]).tolist()

    def index(self, road: int) -> int:
        """Return the index of a road in the tables of the road map."""
        return self._index[road]

    def road(self, road: int) -> Road:
        """Return a road by its id."""
        return self._map.roads[self._index[road]]

    def length(self, road: int) -> float:
        """Return the length of a road, m."""
        return float(self._length[self._index[road]])

    def runs_along(self, lane: int) -> bool:
        """Return whether traffic on a lane runs along s, by the side of the centre on which it lies."""
        return (lane < 0) == (self._map.rule is Rule.RIGHT_HAND)

    def lanes(self, road: int, s: float) -> tuple[Lane, ...]:
        """Return all lanes but the centre at s of a road, those on the left, then those on the right, outwards."""
        sides = self._section(self._index[road], s)[1]
        return sides.left + sides.right

    def at(self, road: int, s: float) -> tuple[LaneAt, ...]:
        """Return all lanes but the centre at s of a road, from left to right."""
        k = self._index[road]
        section, sides = self._section(k, s)
        out: list[LaneAt] = []
        for side, lanes in ((1.0, sides.left), (-1.0, sides.right)):
            edge = self._offset(k, s)
            found = []
            for lane in lanes:
                outer = edge + side * _value(lane.widths, s - section.s)
                found.append(LaneAt(lane.id, lane.type, max(edge, outer), min(edge, outer)))
                edge = outer
            out += found[::-1] if side > 0 else found
        return tuple(out)

    def carriageway(self, road: int, s: float) -> tuple[float, float]:
        """Return t of the left and right edge of the carriageway, m.

        It ends at the first lane of `OFF_CARRIAGEWAY` on either side; without lanes both edges are the centre.
        """
        k = self._index[road]
        section, sides = self._section(k, s)
        left = right = self._offset(k, s)
        for lane in sides.paved_left:
            left += _value(lane.widths, s - section.s)
        for lane in sides.paved_right:
            right -= _value(lane.widths, s - section.s)
        return left, right

    def carriageways(self, road: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what `carriageway` does for many places in ascending order, (n,)."""
        k = self._index[road]
        begins = [section.s for section in self._map.roads[k].lane_sections]
        left = np.array([self._offset(k, at) for at in s.tolist()])
        right = left.copy()
        first = np.searchsorted(s, begins).tolist()
        for place, lo, hi in zip(begins, [0, *first[1:]], [*first[1:], len(s)], strict=True):
            sides, ds = self._section(k, place)[1], s[lo:hi] - place
            for lane in sides.paved_left:
                left[lo:hi] += _values(lane.widths, ds)
            for lane in sides.paved_right:
                right[lo:hi] -= _values(lane.widths, ds)
        return left, right

    def section_start(self, road: int, s: float) -> float:
        """Return where the lane section begins that holds at s of a road, m."""
        return self._section(self._index[road], s)[0].s

    def _section(self, k: int, s: float) -> tuple[LaneSection, _Sides]:
        """Return the lane section that holds at s of the k-th road, and its lanes by sides."""
        sections = self._map.roads[k].lane_sections
        section = sections[0]
        if len(sections) > 1:
            section = sections[max(bisect_right([item.s for item in sections], s) - 1, 0)]
        # Equal sections of roads are one object, which the map keeps alive: its identity is a safe key.
        sides = self._sides.get(id(section))
        if sides is None:
            sides = self._sides[id(section)] = _Sides.of(section)
        return section, sides

    def _offset(self, k: int, s: float) -> float:
        first, last = self._first[k], self._first[k + 1]
        if first == last:
            return 0.0
        row = max(bisect_right(self._offset_s, s, first, last) - 1, first)
        a, b, c, d = self._offsets[row]
        ds = s - self._offset_s[row]
        return float(a + ds * (b + ds * (c + ds * d)))


def _value(cubics: Sequence[Cubic], ds: float) -> float:
    """Return the value of piecewise cubics, never below 0."""
    if not cubics:
        return 0.0
    holding = cubics[0]
    if len(cubics) > 1:
        holding = next((item for item in reversed(cubics) if item.s <= ds), holding)
    return max(holding.at(ds - holding.s), 0.0)


def _values(cubics: Sequence[Cubic], ds: FloatArray) -> float | FloatArray:
    """Return the values of piecewise cubics at places in ascending order, never below 0, (n,)."""
    if len(cubics) < 2 and all(item.is_flat for item in cubics):
        return max(cubics[0].a, 0.0) if cubics else 0.0
    out = np.zeros(len(ds))
    first = np.searchsorted(ds, [item.s for item in cubics]).tolist()
    for item, lo, hi in zip(cubics, [0, *first[1:]], [*first[1:], len(ds)], strict=True):
        at = ds[lo:hi] - item.s
        out[lo:hi] = item.a + at * (item.b + at * (item.c + at * item.d))
    return np.maximum(out, 0.0)
