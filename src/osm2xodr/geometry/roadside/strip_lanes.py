"""Strips beside carriageways become lanes outside the carriageway's own lanes, which stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from osm2xodr.curves import part_of_cubics, value_of_cubics
from osm2xodr.geometry.lanes import NO_MARK, LaneLayout
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strip_columns import Column, columns_of, present, widths_of
from osm2xodr.geometry.roadside.strips import Margins
from osm2xodr.model import Cubic, Lane, LaneSection, MarginSpec, RoadMark
from osm2xodr.system import record

# Strips have no width where they are narrower, m: rounding of their tapers.
_NO_WIDTH: Final = 1e-6
_KERB_MARK: Final = RoadMark("curb", width=defaults.KERB_MARK_WIDTH)


def add_margins(
    layouts: Sequence[LaneLayout], margins: Sequence[Margins], length: Sequence[float]
) -> list[LaneLayout]:
    """Add lanes for the strips beside roads to those of their carriageways; `length` is each road's, m.

    Roads that share a layout and have the same margins share the result.
    """
    alike: dict[tuple[int, tuple[MarginSpec, ...], tuple[MarginSpec, ...]], LaneLayout] = {}
    out: list[LaneLayout] = []
    for layout, beside, whole in zip(layouts, margins, length, strict=True):
        if not any(item.left or item.right for item in beside):
            out.append(layout)
            continue
        shared = len(beside) == 1 and len(layout.sections) == 1 and not (beside[0].wedges or beside[0].notches)
        kind = (id(layout), beside[0].left, beside[0].right)
        found = alike.get(kind) if shared else None
        if found is None:
            found = replace(layout, sections=_with_margins(layout.sections, beside, whole))
            if shared:
                alike[kind] = found
        out.append(found)
    return out


def _with_margins(sections: tuple[LaneSection, ...], margins: Margins, length: float) -> tuple[LaneSection, ...]:
    ends = [*(item.s for item in sections[1:]), length]
    sides = [_Side.of(side, sections, ends, margins) for side in (1, -1)]
    out: list[LaneSection] = []
    for k, section in enumerate(sections):
        left, right = (side.lanes(k) for side in sides)
        own = _with_kerbs(section.lanes, left[:1], right[:1])
        out.append(LaneSection(section.s, (*reversed(left), *own, *right)))
    return tuple(out)


@record
class _Side:
    """One side of a road."""

    side: int  # 1 left, -1 right
    # The columns of strips there, from the carriageway outwards, and their widths along the road
    columns: tuple[Column, ...]
    widths: tuple[tuple[Cubic, ...], ...]
    present: list[list[int]]  # Indices of the columns that each section has
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
            [sum(lane.id * side > 0 for lane in section.lanes) for section in sections],
            borders,
        )

    def lanes(self, k: int) -> list[Lane]:
        """Return the lanes of the k-th section, from the carriageway outwards."""
        here = self.present[k]
        height = [self.columns[column].kind.height for column in here]
        kerb = [*(_is_step(*pair) for pair in pairwise(height)), False]
        return [
            Lane(
                id=self._id(k, column) or 0,
                type=self.columns[column].kind.type,
                widths=part_of_cubics(self.widths[column], *self.borders[k]),
                predecessor=self._linked(k - 1, column, self.borders[k][0]) if k else None,
                successor=self._linked(k + 1, column, self.borders[k][1]) if k + 1 < len(self.borders) else None,
                road_mark=_KERB_MARK if kerb[rank] else NO_MARK,
                height=height[rank],
            )
            for rank, column in enumerate(here)
        ]

    def _id(self, k: int, column: int) -> int | None:
        """Return the lane id of a column in the k-th section; None if the section does not have it."""
        here = self.present[k]
        return self.side * (self.inner[k] + 1 + here.index(column)) if column in here else None

    def _linked(self, k: int, column: int, s: float) -> int | None:
        """Return the lane id of a column in the k-th section if it has any width at s, the border to that section.

        ASAM OpenDRIVE 1.7, 11.6: a lane without width at the border of its section has no link beyond it.
        """
        return self._id(k, column) if has_width(self.widths[column], s) else None


def has_width(widths: Sequence[Cubic], s: float) -> bool:
    """Whether a lane with some widths has any right before s, or at the start of its first record, m."""
    return value_of_cubics(widths, s, before=True) > _NO_WIDTH


def _is_step(inner: float, outer: float) -> bool:
    return abs(inner - outer) > defaults.SAME_HEIGHT


def _with_kerbs(lanes: tuple[Lane, ...], left: Sequence[Lane], right: Sequence[Lane]) -> tuple[Lane, ...]:
    """Mark a kerb at the carriageway's edges where the innermost strip is higher and no line is drawn.

    The edge is that of the outermost lane, or the centre line where all lanes lie on the other side of it.
    """
    sides = ((lanes[0].id, left), (lanes[-1].id, right))
    edges = {lane for lane, beside in sides if beside and _is_step(0.0, beside[0].height)}
    return tuple(
        replace(lane, road_mark=_KERB_MARK)
        if lane.id in edges and (lane.road_mark is None or lane.road_mark.type == "none")
        else lane
        for lane in lanes
    )
