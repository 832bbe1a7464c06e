"""Strips beside carriageways give way where they have no room: beside other carriageways and inside of bends."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import find_record, pose, ranks
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import PARALLEL_GAP, PARALLEL_SPACING, SHORTEST_LANE_SECTION
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.strips import Margins, MarginStretch, Strips, settled
from osm2xodr.model import BoolArray, FloatArray, IntArray, LaneType

# Share of its width that a strip keeps at least; narrower, it is left out. A choice.
_MARGIN_NARROWEST: Final = 0.5

# Bends of larger radii have room inside for any strips, m.
_GENTLE = 60.0
# Obstacles that leave rooms that differ by less are one, m.
_ALIKE = 0.3
# Strips need so much more than there is before they give way, m.
_TOO_LITTLE = 0.01


@dataclass(frozen=True, slots=True)
class _Obstacle:
    """Where a road has little room beside its carriageway: from s to s, on which side, how much there is, m."""

    start: float
    end: float
    side: int
    room: float


def margins_with_room(parts: RoadParts, margins: Sequence[Margins], diagnostics: Diagnostics) -> tuple[Margins, ...]:
    """Narrow or leave out what has no room beside its carriageway, and settle the rest.

    Parameters
    ----------
    parts
        The roads.
    margins
        Beside each of them.
    diagnostics
        Gets the ways that lose something.
    """
    with_any = np.array([bool(beside) for beside in margins], bool)
    if not with_any.any():
        return tuple(margins)
    across = _Across.of(parts)
    obstacles: dict[int, list[_Obstacle]] = {}
    for road, obstacle in (*_bends(parts, across, with_any), *_beside_others(parts, across, margins, with_any)):
        obstacles.setdefault(road, []).append(obstacle)
    told: set[int] = set()
    out: list[Margins] = []
    for k, beside in enumerate(margins):
        if not beside:
            out.append(beside)
            continue
        borders = [stretch.start for stretch in parts.stretches[k][1:]]
        fitting = list(beside)
        for obstacle in obstacles.get(k, ()):
            fitting = _past(fitting, obstacle, borders, told)
        out.append(settled(fitting, borders))
    for way in sorted(told):
        diagnostics.repaired(
            "margin-no-room",
            f"way/{way}",
            "what lies beside its carriageway has no room, and is narrowed or left out",
        )
    return tuple(out)


@dataclass(frozen=True, slots=True, eq=False)
class _Across:
    """The carriageways of all roads: edges and layer by stretch, (stretches,), from `first` (roads + 1,) on."""

    first: IntArray
    s: FloatArray
    left: FloatArray
    right: FloatArray
    layer: IntArray

    @classmethod
    def of(cls, parts: RoadParts) -> _Across:
        """Collect them."""
        flat = [item for stretches in parts.stretches for item in stretches]
        return cls(
            np.concatenate([[0], np.cumsum([len(stretches) for stretches in parts.stretches])]).astype(np.int64),
            np.array([item.start for item in flat]),
            np.array([item.section.left_edge for item in flat]),
            np.array([item.section.right_edge for item in flat]),
            np.array([item.attributes.layer for item in flat], np.int64),
        )


def _bends(parts: RoadParts, across: _Across, with_any: BoolArray) -> list[tuple[int, _Obstacle]]:
    """Return the bends in which the inner strips would fold over themselves."""
    plan = parts.plan_view
    owner = np.repeat(np.arange(len(plan.start) - 1), np.diff(plan.start))
    bent = np.flatnonzero((np.abs(plan.curvature) > 1.0 / _GENTLE) & with_any[owner])
    inside = np.sign(plan.curvature[bent])
    # Lanes of neighbouring stretches reach into a bend with their tapers.
    every = [across.first[owner[bent]], across.first[owner[bent] + 1]]
    left, right = _widest(across.left, *every), _widest(-across.right, *every)
    edge = np.where(inside > 0, left, right)
    room = 1.0 / np.abs(plan.curvature[bent]) - defaults.CORNER_EDGE_RADIUS - edge
    end = plan.s[bent] + plan.length[bent]
    columns = (owner[bent], plan.s[bent], end, inside.astype(np.int64), room)
    return [(row[0], _Obstacle(*row[1:])) for row in zip(*(column.tolist() for column in columns), strict=True)]


def _widest(edge: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return the largest of the edges from each first one up to the last, (n,)."""
    if not len(first):
        return np.zeros(0)
    out: FloatArray = np.maximum.reduceat(np.append(edge, -np.inf), np.column_stack([first, last]).ravel())[0::2]
    return out


def _beside_others(
    parts: RoadParts,
    across: _Across,
    margins: Sequence[Margins],
    with_any: BoolArray,
) -> list[tuple[int, _Obstacle]]:
    """Return where the carriageways of other roads of the same layer run along, (road, obstacle) in their order."""
    count = np.maximum((parts.length / PARALLEL_SPACING).astype(np.int64), 1)
    road = np.repeat(np.arange(len(count)), count)
    number = ranks(count)
    step = (parts.length / count)[road]
    s = (number + 0.5) * step
    x, y, hdg = pose(parts.plan_view, road, s)
    own = np.flatnonzero(with_any[road])
    places = np.column_stack([x, y])
    pairs = cKDTree(places[own]).sparse_distance_matrix(cKDTree(places), defaults.MARGIN_REACH, output_type="ndarray")
    a, b = own[pairs["i"]], pairs["j"]
    stretch = find_record(across.first, across.s, road, s)
    chosen = (road[a] != road[b]) & (across.layer[stretch[a]] == across.layer[stretch[b]])
    a, b = a[chosen], b[chosen]
    turn = hdg[b] - hdg[a]
    dx, dy = x[b] - x[a], y[b] - y[a]
    ds = dx * np.cos(hdg[a]) + dy * np.sin(hdg[a])
    dt = dy * np.cos(hdg[a]) - dx * np.sin(hdg[a])
    along = np.abs(np.sin(turn)) < defaults.MARGIN_ALONG_SINE
    # Abreast, as far as samples tell.
    along &= np.abs(ds) <= 0.5 * np.maximum(step[a], step[b]) + 0.1
    a, b, ds, dt, turn = a[along], b[along], ds[along], dt[along], turn[along]
    dt = dt - ds * np.tan(turn)
    same_way = np.cos(turn) > 0
    at_left = dt > 0
    edge = np.where(at_left, across.left[stretch[a]], -across.right[stretch[a]])
    facing = np.where(at_left == same_way, -across.right[stretch[b]], across.left[stretch[b]])
    room = np.abs(dt) - facing / np.maximum(np.abs(np.cos(turn)), 0.5) - PARALLEL_GAP - edge
    widest = np.zeros(len(margins))
    for k in np.flatnonzero(with_any).tolist():
        widest[k] = max(max(item.width(1), item.width(-1)) for item in margins[k])
    tight = np.flatnonzero(room < widest[road[a]])
    order = tight[np.lexsort((room[tight], b[tight], a[tight]))]
    columns = (road[a], (s - 0.5 * step)[a], (s + 0.5 * step)[a], np.where(at_left, 1, -1), room)
    rows = zip(*(column[order].tolist() for column in columns), strict=True)
    return _in_one((row[0], _Obstacle(*row[1:])) for row in rows)


def _in_one(found: Iterable[tuple[int, _Obstacle]]) -> list[tuple[int, _Obstacle]]:
    """Join the obstacles that follow on each other and leave about the same room, by road."""
    open_: dict[tuple[int, int], _Obstacle] = {}
    out: list[tuple[int, _Obstacle]] = []
    for road, item in found:
        last = open_.get((road, item.side))
        if last is not None and item.start <= last.end + _TOO_LITTLE and abs(item.room - last.room) < _ALIKE:
            item = replace(item, start=last.start, end=max(last.end, item.end), room=min(last.room, item.room))
        elif last is not None:
            out.append((road, last))
        open_[road, item.side] = item
    out += [(road, item) for (road, _), item in open_.items()]
    return sorted(out, key=lambda entry: (entry[0], entry[1].start, entry[1].side))


def _past(
    margins: Sequence[MarginStretch], obstacle: _Obstacle, borders: Iterable[float], told: set[int]
) -> list[MarginStretch]:
    """Cut the strips on one side to the room there is beside an obstacle."""
    lo, hi = obstacle.start, obstacle.end
    touched = [item for item in margins if item.start < hi and item.end > lo]
    if all(item.width(obstacle.side) <= obstacle.room + _TOO_LITTLE for item in touched):
        return list(margins)
    lo, hi = _clear_of_borders(lo, hi, borders, margins[-1].end)
    out: list[MarginStretch] = []
    for item in margins:
        if item.end <= lo or item.start >= hi or item.width(obstacle.side) <= obstacle.room + _TOO_LITTLE:
            out.append(item)
            continue
        told.add(item.way)
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
    """Widen an interval by its clearance, and on to borders of lane sections and ends of roads that are too near."""
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
    """Return the strips that have room, from the carriageway outwards; the last may be narrower."""
    out = []
    for strip in strips:
        width = min(strip.width, float(np.floor(100.0 * room) / 100.0))
        if width < _MARGIN_NARROWEST * strip.width:
            break
        out.append(replace(strip, width=width))
        room -= width
        if width < strip.width:
            break
    while out and out[-1].type is LaneType.BORDER:
        out.pop()
    return tuple(out)
