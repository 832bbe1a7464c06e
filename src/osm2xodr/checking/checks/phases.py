"""Controllers of junctions: signals that show green at the same time to movements that meet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.checking.checks.common import LaneIndex
from osm2xodr.checking.findings import LEVEL_HEIGHT, Findings
from osm2xodr.curves import segments_cross
from osm2xodr.diagnostics import counted
from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.opendrive import End, Furniture, OpenDrive, elevation, lane_borders, pose, section_at
from osm2xodr.system import record

# Movements whose middles end nearer to each other than this end on one lane, m: half of a narrow one.
_SAME_LANE: Final = 1.0
# Movements are compared as polylines of this many points.
_POINTS: Final = 17
# Movements of one controller that are compared: those of damaged files would take forever.
_MOST_MOVEMENTS: Final = 400
_ORIENTATION: Final = {int(End.START): "-", int(End.END): "+"}


@record
class _Movement:
    """One lane through a junction."""

    connecting: int  # Index of the connecting road
    lane: int  # Its lane
    contact: int  # Its end at which the movement begins
    # Index of the incoming road, its end at the junction, its lane
    incoming: int
    incoming_end: int
    incoming_lane: int

    @property
    def approach(self) -> tuple[int, int]:
        """Where it comes from: incoming road and its end."""
        return self.incoming, self.incoming_end


def check_phases(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check all controllers that junctions name.

    A signal governs the lanes of the connecting roads that refer to it; if none does, the lanes that begin where its
    road comes to the junction. Movements of one approach may meet.
    """
    if not findings.wants("conflicting-phase") or not drive.junctions.controllers:
        return
    controllers = {item.id: item for item in reversed(drive.controllers)}
    signals = _Signals(drive)
    groups = []
    for junction, name in drive.junctions.controllers:
        if name in controllers:
            movements = signals.governed(junction, controllers[name].signal_ids)
            if len({movement.approach for movement in movements}) > 1:
                groups.append((junction, controllers[name], movements[:_MOST_MOVEMENTS]))
    paths = _paths(drive, lanes, [movement for *_, movements in groups for movement in movements])
    first = 0
    for junction, controller, movements in groups:
        meeting = _meeting(movements, paths[first : first + len(movements)])
        first += len(movements)
        if not meeting.any():
            continue
        one, other = (movements[k] for k in np.argwhere(meeting)[0].tolist())
        pairs = int(meeting.sum()) // 2
        names = f"connecting roads {drive.roads.id[one.connecting]} and {drive.roads.id[other.connecting]}"
        text = f"{controller.id} of junction {drive.junctions.id[junction]}: {counted(pairs, 'pair')}, {names} first"
        findings.add("conflicting-phase", road=[one.connecting], line=[controller.line], other=[text])


class _Signals:
    """Finds the movements that signals govern."""

    def __init__(self, drive: OpenDrive) -> None:
        self._drive = drive
        self._at: dict[str, list[Furniture]] = defaultdict(list)
        for item in drive.furniture:
            if item.kind in ("signal", "signalReference") and item.road >= 0:
                self._at[item.attributes.get("id", "")].append(item)

    def governed(self, junction: int, signal_ids: Sequence[str]) -> list[_Movement]:
        """Return the movements through a junction that some signals govern, each once."""
        movements = self._movements(junction)
        out: dict[_Movement, None] = {}
        for name in signal_ids:
            items = self._at.get(name, [])
            inside = [item for item in items if int(self._drive.roads.junction[item.road]) == junction]
            governs = _refers if inside else _stops
            out |= {movement: None for item in inside or items for movement in movements if governs(item, movement)}
        return list(out)

    def _movements(self, junction: int) -> list[_Movement]:
        """Return all movements through a junction."""
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
                out.append(_Movement(connecting, lane, contact, incoming, end, before))
        return out


def _refers(item: Furniture, movement: _Movement) -> bool:
    return item.road == movement.connecting and _valid(item, movement.lane)


def _stops(item: Furniture, movement: _Movement) -> bool:
    """Whether a signal stands on the road that a movement comes from, and is for its traffic."""
    orientation = item.attributes.get("orientation", "none")
    towards = orientation == "none" or _ORIENTATION.get(movement.incoming_end) == orientation
    return item.road == movement.incoming and towards and _valid(item, movement.incoming_lane)


def _valid(item: Furniture, lane: int) -> bool:
    return not item.validity or any(min(pair) <= lane <= max(pair) for pair in item.validity)


def _paths(drive: OpenDrive, lanes: LaneIndex, movements: Sequence[_Movement]) -> FloatArray:
    """Return x, y, z along the middles of lanes, as cars travel, (movements, points, 3); NaN if not for cars."""
    road = np.repeat(np.array([movement.connecting for movement in movements], np.int64), _POINTS)
    lane = np.repeat(np.array([movement.lane for movement in movements], np.int64), _POINTS)
    back = np.array([movement.contact == End.END for movement in movements], bool)
    share = np.tile(np.linspace(0.0, 1.0, _POINTS), (len(movements), 1))
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
    return out.reshape(len(movements), _POINTS, 3)


def _meeting(movements: Sequence[_Movement], paths: FloatArray) -> BoolArray:
    """Return which movements of different approaches cross or end on one lane, at one level, (n, n)."""
    numbers = {key: k for k, key in enumerate(dict.fromkeys(movement.approach for movement in movements))}
    approach = np.array([numbers[movement.approach] for movement in movements], np.int64)
    x, y, z = paths[..., 0], paths[..., 1], paths[..., 2]
    gap = np.hypot(x[:, None, -1] - x[None, :, -1], y[:, None, -1] - y[None, :, -1])
    out: BoolArray = (gap < _SAME_LANE) & (np.abs(z[:, None, -1] - z[None, :, -1]) < LEVEL_HEIGHT)
    for k, path in enumerate(paths):
        out[k] |= _crossed(path, paths)
    out |= out.T
    return np.asarray(out & (approach[:, None] != approach))


def _crossed(path: FloatArray, others: FloatArray) -> BoolArray:
    """Return which polylines a polyline crosses at its level, (n,)."""
    a, b = path[:-1][:, None], path[1:][:, None]
    c, d = others[:, None, :-1], others[:, None, 1:]
    level = np.abs(a[..., 2] - c[..., 2]) < LEVEL_HEIGHT
    return np.asarray((segments_cross(a, b, c, d) & level).any(axis=(1, 2)))
