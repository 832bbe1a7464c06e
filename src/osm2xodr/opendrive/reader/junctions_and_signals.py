"""Junctions, and signals and objects on and beside roads with their controllers."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from sys import intern
from typing import Final

import numpy as np

from osm2xodr.opendrive.reader.elements import Node
from osm2xodr.opendrive.reader.values import NAN, Values, extend_starts
from osm2xodr.opendrive.tables import ABSENT, ConnectionTable, Controller, Furniture, JunctionTable

# Other elements that a junction may have in version 1.8.
_JUNCTION_UNREAD: Final = frozenset({
    "surface", "junctionReference", "boundary", "elevationGrid", "planView", "objects", "signals", "crossPath",
    "roadSection", "trafficIsland",
})  # fmt: skip
_CONNECTION_UNREAD: Final = frozenset({"predecessor", "successor"})

_KINDS: Final = {
    "signals": frozenset({"signal", "signalReference"}),
    "objects": frozenset({"object", "objectReference", "bridge", "tunnel"}),
}
# Elements without a t of their own.
_ALONG: Final = frozenset({"bridge", "tunnel"})
_FURNITURE_UNREAD: Final = frozenset({
    "material", "parkingSpace", "markings", "borders", "surface", "skeleton", "dependency", "reference",
    "positionRoad", "positionInertial", "board", "staticBoard", "vmsBoard", "semantics", "vmsGroup", "laneValidity",
})  # fmt: skip
_CORNERS: Final = {"cornerRoad": ("s", "t", "dz", "height"), "cornerLocal": ("u", "v", "z", "height")}
_REPEAT: Final = ("s", "length", "distance", "tStart", "tEnd")

# The corners of an outline, and whether they are local.
_Outline = tuple[tuple[tuple[float, float, float, float], ...], bool]


class JunctionReader:
    """Collects one ``<junction>`` after another."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self.ids: list[str] = []
        self._names: list[tuple[str, str]] = []
        self._lines: list[int] = []
        self._start = array("q", [0])
        self._priorities: list[tuple[int, str, str]] = []
        self._controllers: list[tuple[int, str]] = []
        # Id, incoming and connecting road of each connection.
        self._texts: tuple[list[str], list[str], list[str]] = ([], [], [])
        self._numbers = array("q")
        self._links = array("q")
        self._link_start = array("q", [0])

    def junction(self, node: Node) -> None:
        """Read a junction."""
        values = self._values
        index = len(self.ids)
        self.ids.append(values.text(node, "id"))
        self._names.append((node.get("name"), node.get("type")))
        self._lines.append(node.line)
        for child in node.children:
            if child.tag == "connection":
                self._connection(index, child)
            elif child.tag == "priority":
                self._priorities.append((index, child.get("high"), child.get("low")))
            elif child.tag == "controller":
                self._controllers.append((index, values.text(child, "id")))
            else:
                values.check_known(child, node, _JUNCTION_UNREAD)
        self._start.append(len(self._texts[0]))

    def extend(self, other: JunctionReader) -> None:
        """Add all junctions of another part of the file."""
        first = len(self.ids)
        self.ids.extend(other.ids)
        self._names.extend(other._names)
        self._lines.extend(other._lines)
        self._priorities.extend((first + index, high, low) for index, high, low in other._priorities)
        self._controllers.extend((first + index, name) for index, name in other._controllers)
        for names, others in zip(self._texts, other._texts, strict=True):
            names.extend(others)
        numbers = np.array(other._numbers, np.int64)
        numbers[::3] += first
        self._numbers.frombytes(numbers.tobytes())
        self._links.extend(other._links)
        extend_starts(self._start, other._start)
        extend_starts(self._link_start, other._link_start)

    def _connection(self, junction: int, node: Node) -> None:
        """Read a connection."""
        values = self._values
        for child in node.children:
            if child.tag == "laneLink":
                self._links.extend((values.lane_id(child, "from"), values.lane_id(child, "to")))
            else:
                values.check_known(child, node, _CONNECTION_UNREAD)
        self._link_start.append(len(self._links) // 2)
        linked = "linkedRoad" if "linkedRoad" in node.attributes else "connectingRoad"
        virtual = any(child.tag in _CONNECTION_UNREAD for child in node.children)
        incoming = node.get("incomingRoad") if virtual else values.text(node, "incomingRoad")
        for names, name in zip(
            self._texts, (values.text(node, "id"), incoming, values.text(node, linked)), strict=True
        ):
            names.append(name)
        self._numbers.extend((junction, values.contact(node), node.line))

    def tables(self, roads: dict[str, int]) -> tuple[JunctionTable, ConnectionTable]:
        """Return junctions and connections; `roads` are the indices of roads by id."""
        numbers = np.array(self._numbers, np.int64).reshape(-1, 3)
        links = np.array(self._links, np.int64).reshape(-1, 2)
        ids, incoming, connecting = self._texts
        junctions = JunctionTable(
            id=tuple(self.ids),
            name=tuple(name for name, _ in self._names),
            type=tuple(kind for _, kind in self._names),
            start=np.array(self._start, np.int64),
            priorities=tuple(self._priorities),
            controllers=tuple(self._controllers),
            line=np.array(self._lines, np.int64),
        )
        connections = ConnectionTable(
            junction=numbers[:, 0].copy(),
            id=tuple(ids),
            incoming_id=tuple(incoming),
            connecting_id=tuple(connecting),
            incoming=np.array([roads.get(name, ABSENT) for name in incoming], np.int64),
            connecting=np.array([roads.get(name, ABSENT) for name in connecting], np.int64),
            contact=numbers[:, 1].copy(),
            link_start=np.array(self._link_start, np.int64),
            link_from=links[:, 0].copy(),
            link_to=links[:, 1].copy(),
            line=numbers[:, 2].copy(),
        )
        return junctions, connections


def read_controller(values: Values, node: Node) -> Controller:
    """Read a ``<controller>`` of the file."""
    signals = []
    for child in node.children:
        if child.tag == "control":
            signals.append(values.text(child, "signalId"))
        else:
            values.check_known(child, node)
    return Controller(values.text(node, "id"), node.get("name"), tuple(signals), node.line)


def read_furniture(values: Values, node: Node) -> Iterator[Furniture]:
    """Yield the furniture in ``<signals>`` or ``<objects>`` of the current road."""
    for child in node.children:
        if child.tag in _KINDS[node.tag]:
            yield _item(values, child)
        else:
            values.check_known(child, node, frozenset({"vmsGroup"}))


def _item(values: Values, node: Node) -> Furniture:
    """Read a signal, an object or a reference to one."""
    old: list[_Outline] = []
    outlines: list[_Outline] = []
    validity: list[tuple[int, int]] = []
    repeats: list[tuple[float, float, float, float, float, float]] = []
    for child in node.children:
        if child.tag == "outline":
            old += _outline(values, child)
        elif child.tag == "outlines":
            outlines += _outlines(values, child)
        elif child.tag == "validity":
            ends = values.lane_id(child, "fromLane"), values.lane_id(child, "toLane")
            validity.append(ends[::-1] if values.negated else ends)
        elif child.tag == "repeat":
            s, length, distance, start, end = values.row(child, _REPEAT)
            repeats.append((s, length, distance, start, end, values.optional(child, "widthStart", NAN)))
        else:
            values.check_known(child, node, _FURNITURE_UNREAD)
    along, used = node.tag in _ALONG, outlines or old
    heading = "hOffset" if node.tag.startswith("signal") else "hdg"
    return Furniture(
        kind=node.tag,
        road=node.road,
        attributes={name: intern(text) for name, text in node.attributes.items()},
        s=values.number(node, "s"),
        t=NAN if along else values.number(node, "t"),
        z_offset=values.optional(node, "zOffset", NAN),
        hdg=values.optional(node, heading, NAN),
        length=values.number(node, "length") if along else values.optional(node, "length", NAN),
        width=values.optional(node, "width", NAN),
        height=values.optional(node, "height", NAN),
        outlines=tuple(corners for corners, _ in used),
        local_outlines=tuple(local for _, local in used),
        validity=tuple(validity),
        line=node.line,
        old_outline=old[0][0] if old else (),
        radius=values.optional(node, "radius", NAN),
        repeats=tuple(repeats),
    )


def _outlines(values: Values, node: Node) -> Iterator[_Outline]:
    """Read ``<outlines>``."""
    for outline in node.children:
        if outline.tag == "outline":
            yield from _outline(values, outline)
        else:
            values.check_known(outline, node)


def _outline(values: Values, node: Node) -> Iterator[_Outline]:
    """Read an ``<outline>``; of corners of both kinds only those of the first one's kind are used."""
    corners: list[tuple[float, float, float, float]] = []
    kind = ""
    for child in node.children:
        if child.tag not in _CORNERS:
            values.check_known(child, node)
        elif kind in ("", child.tag):
            kind = child.tag
            a, b, c, d = _CORNERS[kind]
            # Files of version 1.4 may have no height; only the place is needed.
            place = (values.number(child, a), values.number(child, b), values.optional(child, c, 0.0))
            corners.append((*place, values.optional(child, d, 0.0)))
        else:
            text = f"<outline> has corners of two kinds; <{child.tag}> is left out"
            values.report("misplaced-element", child, text)
    if corners:
        yield tuple(corners), kind == "cornerLocal"
    else:
        values.report("missing-element", node, "<outline> has no corner")
