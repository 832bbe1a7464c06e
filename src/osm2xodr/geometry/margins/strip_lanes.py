"""Strips beside carriageways become lanes outside of theirs; the carriageway's own lanes stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from osm2xodr.geometry.lanes import NO_MARK, LaneLayout
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.strip_columns import Column, columns_of, present, widths_of
from osm2xodr.geometry.margins.strips import Margins
from osm2xodr.model import Cubic, Lane, LaneSection, MarginSpec, RoadMark

# Heights that differ by less are no kerb, and borders that are closer are one, m.
_LEVEL = 0.005
_SAME_PLACE = 1e-6
# What is narrower is written as 0, m.
_NO_WIDTH = 1e-6
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


def _with_margins(sections: tuple[LaneSection, ...], margins: Margins, length: float) -> tuple[LaneSection, ...]:
    ends = [*(item.s for item in sections[1:]), length]
    sides = [_Side.of(side, sections, ends, margins) for side in _SIDES]
    out: list[LaneSection] = []
    for k, section in enumerate(sections):
        left, right = (side.lanes(k) for side in sides)
        own = _with_kerbs(section.lanes, left[:1], right[:1])
        out.append(LaneSection(section.s, (*reversed(left), *own, *right)))
    return tuple(out)


@dataclass(frozen=True, slots=True)
class _Side:
    """One side of a road."""

    side: int  # 1 left, -1 right
    # What lies there along the road, from the carriageway outwards
    columns: tuple[Column, ...]
    widths: tuple[tuple[Cubic, ...], ...]
    present: list[list[int]]  # Which of them each section has
    inner: list[int]  # How many lanes the carriageway has there, in each section
    borders: list[tuple[float, float]]  # Where the sections begin and end, s, m

    @classmethod
    def of(cls, side: int, sections: Sequence[LaneSection], ends: Sequence[float], margins: Margins) -> _Side:
        """Return one side of a road with sections that end at given places."""
        columns = columns_of(margins, side)
        borders = [(section.s, end) for section, end in zip(sections, ends, strict=True)]
        return cls(
            side,
            columns,
            tuple(widths_of(column, margins) for column in columns),
            [present(columns, margins, *place) for place in borders],
            [_lanes_on(section.lanes, side) for section in sections],
            borders,
        )

    def lanes(self, k: int) -> list[Lane]:
        """Return the lanes of the k-th section, from the carriageway outwards."""
        here = self.present[k]
        return [
            Lane(
                id=self._id(k, column) or 0,
                type=self.columns[column].kind.type,
                widths=window(self.widths[column], *self.borders[k]),
                predecessor=self._linked(k - 1, column, self.borders[k][0]) if k else None,
                successor=self._linked(k + 1, column, self.borders[k][1]) if k + 1 < len(self.borders) else None,
                road_mark=KERB_MARK if self._is_kerb(here[rank : rank + 2]) else NO_MARK,
                height=self.columns[column].kind.height,
            )
            for rank, column in enumerate(here)
        ]

    def _id(self, k: int, column: int) -> int | None:
        """Return the lane id of a column in the k-th section; None if it has none there."""
        here = self.present[k]
        return self.side * (self.inner[k] + 1 + here.index(column)) if column in here else None

    def _linked(self, k: int, column: int, s: float) -> int | None:
        """Return the lane id of a column in the k-th section, if it has any width at s, where that section touches.

        ASAM OpenDRIVE 1.7, 11.6: a lane without width at the border of its section is linked to none beyond.
        """
        return self._id(k, column) if width_at(self.widths[column], s) > _NO_WIDTH else None

    def _is_kerb(self, neighbours: Sequence[int]) -> bool:
        heights = [self.columns[column].kind.height for column in neighbours]
        return len(heights) == 2 and _kerb(*heights)


def _lanes_on(lanes: tuple[Lane, ...], side: int) -> int:
    return sum(lane.id * side > 0 for lane in lanes)


def _kerb(inner: float, outer: float) -> bool:
    return abs(inner - outer) > _LEVEL


def _with_kerbs(lanes: tuple[Lane, ...], left: Sequence[Lane], right: Sequence[Lane]) -> tuple[Lane, ...]:
    """Mark a kerb at the carriageway's edges where the innermost lane beside it is higher and no line is drawn.

    The edge is that of the outermost lane, or the centre line where all lanes lie on the other side of it.
    """
    sides = ((lanes[0].id, left), (lanes[-1].id, right))
    edges = {lane for lane, beside in sides if beside and _kerb(0.0, beside[0].height)}
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
        out.append(item.begun_later(ds, 0.0) if ds else replace(item, s=item.s - begin))
    return tuple(out)


def width_at(cubics: Sequence[Cubic], s: float) -> float:
    """Return the value of piecewise cubics at s; on a border, that before it."""
    holding = max((item for item in cubics if item.s < s), key=lambda item: item.s, default=cubics[0])
    return holding.at(s - holding.s)
