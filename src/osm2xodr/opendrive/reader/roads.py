"""Roads without their lanes, signals and objects."""

from __future__ import annotations

from array import array
from typing import Any, Final

import numpy as np

from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.reader.elements import Elements, Node, Role
from osm2xodr.opendrive.reader.values import NAN, Records, Values, columns
from osm2xodr.opendrive.tables import ABSENT, GeometryTable, LinkKind, Misfit, RoadTable, Shape, TypeTable

_CUBIC: Final = ("s", "a", "b", "c", "d")
_GEOMETRY: Final = ("s", "x", "y", "hdg", "length")
_PARAMETERS: Final = 8
_SHAPES: Final[dict[Role, tuple[Shape, tuple[str, ...]]]] = {
    Role.LINE: (Shape.LINE, ()),
    Role.ARC: (Shape.ARC, ("curvature",)),
    Role.SPIRAL: (Shape.SPIRAL, ("curvStart", "curvEnd")),
    Role.POLY3: (Shape.POLY3, ("a", "b", "c", "d")),
    Role.PARAM_POLY3: (Shape.PARAM_POLY3, ("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV")),
}
# The records of piecewise cubics, all of them children of children of roads.
_PROFILES: Final = {
    "elevation": Role.ELEVATION,
    "superelevation": Role.SUPERELEVATION,
    "laneOffset": Role.LANE_OFFSET,
}
_LINK_KINDS: Final = {"road": int(LinkKind.ROAD), "junction": int(LinkKind.JUNCTION)}


class RoadReader:
    """Collects attributes, links, types, plan views and profiles of roads."""

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
        self._cubics = {element: Records(element, 5) for element in _PROFILES}
        self._records = (self._types, self._plan, *self._cubics.values())
        self._shapes = array("q")

    def add(self, elements: Elements, roads: IntArray) -> None:
        """Read roads, given by their rows."""
        values, place = self._values, elements.places(roads)
        self.ids += values.texts(elements, roads, "id")
        self._names += elements.words(roads, "name")
        self._junctions += values.texts(elements, roads, "junction")
        self._lengths.frombytes(values.rows(elements, roads, ("length",)).tobytes())
        self._lines.frombytes(elements.lines[roads].tobytes())
        rules = elements.words(roads, "rule")
        self._left_hand += [rule == "LHT" for rule in rules]
        for k in [k for k, rule in enumerate(rules) if rule not in ("", "RHT", "LHT")]:
            text = f"rule={rules[k]!r} of <road> is neither RHT nor LHT"
            values.report("bad-value", elements.node(int(roads[k])), text)
        self._add_links(elements, place, len(roads))
        self._add_types(elements, place, len(roads))
        self._add_plan_views(elements, place, roads)
        for element, role in _PROFILES.items():
            rows = elements.of(role)
            owner = place[elements.parent[elements.parent[rows]]]
            self._cubics[element].add(values.rows(elements, rows, _CUBIC), elements.lines[rows], owner, len(roads))
        shapes = elements.of(Role.LATERAL_SHAPE)
        owner = place[elements.parent[elements.parent[shapes]]]
        self._shapes.frombytes(np.bincount(owner, minlength=len(roads)).tobytes())

    def _add_types(self, elements: Elements, place: IntArray, roads: int) -> None:
        """Read ``<type>`` elements; `place` has the places of roads by row."""
        rows, limits = elements.of(Role.TYPE), elements.of(Role.TYPE_SPEED)
        speeds = np.full(len(rows), NAN)
        # Of several the last one stays.
        speeds[elements.places(rows)[elements.parent[limits]]] = [
            self._values.speed_of(elements, row) for row in limits.tolist()
        ]
        s = self._values.rows(elements, rows, ("s",))[:, 0]
        owner = place[elements.parent[rows]]
        self._types.add(np.column_stack([s, speeds]), elements.lines[rows], owner, roads)
        self._type_words += self._values.texts(elements, rows, "type")

    def _add_plan_views(self, elements: Elements, place: IntArray, roads: IntArray) -> None:
        """Read ``<planView>`` elements."""
        values, rows = self._values, elements.of(Role.GEOMETRY)
        table = np.full((len(rows), 7 + _PARAMETERS), NAN)
        table[:, :5] = values.rows(elements, rows, _GEOMETRY)
        table[:, 5], table[:, 6] = Shape.UNKNOWN, 0.0
        at = elements.places(rows)
        for role, shapes in self._first_shapes(elements).items():
            kind, names = _SHAPES[role]
            k = at[elements.parent[shapes]]
            table[k, 5] = kind
            if kind is Shape.PARAM_POLY3:
                table[k, 6] = [self._normalized(elements.node(row)) for row in shapes.tolist()]
            if names:
                table[k, 7 : 7 + len(names)] = values.rows(elements, shapes, names)
        for row in rows[table[:, 5] == Shape.UNKNOWN].tolist():
            values.report("missing-shape", elements.node(row), "<geometry> has no shape")
        owner = place[elements.parent[elements.parent[rows]]]
        self._plan.add(table, elements.lines[rows], owner, len(roads))
        for k in np.flatnonzero(np.bincount(owner, minlength=len(roads)) == 0).tolist():
            node = elements.node(int(roads[k]))
            values.report("missing-element", node, "<road> has no <planView> with a <geometry>")

    def _first_shapes(self, elements: Elements) -> dict[Role, IntArray]:
        """Return the rows of shapes by their role, the first one of each ``<geometry>``; report further ones."""
        found = {role: elements.of(role) for role in _SHAPES}
        rows = np.sort(np.concatenate(list(found.values())))
        again = rows[1:][elements.parent[rows[1:]] == elements.parent[rows[:-1]]]
        for row in again.tolist():
            text = "<geometry> has more than one shape; the first is used"
            self._values.report("repeated-element", elements.node(row), text)
        return {role: np.setdiff1d(some, again) if len(again) else some for role, some in found.items()}

    def _normalized(self, node: Node) -> float:
        """Return 1 if the parameter of a ``<paramPoly3>`` runs from 0 to 1, as it does by default, else 0."""
        word = self._values.text(node, "pRange")
        if word not in ("arcLength", "normalized", ""):
            text = f"pRange={word!r} of <paramPoly3> is neither arcLength nor normalized"
            self._values.report("bad-value", node, text)
        return 0.0 if word == "arcLength" else 1.0

    def _add_links(self, elements: Elements, place: IntArray, roads: int) -> None:
        """Read the links of roads."""
        values, count = self._values, 2 * roads
        kinds, contacts, ids = [int(LinkKind.NONE)] * count, [-1] * count, [""] * count
        for side, role in enumerate((Role.PREDECESSOR, Role.SUCCESSOR)):
            rows = elements.of(role)
            link = elements.parent[rows]
            again = np.diff(link, prepend=-1) == 0
            for row in rows[again].tolist():
                node = elements.node(row)
                values.repeated(node, elements.node(int(elements.parent[row])))
            rows = rows[~again]
            words = values.texts(elements, rows, "elementType")
            names = values.texts(elements, rows, "elementId")
            owner = (2 * place[elements.parent[elements.parent[rows]]] + side).tolist()
            for k, row, word, name in zip(owner, rows.tolist(), words, names, strict=True):
                kinds[k], ids[k] = _LINK_KINDS.get(word, LinkKind.UNKNOWN), name
                if word and kinds[k] == LinkKind.UNKNOWN:
                    node = elements.node(row)
                    text = f"elementType={word!r} of <{node.tag}> is neither road nor junction"
                    values.report("bad-value", node, text)
                contacts[k] = values.contact_of(elements, row)
        self._link_kinds.extend(kinds)
        self._contacts.extend(contacts)
        self._link_ids += ids

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
