"""Lane sections and lanes."""

from __future__ import annotations

from array import array
from itertools import pairwise
from sys import intern
from typing import Any, Final

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.reader.nodes import Node
from osm2xodr.opendrive.reader.records import Records, extend_starts
from osm2xodr.opendrive.reader.values import NAN, Values
from osm2xodr.opendrive.tables import ABSENT, LaneTable, MarkTable, Misfit, SectionTable

_CUBIC: Final = ("sOffset", "a", "b", "c", "d")
_SIDES: Final = ("left", "center", "right")
_UNREAD: Final = frozenset({"material", "access", "rule", "visibility"})


class LaneReader:
    """Collects the ``<laneSection>`` elements of one road after another."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._section_s = array("d")
        self._section_lines = array("q")
        self._section_start = array("q", [0])
        self._lane_start = array("q", [0])
        self._rows = array("q")
        self._speeds = array("d")
        self._heights = array("d")
        # Type, road mark, its colour, and direction of each lane.
        self._texts: tuple[list[str], list[str], list[str], list[str]] = ([], [], [], [])
        self._mark_start = array("q", [0])
        self._mark_s = array("d")
        # Type and lane change of each road mark.
        self._mark_texts: tuple[list[str], list[str]] = ([], [])
        self._width = Records("width", 5)
        self._border = Records("border", 5)

    def road(self, nodes: list[Node]) -> None:
        """Read the sections of a road."""
        sections = [(self._values.number(node, "s"), node) for node in nodes]
        behind = [node for (before, _), (s, node) in pairwise(sections) if s < before]
        if behind:
            self._values.report("unsorted-records", behind[0], "<laneSection> follows one of a greater s")
            sections.sort(key=lambda item: (item[0] != item[0], item[0]))
        for s, node in sections:
            self._section_s.append(s)
            self._section_lines.append(node.line)
            self._section(node)
        self._section_start.append(len(self._section_s))

    def extend(self, other: LaneReader) -> None:
        """Add all sections of another part of the file."""
        for mine, more in zip(self._columns(), other._columns(), strict=True):
            mine.extend(more)
        for starts, others in zip(self._starts(), other._starts(), strict=True):
            extend_starts(starts, others)
        self._width.extend(other._width)
        self._border.extend(other._border)

    def _columns(self) -> tuple[Any, ...]:
        """Return what has one item for each section, lane or mark, or some of them."""
        return (
            *(self._section_s, self._section_lines, self._rows, self._speeds, self._heights, self._mark_s),
            *(*self._texts, *self._mark_texts),
        )

    def _starts(self) -> tuple[array[int], ...]:
        """Return where the sections of roads, the lanes of sections and the marks of lanes start."""
        return self._section_start, self._lane_start, self._mark_start

    def _section(self, node: Node) -> None:
        """Read the lanes of a section."""
        values = self._values
        lanes: list[tuple[int, Node]] = []
        for side in node.children:
            if side.tag not in _SIDES:
                values.check_known(side, node)
                continue
            for lane in side.children:
                if lane.tag == "lane":
                    lanes.append((self._lane_id(lane, side.tag), lane))
                else:
                    values.check_known(lane, side)
        if values.negated:
            lanes.reverse()
        ids = [number for number, _ in lanes]
        if 0 not in ids:
            values.report("missing-element", node, "<laneSection> has no centre lane")
        if any(b > a for a, b in pairwise(ids)):
            values.report("unsorted-records", node, "the lanes do not stand from left to right; they are sorted")
            lanes.sort(key=lambda item: -item[0])
        for number, lane in lanes:
            self._lane(number, lane)
        self._lane_start.append(len(self._speeds))

    def _lane_id(self, lane: Node, side: str) -> int:
        """Return the id of a lane, and check that it stands on the side that its id says."""
        number = self._values.lane_id(lane)
        written = -number if self._values.negated else number
        right = written > 0 if side == "left" else written < 0 if side == "right" else written == 0
        if not right and number != ABSENT:
            self._values.report("misplaced-element", lane, f"lane {written} stands in <{side}>")
        return number

    def _lane(self, number: int, node: Node) -> None:
        """Read a lane."""
        values = self._values
        links = (ABSENT, ABSENT)
        speed, mark, color, height = NAN, None, "", None
        for child in node.children:
            tag = child.tag
            if tag == "width":
                self._width.add(values.row(child, _CUBIC), child.line)
            elif tag == "link":
                links = self._links(child)
            elif tag == "roadMark":
                if mark is None:
                    mark, color = values.text(child, "type"), child.get("color")
                self._mark(child)
            elif tag == "border":
                self._border.add(values.row(child, _CUBIC), child.line)
            elif tag == "speed":
                speed = values.speed(child) if speed != speed else speed
            elif tag == "height":
                # A lane that opens later may say 0 before it does.
                if height is None or not any(height):
                    height = values.row(child, ("inner", "outer"))
            else:
                values.check_known(child, node, _UNREAD)
        self._mark_start.append(len(self._mark_s))
        self._width.close()
        self._border.close()
        self._rows.extend((number, *links, node.line))
        self._heights.extend(height or (0.0, 0.0))
        self._speeds.append(speed)
        texts = (values.text(node, "type"), mark or "", color, node.get("direction"))
        for words, text in zip(self._texts, texts, strict=True):
            words.append(text)

    def _mark(self, node: Node) -> None:
        """Read a road mark."""
        self._mark_s.append(self._values.optional(node, "sOffset", 0.0))
        for words, name in zip(self._mark_texts, ("type", "laneChange"), strict=True):
            words.append(intern(node.get(name)))

    def _links(self, node: Node) -> tuple[int, int]:
        """Return a lane's first predecessor and successor."""
        found = {"predecessor": ABSENT, "successor": ABSENT}
        for child in node.children:
            if child.tag not in found:
                self._values.check_known(child, node)
            elif found[child.tag] == ABSENT:
                found[child.tag] = self._values.lane_id(child)
        return found["predecessor"], found["successor"]

    def _marks(self) -> MarkTable:
        """Return the road marks of all lanes."""
        kinds, changes = map(tuple, self._mark_texts)
        return MarkTable(np.array(self._mark_start, np.int64), np.array(self._mark_s, np.float64), kinds, changes)

    def tables(self, lengths: FloatArray) -> tuple[SectionTable, LaneTable, dict[str, IntArray], list[Misfit]]:
        """Return sections, lanes, the lines of widths and borders, and reports of those out of order.

        `lengths` are those of the roads, (roads,), m.
        """
        start = np.array(self._section_start, np.int64)
        road = owners(start)
        s = np.array(self._section_s, np.float64)
        end = lengths[road]
        followed = np.flatnonzero(road[1:] == road[:-1])
        end[followed] = s[followed + 1]
        sections = SectionTable(start, road, s, end, np.array(self._section_lines, np.int64))
        lane_start = np.array(self._lane_start, np.int64)
        section = owners(lane_start)
        numbers = np.array(self._rows, np.int64).reshape(-1, 4)
        width, width_lines = self._width.profile()
        border, border_lines = self._border.profile()
        kinds, marks, colors, directions = map(tuple, self._texts)
        lanes = LaneTable(
            start=lane_start,
            section=section,
            id=numbers[:, 0].copy(),
            type=kinds,
            predecessor=numbers[:, 1].copy(),
            successor=numbers[:, 2].copy(),
            width=width,
            border=border,
            height=np.array(self._heights, np.float64).reshape(-1, 2),
            speed=np.array(self._speeds, np.float64),
            mark=marks,
            mark_color=colors,
            marks=self._marks(),
            line=numbers[:, 3].copy(),
            direction=directions,
        )
        misfits = self._width.misfits(road[section]) + self._border.misfits(road[section])
        return sections, lanes, {"width": width_lines, "border": border_lines}, misfits
