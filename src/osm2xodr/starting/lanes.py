"""Lanes that cars drive on, in their directions: which lead to which, and the places along their middles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from osm2xodr.checking import driving_of
from osm2xodr.curves import wrapped
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, lane_borders, pose, speed_limits, surface_points

# Distance of places along lanes, m: a car is longer.
STEP: Final = 1.0
# Of this type are lanes that all cars may use, for all simulators.
_DRIVING: Final = "driving"


@dataclass(frozen=True, eq=False)
class LaneNetwork:
    """Where cars can go in a file.

    A node is a lane in a direction, as of `osm2xodr.checking.Driving`: twice its row, plus 1 against s.
    """

    file: OpenDrive
    nodes: IntArray  # (n,) All of them, ascending
    length: FloatArray  # (2 x lanes,) Of the lane's section along the reference line, m
    # (steps,) Nodes: from the end of one to the beginning of the other
    start: IntArray
    end: IntArray

    @cached_property
    def road(self) -> IntArray:
        """Index of each node's road, (2 x lanes,)."""
        return np.repeat(self.file.sections.road[self.file.lanes.section], 2)

    @cached_property
    def in_junction(self) -> BoolArray:
        """Whether each node is a way through a junction, (2 x lanes,)."""
        return np.asarray(self.file.roads.junction[self.road] != -1)

    @cached_property
    def _metres(self) -> csr_matrix[np.float64]:
        """How much longer a way gets by each step, m."""
        size = len(self.length)
        return csr_matrix((self.length[self.end], (self.start, self.end)), shape=(size, size))

    def ways_from(self, node: int) -> tuple[FloatArray, IntArray]:
        """Return how far it is from the end of a node to that of every other, m, and the node before each."""
        far, before = dijkstra(self._metres, indices=[node], return_predecessors=True)
        return np.asarray(far[0], np.float64), np.asarray(before[0], np.int64)

    def lane(self, node: int) -> tuple[str, int]:
        """Return the ids of the road and the lane of a node."""
        row = node // 2
        return self.file.roads.id[int(self.road[node])], int(self.file.lanes.id[row])

    def section(self, node: int) -> tuple[float, float]:
        """Return s of the begin and end of a node's section, m."""
        section = self.file.lanes.section[node // 2]
        return float(self.file.sections.s[section]), float(self.file.sections.end[section])

    def middle(self, node: int, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places in the middle of a node's lane at s: x, y, z, (n, 3), m, and headings of traffic, rad."""
        road, row = np.full(len(s), self.road[node]), np.full(len(s), node // 2)
        inner, outer = lane_borders(self.file, row, s)
        places = np.column_stack(surface_points(self.file, road, s, 0.5 * (inner + outer)))
        hdg = np.asarray(pose(self.file, road, s)[2]) + (np.pi if node % 2 else 0.0)
        return places, wrapped(hdg)

    @cached_property
    def _limits(self) -> FloatArray:
        return speed_limits(self.file)

    def limit(self, node: int) -> float:
        """Return the speed limit of a node, m/s; NaN where there is none."""
        found = float(self._limits[node // 2])
        return found if np.isfinite(found) else float("nan")


def lane_network(file: OpenDrive) -> LaneNetwork:
    """Return the network of the lanes of type ``driving`` of a file."""
    driving = driving_of(file)
    for_all = np.array([kind == _DRIVING for kind in file.lanes.type], np.bool_)
    is_open = np.column_stack([driving.along & for_all, driving.against & for_all]).ravel()
    kept = is_open[driving.start] & is_open[driving.end]
    section = file.lanes.section
    length = np.repeat(file.sections.end[section] - file.sections.s[section], 2)
    nodes = np.flatnonzero(is_open & (length > 0.0))
    return LaneNetwork(file, nodes, length, driving.start[kept], driving.end[kept])


@dataclass(frozen=True, eq=False)
class Path:
    """A way from lane to lane, as places at even distances."""

    nodes: tuple[int, ...]
    # Each place belongs to one of them, whose s it has
    node: IntArray  # (n,) Index into `nodes`
    s: FloatArray
    place: FloatArray  # (n, 3) x, y, z, m
    hdg: FloatArray  # (n,) Of traffic, rad
    distance: FloatArray  # (n,) From the first place, along the middles of lanes, m
    limit: FloatArray  # (n,) Speed limit, m/s; NaN where there is none

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(self.distance[-1])

    def at(self, distance: FloatArray) -> FloatArray:
        """Return the places at distances, x, y, (n, 2), m."""
        return np.column_stack([np.interp(distance, self.distance, self.place[:, k]) for k in (0, 1)])


def path_along(network: LaneNetwork, nodes: tuple[int, ...], start: float) -> Path:
    """Return the way along nodes, from a distance from the begin of the first of them on, m."""
    columns: list[tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for k, node in enumerate(nodes):
        low, high = network.section(node)
        first = start if k == 0 else 0.0
        count = max(int(np.ceil((high - low - first) / STEP)), 1)
        ahead = first + (high - low - first) * np.arange(count + (k == len(nodes) - 1)) / count
        s = high - ahead if node % 2 else low + ahead
        places, hdg = network.middle(node, s)
        columns.append((np.full(len(s), k), s, places, hdg, np.full(len(s), network.limit(node))))
    node_of, s, places, hdg, limit = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    apart = np.hypot(*np.diff(places[:, :2], axis=0).T)
    distance = np.concatenate([[0.0], np.cumsum(apart)])
    kept = np.concatenate([[True], apart > 0.0])
    return Path(nodes, *(column[kept] for column in (node_of, s, places, hdg, distance, limit)))
