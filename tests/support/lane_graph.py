"""Where one can drive in an OpenDRIVE file: a graph of its lanes for cars."""

from __future__ import annotations

import heapq
import math
from collections import defaultdict

import numpy as np
from xodr_file import CAR_LANES, Road, Section, XodrFile
from xodr_measure import lane_steps

from osm2xodr.model import FloatArray

# (road id, index of the lane section, lane id)
LaneKey = tuple[str, int, int]


class LaneGraph:
    """Lanes for cars, their ways on, and where they lie.

    `next` holds the lanes that follow each lane in the direction of traffic, `beside` those to which one may change.
    """

    def __init__(self, network: XodrFile) -> None:
        self.network = network
        self.length: dict[LaneKey, float] = {}
        self.next: dict[LaneKey, set[LaneKey]] = defaultdict(set)
        self.beside: dict[LaneKey, list[LaneKey]] = {}
        # Places each half to whole metre along each road: s, x, y, m, and its direction, rad.
        self._line: dict[str, tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = {}
        for road in network.roads.values():
            self._add_road(road)
        for step in lane_steps(network):
            a, b = network.roads[step.road], network.roads[step.beyond]
            key_a = (a.id, 0 if step.at_start else len(a.sections) - 1, step.lane)
            key_b = (b.id, 0 if step.beyond_at_start else len(b.sections) - 1, step.beyond_lane)
            if key_a not in self.length or key_b not in self.length:
                continue
            leaves, enters = (
                a.forward(step.lane) != step.at_start,
                b.forward(step.beyond_lane) == step.beyond_at_start,
            )
            if leaves != enters:
                raise ValueError(f"traffic meets head-on at {step}")
            first, second = (key_a, key_b) if leaves else (key_b, key_a)
            self.next[first].add(second)

    def _add_road(self, road: Road) -> None:
        for k, section in enumerate(road.sections):
            lanes = [i for i, lane in section.lanes.items() if lane.type in CAR_LANES]
            for i in lanes:
                self.length[(road.id, k, i)] = section.end - section.s
                self.beside[(road.id, k, i)] = [
                    (road.id, k, j) for j in lanes if j != i and road.forward(j) == road.forward(i)
                ]
        for k, section in enumerate(road.sections[:-1]):
            for i, lane in section.lanes.items():
                for j in lane.successors:
                    first, second = (road.id, k, i), (road.id, k + 1, j)
                    if first in self.length and second in self.length:
                        if not road.forward(i):
                            first, second = second, first
                        self.next[first].add(second)

    def ends(self) -> set[LaneKey]:
        """Return the lanes on which one cannot go on."""
        return {key for key in self.length if not self.next.get(key)}

    def lanes_at(self, x: float, y: float, hdg: float, reach: float = 3.0) -> set[LaneKey]:
        """Return the car lanes in the direction `hdg` of the road, outside junctions, that lies at a place.

        Lanes of all roads whose carriageway is at most `reach` metres away are looked at, the nearest road wins.
        """
        best: tuple[float, set[LaneKey]] = (math.inf, set())
        for road in self.network.roads.values():
            if road.connecting:
                continue
            s, t, along = self._project(road, x, y)
            k = max(i for i, section in enumerate(road.sections) if section.s <= s + 1e-9)
            span = _car_span(road.sections[k], s, float(road.lane_offset.value(np.array([s]))[0]))
            if span is None:
                continue
            turn = math.cos(float(road.pose(np.array([s]))[2][0]) - hdg)
            out = max(span[0] - t, t - span[1], 0.0) + max(along - 0.6, 0.0)
            keys = {(road.id, k, i) for i in road.sections[k].lanes if road.forward(i) == (turn > 0)}
            lanes = keys & self.length.keys()
            score = out + 0.01 * abs(t - sum(span) / 2)
            if lanes and out <= reach and abs(turn) > 0.8 and score < best[0]:
                best = (score, lanes)
        return best[1]

    def _project(self, road: Road, x: float, y: float) -> tuple[float, float, float]:
        """Return s and t of a place on a road (to half a metre along), and how far beyond its ends it lies."""
        if road.id not in self._line:
            s = np.linspace(0.0, road.length, max(2, math.ceil(road.length) + 1))
            self._line[road.id] = (s, *road.pose(s))
        s, px, py, hdg = self._line[road.id]
        k = int(np.argmin(np.hypot(px - x, py - y)))
        along = (x - px[k]) * math.cos(hdg[k]) + (y - py[k]) * math.sin(hdg[k])
        t = -(x - px[k]) * math.sin(hdg[k]) + (y - py[k]) * math.cos(hdg[k])
        return float(s[k]), float(t), abs(float(along))

    def distances(self, start: set[LaneKey], limit: float) -> dict[LaneKey, float]:
        """Return how far after the end of the start's lanes each reachable lane begins, m, lane changes included."""
        found: dict[LaneKey, float] = {}
        queue = [(-self.length[key], key) for key in sorted(start)]
        while queue:
            run, key = heapq.heappop(queue)
            if key in found:
                continue
            found[key] = run
            for other in self.beside[key]:
                heapq.heappush(queue, (run, other))
            after = run + self.length[key]
            if after <= limit:
                for other in sorted(self.next.get(key, ())):
                    heapq.heappush(queue, (after, other))
        return found


def _car_span(section: Section, s: float, offset: float) -> tuple[float, float] | None:
    edges = [
        float(t[0]) + offset
        for i, lane in section.lanes.items()
        if lane.type in CAR_LANES
        for t in section.edges(i, np.array([s]))
    ]
    return (min(edges), max(edges)) if edges else None
