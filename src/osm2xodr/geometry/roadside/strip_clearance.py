"""Strips are narrowed or left out where they have no room: beside other carriageways and inside bends."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, cosine, find_record, pose, ranks, repeated, sine, slope_of, starts
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import PARALLEL_GAP, PARALLEL_SPACING, SHORTEST_LANE_SECTION
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strips import Margins, MarginStretch, Notch, Strips, settled
from osm2xodr.geometry.roadside.tight_bends import notches_in, tight_bends
from osm2xodr.model import BoolArray, FloatArray, IntArray, LaneType
from osm2xodr.system import record

# Share of its width that a strip keeps at least; narrower, it is left out. A choice.
_LEAST_WIDTH_SHARE: Final = 0.5
# Obstacles beside each other that leave rooms that differ by less are one, m: fewer, longer stretches. A choice.
_SAME_ROOM: Final = 0.3
# Strips may be wider than their room by this, m: the step in which widths are cut.
_ROOM_TOLERANCE: Final = 0.01
# Two samples lie abreast if they are no farther apart along the road than half a step and this, m.
_ABREAST_SLACK: Final = 0.1


@record
class _Obstacle:
    """Something that leaves a road little room beside its carriageway."""

    # s on the road, m
    start: float
    end: float
    side: int  # 1 left, -1 right
    room: float  # Between the carriageway's edge and the obstacle, m


def margins_with_room(parts: RoadParts, margins: Sequence[Margins], diagnostics: Diagnostics) -> tuple[Margins, ...]:
    """Narrow or leave out strips that have no room beside their carriageway; join stretches that are too short."""
    with_any = np.array([bool(beside) for beside in margins], bool)
    if not with_any.any():
        return tuple(margins)
    edges = _Edges.of(parts)
    bends = tight_bends(parts, edges.first, edges.left, edges.right, with_any)
    notches, tighter = notches_in(parts, bends, margins)
    in_bends = [(bend.road, _Obstacle(bend.start, bend.end, bend.side, bend.room)) for bend in tighter]
    obstacles: dict[int, list[_Obstacle]] = {}
    for road, obstacle in (*in_bends, *_parallel_roads(parts, edges, margins, with_any)):
        obstacles.setdefault(road, []).append(obstacle)
    changed_ways = {_way_at(margins[road], notch.start) for road, found in notches.items() for notch in found}
    out: list[Margins] = []
    for k, beside in enumerate(margins):
        borders = [stretch.start for stretch in parts.stretches[k][1:]]
        fitting = list(beside)
        for obstacle in obstacles.get(k, ()) if beside else ():
            fitting = _cut_to_room(fitting, obstacle, borders, changed_ways)
        out.append(_notched(settled(fitting, borders), notches.get(k, ())))
    text = "strips beside its carriageway have no room and are narrowed or left out"
    for way in sorted(changed_ways):
        diagnostics.repaired("margin-no-room", f"way/{way}", text)
    return tuple(out)


def _way_at(beside: Margins, s: float) -> int:
    return max((item for item in beside if item.start <= s), key=lambda item: item.start).way


def _notched(beside: Margins, notches: Sequence[Notch]) -> Margins:
    return (replace(beside[0], notches=tuple(notches)), *beside[1:]) if notches else beside


@record(eq=False)
class _Edges:
    """The carriageways of all roads, stretch by stretch."""

    first: IntArray  # (roads + 1,) Index of each road's first stretch
    # (stretches,) s where it begins, t of the carriageway's edges, m, and OSM's layer
    s: FloatArray
    left: FloatArray
    right: FloatArray
    layer: IntArray

    @classmethod
    def of(cls, parts: RoadParts) -> _Edges:
        """Collect the edges of all stretches."""
        flat = [item for stretches in parts.stretches for item in stretches]
        return cls(
            starts([len(stretches) for stretches in parts.stretches]),
            np.array([item.start for item in flat]),
            np.array([item.section.left_edge for item in flat]),
            np.array([item.section.right_edge for item in flat]),
            np.array([item.attributes.layer for item in flat], np.int64),
        )


def _parallel_roads(
    parts: RoadParts, edges: _Edges, margins: Sequence[Margins], with_any: BoolArray
) -> list[tuple[int, _Obstacle]]:
    """Return where the carriageways of other roads of the same layer leave too little room, with their roads.

    Roads are sampled; sample a of a road with strips is compared with samples b of others that lie abreast of it.
    """
    count = np.maximum((parts.length / PARALLEL_SPACING).astype(np.int64), 1)
    road = repeated(count)
    step = (parts.length / count)[road]
    s = (ranks(count) + 0.5) * step
    x, y, hdg = pose(parts.plan_view, road, s)
    own = np.flatnonzero(with_any[road])
    places = np.column_stack([x, y])
    a, b = PointTree(places).within(places[own], defaults.MARGIN_REACH)
    a = own[a]
    stretch = find_record(edges.first, edges.s, road, s)
    chosen = (road[a] != road[b]) & (edges.layer[stretch[a]] == edges.layer[stretch[b]])
    a, b = a[chosen], b[chosen]
    # b in the frame of a, m, rad.
    turn = hdg[b] - hdg[a]
    dx, dy = x[b] - x[a], y[b] - y[a]
    ds = dx * cosine(hdg[a]) + dy * sine(hdg[a])
    dt = dy * cosine(hdg[a]) - dx * sine(hdg[a])
    abreast = np.abs(sine(turn)) < defaults.MARGIN_ALONG_SINE
    abreast &= np.abs(ds) <= 0.5 * np.maximum(step[a], step[b]) + _ABREAST_SLACK
    a, b, ds, dt, turn = a[abreast], b[abreast], ds[abreast], dt[abreast], turn[abreast]
    # Where the line of b crosses the perpendicular to a.
    dt = dt - ds * slope_of(turn)
    same_way = cosine(turn) > 0
    at_left = dt > 0
    edge = np.where(at_left, edges.left[stretch[a]], -edges.right[stretch[a]])
    facing = np.where(at_left == same_way, -edges.right[stretch[b]], edges.left[stretch[b]])
    room = np.abs(dt) - facing / np.abs(cosine(turn)) - PARALLEL_GAP - edge
    widest = np.zeros(len(margins))
    for k in np.flatnonzero(with_any).tolist():
        widest[k] = max(max(item.width(1), item.width(-1)) for item in margins[k])
    tight = np.flatnonzero(room < widest[road[a]])
    order = tight[np.lexsort((room[tight], b[tight], a[tight]))]
    columns = (road[a], (s - 0.5 * step)[a], (s + 0.5 * step)[a], np.where(at_left, 1, -1), room)
    rows = zip(*(column[order].tolist() for column in columns), strict=True)
    return _joined((row[0], _Obstacle(*row[1:])) for row in rows)


def _joined(found: Iterable[tuple[int, _Obstacle]]) -> list[tuple[int, _Obstacle]]:
    """Join obstacles of a road that follow each other and leave about the same room."""
    open_: dict[tuple[int, int], _Obstacle] = {}
    out: list[tuple[int, _Obstacle]] = []
    for road, item in found:
        last = open_.get((road, item.side))
        if last is not None and item.start <= last.end + _ROOM_TOLERANCE and abs(item.room - last.room) < _SAME_ROOM:
            item = replace(item, start=last.start, end=max(last.end, item.end), room=min(last.room, item.room))
        elif last is not None:
            out.append((road, last))
        open_[road, item.side] = item
    out += [(road, item) for (road, _), item in open_.items()]
    return sorted(out, key=lambda entry: (entry[0], entry[1].start, entry[1].side))


def _cut_to_room(
    margins: Sequence[MarginStretch], obstacle: _Obstacle, borders: Iterable[float], changed_ways: set[int]
) -> list[MarginStretch]:
    """Cut the strips beside an obstacle to the room that it leaves; `changed_ways` gets the ways that lose some."""
    lo, hi = obstacle.start, obstacle.end
    touched = [item for item in margins if item.start < hi and item.end > lo]
    if all(item.width(obstacle.side) <= obstacle.room + _ROOM_TOLERANCE for item in touched):
        return list(margins)
    lo, hi = _clear_of_borders(lo, hi, borders, margins[-1].end)
    out: list[MarginStretch] = []
    for item in margins:
        if item.end <= lo or item.start >= hi or item.width(obstacle.side) <= obstacle.room + _ROOM_TOLERANCE:
            out.append(item)
            continue
        changed_ways.add(item.way)
        strips = _fitted(item.strips(obstacle.side), obstacle.room)
        inner = replace(item, start=max(item.start, lo), end=min(item.end, hi), tight=True)
        inner = replace(inner, left=strips) if obstacle.side > 0 else replace(inner, right=strips)
        if item.start < lo:
            out.append(replace(item, end=lo))
        out.append(inner)
        if item.end > hi:
            out.append(replace(item, start=hi))
    return out


def _clear_of_borders(lo: float, hi: float, borders: Iterable[float], length: float) -> tuple[float, float]:
    """Widen an interval by its clearance, and further to borders of lane sections and road ends that are too near."""
    least = SHORTEST_LANE_SECTION
    lo, hi = lo - defaults.MARGIN_CLEARANCE, hi + defaults.MARGIN_CLEARANCE
    for border in sorted(borders):
        if abs(border - lo) < least:
            lo = border if border <= lo else border - least
        if abs(border - hi) < least:
            hi = border if border >= hi else border + least
    if lo < least:
        lo, hi = 0.0, max(hi, least)
    if hi > length - least:
        lo, hi = min(lo, length - least), length
    return (0.0 if lo < least else lo), hi


def _fitted(strips: Strips, room: float) -> Strips:
    """Return the strips that have room, from the carriageway outwards; the last may be narrowed, in whole cm."""
    out = []
    for strip in strips:
        width = min(strip.width, float(np.floor(100.0 * room) / 100.0))
        if width < _LEAST_WIDTH_SHARE * strip.width:
            break
        out.append(replace(strip, width=width))
        room -= width
        if width < strip.width:
            break
    while out and out[-1].type is LaneType.BORDER:
        out.pop()
    return tuple(out)
