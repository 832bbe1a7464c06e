"""Every step from a lane of one road to a lane of the next, and links that lead nowhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.checking.checks.common import end_station
from osm2xodr.checking.checks.index import LaneIndex, lane_place
from osm2xodr.checking.checks.references import ENDS, connection_name
from osm2xodr.checking.findings import Findings
from osm2xodr.curves import Table, owners
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.opendrive import ABSENT, End, LinkKind, OpenDrive, pose


@dataclass(frozen=True)
class Transitions(Table):
    """Steps across ends of roads: from a lane (a) at an end of its road to another (b) at an end of its own."""

    # (n,) Rows of lanes
    lane_a: IntArray
    lane_b: IntArray
    # (n,) `End` of their roads
    end_a: IntArray
    end_b: IntArray
    incoming: BoolArray  # (n,) Whether a connection of a junction states the step, and not the road itself
    line: IntArray  # (n,) Of the file


def transitions(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return all steps, and add findings about links and connections that lead nowhere."""
    links = ((End.START, drive.lanes.predecessor), (End.END, drive.lanes.successor))
    for end, ids in links:
        _check_section_links(drive, lanes, end, ids, findings)
    backwards, forwards = (_road_steps(drive, lanes, end, ids, findings) for end, ids in links)
    return backwards.joined(forwards, _connection_steps(drive, lanes, findings))


def _check_section_links(drive: OpenDrive, lanes: LaneIndex, end: End, ids: IntArray, findings: Findings) -> None:
    """Check links from section to section of a road."""
    table, sections = drive.lanes, drive.sections
    several = np.diff(sections.start)[lanes.road] > 1
    row = np.flatnonzero(several & ~lanes.is_outermost(table.section, end) & (ids != ABSENT))
    lost = row[lanes.find(table.section[row] + (1 if end else -1), ids[row]) < 0]
    findings.add(
        "lane-link",
        other=lambda k: f"{ENDS[end]} is lane {ids[lost[k]]} of the neighbouring section",
        **lane_place(drive, lanes, lost, (sections.end if end else sections.s)[table.section[lost]]),
    )


def _road_steps(drive: OpenDrive, lanes: LaneIndex, end: End, ids: IntArray, findings: Findings) -> Transitions:
    """Return the steps that lanes themselves name at an end of their roads."""
    roads, table = drive.roads, drive.lanes
    linked = (roads.link_kind[:, end] == LinkKind.ROAD) & (roads.link[:, end] != ABSENT)
    row = np.flatnonzero(lanes.is_outermost(table.section, end) & linked[lanes.road] & (ids != ABSENT))
    road = lanes.road[row]
    other = roads.link[road, end]
    contact = np.maximum(roads.contact[road, end], 0)
    section = lanes.end_section(other, contact)
    to = lanes.find(section, ids[row])
    lost = np.flatnonzero((to < 0) & (section >= 0))
    findings.add(
        "lane-link",
        other=lambda k: f"{ENDS[end]} is lane {ids[row[lost[k]]]} of road {roads.id[int(other[lost[k]])]}",
        **lane_place(drive, lanes, row[lost], end_station(drive, road[lost], end)),
    )
    good = to >= 0
    n = int(good.sum())
    return Transitions(row[good], to[good], np.full(n, end), contact[good], np.zeros(n, bool), table.line[row[good]])


def _connection_steps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return steps from incoming roads into junctions."""
    table = drive.connections
    _check_connections(drive, findings)
    row = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT))
    contact = np.maximum(table.contact, 0)
    end = np.full(len(table.junction), -1, np.int64)
    end[row] = _incoming_end(drive, row, contact[row])
    # Roads go on through virtual junctions instead of ending there.
    away = row[(end[row] < 0) & ~_is_virtual(drive)[row]]
    findings.add(
        "incoming-elsewhere",
        road=table.incoming[away],
        line=table.line[away],
        other=lambda k: connection_name(drive, int(away[k])),
    )
    owner = owners(table.link_start)
    link = np.flatnonzero(end[owner] >= 0)
    owner = owner[link]
    section_a = lanes.end_section(table.incoming[owner], end[owner])
    section_b = lanes.end_section(table.connecting[owner], contact[owner])
    lane_a = lanes.find(section_a, table.link_from[link])
    lane_b = lanes.find(section_b, table.link_to[link])
    lost = np.flatnonzero(((lane_a < 0) | (lane_b < 0)) & (section_a >= 0) & (section_b >= 0))
    findings.add(
        "connection-lane",
        road=table.incoming[owner[lost]],
        s=end_station(drive, table.incoming[owner[lost]], end[owner[lost]]),
        line=table.line[owner[lost]],
        other=lambda k: _lost_lane(
            drive, int(owner[lost[k]]), int(link[lost[k]]), at_start=bool(lane_a[lost[k]] < 0)
        ),
    )
    good = (lane_a >= 0) & (lane_b >= 0)
    kept = owner[good]
    incoming = np.ones(len(kept), bool)
    return Transitions(lane_a[good], lane_b[good], end[kept], contact[kept], incoming, table.line[kept])


def _lost_lane(drive: OpenDrive, connection: int, link: int, *, at_start: bool) -> str:
    """Name the lane, of the incoming or the connecting road, that a laneLink names and that does not exist."""
    table = drive.connections
    if at_start:
        lane, road = table.link_from[link], table.incoming_id[connection]
    else:
        lane, road = table.link_to[link], table.connecting_id[connection]
    word = "an unreadable lane" if lane == ABSENT else f"lane {lane}"
    return f"{connection_name(drive, connection)} names {word} of road {road}"


def _check_connections(drive: OpenDrive, findings: Findings) -> None:
    """Check the attributes of connections."""
    table, roads = drive.connections, drive.roads
    for word, index, ids in (
        ("incoming", table.incoming, table.incoming_id),
        ("connecting", table.connecting, table.connecting_id),
    ):
        nameless = np.array([not name for name in ids], bool)
        lost = np.flatnonzero((index == ABSENT) & ~(_is_virtual(drive) & nameless))
        texts = [
            f"{connection_name(drive, k)} "
            + (f"names the {word} road {ids[k]}, which is not in the file" if ids[k] else f"names no {word} road")
            for k in lost.tolist()
        ]
        findings.add(f"{word}-road", line=table.line[lost], other=texts)

    def add(rule: str, rows: IntArray) -> None:
        road = table.connecting[rows]
        findings.add(
            rule,
            road=np.where(road == ABSENT, -1, road),
            line=table.line[rows],
            other=lambda k: connection_name(drive, int(rows[k])),
        )

    add("connection-without-id", np.array([k for k, name in enumerate(table.id) if not name], np.int64))
    add("connection-without-lanes", np.flatnonzero(np.diff(table.link_start) == 0))
    add("no-contact-point", np.flatnonzero((table.contact == End.UNSAID) & (table.connecting != ABSENT)))
    ordinary = np.array([drive.junctions.type[j] in ("", "default") for j in table.junction.tolist()], bool)
    known = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT) & ordinary)
    elsewhere = roads.junction[table.connecting[known]] != table.junction[known]
    add("connecting-elsewhere", known[elsewhere])
    contact = np.maximum(table.contact[known], 0)
    kind = roads.link_kind[table.connecting[known], contact]
    named = roads.link[table.connecting[known], contact]
    add("connection-without-link", known[~elsewhere & ((kind != LinkKind.ROAD) | (named != table.incoming[known]))])


def _is_virtual(drive: OpenDrive) -> BoolArray:
    """Whether connections belong to virtual junctions, (connections,)."""
    kinds = np.array([kind == "virtual" for kind in drive.junctions.type], bool)
    return np.asarray(kinds[drive.connections.junction], bool)


def _incoming_end(drive: OpenDrive, row: IntArray, contact: IntArray) -> IntArray:
    """Return the end at which each connection's incoming road meets the junction; -1 where it does not."""
    roads, table = drive.roads, drive.connections
    road = table.incoming[row]
    meets = (roads.link_kind[road] == LinkKind.JUNCTION) & (roads.link[road] == table.junction[row][:, None])
    # Roads between the connecting roads of one junction name each other.
    named = (roads.link_kind[road] == LinkKind.ROAD) & (roads.link[road] == table.connecting[row][:, None])
    meets = np.where(meets.any(1)[:, None], meets, named)
    out = np.where(meets[:, 0], 0, np.where(meets[:, 1], 1, -1))
    both = np.flatnonzero(meets.all(1))
    if len(both):
        # A loop: the end that is nearer to the connecting road.
        other = table.connecting[row[both]]
        x, y, _ = pose(drive, other, end_station(drive, other, contact[both]))
        apart = []
        for end in (End.START, End.END):
            at_x, at_y, _ = pose(drive, road[both], end_station(drive, road[both], end))
            apart.append(np.hypot(at_x - x, at_y - y))
        out[both] = np.where(apart[1] < apart[0], 1, 0)
    return np.asarray(out, np.int64)
