"""Clearances: how much room one carriageway leaves above another one that it does not meet."""

from __future__ import annotations

import numpy as np

from osm2xodr.checking.checks.common import road_place
from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.checks.surfaces import carriageways, has_length
from osm2xodr.checking.findings import Findings
from osm2xodr.checking.rules import RULES
from osm2xodr.curves import CLEARANCE_STEP, RoadGraph, Stations, close_places
from osm2xodr.opendrive import LinkKind, OpenDrive


def check_clearances(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check places where carriageways that do not meet lie over each other: one finding for each, at its worst."""
    if not findings.wants("clearance"):
        return
    limit = RULES["clearance"].limit
    assert limit is not None
    found = close_places(iter((_stations(drive, lanes),)), _graph(drive), limit.value)
    findings.add(
        "clearance",
        value=found.height,
        other=lambda k: f"road {drive.roads.id[int(found.other[k])]}",
        **road_place(drive, found.road, found.s),
    )


def _stations(drive: OpenDrive, lanes: LaneIndex) -> Stations:
    """Return the edges of all carriageways."""
    ways = carriageways(drive, lanes, np.flatnonzero(has_length(drive)), CLEARANCE_STEP)
    row = np.arange(len(ways.s))
    right, left = (np.column_stack(ways.points(row, t)) for t in (ways.low, ways.high))
    return Stations(ways.road, ways.s, ways.hdg, right, left)


def _graph(drive: OpenDrive) -> RoadGraph:
    """Return which roads of a file meet."""
    roads = drive.roads
    at_junction = (roads.link_kind == LinkKind.JUNCTION) & (roads.link >= 0)
    inside = roads.junction >= 0
    junction = np.where(at_junction, roads.link, -1)
    junction[inside] = roads.junction[inside, None]
    road, end = np.nonzero((roads.link_kind == LinkKind.ROAD) & (roads.link >= 0))
    return RoadGraph(roads.length, inside, junction, road.astype(np.int64), roads.link[road, end])
