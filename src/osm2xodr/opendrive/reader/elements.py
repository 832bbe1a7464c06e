"""Elements of a document in columns: which ones are read, what they are, where they stand, and who they belong to.

Nearly all elements of a file are records and lanes of roads. They are read kind by kind, not one by one: a call of
Python for each of them would take most of the time. Children of an element that is not named here are not looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum, auto
from functools import cache
from sys import intern
from typing import Final

import numpy as np
from numpy.typing import NDArray

from osm2xodr.model import IntArray

# What no attribute can be called: the text of an element stands there, if it is read.
TEXT: Final = "<text>"
# Depth of the children of roads.
_PARTS: Final = 2
# Number of the name, attributes, line and depth of elements.
Columns = tuple[list[int], list[dict[str, str]], list[int], list[int]]


class Role(IntEnum):
    """What an element is to the reader."""

    IGNORED = 0  # Nobody looks at it
    UNKNOWN = auto()  # It does not belong where it stands, or may stand anywhere
    ROOT = auto()
    TREE = auto()  # A child of the root that is read as a tree
    ROAD = auto()
    LINK = auto()
    PREDECESSOR = auto()
    SUCCESSOR = auto()
    TYPE = auto()
    TYPE_SPEED = auto()
    PLAN_VIEW = auto()
    GEOMETRY = auto()
    LINE = auto()
    ARC = auto()
    SPIRAL = auto()
    POLY3 = auto()
    PARAM_POLY3 = auto()
    ELEVATION_PROFILE = auto()
    ELEVATION = auto()
    LATERAL_PROFILE = auto()
    SUPERELEVATION = auto()
    LATERAL_SHAPE = auto()
    LANES = auto()
    LANE_OFFSET = auto()
    SECTION = auto()
    LEFT = auto()
    CENTER = auto()
    RIGHT = auto()
    LANE = auto()
    LANE_LINK = auto()
    LANE_PREDECESSOR = auto()
    LANE_SUCCESSOR = auto()
    WIDTH = auto()
    BORDER = auto()
    MARK = auto()
    LANE_SPEED = auto()
    HEIGHT = auto()
    OBJECTS = auto()
    SIGNALS = auto()
    USER_DATA = auto()


_SIDE: Final = {"lane": Role.LANE}
# The children of elements whose children are looked at: IGNORED ones are known, and not read. All others are UNKNOWN.
_CHILDREN: Final[dict[Role, dict[str, Role]]] = {
    Role.ROAD: {
        "link": Role.LINK,
        "type": Role.TYPE,
        "planView": Role.PLAN_VIEW,
        "elevationProfile": Role.ELEVATION_PROFILE,
        "lateralProfile": Role.LATERAL_PROFILE,
        "lanes": Role.LANES,
        "objects": Role.OBJECTS,
        "signals": Role.SIGNALS,
        "userData": Role.USER_DATA,
        "surface": Role.IGNORED,
        "railroad": Role.IGNORED,
    },
    Role.LINK: {"predecessor": Role.PREDECESSOR, "successor": Role.SUCCESSOR, "neighbor": Role.IGNORED},
    Role.TYPE: {"speed": Role.TYPE_SPEED},
    Role.PLAN_VIEW: {"geometry": Role.GEOMETRY},
    Role.GEOMETRY: {
        "line": Role.LINE,
        "arc": Role.ARC,
        "spiral": Role.SPIRAL,
        "poly3": Role.POLY3,
        "paramPoly3": Role.PARAM_POLY3,
    },
    Role.ELEVATION_PROFILE: {"elevation": Role.ELEVATION},
    Role.LATERAL_PROFILE: {
        "superelevation": Role.SUPERELEVATION,
        "shape": Role.LATERAL_SHAPE,
        "crossfall": Role.IGNORED,
        "crossSectionSurface": Role.IGNORED,
    },
    Role.LANES: {"laneOffset": Role.LANE_OFFSET, "laneSection": Role.SECTION},
    Role.SECTION: {"left": Role.LEFT, "center": Role.CENTER, "right": Role.RIGHT},
    **dict.fromkeys((Role.LEFT, Role.CENTER, Role.RIGHT), _SIDE),
    Role.LANE: {
        "width": Role.WIDTH,
        "border": Role.BORDER,
        "link": Role.LANE_LINK,
        "roadMark": Role.MARK,
        "speed": Role.LANE_SPEED,
        "height": Role.HEIGHT,
        **dict.fromkeys(("material", "access", "rule", "visibility"), Role.IGNORED),
    },
    Role.LANE_LINK: {"predecessor": Role.LANE_PREDECESSOR, "successor": Role.LANE_SUCCESSOR},
}
# Names of elements that are told by them; all others are numbered behind these.
TAGS: Final = tuple(dict.fromkeys(["road", *(name for names in _CHILDREN.values() for name in names)]))
# Elements that a road has only once.
ONCE: Final = (
    *(Role.LINK, Role.PLAN_VIEW, Role.ELEVATION_PROFILE, Role.LATERAL_PROFILE, Role.LANES),
    *(Role.OBJECTS, Role.SIGNALS),
)


@cache
def roles_below() -> NDArray[np.int8]:
    """Return the role of an element by that of its parent and its number in `TAGS`, or behind, (roles, tags + 1)."""
    out = np.full((len(Role), len(TAGS) + 1), Role.IGNORED, np.int8)
    out[Role.ROOT] = Role.TREE
    out[Role.ROOT, TAGS.index("road")] = Role.ROAD
    for role, children in _CHILDREN.items():
        out[role] = Role.UNKNOWN
        for name, child in children.items():
            out[role, TAGS.index(name)] = child
    out.flags.writeable = False
    return out


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
