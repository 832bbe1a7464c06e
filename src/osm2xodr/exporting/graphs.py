"""Where cars can go from lane to lane, as a graph of networkx."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

import networkx
import numpy as np

from osm2xodr.checking import driving_of
from osm2xodr.exporting.geojson import middle_lengths
from osm2xodr.exporting.lanelet2 import mark_of
from osm2xodr.model import BoolArray
from osm2xodr.opendrive import ABSENT, OpenDrive, lane_ribbons, sample_roads, speed_limits

_KMH: Final = 3.6
_WAYS: Final = ("forward", "backward")


def lane_graph(file: OpenDrive) -> Any:
    """Return the graph of the lanes for cars; see `osm2xodr.RoadNetwork.to_networkx`."""
    graph = networkx.DiGraph()
    driving, lanes, sections = driving_of(file), file.lanes, file.sections
    length = middle_lengths(file, lane_ribbons(file, sample_roads(file)))
    limits = speed_limits(file)
    both = driving.along & driving.against
    names: dict[int, tuple[Any, ...]] = {}
    for way, drives in ((0, driving.along), (1, driving.against)):
        for row in np.flatnonzero(drives).tolist():
            section = int(lanes.section[row])
            road = int(sections.road[section])
            name = file.roads.id[road], section - int(sections.start[road]), int(lanes.id[row])
            node = names[2 * row + way] = (*name, _WAYS[way]) if both[row] else name
            graph.add_node(
                node,
                road=name[0],
                road_name=file.roads.name[road],
                section=name[1],
                lane=name[2],
                lane_type=lanes.type[row],
                direction=_WAYS[way],
                s_start_m=float(sections.s[section]),
                s_end_m=float(sections.end[section]),
                length_m=float(length[row]),
                speed_kmh=float(limits[row]) * _KMH,
            )
    for one, other in zip(driving.start.tolist(), driving.end.tolist(), strict=True):
        speed = float(limits[one // 2])
        # Without a known limit no time is known either.
        time = float(length[one // 2]) / speed if speed > 0.0 else math.nan
        graph.add_edge(names[one], names[other], kind="successor", length_m=float(length[one // 2]), time_s=time)
    for one, other in _lane_changes(file, driving.along, driving.against):
        graph.add_edge(names[one], names[other], kind="change", length_m=0.0, time_s=0.0)
    return graph


def _lane_changes(file: OpenDrive, along: BoolArray, against: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield pairs of lanes between which one may change, as nodes of `osm2xodr.checking.Driving`."""
    lanes = file.lanes
    for section in range(len(lanes.start) - 1):
        rows = [row for row in range(int(lanes.start[section]), int(lanes.start[section + 1])) if lanes.id[row] != 0]
        centre = np.flatnonzero(lanes.id[lanes.start[section] : lanes.start[section + 1]] == 0)
        for left, right in pairwise(rows):
            if ABSENT in (lanes.id[left], lanes.id[right]):
                continue
            # Marks stand on outer borders: that between the lanes is the inner one's, or the centre's.
            if lanes.id[left] < 0:
                owner = left
            elif lanes.id[right] > 0:
                owner = right
            elif len(centre):
                owner = int(lanes.start[section] + centre[0])
            else:
                continue
            marks = [
                mark_of(kind, change, outwards_left=bool(lanes.id[owner] > 0), low=False, bare="virtual")
                for k in range(int(lanes.marks.start[owner]), int(lanes.marks.start[owner + 1]))
                for kind, change in [(lanes.marks.type[k], lanes.marks.lane_change[k])]
            ]
            for way, drives in ((0, along), (1, against)):
                if drives[left] and drives[right]:
                    if any(mark.to_right for mark in marks):
                        yield 2 * left + way, 2 * right + way
                    if any(mark.to_left for mark in marks):
                        yield 2 * right + way, 2 * left + way
