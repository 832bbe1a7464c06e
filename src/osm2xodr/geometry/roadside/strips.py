"""Strips beside the carriageways of roads: where they begin, change and end along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from osm2xodr.geometry.defaults import SHORTEST_LANE_SECTION
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import Piece
from osm2xodr.geometry.roadside import defaults
from osm2xodr.model import LaneType, MarginSpec
from osm2xodr.system import record

Strips = tuple[MarginSpec, ...]


@record
class Wedge:
    """How the sidewalk or cycle track at one side of a road becomes narrower before a junction."""

    side: int  # Left 1, right -1, seen along the road
    at_end: bool  # Whether at the road's end, else at its start
    # Distances from where the road ends, m, ascending, and how wide it is there, m; evenly between them. At the last
    # one it is as wide as elsewhere
    widths: tuple[tuple[float, float], ...]
    type: LaneType = LaneType.SIDEWALK

    @property
    def width(self) -> float:
        """How wide it is where the road ends, m."""
        return self.widths[0][1]

    def lies_at(self, end: int, side: int, kind: LaneType) -> bool:
        """Say whether it is that of a strip of a type at one side of a road end."""
        return (self.at_end, self.side, self.type) == (end % 2 == 1, side, kind)


@record
class Notch:
    """How strips inside a tight bend become narrower, evenly, and wide again."""

    side: int  # The inside: left 1, right -1, seen along the road
    # Between where they are as narrow as the bend leaves them, s on the road, m
    start: float
    end: float
    room: float  # How far they reach beyond the carriageway's edge there, m
    # How much farther they reach with each metre before and behind that
    before: float
    after: float

    def extent(self, reach: float) -> tuple[float, float]:
        """Return between which places, s, m, strips may reach less far than that, m."""
        more = max(reach - self.room, 0.0)
        return self.start - more / self.before, self.end + more / self.after

    def reach_at(self, s: float) -> float:
        """Return how far strips may reach at a place, m."""
        return self.room + max(self.before * (self.start - s), self.after * (s - self.end), 0.0)


@record
class MarginStretch:
    """Part of a road beside which nothing changes."""

    # s on the road, m
    start: float
    end: float
    # Strips beside the carriageway from its edge outwards, seen along the road
    left: Strips
    right: Strips
    way: int  # The OSM way (the first, where it is made of several)
    tight: bool = False  # Whether there is no room for wider or more strips
    wedges: tuple[Wedge, ...] = ()  # Where its strips end at junctions, narrower than elsewhere
    notches: tuple[Notch, ...] = ()  # In the first stretch of a road: where bends of the road leave strips less room

    def strips(self, side: int) -> Strips:
        """Return the strips at the left (1) or right (-1)."""
        return self.left if side > 0 else self.right

    def width(self, side: int) -> float:
        """Return the width of all strips at one side, m."""
        return _width(self.strips(side))


Margins = tuple[MarginStretch, ...]
"""Along a whole road, in ascending s without gaps; empty where nothing lies beside the road anywhere."""


def with_wedge(beside: Margins, wedge: Wedge) -> Margins:
    """Return the strips beside a road with a wedge, in the place of another of the same strip."""
    end = int(wedge.at_end)
    here = beside[-end]
    kept = (item for item in here.wedges if not item.lies_at(end, wedge.side, wedge.type))
    changed = replace(here, wedges=(*kept, wedge))
    return (*beside[:-1], changed) if wedge.at_end else (changed, *beside[1:])


def find_margins(parts: RoadParts) -> tuple[Margins, ...]:
    """Return what the tags say lies beside each road, (roads,)."""
    with_any = [any(a.margin_left or a.margin_right for _, a, _ in pieces) for pieces in parts.pieces]
    if not any(with_any):
        return ((),) * len(parts.length)
    rows = zip(parts.street.tolist(), parts.begin.tolist(), parts.end.tolist(), parts.length.tolist(), strict=True)
    return tuple(
        _along(parts.pieces[street], begin, end, length) if with_any[street] else ()
        for street, begin, end, length in rows
    )


def _along(pieces: Sequence[Piece], begin: float, end: float, length: float) -> Margins:
    """Return the margins from s = begin to s = end of a street, which became a road of a given length, m."""
    found: list[MarginStretch] = []
    for k, (s, attributes, _) in enumerate(pieces):
        lower = max(s, begin) if k else begin
        upper = min(pieces[k + 1][0], end) if k + 1 < len(pieces) else end
        if upper > lower:
            strips = attributes.margin_left, attributes.margin_right
            until = length if upper == end else upper - begin
            found.append(MarginStretch(lower - begin, until, *strips, attributes.osm_way_id))
    return tuple(found) if any(item.left or item.right for item in found) else ()


def settled(margins: Sequence[MarginStretch], borders: Sequence[float]) -> Margins:
    """Return the margins of a road with no stretch too short for a lane section of its own.

    Equal neighbours become one; a short stretch joins a neighbour; borders close to where lane sections of the
    carriageway begin (`borders`, s, m) move there. The carriageway's sections stay as they are.
    """
    if len(margins) < 2:
        return tuple(margins)
    found = _joined(margins)
    while len(found) > 1:
        k = min(range(len(found)), key=lambda i: found[i].end - found[i].start)
        if found[k].end - found[k].start >= SHORTEST_LANE_SECTION:
            break
        merged = [_merged(found[k], found[i]) for i in (k - 1, k + 1) if 0 <= i < len(found)]
        best, _ = min(merged, key=lambda item: item[1])
        lower = k - 1 if best.start < found[k].start else k
        found[lower : lower + 2] = [best]
        found = _joined(found)
    return _joined_at(found, borders)


def _merged(short: MarginStretch, neighbour: MarginStretch) -> tuple[MarginStretch, tuple[float, float]]:
    """Return a stretch merged with a short one beside it, and the cost: area that the neighbour loses, then length.

    Where the short one has no room for more, the narrower strips of both remain.
    """
    length = neighbour.end - neighbour.start
    out = replace(neighbour, start=min(short.start, neighbour.start), end=max(short.end, neighbour.end))
    if not short.tight:
        return out, (0.0, -length)
    left, right = (min(short.strips(side), neighbour.strips(side), key=_width) for side in (1, -1))
    lost = neighbour.width(1) + neighbour.width(-1) - _width(left) - _width(right)
    return replace(out, left=left, right=right, tight=True), (lost * length, -length)


def _width(strips: Strips) -> float:
    return sum(strip.width for strip in strips)


def _joined(margins: Sequence[MarginStretch]) -> list[MarginStretch]:
    out: list[MarginStretch] = []
    for item in margins:
        if out and (out[-1].left, out[-1].right) == (item.left, item.right):
            out[-1] = replace(out[-1], end=item.end, tight=out[-1].tight or item.tight)
        else:
            out.append(item)
    return out


def _joined_at(found: Sequence[MarginStretch], borders: Sequence[float]) -> Margins:
    """Move borders onto those of the carriageway's sections that are too close for a section in between."""
    out: list[MarginStretch] = []
    start = found[0].start
    for item in found:
        end = item.end
        if item is not found[-1] and borders:
            nearest = min(borders, key=lambda border: (abs(border - item.end), border))
            if 0.0 < abs(nearest - end) < SHORTEST_LANE_SECTION and 0.0 < nearest < found[-1].end:
                end = nearest
        if end - start > defaults.SAME_PLACE:
            out.append(replace(item, start=start, end=end))
            start = end
    return tuple(_joined(out))
