"""Ids that are used twice, and references to what does not exist."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from osm2xodr.checking.checks.common import LaneIndex, add_furniture, end_station, road_place
from osm2xodr.checking.findings import Findings
from osm2xodr.opendrive import ABSENT, End, Furniture, LinkKind, OpenDrive, section_at

ENDS = ("predecessor", "successor")
_NO_JUNCTION = ("", "-1")


def check_references(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check ids and references of roads, junctions, signals and controllers."""
    _check_ids(drive, findings)
    _check_road_links(drive, findings)
    _check_junctions(drive, findings)
    _check_signals(drive, findings)
    _check_validity(drive, lanes, findings)


def _repeated(ids: Sequence[object]) -> list[int]:
    """Return the indices of ids that stand before in the list."""
    first = {item: k for k, item in reversed(list(enumerate(ids)))}
    return [k for k, item in enumerate(ids) if first[item] != k]


def _check_ids(drive: OpenDrive, findings: Findings) -> None:
    """Check for ids that are used twice."""
    junctions, connections = drive.junctions, drive.connections
    findings.add("duplicate-road-id", **road_place(drive, np.array(_repeated(drive.roads.id), np.int64)))
    twice = _repeated(junctions.id)
    findings.add("duplicate-junction-id", line=junctions.line[twice], other=[junctions.id[k] for k in twice])
    numbered = [k for k, name in enumerate(connections.id) if name]
    found = _repeated([(int(connections.junction[k]), connections.id[k]) for k in numbered])
    twice = [numbered[k] for k in found]
    findings.add(
        "duplicate-connection-id",
        line=connections.line[twice],
        other=lambda row: connection_name(drive, twice[row]),
    )
    for kind in ("signal", "object"):
        things = [item for item in drive.furniture if item.kind == kind and item.attributes.get("id")]
        again = [things[k] for k in _repeated([item.attributes["id"] for item in things])]
        add_furniture(f"duplicate-{kind}-id", again, findings, [item.attributes["id"] for item in again])
    controllers = [drive.controllers[k] for k in _repeated([item.id for item in drive.controllers])]
    findings.add(
        "duplicate-controller-id",
        line=[item.line for item in controllers],
        other=[item.id for item in controllers],
    )


def connection_name(drive: OpenDrive, row: int) -> str:
    """Name a connection for people."""
    connections = drive.connections
    junction = drive.junctions.id[int(connections.junction[row])]
    name = f"connection {connections.id[row]}" if connections.id[row] else "a connection"
    return f"{name} of junction {junction}"


def _check_road_links(drive: OpenDrive, findings: Findings) -> None:
    """Check what roads name as their neighbours and junctions."""
    roads = drive.roads
    road, end = np.nonzero(roads.link == ABSENT)
    kind = roads.link_kind[road, end]
    station = end_station(drive, road, end)
    for wanted, word in ((LinkKind.ROAD, "road"), (LinkKind.JUNCTION, "junction")):
        at = np.flatnonzero(kind == wanted)
        texts = [f"{ENDS[end[k]]} is {word} {roads.link_id[road[k]][end[k]]}" for k in at]
        findings.add(f"{word}-link", other=texts, **road_place(drive, road[at], station[at]))
    lost = np.flatnonzero(roads.junction == ABSENT)
    findings.add("road-junction", other=[roads.junction_id[k] for k in lost], **road_place(drive, lost))
    road, end = np.nonzero((roads.link_kind == LinkKind.ROAD) & (roads.contact == End.UNSAID))
    findings.add("no-contact-point", other=[f"the road's {ENDS[k]}" for k in end], **road_place(drive, road))
    # Connecting roads without a neighbour at an end.
    road, end = np.nonzero((roads.link_kind == LinkKind.NONE) & (roads.junction >= 0)[:, None])
    place = road_place(drive, road, end_station(drive, road, end))
    findings.add("open-connecting-road", other=[ENDS[k] for k in end], **place)
    _check_mutual(drive, findings)


def _check_mutual(drive: OpenDrive, findings: Findings) -> None:
    """Check whether roads that name a neighbour are named by it."""
    roads = drive.roads
    road, end = np.nonzero((roads.link_kind == LinkKind.ROAD) & (roads.link != ABSENT))
    other = roads.link[road, end]
    contact = np.maximum(roads.contact[road, end], 0)
    back_kind, back = roads.link_kind[other, contact], roads.link[other, contact]
    returned = (back_kind == LinkKind.ROAD) & (back == road)
    # A connecting road's neighbours name the junction, unless they are connecting roads themselves.
    inside = np.array([text not in _NO_JUNCTION for text in roads.junction_id], bool)[road]
    to_junction = inside & (back_kind == LinkKind.JUNCTION) & (back == roads.junction[road])
    lost = np.flatnonzero(~returned & ~to_junction)
    findings.add(
        "link-not-returned",
        other=lambda row: f"{ENDS[end[lost[row]]]} is road {roads.id[int(other[lost[row]])]}",
        **road_place(drive, road[lost], end_station(drive, road[lost], end[lost])),
    )


def _check_junctions(drive: OpenDrive, findings: Findings) -> None:
    """Check what junctions name apart from their connections."""
    junctions = drive.junctions
    # Crossings of version 1.8 have no connections.
    crossing = np.array([kind == "crossing" for kind in junctions.type], bool)
    empty = np.flatnonzero((junctions.start[1:] == junctions.start[:-1]) & ~crossing)
    findings.add("junction-empty", line=junctions.line[empty], other=lambda row: junctions.id[int(empty[row])])
    road_ids, controller_ids = set(drive.roads.id), {item.id for item in drive.controllers}
    lost = [(j, name) for j, high, low in junctions.priorities for name in (high, low) if name not in road_ids]
    findings.add(
        "priority-road",
        line=[int(junctions.line[j]) for j, _ in lost],
        other=[f"{junctions.id[j]}: a priority names road {name}" for j, name in lost],
    )
    without = [(j, name) for j, name in junctions.controllers if name not in controller_ids]
    findings.add(
        "junction-controller",
        line=[int(junctions.line[j]) for j, _ in without],
        other=[f"{junctions.id[j]} names controller {name}" for j, name in without],
    )


def _check_signals(drive: OpenDrive, findings: Findings) -> None:
    """Check what refers to signals."""
    signal_ids = {item.attributes.get("id", "") for item in drive.furniture if item.kind == "signal"}
    lost = [
        item
        for item in drive.furniture
        if item.kind == "signalReference" and item.attributes.get("id", "") not in signal_ids
    ]
    add_furniture("signal-reference", lost, findings, [item.attributes.get("id", "") for item in lost])
    missing = [(item, name) for item in drive.controllers for name in item.signal_ids if name not in signal_ids]
    findings.add(
        "controller-signal",
        line=[item.line for item, _ in missing],
        other=[f"{item.id} controls signal {name}" for item, name in missing],
    )
    controlled = [(item, name) for item in drive.controllers for name in dict.fromkeys(item.signal_ids)]
    first = {name: item.id for item, name in reversed(controlled)}
    twice = [controlled[k] for k in _repeated([name for _, name in controlled])]
    findings.add(
        "signal-of-two-controllers",
        line=[item.line for item, _ in twice],
        other=[
            f"controller {item.id} controls signal {name}, as does controller {first[name]}" for item, name in twice
        ],
    )


def _check_validity(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check whether the lanes exist that signals and objects are valid for."""
    rows = [(item, first, last) for item in drive.furniture for first, last in item.validity if item.road >= 0]
    if not rows or not findings.wants("signal-lane"):
        return
    section = section_at(drive, np.array([item.road for item, *_ in rows]), np.array([item.s for item, *_ in rows]))
    bad = np.zeros(len(rows), bool)
    for lane in (np.array([row[1] for row in rows]), np.array([row[2] for row in rows])):
        bad |= (lanes.find(section, lane) < 0) & (lane != 0)
    wrong = [rows[k] for k in np.flatnonzero(bad)]
    add_furniture("signal-lane", [item for item, *_ in wrong], findings, [_validity_text(*row) for row in wrong])


def _validity_text(item: Furniture, first: int, last: int) -> str:
    name = f"{item.kind} {item.attributes.get('id', '')}".strip()
    lowest, highest = ("an unreadable lane" if lane == ABSENT else str(lane) for lane in (first, last))
    return f"{name} is valid for lanes {lowest} to {highest}, not all of which exist"
