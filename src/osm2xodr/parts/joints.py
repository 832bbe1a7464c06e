"""Ends of roads of different files that meet, and the links that they get."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from osm2xodr.checking import lane_index
from osm2xodr.curves import wrapped
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import End, LinkKind, OpenDrive, lane_borders, pose, surface_points
from osm2xodr.parts.defaults import MEET_DISTANCE, MEET_TURN
from osm2xodr.parts.records import Element, lane_sections

_TAGS = {End.START: "predecessor", End.END: "successor"}
_CONTACTS = {End.START: "start", End.END: "end"}


@dataclass(frozen=True, eq=False)
class RoadEnd:
    """An end of a road that leads nowhere."""

    document: int  # Which document it is in
    element: Element
    end: End
    place: FloatArray  # x, y, z, m
    outwards: float  # Heading out of the road, rad
    # By lane id: type, whether traffic leaves the road there (None for both ways), and the corners of the lane as
    # seen outwards, left and right, (2, 3), m
    lanes: dict[int, tuple[str, bool | None, FloatArray]]


def free_ends(file: OpenDrive, elements: Sequence[Element], document: int) -> Iterator[RoadEnd]:
    """Yield the ends of roads that have no link."""
    index = lane_index(file)
    for road, element in enumerate(elements):
        length = float(file.roads.length[road])
        first, last = int(file.sections.start[road]), int(file.sections.start[road + 1])
        if not length > 0 or first == last:
            continue
        for end in (End.START, End.END):
            if file.roads.link_kind[road, end] != LinkKind.NONE:
                continue
            at_end = end == End.END
            one, s = np.array([road]), np.array([length if at_end else 0.0])
            hdg = float(pose(file, one, s, before=at_end)[2][0])
            place = np.concatenate(surface_points(file, one, s, np.zeros(1), before=at_end))
            section = last - 1 if at_end else first
            rows = np.arange(int(file.lanes.start[section]), int(file.lanes.start[section + 1]))
            rows = rows[file.lanes.id[rows] != 0]
            many = np.full(len(rows), s[0])
            borders = lane_borders(file, rows, many, before=at_end)
            corners = [
                np.column_stack(surface_points(file, np.full(len(rows), road), many, t, before=at_end))
                for t in borders
            ]
            lanes = {}
            for k, row in enumerate(rows.tolist()):
                # The left border along s is the outer one of lanes on the left.
                left_first = (file.lanes.id[row] > 0) == at_end
                pair = [corners[1][k], corners[0][k]] if left_first else [corners[0][k], corners[1][k]]
                leaves = None if index.both_ways[row] else bool(index.forward[row]) == at_end
                lanes[int(file.lanes.id[row])] = (file.lanes.type[row], leaves, np.array(pair))
            yield RoadEnd(document, element, end, place, hdg if at_end else hdg + np.pi, lanes)


def join_ends(ends: Sequence[RoadEnd]) -> tuple[int, int]:
    """Link ends that meet; returns how many pairs were linked, and how many ends meet several others."""
    if len(ends) < 2:
        return 0, 0
    places = np.array([end.place for end in ends])
    usable = np.flatnonzero(np.isfinite(places).all(1))
    tree = KDTree(places[usable])
    meeting: dict[int, list[int]] = {}
    for a, b in sorted(tree.query_pairs(MEET_DISTANCE)):
        one, other = int(usable[a]), int(usable[b])
        if _meet(ends[one], ends[other]):
            meeting.setdefault(one, []).append(other)
            meeting.setdefault(other, []).append(one)
    linked = 0
    for one, others in sorted(meeting.items()):
        if len(others) == 1 and meeting[others[0]] == [one] and one < others[0]:
            _link(ends[one], ends[others[0]])
            linked += 1
    return linked, sum(len(others) > 1 for others in meeting.values())


def _meet(one: RoadEnd, other: RoadEnd) -> bool:
    """Return whether a road goes on as another one, of another document, with a lane at least."""
    if one.document == other.document:
        return False
    turn = float(wrapped(np.array([one.outwards - other.outwards - np.pi]))[0])
    return abs(turn) <= MEET_TURN and bool(_lane_pairs(one, other))


def _lane_pairs(one: RoadEnd, other: RoadEnd) -> list[tuple[int, int]]:
    """Return the lanes that meet: of one type, with the same corners, and traffic in the same direction."""
    return [
        (a, b)
        for a, (kind, leaves, corners) in sorted(one.lanes.items())
        for b, (other_kind, enters, others) in sorted(other.lanes.items())
        if kind == other_kind
        and (leaves is None or enters is None or leaves != enters)
        and float(np.abs(corners - others[::-1]).max()) <= MEET_DISTANCE
    ]


def _link(one: RoadEnd, other: RoadEnd) -> None:
    """Link two ends of roads and their lanes."""
    for here, there in ((one, other), (other, one)):
        _set_link(here, there)
    for a, b in _lane_pairs(one, other):
        for end, name, to in ((one, a, b), (other, b, a)):
            sections = lane_sections(end.element)
            lane = sections[0 if end.end == End.START else -1].find(f"*/lane[@id='{name}']")
            insert_link(lane, lane.makeelement(_TAGS[end.end], {"id": str(to)}))


def _set_link(here: RoadEnd, there: RoadEnd) -> None:
    """Let a road lead on to another one."""
    attributes = {
        "elementType": "road",
        "elementId": there.element.get("id"),
        "contactPoint": _CONTACTS[there.end],
    }
    insert_link(here.element, here.element.makeelement(_TAGS[here.end], attributes))


def insert_link(element: Element, item: Element) -> None:
    """Insert a predecessor or successor into the link of a road or lane, which stands first in it."""
    link = element.find("link")
    if link is None:
        link = element.makeelement("link", {})
        element.insert(0, link)
    # Predecessors stand before successors.
    link.insert(len(link.findall("predecessor")) if item.tag == "predecessor" else len(link), item)
