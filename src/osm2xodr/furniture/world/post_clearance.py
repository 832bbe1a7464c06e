"""Keeps posts beside a road off the lanes of other roads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import CurveFinder, cubic_value, lengths, owners, pose, ranks, sorted_unique
from osm2xodr.furniture.world.world import World, points_beside, way_at
from osm2xodr.model import FloatArray, IntArray, PlanView

# Roads whose heights differ by more are on different levels, m: half of the headroom below bridges.
_OTHER_LEVEL: Final = 2.25
# Size of the square cells in which curves are looked up, with the cells around, m: larger than the reach of signs.
_CELL: Final = 64.0
# Number of columns of cells; a cell's key is its column times this plus its row.
_COLUMNS: Final = 1 << 24
# How far a post may be from the reference line of a road on which it stands, m: half of a very wide road.
_REACH: Final = 25.0
# Rounding of distances, m.
_BESIDE_TOLERANCE: Final = 1e-6


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
        point, curve, at, lateral, far = self._finder.near(*points_beside(plan, own, s, t)[:2], _REACH)
        # Roads that the place lies beside, not before their start or beyond their end, and on the same level.
        near = (curve != own[point]) & (far <= np.abs(lateral) + _BESIDE_TOLERANCE)
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
