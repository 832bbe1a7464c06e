"""Strips beside carriageways become lanes outside of theirs; the carriageway's own lanes stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from osm2xodr import defaults
from osm2xodr.geometry.lane_sections import LaneLayout, tapered
from osm2xodr.geometry.margins import Margins, MarginStretch, matched
from osm2xodr.geometry.road_marks import NO_MARK
from osm2xodr.model import Cubic, Lane, LaneSection, MarginSpec, RoadMark

# Heights that differ by less are no kerb, and borders that are closer are one, m.
_LEVEL = 0.005
_SAME_PLACE = 1e-6
_SIDES = (1, -1)
KERB_MARK = RoadMark("curb", width=defaults.KERB_MARK_WIDTH)


def add_margins(
    layouts: Sequence[LaneLayout], margins: Sequence[Margins], length: Sequence[float]
) -> list[LaneLayout]:
    """Add lanes for what lies beside roads.

    Parameters
    ----------
    layouts
        The lanes of the roads' carriageways. Roads that share a layout and have the same margins share the result.
    margins
        Beside each road, settled.
    length
        Of each road, m.
    """
    alike: dict[tuple[int, tuple[MarginSpec, ...], tuple[MarginSpec, ...]], LaneLayout] = {}
    out: list[LaneLayout] = []
    for layout, beside, whole in zip(layouts, margins, length, strict=True):
        if not any(item.left or item.right for item in beside):
            out.append(layout)
            continue
        if len(beside) > 1 or len(layout.sections) > 1:
            out.append(replace(layout, sections=_with_margins(layout.sections, beside, whole)))
            continue
        kind = (id(layout), beside[0].left, beside[0].right)
        found = alike.get(kind)
        if found is None:
            found = alike[kind] = replace(layout, sections=_with_margins(layout.sections, beside, whole))
        out.append(found)
    return out


@dataclass(frozen=True, slots=True)
class _Part:
    """A lane section to be: the carriageway's section and the margins that hold there, by their indices."""

    start: float
    end: float
    section: int
    beside: int


def _with_margins(sections: tuple[LaneSection, ...], margins: Margins, length: float) -> tuple[LaneSection, ...]:
    parts = _parts(sections, margins, length)
    widths = {side: _widths(margins, side) for side in _SIDES}
    heirs = {
        side: [matched(one.strips(side), other.strips(side)) for one, other in pairwise(margins)] for side in _SIDES
    }
    out: list[LaneSection] = []
    for k, part in enumerate(parts):
        before = parts[k - 1] if k else None
        after = parts[k + 1] if k + 1 < len(parts) else None
        section = sections[part.section]
        own = _carriageway(section, part, before, after)
        outer = []
        for side in _SIDES:
            strips = margins[part.beside].strips(side)
            course = _Course(sections, heirs[side], side, part, before, after)
            profiles = widths[side][part.beside]
            outer.append(_strip_lanes(strips, profiles, margins[part.beside], course))
        own = _with_kerbs(own, *(margins[part.beside].strips(side) for side in _SIDES))
        out.append(LaneSection(part.start, (*reversed(outer[0]), *own, *outer[1])))
    return tuple(out)


def _parts(sections: tuple[LaneSection, ...], margins: Margins, length: float) -> list[_Part]:
    """Cut a road wherever its carriageway's lanes or its margins change."""
    starts = sorted({0.0, *(item.s for item in sections), *(item.start for item in margins)})
    starts = [s for k, s in enumerate(starts) if not k or s - starts[k - 1] > _SAME_PLACE]
    out: list[_Part] = []
    for s, end in pairwise([*starts, length]):
        here = s + _SAME_PLACE
        section = max(i for i, item in enumerate(sections) if item.s <= here)
        beside = max(i for i, item in enumerate(margins) if item.start <= here)
        out.append(_Part(s, end, section, beside))
    return out


def _carriageway(section: LaneSection, part: _Part, before: _Part | None, after: _Part | None) -> tuple[Lane, ...]:
    """Return the carriageway's lanes in a part of their section."""
    first = before is None or before.section != part.section
    last = after is None or after.section != part.section
    if first and last:
        return section.lanes
    begin, end = part.start - section.s, part.end - section.s
    return tuple(
        replace(
            lane,
            widths=window(lane.widths, begin, end),
            predecessor=lane.predecessor if first else lane.id or None,
            successor=lane.successor if last else lane.id or None,
        )
        for lane in section.lanes
    )


def _widths(margins: Margins, side: int) -> list[list[tuple[Cubic, ...]]]:
    """Return the widths of all strips at one side, by stretch, s local to the stretch.

    What begins or ends with a stretch does so in a taper; what goes on with another width is led to it beyond.
    """
    out: list[list[tuple[Cubic, ...]]] = []
    behind: dict[int, float] = {}
    for k, item in enumerate(margins):
        strips = item.strips(side)
        ahead = matched(strips, margins[k + 1].strips(side)) if k + 1 < len(margins) else None
        length = item.end - item.start
        taper = min(defaults.MARGIN_TAPER_LENGTH, defaults.TAPER_SHARE * length)
        out.append(
            [
                tapered(
                    length,
                    taper,
                    behind.get(i, 0.0) if k else strip.width,
                    strip.width,
                    strip.width if ahead is None or i in ahead else 0.0,
                )
                for i, strip in enumerate(strips)
            ]
        )
        behind = {to: strips[i].width for i, to in (ahead or {}).items()}
    return out


@dataclass(frozen=True, slots=True)
class _Course:
    """How margins come, run and go at one side (1 left, -1 right): which strip goes on as which, the parts."""

    sections: tuple[LaneSection, ...]
    heirs: list[dict[int, int]]
    side: int
    part: _Part
    before: _Part | None
    after: _Part | None

    def id(self, strip: int, part: _Part) -> int:
        """Return the lane id of a strip in a part."""
        return self.side * (_lanes_on(self.sections[part.section].lanes, self.side) + 1 + strip)

    def predecessor(self, strip: int) -> int | None:
        """Return the lane that a strip goes on from."""
        if self.before is None:
            return None
        if self.before.beside == self.part.beside:
            return self.id(strip, self.before)
        behind = {to: one for one, to in self.heirs[self.before.beside].items()}
        return self.id(behind[strip], self.before) if strip in behind else None

    def successor(self, strip: int) -> int | None:
        """Return the lane that a strip goes on as."""
        if self.after is None:
            return None
        if self.after.beside == self.part.beside:
            return self.id(strip, self.after)
        heir = self.heirs[self.part.beside].get(strip)
        return None if heir is None else self.id(heir, self.after)


def _strip_lanes(
    strips: tuple[MarginSpec, ...],
    profiles: list[tuple[Cubic, ...]],
    beside: MarginStretch,
    course: _Course,
) -> list[Lane]:
    """Return the lanes of the strips at one side of a part, from the carriageway outwards."""
    part = course.part
    begin, end = part.start - beside.start, part.end - beside.start
    return [
        Lane(
            id=course.id(k, part),
            type=strip.type,
            widths=window(profiles[k], begin, end),
            predecessor=course.predecessor(k),
            successor=course.successor(k),
            road_mark=KERB_MARK if k + 1 < len(strips) and _kerb(strip.height, strips[k + 1].height) else NO_MARK,
            height=strip.height,
        )
        for k, strip in enumerate(strips)
    ]


def _lanes_on(lanes: tuple[Lane, ...], side: int) -> int:
    return sum(lane.id * side > 0 for lane in lanes)


def _kerb(inner: float, outer: float) -> bool:
    return abs(inner - outer) > _LEVEL


def _with_kerbs(
    lanes: tuple[Lane, ...], left: tuple[MarginSpec, ...], right: tuple[MarginSpec, ...]
) -> tuple[Lane, ...]:
    """Mark a kerb at the carriageway's edges where the ground rises there and no line is drawn.

    The edge is that of the outermost lane, or the centre line where all lanes lie on the other side of it.
    """
    sides = ((lanes[0].id, left), (lanes[-1].id, right))
    edges = {lane for lane, strips in sides if strips and _kerb(0.0, strips[0].height)}
    return tuple(
        replace(lane, road_mark=KERB_MARK)
        if lane.id in edges and (lane.road_mark is None or lane.road_mark.type == "none")
        else lane
        for lane in lanes
    )


def window(cubics: Sequence[Cubic], begin: float, end: float) -> tuple[Cubic, ...]:
    """Return what cubics say from s = begin to s = end, with s counted from there."""
    out: list[Cubic] = []
    for k, item in enumerate(cubics):
        until = cubics[k + 1].s if k + 1 < len(cubics) else end
        if until <= begin + _SAME_PLACE or item.s >= end - _SAME_PLACE:
            continue
        ds = max(begin - item.s, 0.0)
        out.append(
            Cubic(
                max(item.s - begin, 0.0),
                item.a + ds * (item.b + ds * (item.c + ds * item.d)),
                item.b + ds * (2 * item.c + 3 * ds * item.d),
                item.c + 3 * ds * item.d,
                item.d,
            )
            if ds
            else replace(item, s=item.s - begin)
        )
    return tuple(out)
