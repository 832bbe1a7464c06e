"""Where things beside roads lie: the road whose edge is nearest, s and t there; posts are kept off other roads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.curves import (
    SAMPLE_SPACING,
    CurveFinder,
    PointTree,
    Table,
    cubic_value,
    find_record,
    join_tables,
    lengths,
    owners,
    pose,
    project,
    ranks,
    sample_curves,
    sorted_unique,
    starts,
    unique_first,
    unique_inverse,
)
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world.world import World, pieces_on_road, points_beside, way_at
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView, Structure

# Samples of curves that are looked at for each point: enough for the next road at a junction of four arms.
_NEIGHBOURS: Final = 12
# So many points are looked up together: few enough for the memory that all pairs of points and curves need.
_AT_ONCE: Final = 5000
# Half of the widest carriageway beside which things are found, m; and of connecting roads, which have few lanes.
_HALF_WIDTH_MAX: Final = 20.0
_HALF_WIDTH_MAX_CONNECTING: Final = 6.0
# A point whose distance from a curve exceeds |t| by more lies before its start or beyond its end, m.
_AT_ENDS_TOLERANCE: Final = 0.01
# Distance of the stations at which the edges of carriageways that change are looked up, m.
_STATION_SPACING: Final = 3.0

# Roads whose heights differ by more are on different levels, m: half of the headroom below bridges.
_OTHER_LEVEL: Final = 2.25
# Size of the square cells in which curves are looked up, with the cells around, m: larger than the reach of signs.
_CELL: Final = 64.0
# Number of columns of cells; a cell's key is its column times this plus its row.
_COLUMNS: Final = 1 << 24
# How far a post may be from the reference line of a road on which it stands, m: half of a very wide road.
_POST_REACH: Final = 25.0
# Rounding of distances, m.
_DISTANCE_ROUNDING: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class RoadsidePlaces(Table):
    """Places of points beside roads outside junctions, all (n,); NaN without a road."""

    road: IntArray  # Index of the road, -1 where none is within reach
    s: FloatArray  # Where on it, m
    t: FloatArray  # m
    left: FloatArray  # t of the left edge of its carriageway there, m
    right: FloatArray  # Of the right edge, m

    @property
    def beyond(self) -> FloatArray:
        """How far outside the carriageway each point lies, below 0 on it, m."""
        return np.maximum(self.t - self.left, self.right - self.t)


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """Points along curves."""

    tree: PointTree
    curve: IntArray  # The curve of each point


class RoadsideFinder:
    """Finds places beside the roads outside junctions."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._plan = world.road_map.plan_view
        self._length = lengths(self._plan)
        self._edges: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = {}

    @cached_property
    def _outside(self) -> _Samples:
        """Samples of the roads outside junctions, which come first."""
        return _sampled(self._plan, np.arange(len(self._world.places.road_street)))

    @cached_property
    def _connecting(self) -> _Samples:
        """Samples of the connecting roads."""
        return _sampled(self._plan, np.arange(len(self._world.places.road_street), len(self._length)))

    def places(self, x: FloatArray, y: FloatArray, reach: float = defaults.OBJECT_REACH) -> RoadsidePlaces:
        """Return the places of points (n,), m, beside the nearest carriageway within reach of its edge.

        A reach below 0 asks for points on carriageways, so far within them. Points in junctions have none.
        """
        begins = range(0, max(len(x), 1), _AT_ONCE)
        return join_tables(self._places(x[k : k + _AT_ONCE], y[k : k + _AT_ONCE], reach) for k in begins)

    def _places(self, x: FloatArray, y: FloatArray, reach: float) -> RoadsidePlaces:
        """Return the places of some of the points."""
        point, curve, s, t, left, right = self._beside(self._outside, x, y, reach + _HALF_WIDTH_MAX)
        beyond = np.maximum(t - left, right - t)
        near = (beyond <= reach) & ~self._covered(curve, s)
        order = np.flatnonzero(near)[np.lexsort((curve[near], beyond[near], point[near]))]
        order = order[unique_first(point[order])[1]]
        out = RoadsidePlaces(np.full(len(x), -1, np.int64), *(np.full(len(x), np.nan) for _ in range(4)))
        at = point[order]
        # Points on connecting roads lie in a junction, even where it is wider than its arms.
        crossed, _, _, lateral, one, other = self._beside(self._connecting, x[at], y[at], _HALF_WIDTH_MAX_CONNECTING)
        free = np.ones(len(at), np.bool_)
        free[crossed[(lateral < one) & (lateral > other)]] = False
        at, order = at[free], order[free]
        out.road[at], out.s[at], out.t[at] = curve[order], s[order], t[order]
        out.left[at], out.right[at] = left[order], right[order]
        return out

    def on_connecting_roads(self, x: FloatArray, y: FloatArray) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Return the points (n,) that lie on lanes through junctions: point, index of the road, s and t, all (m,).

        A point may lie on several roads.
        """
        point, curve, s, t, left, right = self._beside(self._connecting, x, y, _HALF_WIDTH_MAX_CONNECTING)
        on = (t < left) & (t > right)
        return point[on], curve[on], s[on], t[on]

    def _covered(self, curve: IntArray, s: FloatArray) -> BoolArray:
        """Return which places on roads lie in tunnels: what OSM has there is above them."""
        out = np.zeros(len(curve), np.bool_)
        for road, parts in self._tunnels.items():
            rows = np.flatnonzero(curve == road)
            for begin, end in parts:
                out[rows] |= (begin <= s[rows]) & (s[rows] <= end)
        return out

    @cached_property
    def _tunnels(self) -> dict[int, list[tuple[float, float]]]:
        """(start, end) of tunnels by the index of their road, m."""
        world, out = self._world, {}
        for k, index in enumerate(world.places.road_street.tolist()):
            street = world.network.streets[index]
            if any(piece.structure is Structure.TUNNEL for _, piece in street.pieces):
                pieces = pieces_on_road(world, street, world.road_map.roads[k].id)
                out[k] = [(begin, end) for begin, end, piece in pieces if piece.structure is Structure.TUNNEL]
        return out

    def edges(self, curve: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t of the left and right edge of a road's carriageway at s, (n,), m."""
        stations, left, right = self._table(curve)
        return np.interp(s, stations, left), np.interp(s, stations, right)

    def _beside(
        self, samples: _Samples, x: FloatArray, y: FloatArray, reach: float
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return points, curves that they lie beside, s, t, and t of the carriageway's edges, all (m,)."""
        point, curve = _pairs(samples, x, y, reach + SAMPLE_SPACING)
        s, t, distance = project(self._plan, curve, x[point], y[point])
        beside = (distance - np.abs(t) <= _AT_ENDS_TOLERANCE) & (distance <= reach)
        point, curve, s, t = point[beside], curve[beside], s[beside], t[beside]
        left, right = self._edges_at(curve, s)
        return point, curve, s, t, left, right

    def _edges_at(self, curve: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what `edges` does, for places on several roads."""
        used, owner = unique_inverse(curve)
        if not len(used):
            return np.zeros(0), np.zeros(0)
        tables = [self._table(k) for k in used.tolist()]
        start = starts([len(item[0]) for item in tables])
        stations, left, right = (np.concatenate(column) for column in zip(*tables, strict=True))
        k = find_record(start, stations, owner, s)
        following = np.minimum(k + 1, start[owner + 1] - 1)
        apart, ds = np.where(following > k, stations[following] - stations[k], 1.0), s - stations[k]
        one, other = (edge[k] + (edge[following] - edge[k]) / apart * ds for edge in (left, right))
        return one, other

    def _table(self, curve: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return stations along a road and t of its carriageway's left and right edge there, m."""
        found = self._edges.get(curve)
        if found is None:
            road, length, stations = self._world.road_map.roads[curve], float(self._length[curve]), np.zeros(1)
            if self._changes(curve):
                count = max(int(np.ceil(length / _STATION_SPACING)), 1) + 1
                begins = [min(section.s, length) for section in road.lane_sections]
                stations = np.unique(np.concatenate([np.linspace(0.0, length, count), begins]))
            found = self._edges[curve] = (stations, *self._world.lanes.carriageways(road.id, stations))
        return found

    def _changes(self, curve: int) -> bool:
        """Return whether the edges of a road's carriageway change along it."""
        sections, offset = self._world.road_map.roads[curve].lane_sections, self._world.road_map.lane_offset
        records = slice(int(offset.start[curve]), int(offset.start[curve + 1]))
        widths = [lane.widths for lane in sections[0].lanes]
        return (
            len(sections) > 1
            or len(offset.s[records]) > 1
            or any(bool(cubics[records].any()) for cubics in (offset.b, offset.c, offset.d))
            or any(len(cubics) > 1 or not all(item.is_flat for item in cubics) for cubics in widths)
        )


def _sampled(plan: PlanView, curves: IntArray) -> _Samples:
    curve, x, y = sample_curves(plan, curves)
    return _Samples(PointTree(np.column_stack([x, y])), curve)


def _pairs(samples: _Samples, x: FloatArray, y: FloatArray, reach: float) -> tuple[IntArray, IntArray]:
    """Return the pairs of points and curves near them, each once, ascending."""
    _, found = samples.tree.neighbours(np.column_stack([x, y]), _NEIGHBOURS, reach)
    point, rank = np.nonzero(found >= 0)
    curves = int(samples.curve.max(initial=0)) + 1
    pair = sorted_unique(point * curves + samples.curve[found[point, rank]])
    return pair // curves, pair % curves


class PostClearance:
    """Finds out whether places beside roads are on the lanes of other roads, near given places (road, s) of posts."""

    def __init__(self, world: World, places: Sequence[tuple[int, float]]) -> None:
        self._world = world
        plan = world.road_map.plan_view
        curve = np.array([world.lanes.index(road) for road, _ in places], np.int64)
        s = np.array([s for _, s in places])
        x, y, _ = pose(plan, curve, s)
        self._finder = CurveFinder(plan, curves_near(plan, x, y))

    def are_free(self, places: Sequence[tuple[int, float, float]]) -> list[bool]:
        """Return for each place (road, s, t, m) whether no other road has lanes there."""
        out = [True] * len(places)
        if not places:
            return out
        world, plan = self._world, self._world.road_map.plan_view
        own = np.array([world.lanes.index(road) for road, *_ in places], np.int64)
        s, t = np.array([s for _, s, _ in places]), np.array([t for *_, t in places])
        x, y, _ = pose(plan, own, s)
        point, curve, at, lateral, far = self._finder.near(*points_beside(plan, own, s, t)[:2], _POST_REACH)
        # Roads that the place lies beside, not before their start or beyond their end, and on the same level.
        near = (curve != own[point]) & (far <= np.abs(lateral) + _DISTANCE_ROUNDING)
        elevation = world.road_map.elevation
        rise = cubic_value(elevation, curve, at) - cubic_value(elevation, own, s)[point]
        rows = np.flatnonzero(near & (np.abs(rise) <= _OTHER_LEVEL))
        columns = (column[rows].tolist() for column in (point, curve, at, lateral))
        for place, other, on, off in zip(*columns, strict=True):
            if out[place]:
                left, right = world.lanes.carriageway(world.road_map.roads[other].id, on)
                at_place = float(x[place]), float(y[place])
                levels = (self._level(road, *at_place) for road in (int(own[place]), other))
                out[place] = not right < off < left or len(set(levels)) > 1
        return out

    def _level(self, curve: int, x: float, y: float) -> int:
        """Return OSM's layer of a road near a place, or 0 where heights show which roads are above others.

        Connecting roads have the layer of the road that they come from.
        """
        if self._world.road_map.elevation_report is not None:
            return 0
        streets = self._world.places.road_street
        if curve >= len(streets):
            before = self._world.road_map.roads[curve].predecessor
            if before is None or before.to_junction:
                return 0
            curve = self._world.lanes.index(before.id)
        return way_at(self._world.network.streets[int(streets[curve])], x, y).layer


def curves_near(plan: PlanView, x: FloatArray, y: FloatArray) -> IntArray:
    """Return the indices of all curves within a cell's size of points, and of some more, ascending; points in m."""
    if not len(x) or not len(plan.s):
        return np.zeros(0, np.int64)
    step = np.arange(-1, 2)
    column = np.floor(x / _CELL).astype(np.int64)[:, None] + np.repeat(step, 3)
    row = np.floor(y / _CELL).astype(np.int64)[:, None] + np.tile(step, 3)
    cells = sorted_unique(column * _COLUMNS + row)
    owner = owners(plan.start)
    # Samples that are at most half a cell apart.
    parts = np.maximum(np.ceil(plan.length / (0.5 * _CELL)).astype(np.int64), 1)
    curve = np.repeat(owner, parts)
    rank = ranks(parts)
    s = np.repeat(plan.s, parts) + np.repeat(plan.length / parts, parts) * (rank + 0.5)
    s = np.minimum(s, lengths(plan, curve))
    px, py, _ = pose(plan, curve, s)
    key = np.floor(px / _CELL).astype(np.int64) * _COLUMNS + np.floor(py / _CELL).astype(np.int64)
    return sorted_unique(curve[np.isin(key, cells)])
