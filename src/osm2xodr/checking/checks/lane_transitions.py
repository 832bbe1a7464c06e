"""Every step from a lane of one road to a lane of the next, and the links that lead nowhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.checks.references import connection_name
from osm2xodr.checking.findings import Findings
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.opendrive import ABSENT, End, LinkKind, OpenDrive, pose


@dataclass(frozen=True)
class Transitions:
    """Steps across ends of roads: from a lane (a) at an end of its road to another (b) at an end of its own."""

    # (n,) Rows of lanes
    lane_a: IntArray
    lane_b: IntArray
    # (n,) `End` of their roads
    end_a: IntArray
    end_b: IntArray
    # (n,) Whether it is a connection of a junction that says so, and not a link of the road itself
    incoming: BoolArray
    line: IntArray  # (n,) Of the file

    def joined(self, other: Transitions) -> Transitions:
        """Return the steps of both."""
        names = ("lane_a", "lane_b", "end_a", "end_b", "incoming", "line")
        return Transitions(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in names))


def transitions(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return all steps, and take in findings about links and connections that lead nowhere."""
    _check_section_links(drive, lanes, findings)
    return _road_steps(drive, lanes, findings).joined(_connection_steps(drive, lanes, findings))


def _check_section_links(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look at links from section to section of a road."""
    table = drive.lanes
    inner = np.diff(drive.sections.start)[lanes.road] > 1
    for end, ids in ((0, table.predecessor), (1, table.successor)):
        outermost = lanes.end_section(lanes.road, np.full(len(lanes.road), end)) == table.section
        row = np.flatnonzero(inner & ~outermost & (ids != ABSENT))
        lost = row[lanes.find(table.section[row] + (1 if end else -1), ids[row]) < 0]
        station = drive.sections.end[table.section[lost]] if end else drive.sections.s[table.section[lost]]
        word = ("predecessor", "successor")[end]
        findings.add(
            "lane-link",
            road=lanes.road[lost],
            lane=table.id[lost],
            s=station,
            line=table.line[lost],
            other=lambda row, lost=lost, ids=ids, word=word: (  # type: ignore[misc]
                f"{word} is lane {ids[lost[row]]} of the neighbouring section"
            ),
        )


def _road_steps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return steps that lanes themselves name at the ends of roads."""
    roads, table = drive.roads, drive.lanes
    parts = []
    for end, ids in ((0, table.predecessor), (1, table.successor)):
        at_end = lanes.end_section(lanes.road, np.full(len(lanes.road), end)) == table.section
        linked = (roads.link_kind[:, end] == LinkKind.ROAD) & (roads.link[:, end] != ABSENT)
        row = np.flatnonzero(at_end & linked[lanes.road] & (ids != ABSENT))
        road = lanes.road[row]
        other = roads.link[road, end]
        contact = np.maximum(roads.contact[road, end], 0)
        section = lanes.end_section(other, contact)
        to = lanes.find(section, ids[row])
        lost = np.flatnonzero((to < 0) & (section >= 0))
        word = ("predecessor", "successor")[end]
        findings.add(
            "lane-link",
            road=road[lost],
            lane=table.id[row[lost]],
            s=roads.length[road[lost]] * end,
            line=table.line[row[lost]],
            other=lambda k, rows=row[lost], ids=ids, others=other[lost], word=word: (  # type: ignore[misc]
                f"{word} is lane {ids[rows[k]]} of road {roads.id[int(others[k])]}"
            ),
        )
        good = to >= 0
        n = int(good.sum())
        parts.append(
            Transitions(row[good], to[good], np.full(n, end), contact[good], np.zeros(n, bool), table.line[row[good]])
        )
    return parts[0].joined(parts[1])


def _connection_steps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return steps from incoming roads into junctions."""
    roads, table = drive.roads, drive.connections
    _check_connections(drive, findings)
    row = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT))
    contact = np.maximum(table.contact, 0)
    end = np.full(len(table.junction), -1, np.int64)
    end[row] = _incoming_end(drive, row, contact[row])
    # Roads go on through virtual junctions instead of ending there.
    away = row[(end[row] < 0) & ~_virtual(drive)[row]]
    findings.add(
        "incoming-elsewhere",
        road=table.incoming[away],
        line=table.line[away],
        other=lambda k: f"{connection_name(drive, int(away[k]))} comes in from the road",
    )
    counts = np.diff(table.link_start)
    owner = np.repeat(np.arange(len(counts)), counts)
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
        s=roads.length[table.incoming[owner[lost]]] * end[owner[lost]],
        line=table.line[owner[lost]],
        other=lambda k: _lost_lane(drive, int(owner[lost[k]]), int(link[lost[k]]), from_it=bool(lane_a[lost[k]] < 0)),
    )
    good = (lane_a >= 0) & (lane_b >= 0)
    return Transitions(
        lane_a[good],
        lane_b[good],
        end[owner][good],
        contact[owner][good],
        np.ones(int(good.sum()), bool),
        table.line[owner][good],
    )


def _lost_lane(drive: OpenDrive, connection: int, link: int, *, from_it: bool) -> str:
    """Name a lane that a laneLink names and that is not there."""
    table = drive.connections
    lane, road = (
        (table.link_from[link], table.incoming_id[connection])
        if from_it
        else (table.link_to[link], table.connecting_id[connection])
    )
    word = "an unreadable lane" if lane == ABSENT else f"lane {lane}"
    return f"{connection_name(drive, connection)} names {word} of road {road}"


def _check_connections(drive: OpenDrive, findings: Findings) -> None:
    """Look at the attributes of connections."""
    table, roads = drive.connections, drive.roads
    for rule, index, ids, word in (
        ("incoming-road", table.incoming, table.incoming_id, "incoming"),
        ("connecting-road", table.connecting, table.connecting_id, "connecting"),
    ):
        lost = np.flatnonzero((index == ABSENT) & ~(_virtual(drive) & _nameless(ids)))
        findings.add(
            rule,
            line=table.line[lost],
            other=lambda k, lost=lost, ids=ids, word=word: (  # type: ignore[misc]
                f"{connection_name(drive, int(lost[k]))} "
                + (
                    f"names the {word} road {ids[lost[k]]}, which is not in the file"
                    if ids[lost[k]]
                    else f"names no {word} road"
                )
            ),
        )

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


def _nameless(ids: tuple[str, ...]) -> BoolArray:
    """Whether ids are missing, (n,)."""
    return np.array([not name for name in ids], bool)


def _virtual(drive: OpenDrive) -> BoolArray:
    """Whether connections are those of virtual junctions, (connections,)."""
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
        x, y, _ = pose(drive, other, np.where(contact[both] == 0, 0.0, roads.length[other]))
        apart = []
        for end in (0, 1):
            at_x, at_y, _ = pose(drive, road[both], roads.length[road[both]] * end)
            apart.append(np.hypot(at_x - x, at_y - y))
        out[both] = np.where(apart[1] < apart[0], 1, 0)
    return np.asarray(out, np.int64)
