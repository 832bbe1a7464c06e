"""Elements of a document in columns: what they are, where they stand, and who they belong to.

Nearly all elements of a file are records and lanes of roads. They are read kind by kind, not one by one: a call of
Python for each of them would take most of the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from sys import intern
from typing import Final

import numpy as np

from osm2xodr.model import IntArray
from osm2xodr.opendrive.reader.grammar import ONCE, Role, roles_below

# What no attribute can be called: the text of an element stands there, if it is read.
TEXT: Final = "<text>"
# Depth of the children of roads.
_PARTS: Final = 2
# Number of the name, attributes, line and depth of elements.
Columns = tuple[list[int], list[dict[str, str]], list[int], list[int]]


class Node:
    """An element: its name without prefix, attributes, children and line.

    `road` is the index of the road that it stands in, -1 outside roads; `order` its place among the elements that are
    read with it.
    """

    __slots__ = ("attributes", "children", "line", "order", "road", "tag")

    def __init__(self, tag: str, attributes: dict[str, str], line: int, order: int = 0, road: int = -1) -> None:
        self.tag = tag
        self.attributes = attributes
        self.children: list[Node] = []
        self.line = line
        self.order = order
        self.road = road

    def get(self, name: str) -> str:
        """Return an attribute, empty where there is none; texts that are alike, as most are, are one in memory."""
        return intern(self.attributes.get(name, ""))


class Elements:
    """Some children of the root with all that is in them, in the order of the file; the root is the first element.

    `names` are those of elements by number, `lines_before` and `roads_before` what the file has in front of them.
    """

    def __init__(self, names: Sequence[str], columns: Columns, lines_before: int, roads_before: int) -> None:
        self._names = names
        codes, self.attributes, lines, self._depths = columns
        self._codes = np.array(codes, np.int64)
        self.lines = np.array(lines, np.int64) + lines_before
        # Index of the road that each element stands in, -1 outside roads.
        self._road = np.full(len(codes), -1, np.int64)
        self.parent = np.zeros(len(codes), np.int64)
        self._roles = np.zeros(len(codes), np.int8)
        # Further elements of which a road has only one: they are left out.
        self.repeated: list[int] = []
        self._settle(np.array(self._depths, np.int64), roads_before)
        self._order = np.argsort(self._roles, kind="stable")
        self._bounds = np.searchsorted(self._roles[self._order], np.arange(len(Role) + 1))

    def _settle(self, depth: IntArray, roads_before: int) -> None:
        """Find parent, role and road of each element, level by level."""
        self._roles[0] = Role.ROOT
        above = np.zeros(1, np.int64)
        table, k = roles_below(), 1
        while len(level := np.flatnonzero(depth == k)):
            parent = above[np.searchsorted(above, level) - 1]
            self.parent[level] = parent
            self._roles[level] = table[self._roles[parent], np.minimum(self._codes[level], table.shape[1] - 1)]
            self._road[level] = self._road[parent]
            if k == 1:
                roads = level[self._roles[level] == Role.ROAD]
                self._road[roads] = roads_before + np.arange(len(roads))
            elif k == _PARTS:
                self._pass_over_repeated(level)
            above, k = level, k + 1

    def _pass_over_repeated(self, level: IntArray) -> None:
        """Leave out further elements of which a road has only one."""
        for role in ONCE:
            rows = level[self._roles[level] == role]
            again = 1 + np.flatnonzero(self.parent[rows[1:]] == self.parent[rows[:-1]])
            if len(again):
                self.repeated += rows[again].tolist()
                self._roles[rows[again]] = Role.IGNORED

    def of(self, role: Role) -> IntArray:
        """Return the rows of a role, ascending."""
        return self._order[self._bounds[role] : self._bounds[role + 1]]

    def places(self, owners: IntArray) -> IntArray:
        """Return for the rows of owners, in some order, their places in it, by row, (n,); nonsense for other rows."""
        out = np.zeros(len(self._codes), np.int64)
        out[owners] = np.arange(len(owners))
        return out

    def attributes_of(self, rows: IntArray) -> list[dict[str, str]]:
        """Return the attributes of some rows."""
        attributes = self.attributes
        return [attributes[row] for row in rows.tolist()]

    def words(self, rows: IntArray, name: str) -> list[str]:
        """Return an attribute of some rows, empty where there is none."""
        return [intern(item.get(name, "")) for item in self.attributes_of(rows)]

    def node(self, row: int) -> Node:
        """Return an element without its children."""
        return Node(
            self._names[self._codes[row]], self.attributes[row], int(self.lines[row]), row, int(self._road[row])
        )

    def tree(self, row: int) -> Node:
        """Return an element with all that is in it."""
        top = self.node(row)
        above, first = [top], self._depths[row]
        for k in range(row + 1, len(self._depths)):
            depth = self._depths[k] - first
            if depth <= 0:
                break
            node = Node(self._names[self._codes[k]], self.attributes[k], int(self.lines[k]), k, top.road)
            del above[depth:]
            above[-1].children.append(node)
            above.append(node)
        return top
