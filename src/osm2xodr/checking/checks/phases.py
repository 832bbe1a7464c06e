"""Controllers of junctions: signals that show green at once to ways through a junction that meet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.checking import defaults
from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.findings import Findings
from osm2xodr.curves import segments_cross
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import End, Furniture, OpenDrive, elevation, lane_borders, pose, section_at

# Middles of lanes that end so near to each other end on one lane, m: half of a narrow one.
_CHECK_SAME_LANE: Final = 1.0

# Ways through junctions are compared as polylines of this many points.
_POINTS: Final = 17
# No controller governs more ways: those of damaged files would take all time.
_MOST: Final = 400
_ORIENTATION: Final = {int(End.START): "-", int(End.END): "+"}


@dataclass(frozen=True)
class _Way:
    """One lane through a junction: rows of roads, the end of the incoming road, the lanes, the end it begins at."""

    connecting: int
    lane: int
    contact: int
    incoming: int
    incoming_end: int
    incoming_lane: int


def check_phases(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look at all controllers that junctions name.

    A signal governs the lanes of connecting roads that refer to it; one that no connecting road refers to those that
    begin where its road comes to the junction. Ways of one approach may meet.
    """
    if not findings.wants("conflicting-phase") or not drive.junctions.controllers:
        return
    controllers = {item.id: item for item in reversed(drive.controllers)}
    signals = _Signals(drive)
    groups = []
    for junction, name in drive.junctions.controllers:
        if name in controllers:
            ways = signals.governed(junction, controllers[name].signal_ids)
            if len({(way.incoming, way.incoming_end) for way in ways}) > 1:
                groups.append((junction, controllers[name], ways[:_MOST]))
    paths = _paths(drive, lanes, [way for *_, ways in groups for way in ways])
    first = 0
    for junction, controller, ways in groups:
        meeting = _meeting(ways, paths[first : first + len(ways)])
        first += len(ways)
        if not meeting.any():
            continue
        one, other = (ways[k] for k in np.argwhere(meeting)[0].tolist())
        pairs = int(meeting.sum()) // 2
        names = f"connecting roads {drive.roads.id[one.connecting]} and {drive.roads.id[other.connecting]}"
        text = f"{controller.id} of junction {drive.junctions.id[junction]}: {pairs} pairs, {names} first"
        findings.add("conflicting-phase", road=[one.connecting], line=[controller.line], other=[text])


class _Signals:
    """Finds the ways that signals govern."""

    def __init__(self, drive: OpenDrive) -> None:
        self._drive = drive
        self._at: dict[str, list[Furniture]] = defaultdict(list)
        for item in drive.furniture:
            if item.kind in ("signal", "signalReference") and item.road >= 0:
                self._at[item.attributes.get("id", "")].append(item)

    def governed(self, junction: int, signal_ids: Sequence[str]) -> list[_Way]:
        """Return the ways through a junction that some signals govern, each once."""
        ways = self._ways(junction)
        out: dict[_Way, None] = {}
        for name in signal_ids:
            things = self._at.get(name, [])
            inside = [item for item in things if int(self._drive.roads.junction[item.road]) == junction]
            if inside:
                out |= {way: None for item in inside for way in ways if _refers(item, way)}
            else:
                out |= {way: None for item in things for way in ways if _stops(item, way)}
        return list(out)

    def _ways(self, junction: int) -> list[_Way]:
        """Return all lanes through a junction."""
        table, roads = self._drive.connections, self._drive.roads
        out = []
        for row in range(int(self._drive.junctions.start[junction]), int(self._drive.junctions.start[junction + 1])):
            connecting, incoming, contact = (
                int(column[row]) for column in (table.connecting, table.incoming, table.contact)
            )
            if min(connecting, incoming, contact) < 0:
                continue
            end = int(roads.contact[connecting, contact])
            for link in range(int(table.link_start[row]), int(table.link_start[row + 1])):
                lane, before = int(table.link_to[link]), int(table.link_from[link])
                out.append(_Way(connecting, lane, contact, incoming, end, before))
        return out


def _refers(item: Furniture, way: _Way) -> bool:
    return item.road == way.connecting and _valid(item, way.lane)


def _stops(item: Furniture, way: _Way) -> bool:
    """Whether a signal on the road that a way comes from is for its traffic."""
    orientation = item.attributes.get("orientation", "none")
    towards = orientation == "none" or _ORIENTATION.get(way.incoming_end) == orientation
    return item.road == way.incoming and towards and _valid(item, way.incoming_lane)


def _valid(item: Furniture, lane: int) -> bool:
    return not item.validity or any(min(pair) <= lane <= max(pair) for pair in item.validity)


def _paths(drive: OpenDrive, lanes: LaneIndex, ways: Sequence[_Way]) -> FloatArray:
    """Return x, y, z on the middles of lanes in the order of travel, (ways, points, 3); NaN if not for cars."""
    road = np.repeat(np.array([way.connecting for way in ways], np.int64), _POINTS)
    lane = np.repeat(np.array([way.lane for way in ways], np.int64), _POINTS)
    back = np.array([way.contact == End.END for way in ways], bool)
    share = np.tile(np.linspace(0.0, 1.0, _POINTS), (len(ways), 1))
    s = drive.roads.length[road] * np.where(back[:, None], 1.0 - share, share).ravel()
    row = lanes.find(section_at(drive, road, s), lane)
    known = np.flatnonzero(row >= 0)
    known = known[lanes.driving[row[known]]]
    out = np.full((len(road), 3), np.nan)
    if len(known):
        inner, outer = lane_borders(drive, row[known], s[known])
        t = 0.5 * (inner + outer)
        x, y, hdg = pose(drive, road[known], s[known])
        z = elevation(drive, road[known], s[known])
        out[known] = np.column_stack([x - t * np.sin(hdg), y + t * np.cos(hdg), z])
    return out.reshape(len(ways), _POINTS, 3)


def _meeting(ways: Sequence[_Way], paths: FloatArray) -> BoolArray:
    """Say which ways of different approaches cross or end on one lane, at one level, (n, n)."""
    numbers: Mapping[tuple[int, int], int] = {
        key: k for k, key in enumerate(dict.fromkeys((way.incoming, way.incoming_end) for way in ways))
    }
    approach: IntArray = np.array([numbers[way.incoming, way.incoming_end] for way in ways], np.int64)
    x, y, z = paths[..., 0], paths[..., 1], paths[..., 2]
    gap = np.hypot(x[:, None, -1] - x[None, :, -1], y[:, None, -1] - y[None, :, -1])
    out: BoolArray = (gap < _CHECK_SAME_LANE) & (np.abs(z[:, None, -1] - z[None, :, -1]) < defaults.CHECK_LEVELS)
    for k in range(len(ways)):
        out[k] |= _crossed(paths[k], paths)
    out |= out.T
    found: BoolArray = out & (approach[:, None] != approach)
    return found


def _crossed(path: FloatArray, others: FloatArray) -> BoolArray:
    """Say which polylines a polyline crosses at its level, (n,)."""
    a, b = path[:-1][:, None], path[1:][:, None]
    c, d = others[:, None, :-1], others[:, None, 1:]
    level = np.abs(a[..., 2] - c[..., 2]) < defaults.CHECK_LEVELS
    out: BoolArray = (segments_cross(a, b, c, d) & level).any(axis=(1, 2))
    return out
