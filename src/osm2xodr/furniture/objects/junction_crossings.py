"""Crossings inside junctions: on which connecting road each lies, and from where to where it leads."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    arccosine,
    cosine,
    heading_change,
    lengths,
    places_along,
    pose,
    sine,
    slope_of,
    wrapped,
)
from osm2xodr.furniture.world import World
from osm2xodr.model import VEHICLE_LANES, BoolArray, FloatArray, IntArray, LaneType
from osm2xodr.system import record

# People cross the lanes of cars and bicycles.
_TRAFFIC: Final = VEHICLE_LANES | {LaneType.BIKING}
# Distance of the samples of roads, m; a choice.
_SPACING: Final = 1.0
# A path belongs to the traffic that a crossing leads over if it runs within 35 degrees of it, by their cosine, and
# crosses that traffic if it runs at over 50 degrees to it; a crossing leads over traffic at such angles. Choices.
_ALONG_COSINE: Final = 0.82
_ACROSS_COSINE: Final = 0.64
# Paths that turn by less run straight through a junction (34 degrees), by more back (150 degrees), rad; choices.
_THROUGH_TURN: Final = 0.6
_BACK_TURN: Final = 2.6
# How far a crossing keeps from the middle of lanes that run straight along it, m: half a lane, and a bit; a choice.
_FROM_CROSSED: Final = 2.0
# Steps in which a crossing is moved off such lanes, m; a choice.
_STEP: Final = 0.5
# A gap between lanes that a crossing leads over like a lane, m: kerbs and medians on which nobody can wait; a choice.
_GAP: Final = 1.5
# How much of the arms of a junction belongs to it for crossings, m: they end at different distances; a choice.
_OF_ARMS: Final = 12.0
# How far from the lanes a node lies that is still one of a crossing of them, m; a choice.
_BESIDE: Final = 2.5
# Crossings lead on over the rounded corners of the pavement, up to this far, m, in steps of this, m. Choices: the
# radius of a corner, and what nobody sees.
_CORNER: Final = 5.0
_CORNER_STEP: Final = 0.25
# How far along a road its pavement is like that at a sample, m: farther than to the middle between two, which are
# farther apart on the outside of bends. Pavements that are this near to each other touch, m. Choices.
_OF_SAMPLE: Final = 0.8
_SEAM: Final = 0.05
# No carriageway reaches farther from its road's reference line, m: as wide as eight lanes. A choice.
_WIDEST: Final = 28.0
# Nodes of crossings that lie this near to a crossing's line, m, share it with that crossing; a choice.
_ON_LINE: Final = 3.0


@record
class Course:
    """The line on which people cross a junction's traffic."""

    # Local place, m, and the heading of the traffic there, away from the arm, rad
    x: float
    y: float
    hdg: float
    across: float  # Heading in which people cross, rad


@record
class Span:
    """A crossing on a connecting road."""

    road: int  # Id
    s: float  # m
    # t of its left and right end, m
    left: float
    right: float
    skew: float  # How far it leads on along the road for each metre to the left
    to_kerbs: bool  # Whether the pavement ends at both ends, or another crossing goes on there


@record(eq=False)
class _Samples(Table):
    """Points along the connecting roads and arms of a junction, (n,), road by road."""

    curve: IntArray
    s: FloatArray
    x: FloatArray
    y: FloatArray
    hdg: FloatArray
    turn: FloatArray  # Change of heading along the road, rad
    on_arm: BoolArray  # Whether the road is an arm
    through: BoolArray  # Whether it is a connecting road that leads straight on
    # t of the edges of the road's carriageway there, m
    left: FloatArray
    right: FloatArray


class JunctionPaths:
    """Finds where lines lead over the connecting roads of some junctions that cars drive on."""

    def __init__(self, world: World, junctions: Collection[int], nodes: FloatArray) -> None:
        """Take the ids of the junctions, and where the nodes of all crossings are, (n, 2), m."""
        self._world = world
        self._junctions = frozenset(junctions)
        self._nodes = nodes

    @cached_property
    def _of_junction(self) -> dict[int, _Samples]:
        """Samples of all junctions by their id."""
        world, plan = self._world, self._world.road_map.plan_view
        length = lengths(plan)
        curve, s, on_arm, count = [np.zeros(0, np.int64)], [np.zeros(0)], [np.zeros(0, np.bool_)], [0]
        for junction in world.road_map.junctions if self._junctions else ():
            if junction.id not in self._junctions:
                continue
            own = {item.connecting_road for item in junction.connections}
            curves = np.array(sorted(world.lanes.index(road) for road in own if self._has_traffic(road)), np.int64)
            first = places_along(plan, _SPACING, curves)
            arms = [(world.lanes.index(item.road), item.at_end) for item in world.nodes.arms.get(junction.id, ())]
            ends = [_end(k, float(length[k]), at_end=at_end) for k, at_end in arms]
            parts = [first, *ends]
            curve += [part[0] for part in parts]
            s += [part[1] for part in parts]
            on_arm.append(np.arange(sum(len(part[0]) for part in parts)) >= len(first[0]))
            count.append(count[-1] + len(on_arm[-1]))
        every, at = np.concatenate(curve), np.concatenate(s)
        x, y, hdg = pose(plan, every, at)
        turn = heading_change(plan, every)
        arm = np.concatenate(on_arm)
        through = ~arm & (np.abs(turn) <= _THROUGH_TURN)
        found = _Samples(every, at, x, y, hdg, turn, arm, through, *world.lanes.carriageways(every, at))
        used = (junction.id for junction in world.road_map.junctions if junction.id in self._junctions)
        return {junction: found.chosen(slice(*ends)) for junction, ends in zip(used, pairwise(count), strict=True)}

    def _has_traffic(self, road: int) -> bool:
        return any(lane.type in _TRAFFIC for lane in self._world.lanes.road(road).lane_sections[0].lanes)

    def clear_of_through_traffic(
        self, junction: int, course: Course, half: tuple[float, float], most: float
    ) -> float | None:
        """Return how far back towards its arm a crossing goes so that no lane runs straight along it, m.

        `half` is half of its extent along and across the traffic, m; None where more than `most` would be needed.
        """
        found = self._of_junction.get(junction)
        if found is None or not len(found.s):
            return 0.0
        rows = np.flatnonzero(found.through & (np.abs(cosine(found.hdg - course.hdg)) < _ACROSS_COSINE))
        if not len(rows):
            return 0.0
        ahead, lateral = _in_frame(found, rows, course.x, course.y, course.hdg)
        crossed = ahead[np.abs(lateral) <= half[1]]
        back = np.arange(0.0, most + _STEP, _STEP)
        clear = np.flatnonzero((np.abs(crossed[:, None] + back) >= half[0] + _FROM_CROSSED).all(axis=0))
        return float(back[clear[0]]) if len(clear) else None

    def span(self, junction: int, course: Course) -> Span | None:
        """Return the crossing on a line over the traffic of a junction; None where there are no lanes."""
        found = self._of_junction.get(junction)
        if found is None or len(found.s) < 2:
            return None
        ahead, lateral = _in_frame(found, slice(None), course.x, course.y, course.across - 0.5 * np.pi)
        # Where the reference lines of connecting roads cross the line
        meets = (found.curve[1:] == found.curve[:-1]) & ((ahead[1:] >= 0.0) != (ahead[:-1] >= 0.0))
        meets &= (np.abs(cosine(found.hdg[1:] - course.hdg)) >= _ALONG_COSINE) & (
            (np.abs(found.turn[1:]) < _BACK_TURN) | found.on_arm[1:]
        )
        row = np.flatnonzero(meets)
        if not len(row) or found.on_arm[row].all():
            return None
        share = ahead[row] / (ahead[row] - ahead[row + 1])
        s = found.s[row] + share * (found.s[row + 1] - found.s[row])
        along = lateral[row] + share * (lateral[row + 1] - lateral[row])
        hdg = found.hdg[row] + share * wrapped(found.hdg[row + 1] - found.hdg[row])
        curve = found.curve[row]
        # Metres of the line for each metre of t of the roads
        per_t = 1.0 / cosine(course.across - 0.5 * np.pi - hdg)
        roads = self._world.road_map.roads
        edges = np.column_stack(self._world.lanes.carriageways(curve, s))
        ends = np.sort(along[:, None] + edges * per_t[:, None], axis=1)
        low, high, inside = _widest(ends)
        if max(low, -high) > _BESIDE:
            return None
        before, after = _to_kerbs(found, course, low, high)
        low, high, cut = self._cut_at_others(course, low - (before or 0.0), high + (after or 0.0))
        # The straightest of the connecting roads, the nearest of equals
        key = np.lexsort((np.abs(along), np.abs(found.turn[row]).round(2), found.on_arm[row], ~inside))
        best = int(key[0])
        if found.on_arm[row[best]]:
            return None
        left, right = sorted(((high - along[best]) / per_t[best], (low - along[best]) / per_t[best]), reverse=True)
        skew = float(slope_of(course.across - 0.5 * np.pi - hdg[best]))
        ends_well = cut or (before is not None and after is not None)
        return Span(roads[int(curve[best])].id, float(s[best]), float(left), float(right), -skew, ends_well)

    def _cut_at_others(self, course: Course, low: float, high: float) -> tuple[float, float, bool]:
        """Cut a line from `low` to `high` half way to the nodes of other crossings on it, m; also whether it was."""
        x, y = self._nodes[:, 0] - course.x, self._nodes[:, 1] - course.y
        cos, sin = cosine(course.across), sine(course.across)
        along, off = x * cos + y * sin, y * cos - x * sin
        others = along[(np.abs(off) <= _ON_LINE) & (np.abs(along) > _BESIDE)]
        first = max(low, 0.5 * float(others[others < 0.0].max(initial=-np.inf)))
        last = min(high, 0.5 * float(others[others > 0.0].min(initial=np.inf)))
        return first, last, (first, last) != (low, high)


def _to_kerbs(found: _Samples, course: Course, low: float, high: float) -> tuple[float | None, float | None]:
    """Return how far the pavement reaches beyond both ends of a line, m; None where it does not end soon."""
    steps = np.arange(_CORNER_STEP, _CORNER + _CORNER_STEP, _CORNER_STEP)
    along = np.concatenate([low - steps, high + steps])
    x, y = course.x + along * cosine(course.across), course.y + along * sine(course.across)
    dx, dy = x[:, None] - found.x, y[:, None] - found.y
    cos, sin = cosine(found.hdg), sine(found.hdg)
    t = dy * cos - dx * sin
    point, row = np.nonzero((np.abs(dx * cos + dy * sin) <= _OF_SAMPLE) & (np.abs(t) <= _WIDEST))
    beside = t[point, row]
    paved = np.zeros(len(along), np.bool_)
    paved[point[(beside <= found.left[row] + _SEAM) & (beside >= found.right[row] - _SEAM)]] = True
    before, after = (None if side.all() else float(np.argmin(side)) * _CORNER_STEP for side in paved.reshape(2, -1))
    return before, after


def _end(curve: int, length: float, *, at_end: bool) -> tuple[IntArray, FloatArray]:
    """Return the samples of a curve near its end (or start): the curve, and s, m."""
    away = np.arange(0.0, min(_OF_ARMS, length), _SPACING)
    return np.full(len(away), curve, np.int64), length - away if at_end else away


def _in_frame(
    found: _Samples, rows: IntArray | slice, x: float, y: float, hdg: float
) -> tuple[FloatArray, FloatArray]:
    """Return how far some samples lie ahead and to the left of a place that looks in a direction, m."""
    cos, sin = cosine(hdg), sine(hdg)
    dx, dy = found.x[rows] - x, found.y[rows] - y
    return dx * cos + dy * sin, dy * cos - dx * sin


def _widest(ends: FloatArray) -> tuple[float, float, BoolArray]:
    """Join intervals (n, 2), m, that touch; return the one nearest to 0, and which intervals are parts of it."""
    order = np.argsort(ends[:, 0], kind="stable")
    reach = np.maximum.accumulate(ends[order, 1])
    begins = np.concatenate([[True], ends[order[1:], 0] > reach[:-1] + _GAP])
    group = np.cumsum(begins) - 1
    bounds = [*np.flatnonzero(begins).tolist(), len(order)]
    joined = [(float(ends[order[a], 0]), float(reach[b - 1])) for a, b in pairwise(bounds)]
    best = min(range(len(joined)), key=lambda k: max(joined[k][0], -joined[k][1], 0.0))
    inside = np.zeros(len(ends), np.bool_)
    inside[order[group == best]] = True
    return *joined[best], inside


def across_of(hdg: float, heading: float | None) -> float:
    """Return the heading in which people cross traffic, rad: that of their way, if it leads across, else square."""
    square = hdg + 0.5 * np.pi
    if heading is None:
        return float(square)
    off = float(wrapped(np.array([heading - square]))[0])
    if abs(off) > 0.5 * np.pi:
        off -= np.copysign(np.pi, off)
    return float(square + off) if abs(off) <= arccosine(_ACROSS_COSINE) else float(square)
