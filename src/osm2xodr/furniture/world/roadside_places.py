"""Where things beside roads lie: the road whose edge is nearest, s and t there; posts are kept off other roads."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.curves import (
    CurveFinder,
    Table,
    cubic_value,
    find_record,
    join_tables,
    lengths,
    places_along,
    pose,
    starts,
    unique_first,
    unique_inverse,
)
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world.world import World, pieces_on_road, points_beside, way_at
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure
from osm2xodr.system import record

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
# How far a post may be from the reference line of a road on which it stands, m: half of a very wide road.
_POST_REACH: Final = 25.0
# Rounding of distances, m.
_DISTANCE_ROUNDING: Final = 1e-6


@record(eq=False)
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


class RoadsideFinder:
    """Finds places beside the roads outside junctions."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._plan = world.road_map.plan_view
        self._length = lengths(self._plan)
        self._edges: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = {}

    def places(self, x: FloatArray, y: FloatArray, reach: float = defaults.OBJECT_REACH) -> RoadsidePlaces:
        """Return the places of points (n,), m, beside the nearest carriageway within reach of its edge.

        A reach below 0 asks for points on carriageways, so far within them. Points in junctions have none.
        """
        begins = range(0, max(len(x), 1), _AT_ONCE)
        return join_tables(self._places(x[k : k + _AT_ONCE], y[k : k + _AT_ONCE], reach) for k in begins)

    def _places(self, x: FloatArray, y: FloatArray, reach: float) -> RoadsidePlaces:
        """Return the places of some of the points."""
        point, curve, s, t, left, right = self._beside(self._world.outside_junctions, x, y, reach + _HALF_WIDTH_MAX)
        beyond = np.maximum(t - left, right - t)
        near = (beyond <= reach) & ~self._covered(curve, s)
        order = np.flatnonzero(near)[np.lexsort((curve[near], beyond[near], point[near]))]
        order = order[unique_first(point[order])[1]]
        out = RoadsidePlaces(np.full(len(x), -1, np.int64), *(np.full(len(x), np.nan) for _ in range(4)))
        at = point[order]
        # Points on connecting roads lie in a junction, even where it is wider than its arms.
        crossing = self._beside(self._world.in_junctions, x[at], y[at], _HALF_WIDTH_MAX_CONNECTING)
        crossed, _, _, lateral, one, other = crossing
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
        point, curve, s, t, left, right = self._beside(self._world.in_junctions, x, y, _HALF_WIDTH_MAX_CONNECTING)
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

    def _beside(
        self, finder: CurveFinder, x: FloatArray, y: FloatArray, reach: float
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return points, curves that they lie beside, s, t, and t of the carriageway's edges, all (m,)."""
        point, curve, s, t, distance = finder.nearest(x, y, reach, _NEIGHBOURS)
        beside = distance - np.abs(t) <= _AT_ENDS_TOLERANCE
        point, curve, s, t = point[beside], curve[beside], s[beside], t[beside]
        left, right = self.edges(curve, s)
        return point, curve, s, t, left, right

    def edges(self, curve: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t of the left and right edge of the carriageways of roads at s, (n,), m."""
        used, owner = unique_inverse(curve)
        if not len(used):
            return np.zeros(0), np.zeros(0)
        self._add_tables(np.array([k for k in used.tolist() if k not in self._edges], np.int64))
        tables = [self._edges[k] for k in used.tolist()]
        start = starts([len(item[0]) for item in tables])
        stations, left, right = (np.concatenate(column) for column in zip(*tables, strict=True))
        k = find_record(start, stations, owner, s)
        following = np.minimum(k + 1, start[owner + 1] - 1)
        apart, ds = np.where(following > k, stations[following] - stations[k], 1.0), s - stations[k]
        one, other = (edge[k] + (edge[following] - edge[k]) / apart * ds for edge in (left, right))
        return one, other

    def _add_tables(self, curves: IntArray) -> None:
        """Work out stations along roads, and t of their carriageway's left and right edge there, m."""
        lanes, roads = self._world.lanes, self._world.road_map.roads
        changing = np.array([lanes.change_along(k) for k in curves.tolist()], np.bool_)
        even, s = places_along(self._plan, _STATION_SPACING, curves[changing])
        last = np.diff(even, append=-1) != 0
        s[last] = self._length[even[last]]
        begins = [[section.s for section in roads[k].lane_sections] for k in curves.tolist()]
        each = np.repeat(curves, [len(of_road) for of_road in begins])
        curve = np.concatenate([even, each])
        s = np.concatenate([s, np.minimum(np.concatenate([np.zeros(0), *begins]), self._length[each])])
        order = np.lexsort((s, curve))
        curve, s = curve[order], s[order]
        new = (np.diff(curve, prepend=-1) != 0) | (np.diff(s, prepend=-1.0) != 0.0)
        curve, s = curve[new], s[new]
        columns = (s, *lanes.carriageways(curve, s))
        for k, (first, end) in zip(curves.tolist(), np.searchsorted(curve, [curves, curves + 1]).T, strict=True):
            stations, left, right = (column[first:end] for column in columns)
            self._edges[k] = stations, left, right


def free_of_other_roads(world: World, places: Sequence[tuple[int, float, float]]) -> list[bool]:
    """Return for each place (road, s, t, m) whether no other road has lanes there."""
    out = [True] * len(places)
    if not places:
        return out
    plan = world.road_map.plan_view
    own = np.array([world.lanes.index(road) for road, *_ in places], np.int64)
    s, t = np.array([s for _, s, _ in places]), np.array([t for *_, t in places])
    x, y, _ = pose(plan, own, s)
    at_x, at_y, _ = points_beside(plan, own, s, t)
    found = [finder.near(at_x, at_y, _POST_REACH) for finder in (world.outside_junctions, world.in_junctions)]
    point, curve, at, lateral, far = (np.concatenate(column) for column in zip(*found, strict=True))
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
            levels = (_level(world, road, *at_place) for road in (int(own[place]), other))
            out[place] = not right < off < left or len(set(levels)) > 1
    return out


def _level(world: World, curve: int, x: float, y: float) -> int:
    """Return OSM's layer of a road near a place, or 0 where heights show which roads are above others.

    Connecting roads have the layer of the road that they come from.
    """
    if world.road_map.elevation_report is not None:
        return 0
    streets = world.places.road_street
    if curve >= len(streets):
        before = world.road_map.roads[curve].predecessor
        if before is None or before.to_junction:
            return 0
        curve = world.lanes.index(before.id)
    return way_at(world.network.streets[int(streets[curve])], x, y).layer
