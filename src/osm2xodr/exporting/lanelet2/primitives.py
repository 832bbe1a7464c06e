"""Nodes, ways and relations as they are written."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from osm2xodr.exporting.lanelet2.words import Tags
from osm2xodr.model import FloatArray


@dataclass
class Line:
    """A way: numbers of nodes, and its tags."""

    nodes: list[int]
    tags: Tags


@dataclass
class Lanelet:
    """A lanelet: numbers of the lines that bound it in the direction of traffic, and its tags."""

    left: int
    right: int
    tags: Tags
    rules: list[int] = field(default_factory=list)  # Numbers of its regulatory elements


@dataclass
class Rule:
    """A regulatory element: role, kind (``way`` or ``lanelet``) and number of its members, and its tags."""

    members: list[tuple[str, str, int]]
    tags: Tags


class Primitives:
    """All nodes, ways, lanelets and regulatory elements; each has a number among its kind."""

    def __init__(self) -> None:
        self._points: list[FloatArray] = []
        self._count = 0
        self.lines: list[Line] = []
        self.lanelets: list[Lanelet] = []
        self.rules: list[Rule] = []

    def add_points(self, points: FloatArray) -> list[int]:
        """Add nodes at x, y, z, (n, 3), m, and return their numbers."""
        first = self._count
        self._points.append(points)
        self._count += len(points)
        return list(range(first, self._count))

    def add_line(self, nodes: list[int], tags: Tags) -> int:
        """Add a way and return its number."""
        self.lines.append(Line(nodes, tags))
        return len(self.lines) - 1

    def add_lanelet(self, left: int, right: int, tags: Tags) -> int:
        """Add a lanelet and return its number."""
        self.lanelets.append(Lanelet(left, right, tags))
        return len(self.lanelets) - 1

    def add_rule(self, members: list[tuple[str, str, int]], tags: Tags, lanelets: list[int]) -> None:
        """Add a regulatory element that holds for some lanelets."""
        for lanelet in lanelets:
            self.lanelets[lanelet].rules.append(len(self.rules))
        self.rules.append(Rule(members, tags))

    def points(self) -> FloatArray:
        """Return x, y, z of all nodes, (n, 3), m."""
        return np.concatenate(self._points) if self._points else np.zeros((0, 3))
