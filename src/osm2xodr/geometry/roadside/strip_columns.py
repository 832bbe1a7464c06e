"""Strips beside a road that continue each other: each such column becomes one lane, however its width changes.

A strip that begins or ends within a lane section is a lane of the whole section, of width 0 where it is missing: so
strips never cut the lane sections in which cars change lanes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import part_of_cubics, smooth_cubic, value_of_cubics
from osm2xodr.geometry.defaults import TAPER_SHARE
from osm2xodr.geometry.lanes import without_repeats
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strips import Margins, Notch, Wedge
from osm2xodr.model import Cubic, LaneType, MarginSpec
from osm2xodr.system import record

# Parts of the carriageway beside its lanes: they take the place of each other.
_BESIDE_LANES: Final = frozenset({LaneType.PARKING, LaneType.RESTRICTED})
# Widths that differ by less are the same, m.
_SAME_WIDTH: Final = 1e-9
# Places within wedges that are closer are the same, m.
_NEAR: Final = 1e-3


@record
class Column:
    """Strips of one kind at one side of a road, one behind the other."""

    strips: tuple[MarginSpec | None, ...]  # The strip in each stretch of the road's margins; None where there is none
    wedges: tuple[Wedge, ...] = ()  # Before junctions
    notches: tuple[Notch, ...] = ()  # Inside tight bends, with the room that strips inside of it leave
    # Stretches in which it opens already, as the strip in whose place it comes closes
    opening: frozenset[int] = frozenset()

    def strip_at(self, end: int, side: int) -> MarginSpec | None:
        """Return the strip at a road end, as narrow as a wedge leaves it, at the side (left 1, right -1) it is on."""
        strip = self.strips[-(end % 2)]
        wedge = next((item for item in self.wedges if item.lies_at(end, side, self.kind.type)), None)
        return strip if strip is None or wedge is None else replace(strip, width=wedge.width)

    @property
    def kind(self) -> MarginSpec:
        """One of its strips; all are of its type, direction and height."""
        return next(strip for strip in self.strips if strip is not None)


def columns_of(margins: Margins, side: int) -> tuple[Column, ...]:
    """Return the columns at the left (1) or right (-1) of a road, from the carriageway outwards.

    Each strip joins the first column of its kind that lies outside of the strip before it, or begins one.
    """
    found: list[list[MarginSpec | None]] = []
    for k, item in enumerate(margins):
        at = 0
        for strip in item.strips(side):
            place = next((i for i in range(at, len(found)) if _same_kind(found[i], strip)), -1)
            if place < 0:
                place = at
                found.insert(place, [None] * k)
            found[place].append(strip)
            at = place + 1
        for column in found:
            if len(column) == k:
                column.append(None)
    notches = [notch for notch in margins[0].notches if notch.side == side]
    return tuple(
        Column(
            tuple(column),
            _wedges(column, margins, side),
            tuple(_beside(found[:k], margins, item) for item in notches),
            _opening(column, [*found[:k], *found[k + 1 :]]),
        )
        for k, column in enumerate(found)
    )


def _opening(column: Sequence[MarginSpec | None], others: Sequence[Sequence[MarginSpec | None]]) -> frozenset[int]:
    """Return the stretches in which one of some other columns ends, in whose place a column begins."""
    begins = [k for k in range(len(column) - 1) if column[k] is None and column[k + 1] is not None]
    return frozenset(k for k in begins if any(_gives_way(other[k], other[k + 1], column[k + 1]) for other in others))


def _gives_way(before: MarginSpec | None, after: MarginSpec | None, follows: MarginSpec | None) -> bool:
    """Whether one of two strips before and after a border ends there, and another one takes its place."""
    if before is None or after is not None or follows is None:
        return False
    return {before.type, follows.type} == _BESIDE_LANES and before.height == follows.height


def _beside(inner: Sequence[Sequence[MarginSpec | None]], margins: Margins, notch: Notch) -> Notch:
    """Return a notch with the room that it leaves beside some columns."""
    here = [k for k, item in enumerate(margins) if item.start < notch.end and item.end > notch.start]
    taken = [sum(strip.width for column in inner if (strip := column[k]) is not None) for k in here]
    room = notch.room - max(taken, default=0.0)
    if room >= 0.0:
        return replace(notch, room=room)
    return replace(notch, start=notch.start + room / notch.before, end=notch.end - room / notch.after, room=0.0)


def _wedges(column: Sequence[MarginSpec | None], margins: Margins, side: int) -> tuple[Wedge, ...]:
    """Return the wedges at one side of a road that belong to a column."""
    return tuple(
        wedge
        for end in (0, 1)
        for wedge in margins[-end].wedges
        if (strip := column[-end]) is not None and wedge.lies_at(end, side, strip.type)
    )


def _same_kind(column: Sequence[MarginSpec | None], strip: MarginSpec) -> bool:
    other = next(item for item in column if item is not None)
    return (other.type, other.direction, other.height) == (strip.type, strip.direction, strip.height)


def present(columns: Sequence[Column], margins: Margins, begin: float, end: float) -> list[int]:
    """Return the indices of the columns with a strip anywhere between two places on the road, s, m."""
    here = [
        k
        for k, item in enumerate(margins)
        if item.start < end - defaults.SAME_PLACE and item.end > begin + defaults.SAME_PLACE
    ]
    return [
        i
        for i, column in enumerate(columns)
        if any(column.strips[k] is not None or k in column.opening for k in here)
    ]


def widths_of(column: Column, margins: Margins) -> tuple[Cubic, ...]:
    """Return the width of a column along the whole road.

    Strips begin and end in a taper within their own stretch; those that change their width do so beyond the border,
    and those that take the place of another one open where that one closes.
    """
    out: list[Cubic] = []
    for k, (item, strip) in enumerate(zip(margins, column.strips, strict=True)):
        length = item.end - item.start
        width = 0.0 if strip is None else strip.width
        after = column.strips[k + 1] if k + 1 < len(margins) else strip
        before = column.strips[k - 1] if k and k - 1 not in column.opening else strip
        begins = before.width if before is not None and strip is not None else 0.0
        ends = after.width if after is not None and k in column.opening else width if after is not None else 0.0
        taper = min(defaults.MARGIN_TAPER_LENGTH, TAPER_SHARE * length)
        out += [Cubic(item.start + c.s, c.a, c.b, c.c, c.d) for c in tapered(length, taper, begins, width, ends)]
    for notch in column.notches:
        out = _with_notch(out, notch, margins[-1].end)
    return without_repeats(_narrowed(out, column.wedges, margins[-1].end) if column.wedges else out)


def _with_notch(widths: Sequence[Cubic], notch: Notch, length: float) -> list[Cubic]:
    """Return widths along a road of some length, m, that are no larger than a notch allows."""
    widest = max(item.a for item in widths)
    if widest <= notch.room + _SAME_WIDTH:
        return list(widths)
    # Strips far from the bend may be wider than those at it.
    begin, end = (min(max(s, 0.0), length) for s in notch.extent(widest))
    # Strips may begin or end in the notch.
    borders = sorted([begin, notch.start, notch.end, end, *(item.s for item in widths if begin < item.s < end)])
    places = [begin, *(s for before, s in pairwise(borders) if s - before > defaults.SAME_PLACE)]
    values = [min(value_of_cubics(widths, s), notch.reach_at(s)) for s in places]
    pieces = zip(pairwise(places), pairwise(values), strict=True)
    return [
        *(item for item in widths if item.s < begin),
        *(Cubic(s, width, (wide - width) / (to - s)) for (s, to), (width, wide) in pieces),
        *(Cubic(end + c.s, c.a, c.b, c.c, c.d) for c in part_of_cubics(widths, end, length) if end < length),
    ]


def _narrowed(widths: Sequence[Cubic], wedges: Sequence[Wedge], length: float) -> list[Cubic]:
    """Return widths along a road of some length, m, as narrow as wedges leave them: linear within these."""
    limits = [sorted((length - u if wedge.at_end else u, wide) for u, wide in wedge.widths) for wedge in wedges]
    zones = [(limit[0][0], limit[-1][0]) for limit in limits]
    ends = {length if wedge.at_end else 0.0: wedge.width for wedge in wedges}

    def within(s: float) -> list[float]:
        """Return what the wedges around s leave there."""
        return [_interpolated(limit, s) for limit, (low, high) in zip(limits, zones, strict=True) if low < s < high]

    def wide(s: float) -> float:
        return ends.get(s, min([value_of_cubics(widths, s), *within(s)]))

    near = [item.s for item in widths if within(item.s)]
    places = _apart([0.0, length, *near, *(s for limit in limits for s, _ in limit if 0.0 < s < length)])
    if len(limits) == 2:
        places = _apart([*places, *_crossings(limits[0], limits[1], places)])
    out: list[Cubic] = []
    for begin, end in pairwise(places):
        if within((begin + end) / 2):
            one, other = wide(begin), wide(end)
            out.append(Cubic(begin, one, (other - one) / (end - begin)))
        else:
            out += [Cubic(begin + c.s, c.a, c.b, c.c, c.d) for c in part_of_cubics(widths, begin, end)]
    return out


def _apart(places: Sequence[float]) -> list[float]:
    """Return places in order, without those next to another one; the first and the last stay."""
    first, *inner, last = sorted(places)
    out = [first]
    for s in inner:
        if s - out[-1] > _NEAR and last - s > _NEAR:
            out.append(s)
    return [*out, last]


def _interpolated(points: Sequence[tuple[float, float]], s: float) -> float:
    places, values = zip(*points, strict=True)
    return float(np.interp(s, places, values))


def _crossings(
    one: Sequence[tuple[float, float]], other: Sequence[tuple[float, float]], places: Sequence[float]
) -> list[float]:
    """Return where two lines cross between the places of their points."""
    off = [_interpolated(one, s) - _interpolated(other, s) for s in places]
    steps = zip(pairwise(places), pairwise(off), strict=True)
    return [a + (b - a) * before / (before - after) for (a, b), (before, after) in steps if before * after < 0.0]


def tapered(length: float, taper: float, start: float, middle: float, end: float) -> tuple[Cubic, ...]:
    """Return cubics that go from `start` to `middle` in a taper, stay, and go to `end` in another."""
    out: list[Cubic] = []
    stays_from = 0.0
    if abs(middle - start) > _SAME_WIDTH:
        out.append(smooth_cubic(0.0, taper, start, middle))
        stays_from = taper
    out.append(Cubic(stays_from, middle))
    if abs(end - middle) > _SAME_WIDTH:
        out.append(smooth_cubic(length - taper, taper, middle, end))
    return tuple(out)
