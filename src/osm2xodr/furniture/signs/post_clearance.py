"""Where beside a road there is room for a pole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import CurveFinder, cubic_value, lengths, pose, ranks
from osm2xodr.furniture.world import World, way_at
from osm2xodr.model import FloatArray, IntArray, PlanView

# Roads whose heights differ by more than this are on other levels, m: half of the headroom below bridges.
_SIGN_LEVELS: Final = 2.25

# Curves are looked for in squares of this size, m, and in those around them: larger than what signs reach.
_CELL: Final = 64.0
# How far a pole may be from the reference line of a road that it stands on, m: half of a very wide road.
_REACH: Final = 25.0
_COLUMNS: Final = 1 << 24
# Rounding of distances, m; width of lanes that open behind the last record of their width, m.
_BESIDE: Final = 1e-6
_OPENING: Final = 10.0


class SignRoom:
    """Says whether a place beside a road is on the lanes of another one.

    Parameters
    ----------
    world
        The roads.
    places
        Road and s of all poles, m: what is near none of them is not looked at.
    """

    def __init__(self, world: World, places: Sequence[tuple[int, float]]) -> None:
        self._world = world
        self._half_widths: dict[int, float] = {}
        plan = world.road_map.plan_view
        curve = np.array([world.lanes.index(road) for road, _ in places], np.int64)
        s = np.array([s for _, s in places])
        x, y, _ = pose(plan, curve, s)
        self._finder = CurveFinder(plan, curves_near(plan, x, y))

    def free(self, places: Sequence[tuple[int, float, float]]) -> list[bool]:
        """Say of each place on a road whether no other road has lanes there.

        Parameters
        ----------
        places
            Road, s and t, m.
        """
        out = [True] * len(places)
        if not places:
            return out
        world, plan = self._world, self._world.road_map.plan_view
        own = np.array([world.lanes.index(road) for road, *_ in places], np.int64)
        s, t = np.array([s for _, s, _ in places]), np.array([t for *_, t in places])
        x, y, hdg = pose(plan, own, s)
        point, curve, at, aside, far = self._finder.near(x - t * np.sin(hdg), y + t * np.cos(hdg), _REACH)
        # Beside it, not before its start or beyond its end, and no road of another level.
        near = (curve != own[point]) & (far <= np.abs(aside) + _BESIDE)
        elevation = world.road_map.elevation
        rise = cubic_value(elevation, curve, at) - cubic_value(elevation, own, s)[point]
        rows = np.flatnonzero(near & (np.abs(rise) <= _SIGN_LEVELS))
        for place, other, on, off in zip(
            point[rows].tolist(), curve[rows].tolist(), at[rows].tolist(), aside[rows].tolist(), strict=True
        ):
            if out[place] and abs(off) < self._half_width(other):
                left, right = world.lanes.carriageway(world.road_map.roads[other].id, on)
                at_place = float(x[place]), float(y[place])
                levels = (self._level(road, *at_place) for road in (int(own[place]), other))
                out[place] = not right < off < left or len(set(levels)) > 1
        return out

    def _level(self, curve: int, x: float, y: float) -> int:
        """Return the level of a road near a place.

        On a level world bridges are as high as what is below them; there it is OSM's layer. Roads of junctions are on
        that of the road that they come from.
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

    def _half_width(self, curve: int) -> float:
        """Return how far from its reference line a road has lanes at most, m."""
        if curve not in self._half_widths:
            table = self._world.road_map.lane_offset
            first, last = int(table.start[curve]), int(table.start[curve + 1])
            sides = [0.0]
            for section in self._world.road_map.roads[curve].lane_sections:
                for sign in (1, -1):
                    widths = [lane.widths for lane in section.lanes if lane.id * sign > 0]
                    sides.append(sum(max((item.a for item in width), default=0.0) for width in widths))
            offset = float(np.abs(table.a[first:last]).max()) if last > first else 0.0
            # Lanes that open are narrow where their records begin.
            self._half_widths[curve] = max(sides) + offset + _OPENING
        return self._half_widths[curve]


def curves_near(plan: PlanView, x: FloatArray, y: FloatArray) -> IntArray:
    """Return the indices of all curves within a cell's size of points, and of some more, ascending."""
    if not len(x) or not len(plan.s):
        return np.zeros(0, np.int64)
    step = np.arange(-1, 2)
    column = np.floor(x / _CELL).astype(np.int64)[:, None] + np.repeat(step, 3)
    row = np.floor(y / _CELL).astype(np.int64)[:, None] + np.tile(step, 3)
    cells = np.unique(column * _COLUMNS + row)
    owner = np.repeat(np.arange(len(plan.start) - 1), np.diff(plan.start))
    # Every record has a place in each half of a cell.
    parts = np.maximum(np.ceil(plan.length / (0.5 * _CELL)).astype(np.int64), 1)
    curve = np.repeat(owner, parts)
    rank = ranks(parts)
    s = np.repeat(plan.s, parts) + np.repeat(plan.length / parts, parts) * (rank + 0.5)
    s = np.minimum(s, lengths(plan)[curve])
    px, py, _ = pose(plan, curve, s)
    key = np.floor(px / _CELL).astype(np.int64) * _COLUMNS + np.floor(py / _CELL).astype(np.int64)
    found: IntArray = np.unique(curve[np.isin(key, cells)])
    return found
