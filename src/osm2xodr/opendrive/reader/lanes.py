"""Lane sections and lanes."""

from __future__ import annotations

from array import array
from typing import Any, Final

import numpy as np

from osm2xodr.curves import owners, sorted_unique
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive.reader.elements import Elements, Role
from osm2xodr.opendrive.reader.values import NAN, Records, Values, extend_counts, extend_starts
from osm2xodr.opendrive.tables import ABSENT, LaneTable, MarkTable, Misfit, SectionTable

_CUBIC: Final = ("sOffset", "a", "b", "c", "d")


class LaneReader:
    """Collects ``<laneSection>`` elements with their lanes."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._section_s = array("d")
        self._section_lines = array("q")
        self._section_start = array("q", [0])
        self._lane_start = array("q", [0])
        # Ids of the lanes that were read last.
        self._ids = np.zeros(0, np.int64)
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

    def add(self, elements: Elements, roads: IntArray) -> None:
        """Read the sections of some roads, given by their rows."""
        sections, place = self._sections(elements, roads)
        lanes = self._lanes(elements, sections, place)
        owner = elements.places(lanes)
        self._curves(elements, owner, len(lanes))
        self._marks(elements, owner, len(lanes))
        self._numbers(elements, owner, lanes)
        self._texts[0].extend(self._values.texts(elements, lanes, "type"))
        self._texts[3].extend(elements.words(lanes, "direction"))

    def _sections(self, elements: Elements, roads: IntArray) -> tuple[IntArray, IntArray]:
        """Read sections; return their rows in the order of the file, and their places in ascending s, by row."""
        rows = elements.of(Role.SECTION)
        road = elements.places(roads)[elements.parent[elements.parent[rows]]]
        s = self._values.rows(elements, rows, ("s",))[:, 0]
        behind = 1 + np.flatnonzero((road[1:] == road[:-1]) & (s[1:] < s[:-1]))
        order = np.arange(len(rows))
        for k in behind[np.diff(road[behind], prepend=-1) > 0].tolist():
            node = elements.node(int(rows[k]))
            self._values.report("unsorted-records", node, "<laneSection> follows one of a greater s")
            own = np.flatnonzero(road == road[k])
            order[own] = own[np.lexsort((np.nan_to_num(s[own]), np.isnan(s[own])))]
        self._section_s.frombytes(s[order].tobytes())
        self._section_lines.frombytes(elements.lines[rows[order]].tobytes())
        extend_counts(self._section_start, np.bincount(road, minlength=len(roads)))
        return rows, elements.places(rows[order])

    def _lanes(self, elements: Elements, sections: IntArray, place: IntArray) -> IntArray:
        """Return the rows of lanes from left to right, section by section; report what is not as it should be."""
        values, rows = self._values, elements.of(Role.LANE)
        ids = values.lane_ids(elements, rows)
        side = elements.parent[rows]
        self._check_sides(elements, rows, ids)
        section = elements.parent[side]
        without = np.setdiff1d(sections, section[ids == 0])
        for row in without.tolist():
            values.report("missing-element", elements.node(row), "<laneSection> has no centre lane")
        # The order in which lanes were written, which is from right to left where ids are negated.
        order = np.arange(len(rows))
        if values.negated:
            order = np.lexsort((-order, section))
        along, of = ids[order], section[order]
        wrong = sorted_unique(of[1:][(along[1:] > along[:-1]) & (of[1:] == of[:-1])])
        for row in wrong.tolist():
            text = "the lanes do not stand from left to right; they are sorted"
            values.report("unsorted-records", elements.node(row), text)
        at = place[of]
        if len(wrong) or np.any(at[1:] < at[:-1]):
            # Lanes without an id stand last.
            rank = np.where(np.isin(of, wrong) & (along != ABSENT), -along, 0)
            rank[np.isin(of, wrong) & (along == ABSENT)] = -(ABSENT + 1)
            again = np.lexsort((rank, at))
            order, at = order[again], at[again]
        extend_counts(self._lane_start, np.bincount(at, minlength=len(sections)))
        self._ids = ids[order]
        return np.asarray(rows[order], np.int64)

    def _check_sides(self, elements: Elements, rows: IntArray, ids: IntArray) -> None:
        """Check that lanes stand on the side that their ids, (n,), say."""
        values = self._values
        written = np.where(ids == ABSENT, 0, np.sign(ids)) * (-1 if values.negated else 1)
        side = np.zeros(len(elements.lines), np.int64)
        side[elements.of(Role.LEFT)], side[elements.of(Role.RIGHT)] = 1, -1
        of = side[elements.parent[rows]]
        for k in np.flatnonzero((written != of) & (ids != ABSENT)).tolist():
            lane = elements.node(int(rows[k]))
            number = -ids[k] if values.negated else ids[k]
            tag = elements.node(int(elements.parent[rows[k]])).tag
            values.report("misplaced-element", lane, f"lane {number} stands in <{tag}>")

    def _curves(self, elements: Elements, owner: IntArray, lanes: int) -> None:
        """Read widths and borders; `owner` has the places of lanes by row."""
        for role, records in ((Role.WIDTH, self._width), (Role.BORDER, self._border)):
            rows = elements.of(role)
            of = owner[elements.parent[rows]]
            cubics = self._values.rows(elements, rows, _CUBIC)
            order = np.argsort(of, kind="stable")
            records.add(cubics[order], elements.lines[rows[order]], of[order], lanes)

    def _marks(self, elements: Elements, owner: IntArray, lanes: int) -> None:
        """Read road marks."""
        values, rows = self._values, elements.of(Role.MARK)
        rows = rows[np.argsort(owner[elements.parent[rows]], kind="stable")]
        of = owner[elements.parent[rows]]
        self._mark_s.frombytes(values.optionals(elements, rows, "sOffset", 0.0).tobytes())
        self._mark_texts[0].extend(elements.words(rows, "type"))
        self._mark_texts[1].extend(elements.words(rows, "laneChange"))
        extend_counts(self._mark_start, np.bincount(of, minlength=lanes))
        first = np.diff(of, prepend=-1) > 0
        kinds, colors = [""] * lanes, [""] * lanes
        found = (
            of[first].tolist(),
            values.texts(elements, rows[first], "type"),
            elements.words(rows[first], "color"),
        )
        for k, kind, color in zip(*found, strict=True):
            kinds[k], colors[k] = kind, color
        self._texts[1].extend(kinds)
        self._texts[2].extend(colors)

    def _numbers(self, elements: Elements, owner: IntArray, lanes: IntArray) -> None:
        """Read links, speeds and heights, and collect them with the ids and lines of lanes."""
        links = elements.of(Role.LANE_LINK)
        link_of = elements.places(links)
        table = np.full((len(lanes), 4), ABSENT)
        table[:, 0], table[:, 3] = self._ids, elements.lines[lanes]
        for k, role in enumerate((Role.LANE_PREDECESSOR, Role.LANE_SUCCESSOR), 1):
            rows = elements.of(role)
            # Of several links of a lane the last one stays.
            table[owner[elements.parent[links]], k] = self._first_ids(elements, rows, link_of, len(links))
        self._rows.frombytes(table.tobytes())
        speeds = [NAN] * len(lanes)
        rows = elements.of(Role.LANE_SPEED)
        for row, lane in zip(rows.tolist(), owner[elements.parent[rows]].tolist(), strict=True):
            if speeds[lane] != speeds[lane]:
                speeds[lane] = self._values.speed_of(elements, row)
        self._speeds.extend(speeds)
        heights = np.zeros((len(lanes), 2))
        rows = elements.of(Role.HEIGHT)
        for row, lane in zip(rows.tolist(), owner[elements.parent[rows]].tolist(), strict=True):
            # A lane that opens later may say 0 before it does.
            if not heights[lane].any():
                heights[lane] = self._values.row(elements.node(row), ("inner", "outer"))
        self._heights.frombytes(heights.tobytes())

    def _first_ids(self, elements: Elements, rows: IntArray, link_of: IntArray, links: int) -> IntArray:
        """Return the first lane id of each link, (links,); `ABSENT` where there is none."""
        out = np.full(links, ABSENT)
        of = link_of[elements.parent[rows]]
        if np.any(of[1:] == of[:-1]):
            for row, link in zip(rows.tolist(), of.tolist(), strict=True):
                if out[link] == ABSENT:
                    out[link] = self._values.lane_id(elements.node(row))
        else:
            out[of] = self._values.lane_ids(elements, rows)
        return out

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

    def _mark_table(self) -> MarkTable:
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
            marks=self._mark_table(),
            line=numbers[:, 3].copy(),
            direction=directions,
        )
        misfits = self._width.misfits(road[section]) + self._border.misfits(road[section])
        return sections, lanes, {"width": width_lines, "border": border_lines}, misfits
