"""Roads without their lanes, signals and objects."""

from __future__ import annotations

from array import array
from typing import Any, Final

import numpy as np

from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.reader.nodes import Node
from osm2xodr.opendrive.reader.records import Records, columns
from osm2xodr.opendrive.reader.values import NAN, Values
from osm2xodr.opendrive.tables import ABSENT, GeometryTable, LinkKind, Misfit, RoadTable, Shape, TypeTable

_CUBIC: Final = ("s", "a", "b", "c", "d")
_GEOMETRY: Final = ("s", "x", "y", "hdg", "length")
_PARAMETERS: Final = 8
_SHAPES: Final[dict[str, tuple[Shape, tuple[str, ...]]]] = {
    "line": (Shape.LINE, ()),
    "arc": (Shape.ARC, ("curvature",)),
    "spiral": (Shape.SPIRAL, ("curvStart", "curvEnd")),
    "poly3": (Shape.POLY3, ("a", "b", "c", "d")),
    "paramPoly3": (Shape.PARAM_POLY3, ("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV")),
}
# The records of piecewise cubics in each element of a road, and what else it may have.
_PROFILES: Final[dict[str, tuple[str, frozenset[str]]]] = {
    "elevationProfile": ("elevation", frozenset()),
    "lateralProfile": ("superelevation", frozenset({"shape", "crossfall", "crossSectionSurface"})),
    "lanes": ("laneOffset", frozenset({"laneSection"})),
}
_LINK_KINDS: Final = {"road": LinkKind.ROAD, "junction": LinkKind.JUNCTION}
# Padding of the parameters of a shape, by their number.
_PADDING: Final = {count: [NAN] * (_PARAMETERS - count) for count in range(_PARAMETERS + 1)}

# (kind, id, contact) of a link.
_Link = tuple[int, str, int]
_NO_LINK: Final[_Link] = (LinkKind.NONE, "", -1)


class RoadReader:
    """Collects attributes, links, types, plan views and profiles of one road after another."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self.ids: list[str] = []
        self._names: list[str] = []
        self._junctions: list[str] = []
        self._left_hand: list[bool] = []
        self._lengths = array("d")
        self._lines = array("q")
        # Kind, contact and id of predecessor and successor, road after road.
        self._link_kinds = array("q")
        self._contacts = array("q")
        self._link_ids: list[str] = []
        self._types = Records("type", 2)
        self._type_words: list[str] = []
        self._plan = Records("geometry", 7 + _PARAMETERS)
        self._cubics = {element: Records(element, 5) for element, _ in _PROFILES.values()}
        self._records = (self._types, self._plan, *self._cubics.values())
        self._shapes = array("q")

    def begin(self, node: Node) -> None:
        """Read a road's attributes and begin its records."""
        values = self._values
        self.ids.append(values.text(node, "id"))
        self._names.append(node.get("name"))
        self._junctions.append(values.text(node, "junction"))
        self._lengths.append(values.number(node, "length"))
        self._lines.append(node.line)
        rule = node.get("rule")
        if rule not in ("", "RHT", "LHT"):
            values.report("bad-value", node, f"rule={rule!r} of <road> is neither RHT nor LHT")
        self._left_hand.append(rule == "LHT")
        self._shapes.append(0)

    def end(self, node: Node, link: Node | None) -> None:
        """End a road's records, and read its links."""
        if self._plan.is_empty:
            self._values.report("missing-element", node, "<road> has no <planView> with a <geometry>")
        for kind, name, contact in self._link(link):
            self._link_kinds.append(kind)
            self._link_ids.append(name)
            self._contacts.append(contact)
        for records in self._records:
            records.close()

    def type(self, node: Node) -> None:
        """Read a ``<type>``."""
        speed = NAN
        for child in node.children:
            if child.tag == "speed":
                speed = self._values.speed(child)
            else:
                self._values.check_known(child, node)
        self._types.add((self._values.number(node, "s"), speed), node.line)
        self._type_words.append(self._values.text(node, "type"))

    def plan_view(self, node: Node) -> None:
        """Read a ``<planView>``."""
        for child in node.children:
            if child.tag == "geometry":
                row = self._values.row(child, _GEOMETRY)
                row.extend(self._shape(child))
                self._plan.add(row, child.line)
            else:
                self._values.check_known(child, node)

    def _shape(self, node: Node) -> list[float]:
        """Return kind, whether normalized, and parameters of a ``<geometry>``."""
        values = self._values
        found: list[float] | None = None
        for child in node.children:
            shape = _SHAPES.get(child.tag)
            if shape is None:
                values.check_known(child, node)
            elif found is not None:
                values.report("repeated-element", child, "<geometry> has more than one shape; the first is used")
            else:
                kind, names = shape
                found = [kind, self._normalized(child)] if kind is Shape.PARAM_POLY3 else [kind, 0.0]
                if names:
                    found.extend(values.row(child, names))
                found.extend(_PADDING[len(names)])
        if found is None:
            values.report("missing-shape", node, "<geometry> has no shape")
            return [Shape.UNKNOWN, 0.0, *_PADDING[0]]
        return found

    def _normalized(self, node: Node) -> float:
        """Return 1 if the parameter of a ``<paramPoly3>`` runs from 0 to 1, as it does by default, else 0."""
        word = self._values.text(node, "pRange")
        if word not in ("arcLength", "normalized", ""):
            text = f"pRange={word!r} of <paramPoly3> is neither arcLength nor normalized"
            self._values.report("bad-value", node, text)
        return 0.0 if word == "arcLength" else 1.0

    def profile(self, node: Node) -> None:
        """Read the piecewise cubics in one of `_PROFILES`."""
        element, known = _PROFILES[node.tag]
        for child in node.children:
            if child.tag == element:
                self._cubics[element].add(self._values.row(child, _CUBIC), child.line)
            else:
                self._values.check_known(child, node, known)
        if node.tag == "lateralProfile":
            self._shapes[-1] = sum(child.tag == "shape" for child in node.children)

    def _link(self, node: Node | None) -> tuple[_Link, _Link]:
        """Return a road's predecessor and successor."""
        if node is None or not node.children:
            return _NO_LINK, _NO_LINK
        found: dict[str, Node | None] = {"predecessor": None, "successor": None}
        for child in node.children:
            if child.tag in found:
                found[child.tag] = self._values.first_only(child, node, found[child.tag])
            else:
                self._values.check_known(child, node, frozenset({"neighbor"}))
        return self._side(found["predecessor"]), self._side(found["successor"])

    def _side(self, node: Node | None) -> _Link:
        """Read a ``<predecessor>`` or ``<successor>`` of a road."""
        if node is None:
            return _NO_LINK
        word = self._values.text(node, "elementType")
        kind = _LINK_KINDS.get(word, LinkKind.UNKNOWN)
        if word and kind is LinkKind.UNKNOWN:
            text = f"elementType={word!r} of <{node.tag}> is neither road nor junction"
            self._values.report("bad-value", node, text)
        return kind, self._values.text(node, "elementId"), self._values.contact(node)

    def extend(self, other: RoadReader) -> None:
        """Add all roads of another part of the file."""
        for mine, more in zip(self._columns(), other._columns(), strict=True):
            mine.extend(more)
        for records, others in zip(self._records, other._records, strict=True):
            records.extend(others)

    def _columns(self) -> tuple[Any, ...]:
        """Return what has one item for each road, or two for its ends, and the words of types."""
        return (
            *(self.ids, self._names, self._junctions, self._left_hand, self._lengths, self._lines, self._shapes),
            *(self._link_kinds, self._contacts, self._link_ids, self._type_words),
        )

    @property
    def lengths(self) -> FloatArray:
        """Lengths of the roads as written, (roads,), m."""
        return np.array(self._lengths, np.float64)

    def roads(self, junctions: dict[str, int]) -> RoadTable:
        """Return the table of roads; `junctions` are the indices of junctions by id."""
        where: dict[int, dict[str, int]] = {LinkKind.ROAD: first_index(self.ids), LinkKind.JUNCTION: junctions}
        ends = zip(self._link_kinds, self._link_ids, strict=True)
        target = array("q", [where.get(kind, {}).get(name, ABSENT) for kind, name in ends])
        own = [-1 if name in ("-1", "") else junctions.get(name, ABSENT) for name in self._junctions]
        return RoadTable(
            id=tuple(self.ids),
            name=tuple(self._names),
            length=self.lengths,
            junction=np.array(own, np.int64),
            junction_id=tuple(self._junctions),
            left_hand=np.array(self._left_hand, np.bool_),
            link_kind=_pairs(self._link_kinds),
            link=_pairs(target),
            link_id=tuple(zip(self._link_ids[::2], self._link_ids[1::2], strict=True)),
            contact=_pairs(self._contacts),
            line=np.array(self._lines, np.int64),
        )

    def types(self) -> tuple[TypeTable, IntArray]:
        """Return the table of types, and their lines."""
        rows, lines, order = self._types.table()
        s, speed = columns(rows)
        words = tuple(self._type_words if order is None else [self._type_words[k] for k in order.tolist()])
        return TypeTable(self._types.start, s, speed, words), lines

    def plan(self) -> GeometryTable:
        """Return the plan views."""
        rows, lines, _ = self._plan.table()
        parts = columns(rows)
        return GeometryTable(
            self._plan.start,
            s=parts[0],
            x=parts[1],
            y=parts[2],
            hdg=parts[3],
            length=parts[4],
            shape=parts[5].astype(np.int64),
            parameters=rows[:, 7:].copy(),
            normalized=parts[6] != 0,
            line=lines,
        )

    def profiles(self) -> list[tuple[CubicProfile, IntArray]]:
        """Return elevation, superelevation and lane offset, and the lines of their records."""
        return [records.profile() for records in self._cubics.values()]

    def shapes(self) -> IntArray:
        """Return how many ``<shape>`` records each road has, (roads,)."""
        return np.array(self._shapes, np.int64)

    def misfits(self) -> list[Misfit]:
        """Report records out of order."""
        return [item for records in self._records for item in records.misfits()]


def first_index(ids: list[str]) -> dict[str, int]:
    """Return the first index of each id."""
    index: dict[str, int] = {}
    for k, name in enumerate(ids):
        index.setdefault(name, k)
    return index


def _pairs(flat: array[int]) -> IntArray:
    """Return pairs as an array, (n, 2)."""
    return np.array(flat, np.int64).reshape(-1, 2)
