"""Lane sections as XML."""

from __future__ import annotations

from typing import TypeAlias

from osm2xodr.model import Cubic, Lane, LaneSection, LaneType, RoadMark
from osm2xodr.xodrWriter.formatting import lane_speed_attributes, number, position, start_of_last
from osm2xodr.xodrWriter.words import Words

_Head: TypeAlias = tuple[int, LaneType, int | None, int | None]


class LaneWriter:
    """Make the text of lane sections; remember the parts of lanes, since even whole cities have only a few kinds."""

    def __init__(self, words: Words) -> None:
        self._words = words
        self._sections: dict[int, str] = {}
        self._heads: dict[_Head, str] = {}
        self._widths: dict[tuple[Cubic, ...], str] = {}
        # By side of the centre line, on which the words for a mark may depend.
        self._marks: tuple[dict[RoadMark, str], ...] = ({}, {}, {})

    def sections(self, sections: tuple[LaneSection, ...], length: float) -> str:
        """Return the ``<laneSection>`` elements of a road of a length, m."""
        if len(sections) == 1 and sections[0].s == 0.0:
            # Roads share sections that are alike, so identity is enough (the map keeps them alive).
            known = self._sections.get(id(sections[0]))
            if known is None:
                known = self._sections[id(sections[0])] = self._section(sections[0], "0")
            return known
        starts = [position(section.s) for section in sections]
        starts[-1] = start_of_last(sections[-1].s, length)
        return "".join([self._section(*pair) for pair in zip(sections, starts, strict=True)])

    def _section(self, section: LaneSection, start: str) -> str:
        """Return one section: left lanes, centre, right lanes, each from left to right."""
        texts: dict[int, list[str]] = {1: [], 0: [], -1: []}
        for lane in section.lanes:
            texts[(lane.id > 0) - (lane.id < 0)].append(self._lane(lane))
        left, center, right = map("".join, texts.values())
        return (
            f'   <laneSection s="{start}">\n'
            + (f"    <left>\n{left}    </left>\n" if left else "")
            + f"    <center>\n{center}    </center>\n"
            + (f"    <right>\n{right}    </right>\n" if right else "")
            + "   </laneSection>\n"
        )

    def _lane(self, lane: Lane) -> str:
        """Return one lane, its parts in the order of the schema."""
        key = (lane.id, lane.type, lane.predecessor, lane.successor)
        head = self._heads.get(key) or self._head(key)
        widths = self._widths.get(lane.widths)
        if widths is None:
            widths = self._width(lane.widths)
        mark = ""
        if lane.road_mark is not None:
            side = (lane.id > 0) - (lane.id < 0)
            mark = self._marks[side].get(lane.road_mark) or self._mark(lane.road_mark, side)
        speed = ""
        if lane.speed is not None:
            speed = f'      <speed sOffset="0" {lane_speed_attributes(lane.speed)}/>\n'
        height = ""
        if lane.height:
            up = position(lane.height)
            height = f'      <height sOffset="0" inner="{up}" outer="{up}"/>\n'
        return f"{head}{widths}{mark}{speed}{height}     </lane>\n"

    def _head(self, key: _Head) -> str:
        """Return and remember the start of a lane and its links."""
        number_, kind, predecessor, successor = key
        runs = self._words.lane_direction(kind.value)
        direction = f' direction="{runs}"' if runs else ""
        text = f'     <lane id="{number_}" type="{self._words.lane_type(kind.value)}"{direction}>\n'
        if predecessor is not None or successor is not None:
            before = "" if predecessor is None else f'<predecessor id="{predecessor}"/>'
            after = "" if successor is None else f'<successor id="{successor}"/>'
            text += f"      <link>{before}{after}</link>\n"
        self._heads[key] = text
        return text

    def _width(self, widths: tuple[Cubic, ...]) -> str:
        """Return and remember the ``<width>`` elements of a lane."""
        text = "".join(
            f'      <width sOffset="{position(w.s)}" a="{position(w.a)}" b="{number(w.b)}"'
            f' c="{number(w.c)}" d="{number(w.d)}"/>\n'
            for w in widths
        )
        self._widths[widths] = text
        return text

    def _mark(self, mark: RoadMark, side: int) -> str:
        """Return and remember the ``<roadMark>`` of a lane left (1) or right (-1) of the centre, or of that (0)."""
        kind, color = self._words.mark_type(mark.type), self._words.mark_color(mark.color)
        change = self._words.lane_change(mark.lane_change, side)
        text = (
            f'      <roadMark sOffset="0" type="{kind}" weight="standard" color="{color}"'
            f' width="{number(mark.width)}" laneChange="{change}"/>\n'
        )
        self._marks[side][mark] = text
        return text
