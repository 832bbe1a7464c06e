"""Where the lanes of roads lie across them, and where nodes of streets lie on the roads outside junctions."""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import takewhile
from typing import Final

import numpy as np

from osm2xodr.conventions import places_on_streets
from osm2xodr.curves import (
    arctan2,
    cosine,
    cubic_value,
    find_record,
    lengths,
    pose,
    profile_of,
    project,
    sine,
    starts,
    unique_inverse,
)
from osm2xodr.model import (
    Cubic,
    FloatArray,
    IntArray,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadMap,
    Rule,
    StreetNetwork,
    StreetPlaces,
)
from osm2xodr.system import record

# Lanes beyond the kerb or the edge of the pavement; the carriageway lies between the innermost of them.
OFF_CARRIAGEWAY: Final = frozenset({LaneType.SIDEWALK, LaneType.BORDER, LaneType.CURB})

# Nodes beyond a road's end by less lie on it, m: rounding.
_END_TOLERANCE: Final = 1e-6


@record
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


@record
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

    def carriageways(self, curve: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what `carriageway` does for many places, (n,), by the indices of their roads."""
        used, owner = unique_inverse(curve)
        of_road = [self._map.roads[k].lane_sections for k in used.tolist()]
        sections = [section for group in of_road for section in group]
        begin = np.array([section.s for section in sections])
        at = find_record(starts([len(group) for group in of_road]), begin, owner, s)
        ds = s - begin[at]
        left = cubic_value(self._map.lane_offset, curve, s)
        right = left.copy()
        sides = [self._sides_of(section) for section in sections]
        for edge, sign, lanes in (
            (left, 1.0, [item.paved_left for item in sides]),
            (right, -1.0, [item.paved_right for item in sides]),
        ):
            first = starts([len(group) for group in lanes])
            widths = profile_of([lane.widths for group in lanes for lane in group])
            count = np.diff(first)[at]
            for rank in range(int(count.max(initial=0))):
                rows = np.flatnonzero(count > rank)
                edge[rows] += sign * np.maximum(cubic_value(widths, first[at[rows]] + rank, ds[rows]), 0.0)
        return left, right

    def change_along(self, k: int) -> bool:
        """Return whether the edges of the carriageway of the k-th road change along it."""
        sections, offsets = self._map.roads[k].lane_sections, self._offsets[self._first[k] : self._first[k + 1]]
        return (
            len(sections) > 1
            or len(offsets) > 1
            or any(any(terms[1:]) for terms in offsets)
            or any(
                len(lane.widths) > 1 or not all(item.is_flat for item in lane.widths) for lane in sections[0].lanes
            )
        )

    def section_start(self, road: int, s: float) -> float:
        """Return where the lane section begins that holds at s of a road, m."""
        return self._section(self._index[road], s)[0].s

    def _section(self, k: int, s: float) -> tuple[LaneSection, _Sides]:
        """Return the lane section that holds at s of the k-th road, and its lanes by sides."""
        sections = self._map.roads[k].lane_sections
        section = sections[0]
        if len(sections) > 1:
            section = sections[max(bisect_right([item.s for item in sections], s) - 1, 0)]
        return section, self._sides_of(section)

    def _sides_of(self, section: LaneSection) -> _Sides:
        """Return the lanes of a section by sides."""
        # Equal sections of roads are one object, which the map keeps alive: its identity is a safe key.
        sides = self._sides.get(id(section))
        if sides is None:
            sides = self._sides[id(section)] = _Sides.of(section)
        return sides

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


@record
class NodePlace:
    """One place of a node on a street."""

    node: int  # OSM id
    street: int  # Index of the street
    # Local position, m, and direction of the street there, rad
    x: float
    y: float
    hdg: float
    road: int  # Id of the street's road nearest to it; -1 where the street lies inside a junction
    s: float  # Where on that road, m; before 0 or beyond its length for nodes in the junction there
    junction: int  # Id of the junction that it lies in, -1 for none


@record
class Arm:
    """A road's end at a junction."""

    road: int
    at_end: bool
    # Local position, m, and the road's heading there, rad
    x: float
    y: float
    hdg: float


class NodePlaces:
    """Finds the places of nodes of streets."""

    def __init__(self, network: StreetNetwork, road_map: RoadMap, places: StreetPlaces, lanes: LaneTable) -> None:
        self._network = network
        self._road_map = road_map
        self._places = places
        self._lanes = lanes

    @cached_property
    def _tagged(self) -> Mapping[tuple[int, int], list[int]]:
        """Rows of `StreetPlaces` by node and street."""
        out: dict[tuple[int, int], list[int]] = defaultdict(list)
        places = self._places
        for row, key in enumerate(zip(places.node.tolist(), places.street.tolist(), strict=True)):
            out[key].append(row)
        return out

    @cached_property
    def _roads(self) -> Mapping[int, list[int]]:
        """Indices of each street's roads."""
        out: dict[int, list[int]] = defaultdict(list)
        for k, street in enumerate(self._places.road_street.tolist()):
            out[street].append(k)
        return out

    @cached_property
    def arms(self) -> Mapping[int, tuple[Arm, ...]]:
        """Road ends by their junction, in the order of streets."""
        places, lanes = self._places, self._lanes
        used = np.flatnonzero((places.end_road >= 0) & (places.end_junction >= 0))
        road = places.end_road[used].tolist()
        at_end = (used % 2).astype(bool).tolist()
        curve = np.array([lanes.index(item) for item in road], np.int64)
        s = np.array([lanes.length(item) if last else 0.0 for item, last in zip(road, at_end, strict=True)])
        x, y, hdg = pose(self._road_map.plan_view, curve, s)
        out: dict[int, list[Arm]] = defaultdict(list)
        found = map(Arm, road, at_end, x.tolist(), y.tolist(), hdg.tolist())
        for junction, arm in zip(places.end_junction[used].tolist(), found, strict=True):
            out[junction].append(arm)
        return {junction: tuple(arms) for junction, arms in out.items()}

    def on_streets(self, nodes: Iterable[int]) -> dict[int, list[NodePlace]]:
        """Return all places on streets of nodes, by OSM id, in the order of streets; nodes on none are left out."""
        seen: dict[tuple[int, int], int] = defaultdict(int)
        out: dict[int, list[NodePlace]] = defaultdict(list)
        for street, at in places_on_streets(self._network.streets, nodes):
            key = int(street.node_ids[at]), street.id
            out[key[0]].append(self._place(*key, at, seen[key]))
            seen[key] += 1
        return out

    def _place(self, node: int, street: int, at: int, again: int) -> NodePlace:
        points = self._network.streets[street].points
        x, y = points[at].tolist()
        along = points[min(at + 1, len(points) - 1)] - points[max(at - 1, 0)]
        if not along.any():
            # The start and end of a loop: the direction in which it begins.
            along = points[1] - points[0]
        hdg = float(arctan2(along[1], along[0]))
        rows, places = self._tagged.get((node, street), [])[again:], self._places
        if rows:
            found = int(places.road[rows[0]]), float(places.s[rows[0]]), int(places.junction[rows[0]])
        else:
            found = self._find(street, points[at])
        return NodePlace(node, street, x, y, hdg, *found)

    def _find(self, street: int, point: FloatArray) -> tuple[int, float, int]:
        """Return road, s and junction, as in `NodePlace`, of a node that is not in `StreetPlaces`."""
        places = self._places
        roads = self._roads.get(street)
        if not roads:
            return -1, float("nan"), int(places.end_junction[2 * street])
        plan, curves = self._road_map.plan_view, np.array(roads, np.int64)
        s, _, distance = project(plan, curves, *(np.full(len(roads), value) for value in point))
        best = int(np.argmin(distance))
        (x,), (y,), (hdg,) = pose(plan, curves[best : best + 1], s[best : best + 1])
        road = self._road_map.roads[roads[best]].id
        at = float(s[best] + ((point[0] - x) * cosine(hdg) + (point[1] - y) * sine(hdg)))
        beyond = at > self._lanes.length(road) + _END_TOLERANCE
        off = at < -_END_TOLERANCE or beyond
        return road, at, int(places.end_junction[2 * street + beyond]) if off else -1
