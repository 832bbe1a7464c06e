"""Road networks of one frame as one network.

Ids that another document has already are given anew, and ends of roads that meet are linked.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from lxml import etree

from osm2xodr.checking import lane_index
from osm2xodr.crop_and_merge.document import (
    MEET_DISTANCE,
    MEET_TURN,
    Element,
    drop_dangling,
    lane_sections,
    number,
    put,
    read_tree,
    remove,
)
from osm2xodr.curves import PointTree, wrapped
from osm2xodr.defaults import NEGATED_LANES
from osm2xodr.diagnostics import counted
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.opendrive import End, LinkKind, OpenDrive, frame_of, lane_borders, pose, surface_points
from osm2xodr.system import record

_NO_OFFSET: Final = (0.0, 0.0, 0.0, 0.0)
# The order of the root's elements: OpenDRIVE 1.7, section 5.1.
_ORDER: Final = ("header", "road", "controller", "junction", "junctionGroup", "station")
_BOUNDS: Final = {"north": max, "south": min, "east": max, "west": min}
# What has ids of its own, by the path of its elements.
_KINDS: Final = {
    "road": "road",
    "junction": "junction",
    "controller": "controller",
    "signal": "road/signals/signal",
    "object": "road/objects/object",
    "bridge": "road/objects/bridge",
    "tunnel": "road/objects/tunnel",
    "junctionGroup": "junctionGroup",
    "station": "station",
}
# Attributes that name something of a kind; paths count from the root.
_REFERENCES: Final = {
    "road": (
        ("junction/connection", ("incomingRoad", "connectingRoad", "linkedRoad")),
        ("junction/priority", ("high", "low")),
        ("junction/boundary/segment", ("roadId",)),
        ("junction", ("mainRoad",)),
        ("junction/crossPath", ("crossingRoad", "roadAtStart", "roadAtEnd")),
        ("station/platform/segment", ("roadId",)),
        ("road/link/neighbor", ("elementId",)),
        (".//positionRoad", ("roadId",)),
    ),
    "junction": (("road", ("junction",)), ("junctionGroup/junctionReference", ("junction",))),
    "controller": (("junction/controller", ("id",)),),
    "signal": (
        ("road/signals/signalReference", ("id",)),
        ("road/signals/signal/dependency", ("id",)),
        ("controller/control", ("signalId",)),
    ),
    "object": (("road/objects/objectReference", ("id",)),),
}
# Attributes that name something of the kind that stands beside them.
_TYPED: Final = ("road/link/predecessor", "road/link/successor", "road/signals/signal/reference")
_TAGS = {End.START: "predecessor", End.END: "successor"}
_CONTACTS = {End.START: "start", End.END: "end"}


def merge_networks(files: Sequence[OpenDrive]) -> tuple[Element, list[str]]:
    """Return the document of several files as one, and sentences about what was done.

    The ids of the first file stay; later ones are new where they are in use. Roads that an earlier file has with the
    same plan view and lanes are dropped. `InputError` if the files are not of one frame.
    """
    for file in files[1:]:
        _check_frame(files[0], file)
    roots = [read_tree(file.path) for file in files]
    names, known = Names(roots), dict[str, Element]()
    ends: list[RoadEnd] = []
    renamed = dropped = 0
    for k, (file, root) in enumerate(zip(files, roots, strict=True)):
        elements = root.findall("road")
        same = {element: known[text] for element in elements if (text := _signature(element)) in known}
        renamed += names.rename(root, _given(root, same))
        dropped += len(same)
        for element, earlier in same.items():
            _adopt_links(earlier, element)
        ends += [end for end in free_ends(file, elements, k) if end.element not in same]
        for element in elements:
            known.setdefault(_signature(element), element)
        _drop(root, same)
    linked, unclear = join_ends([end for end in ends if not _has_link(end)])
    merged = roots[0]
    for root in roots[1:]:
        _merge_header(merged, root)
        for item in root:
            if item.tag in _ORDER[1:]:
                _append(merged, item)
    return merged, _sentences(renamed, dropped, linked, unclear)


def _sentences(renamed: int, dropped: int, linked: int, unclear: int) -> list[str]:
    lines = [f"{linked} {'pair' if linked == 1 else 'pairs'} of ends of roads that meet: linked"]
    if renamed:
        lines.append(f"{counted(renamed, 'id')} in use before: given anew")
    if dropped:
        lines.append(f"{counted(dropped, 'road')} that an earlier file has: left out")
    if unclear:
        lines.append(f"{unclear} {'end' if unclear == 1 else 'ends'} of roads where several others meet: not linked")
    return lines


def _check_frame(first: OpenDrive, other: OpenDrive) -> None:
    """Raise `InputError` unless two files have the same projection, offset and kind of lane ids."""
    texts = [" ".join((file.header.geo_reference or "").split()) for file in (first, other)]
    if texts[0] != texts[1]:
        frames = [frame_of(file.header)[0] for file in (first, other)]
        if frames[0] is None or frames[1] is None or frames[0].crs != frames[1].crs:
            raise InputError(
                f"{first.path} and {other.path} have different geoReferences; convert both with --frame, or as areas "
                "of one batch --shared-frame"
            )
    if (first.header.offset or _NO_OFFSET) != (other.header.offset or _NO_OFFSET):
        raise InputError(f"{first.path} and {other.path} have different offsets in their headers; merge files of one")
    code, value = NEGATED_LANES
    if (first.provenance.get((-1, code)) == value) != (other.provenance.get((-1, code)) == value):
        raise InputError(f"{first.path} or {other.path} has negated lane ids for SUMO; convert both in the same way")


def _signature(element: Element) -> str:
    """Return what two files have in common of the same road: its plan view, and its lanes without their links."""
    lanes = element.find("lanes")
    bare = copy.deepcopy(lanes) if lanes is not None else element.makeelement("lanes", {})
    for link in bare.findall("laneSection/*/lane/link"):
        remove(link)
    parts = [element.find("planView"), element.find("elevationProfile"), bare]
    return "".join(etree.tostring(part, method="c14n").decode() for part in parts if part is not None)


def _given(root: Element, same: dict[Element, Element]) -> dict[str, dict[str, str]]:
    """Return the ids that roads and junctions have already in earlier files, by their ids in this one."""
    roads = {element.get("id"): earlier.get("id") for element, earlier in same.items()}
    members: dict[str, list[Element]] = {}
    for element in root.findall("road"):
        members.setdefault(element.get("junction", "-1"), []).append(element)
    junctions = {
        name: same[found[0]].get("junction")
        for name, found in members.items()
        if name != "-1" and all(element in same for element in found)
    }
    return {"road": roads, "junction": junctions}


def _adopt_links(road: Element, twin: Element) -> None:
    """Give a road the links that it lacks and that the same road has in another file."""
    sections = road.findall("lanes/laneSection"), twin.findall("lanes/laneSection")
    for tag, place in (("predecessor", 0), ("successor", -1)):
        found = twin.find(f"link/{tag}")
        if found is None or road.find(f"link/{tag}") is not None:
            continue
        insert_link(road, copy.deepcopy(found))
        for lane in sections[1][place].findall("*/lane"):
            own = sections[0][place].find(f"*/lane[@id='{lane.get('id')}']")
            for item in lane.findall(f"link/{tag}"):
                insert_link(own, copy.deepcopy(item))


def _drop(root: Element, same: dict[Element, Element]) -> None:
    """Drop the roads that earlier files have, the junctions of such roads alone, and what refers to them."""
    if not same:
        return
    gone = {element.get("junction", "-1") for element in same} - {"-1"}
    for element in same:
        remove(element)
    left = {element.get("junction") for element in root.findall("road")}
    for junction in root.findall("junction"):
        if junction.get("id") in gone - left:
            remove(junction)
    signals = {item.get("id") for item in root.iter("signal")}
    if any(control.get("signalId") not in signals for control in root.findall("controller/control")):
        drop_dangling(root)


def _has_link(end: RoadEnd) -> bool:
    """Return whether an end has got a link meanwhile."""
    return end.element.find("link/" + ("successor" if end.end else "predecessor")) is not None


def _merge_header(merged: Element, root: Element) -> None:
    """Let the header cover another document as well."""
    header, other = merged.find("header"), root.find("header")
    if header is None or other is None:
        return
    for name, choose in _BOUNDS.items():
        if header.get(name) is not None and other.get(name) is not None:
            put(header, name, choose(number(header, name), number(other, name)))
    known = {(item.get("code"), item.get("value")) for item in header.findall("userData")}
    # Who has to be named for the data, and the like.
    for item in other.findall("userData"):
        if (item.get("code"), item.get("value")) not in known:
            header.append(item)
    versions = [(number(item, "revMajor"), number(item, "revMinor")) for item in (header, other)]
    if versions[1] > versions[0]:
        for name in ("revMajor", "revMinor"):
            header.set(name, other.get(name, "0"))


def _append(merged: Element, item: Element) -> None:
    """Append an element behind the last one that may stand before it."""
    before = _ORDER[: _ORDER.index(item.tag) + 1]
    places = [k for k, child in enumerate(merged) if child.tag in before]
    merged.insert(places[-1] + 1 if places else 0, item)


class Names:
    """The ids that are in use while documents are joined, one after another.

    Roads and junctions have different ones, as CARLA wants it.
    """

    def __init__(self, roots: Sequence[Element]) -> None:
        self._used: dict[str, set[str]] = {kind: set() for kind in _KINDS}
        self._used["junction"] = self._used["road"]
        names = {item.get("id", "") for root in roots for path in _KINDS.values() for item in root.findall(path)}
        # New ids are numbers above all others.
        self._fresh = max((int(name) for name in names if name.isascii() and name.isdigit()), default=0)

    def rename(self, root: Element, given: dict[str, dict[str, str]]) -> int:
        """Give new ids to what has one that is in use, and return to how many; then all of these are in use.

        `given` are new ids that are decided already, by kind and former id: of what the other documents have.
        """
        before = self._fresh
        for kind, path in _KINDS.items():
            new = dict(given.get(kind, {}))
            elements = root.findall(path)
            for item in elements:
                name = item.get("id", "")
                if name in self._used[kind] and name not in new:
                    self._fresh += 1
                    new[name] = str(self._fresh)
            for item in elements:
                item.set("id", new.get(item.get("id", ""), item.get("id", "")))
            _rename_references(root, kind, new)
        for kind, path in _KINDS.items():
            self._used[kind].update(item.get("id", "") for item in root.findall(path))
        return self._fresh - before


def _rename_references(root: Element, kind: str, new: dict[str, str]) -> None:
    """Let what names something of a kind name its new id."""
    if not new:
        return
    for path, attributes in _REFERENCES.get(kind, ()):
        for item in root.findall(path):
            for attribute in attributes:
                name = item.get(attribute)
                if name in new:
                    item.set(attribute, new[name])
    for path in _TYPED:
        for item in root.findall(path):
            if item.get("elementType") == kind and item.get("elementId") in new:
                item.set("elementId", new[item.get("elementId")])


@record(eq=False)
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
    near = np.column_stack(PointTree(places[usable]).within(places[usable], MEET_DISTANCE))
    meeting: dict[int, list[int]] = {}
    for a, b in sorted(near[near[:, 0] < near[:, 1]].tolist()):
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
