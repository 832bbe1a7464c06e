"""Attributes as numbers, rows of numbers that belong to owners, and reports of what is wrong with them.

Rows are collected kind by kind and turned into tables at the end. They are kept as plain numbers from the start: as
objects of Python they would take four times the memory.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from operator import itemgetter
from typing import Final

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.reader.elements import Elements, Node
from osm2xodr.opendrive.tables import ABSENT, End, Misfit

NAN: Final = math.nan

# No length, coefficient or curvature of a road is as large as this; larger ones might overflow when multiplied.
_TOO_LARGE: Final = 1e12
# Nor is a lane id as large as this.
_LARGEST_ID: Final = 2**62
_ENDS: Final = {"start": int(End.START), "end": int(End.END), "": int(End.UNSAID)}
# m/s per unit; m/s is OpenDRIVE's default.
_UNITS: Final = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
# Elements that may stand anywhere.
_ANYWHERE: Final = frozenset({"userData", "include", "dataQuality"})
# Elements of which some readers take the last child for the content, whatever it is.
_NO_USER_DATA: Final = frozenset({"geometry", "elevationProfile"})


class Values:
    """Reads attributes and reports what it could not read in `misfits`.

    `negated` says whether the file has lane ids with the other sign than the standard wants.
    """

    def __init__(self, negated: bool = False) -> None:
        self.misfits: list[Misfit] = []
        self.negated = negated
        # What was reported since `settle`, and the place of its element.
        self._reports: list[tuple[int, Misfit]] = []
        # Speeds that were read without a report, by attributes.
        self._speeds: dict[tuple[str | None, str | None], float] = {}

    def extend(self, other: Values, first: int) -> None:
        """Add the reports of another part of the file, whose roads begin with the index `first`."""
        self.misfits.extend(replace(item, road=first + item.road if item.road >= 0 else -1) for item in other.misfits)

    def report(self, rule: str, node: Node, text: str) -> None:
        """Report something that is wrong with an element."""
        self._reports.append((node.order, Misfit(rule, node.line, node.road, text)))

    def settle(self) -> None:
        """Put the reports about elements that were read together into the order of the file."""
        self.misfits.extend(item for _, item in sorted(self._reports, key=itemgetter(0)))
        self._reports = []

    def rows(self, elements: Elements, which: IntArray, names: Sequence[str]) -> FloatArray:
        """Return the numbers of several required attributes of elements, (n, attributes)."""
        attributes, count = elements.attributes_of(which), len(names)
        try:
            texts = map(itemgetter(*names), attributes)
            flat = texts if count == 1 else chain.from_iterable(texts)
            found = np.fromiter(map(float, flat), np.float64, count * len(attributes)).reshape(-1, count)
        except (KeyError, ValueError):
            rows = [self.row(elements.node(row), names) for row in which.tolist()]
            return np.array(rows, np.float64).reshape(-1, count)
        with np.errstate(over="ignore"):
            sizes = np.abs(found).sum(axis=1)
        for k in np.flatnonzero(~(sizes < _TOO_LARGE)).tolist():
            found[k] = self.row(elements.node(int(which[k])), names)
        return found

    def optionals(self, elements: Elements, which: IntArray, name: str, default: float) -> FloatArray:
        """Return the numbers of an attribute of elements, (n,); a default where it is missing."""
        if all(name in item for item in elements.attributes_of(which)):
            return self.rows(elements, which, (name,))[:, 0]
        found = [self.optional(elements.node(row), name, default) for row in which.tolist()]
        return np.array(found, np.float64)

    def texts(self, elements: Elements, which: IntArray, name: str) -> list[str]:
        """Return a required attribute of elements; empty where it is missing."""
        attributes = elements.attributes_of(which)
        for k in [k for k, item in enumerate(attributes) if name not in item]:
            self.text(elements.node(int(which[k])), name)
        return elements.words(which, name)

    def lane_ids(self, elements: Elements, which: IntArray) -> IntArray:
        """Return the lane ids of elements, (n,); see `lane_id`."""
        try:
            found = np.array([int(item["id"]) for item in elements.attributes_of(which)], np.int64)
        except (KeyError, ValueError, OverflowError):
            found = None
        if found is None or np.any(np.abs(found) >= _LARGEST_ID) or np.any(found == ABSENT):
            return np.array([self.lane_id(elements.node(row)) for row in which.tolist()], np.int64)
        return -found if self.negated else found

    def row(self, node: Node, names: Sequence[str]) -> list[float]:
        """Return the numbers of several required attributes."""
        attributes = node.attributes
        try:
            values = [float(attributes[name]) for name in names]
        except (KeyError, ValueError):
            return [self.number(node, name) for name in names]
        # Numbers that are too large, and NaN, show in the sum.
        return values if sum(map(abs, values)) < _TOO_LARGE else [self.number(node, name) for name in names]

    def number(self, node: Node, name: str) -> float:
        """Return the number of a required attribute; NaN where it is missing or not a number."""
        self.text(node, name)
        return self.optional(node, name, NAN)

    def optional(self, node: Node, name: str, default: float) -> float:
        """Return the number of an attribute; a default where it is missing, NaN where it is not a number."""
        text = node.attributes.get(name)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = NAN
        if not abs(value) < _TOO_LARGE:
            self.report("bad-number", node, f"{name}={text!r} of <{node.tag}> is not a usable number")
            return NAN
        return value

    def lane_id(self, node: Node, name: str = "id") -> int:
        """Return a lane id, with the other sign where ids are `negated`; `ABSENT` if missing or not an integer."""
        text = self.text(node, name)
        try:
            value = int(text)
        except ValueError:
            value = ABSENT
        if -_LARGEST_ID < value < _LARGEST_ID:
            return -value if self.negated else value
        if name in node.attributes:
            self.report("bad-number", node, f"{name}={text!r} of <{node.tag}> is not a lane id")
        return ABSENT

    def text(self, node: Node, name: str) -> str:
        """Return a required attribute; empty where it is missing."""
        if name not in node.attributes:
            self.report("missing-attribute", node, f"<{node.tag}> has no attribute {name}")
        return node.get(name)

    def contact(self, node: Node) -> int:
        """Return the `End` that ``contactPoint`` names."""
        text = node.get("contactPoint")
        if text not in _ENDS:
            self.report("bad-value", node, f"contactPoint={text!r} of <{node.tag}> is neither start nor end")
        return _ENDS.get(text, End.UNSAID)

    def speed_of(self, elements: Elements, row: int) -> float:
        """Return the speed limit of a ``<speed>`` by its row; see `speed`. Most are alike."""
        attributes = elements.attributes[row]
        key = attributes.get("max"), attributes.get("unit")
        value = self._speeds.get(key)
        if value is None:
            before = len(self._reports)
            value = self.speed(elements.node(row))
            if len(self._reports) == before:
                self._speeds[key] = value
        return value

    def contact_of(self, elements: Elements, row: int) -> int:
        """Return the `End` that ``contactPoint`` names, of an element by its row."""
        end = _ENDS.get(elements.attributes[row].get("contactPoint", ""))
        return self.contact(elements.node(row)) if end is None else end

    def speed(self, node: Node) -> float:
        """Return the speed limit of a ``<speed>``, m/s; infinity for no limit, NaN where it is unknown."""
        text, unit = self.text(node, "max"), node.get("unit")
        if text == "no limit":
            return math.inf
        if text in ("undefined", ""):
            return NAN
        if unit and unit not in _UNITS:
            self.report("bad-value", node, f"unit={unit!r} of <speed> is not one of {', '.join(_UNITS)}")
            return NAN
        return self.optional(node, "max", NAN) * _UNITS.get(unit, 1.0)

    def check_known(self, node: Node, parent: Node, known: frozenset[str] = frozenset()) -> None:
        """Report an element that is not read, unless it is one of the `known` children of its parent."""
        tag = node.tag
        if tag in known:
            return
        if tag == "include":
            self.report("include", node, f"<include> of {node.get('file')!r} is not followed: its content is missing")
        elif tag == "userData" and parent.tag in _NO_USER_DATA:
            self.report("misplaced-user-data", node, f"<userData> stands in <{parent.tag}>, which misleads readers")
        elif tag not in _ANYWHERE:
            self.report("unknown-element", node, f"<{tag}> does not belong in <{parent.tag}>")

    def repeated(self, node: Node, parent: Node) -> None:
        """Report a further one of elements of which there may be only one."""
        self.report("repeated-element", node, f"<{parent.tag}> has more than one <{node.tag}>; the first is used")


class Records:
    """Rows of `width` numbers, the first of them s, from elements of one name, of one owner after another."""

    def __init__(self, element: str, width: int) -> None:
        self.element = element
        self._width = width
        self._flat = array("d")
        self._lines = array("q")
        self._start = array("q", [0])
        # Of each row out of order: owner, line, its s and that of the row before it.
        self._behind: list[tuple[int, int, float, float]] = []

    def add(self, rows: FloatArray, lines: IntArray, owner: IntArray, owners_: int) -> None:
        """Add the rows of further owners, with their lines; `owner` counts from 0 and ascends, (rows,)."""
        self._flat.frombytes(np.ascontiguousarray(rows).tobytes())
        self._lines.frombytes(lines.tobytes())
        extend_counts(self._start, np.bincount(owner, minlength=owners_))

    def extend(self, other: Records) -> None:
        """Add all owners of another collection."""
        extend_starts(self._start, other._start)
        self._flat.extend(other._flat)
        self._lines.extend(other._lines)

    @property
    def start(self) -> IntArray:
        """Index of each owner's first row, (owners + 1,)."""
        return np.array(self._start, np.int64)

    def table(self) -> tuple[FloatArray, IntArray, IntArray | None]:
        """Return all rows (rows, width) in ascending s per owner, and their lines.

        The third array has their places in the file, None where that is their order. Rows are handed over: only once,
        and `misfits` knows which of them were out of order.
        """
        rows = np.frombuffer(self._flat, np.float64).reshape(-1, self._width)
        lines = np.frombuffer(self._lines, np.int64)
        self._flat, self._lines = array("d"), array("q")
        owner = owners(self.start)
        behind = 1 + np.flatnonzero((np.diff(rows[:, 0]) < 0) & (owner[1:] == owner[:-1]))
        if not len(behind):
            return rows, lines, None
        columns_ = (owner[behind], lines[behind], rows[behind, 0], rows[behind - 1, 0])
        self._behind = list(zip(*(column.tolist() for column in columns_), strict=True))
        order = np.lexsort((rows[:, 0], owner))
        return rows[order], lines[order], order

    def misfits(self, roads: IntArray | None = None) -> list[Misfit]:
        """Report rows out of order; `roads` holds the road of each owner, (owners,), unless owners are roads."""
        return [
            Misfit(
                "unsorted-records",
                line,
                owner if roads is None else int(roads[owner]),
                f"<{self.element}> at {s:g} follows one at {before:g}; they are sorted",
            )
            for owner, line, s, before in self._behind
        ]

    def profile(self) -> tuple[CubicProfile, IntArray]:
        """Return rows of s, a, b, c, d as a table, and their lines."""
        rows, lines, _ = self.table()
        return CubicProfile(self.start, *columns(rows)), lines


def extend_starts(starts: array[int], others: array[int]) -> None:
    """Add the rows of other owners to the indices at which those of some owners start, (owners + 1,)."""
    last = starts[-1]
    starts.extend(last + start for start in others[1:])


def extend_counts(starts: array[int], counts: IntArray) -> None:
    """Add further owners with so many rows each."""
    starts.frombytes((starts[-1] + np.cumsum(counts, dtype=np.int64)).tobytes())


def columns(rows: FloatArray) -> list[FloatArray]:
    """Return the columns of a table, each on its own."""
    return [np.ascontiguousarray(column) for column in rows.T]
