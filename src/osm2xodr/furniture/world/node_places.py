"""Where nodes of streets lie on the roads outside junctions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from osm2xodr.conventions import places_on_streets
from osm2xodr.curves import (
    arctan2,
    cosine,
    pose,
    project,
    sine,
)
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.model import FloatArray, RoadMap, StreetNetwork, StreetPlaces

# Nodes beyond a road's end by less lie on it, m: rounding.
_END_TOLERANCE: Final = 1e-6


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
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
