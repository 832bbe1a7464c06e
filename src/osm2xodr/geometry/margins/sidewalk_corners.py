"""Sidewalks continue round the corners of junctions, from each arm to its neighbour."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cut_curves,
    dubins_without_slivers,
    end_curvature,
    lengths,
    owners,
    pose,
    record_turns,
    replace_curves,
    reverse_curves,
    smallest_radius,
    wrapped,
)
from osm2xodr.geometry.connections import ConnectingRoads, connect
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.margins import defaults
from osm2xodr.geometry.margins.corner_lanes import strips_at_end
from osm2xodr.geometry.margins.corner_overlaps import onto_lanes, onto_roads, probes
from osm2xodr.geometry.margins.corner_strips import Sidewalk, between, with_inner_lanes
from osm2xodr.geometry.margins.strips import Margins
from osm2xodr.model import Access, BoolArray, FloatArray, IntArray, LaneType, MarginSpec, PlanView, Rule

# Greatest slope of a sidewalk against the direction of the curve that it runs beside. A choice.
_STEEPEST: Final = 0.5
# Greatest slope of a smooth step, in multiples of its mean slope.
_STEP_SLOPE: Final = 1.5
# Factor on a smallest radius that is asked for, so that rounding does not fall below it.
_RADIUS_MARGIN: Final = 1.001


@dataclass(frozen=True, slots=True)
class _Corner:
    """Two neighbouring arms whose sidewalks face each other, in the direction of the road that connects them.

    By their lane ids, the first sidewalk leads into the junction, the second one out of it.
    """

    junction: int
    # Road ends of the first and the second arm
    entry: int
    exit: int
    first: Sidewalk
    second: Sidewalk


def sidewalk_corners(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule, junctions: IntArray | None = None
) -> tuple[ConnectingRoads, ConnectingRoads]:
    """Connect the sidewalks of neighbouring arms (of `junctions`, if given); return roads, and those without room.

    A sidewalk runs beside the turn of cars from one arm to the other, on that turn's own reference line, if the turn
    leaves it room, else on a curve of its own. It is drawn in the direction that the ids of its lanes stand for (ASAM
    OpenDRIVE 1.8, 12.4: lanes are linked only in that direction), if necessary against cars. Arms that no connecting
    road for `cars` touches are no part of the junction.
    """
    corners = list(_corners(parts, margins, cars, rule, junctions))
    if not corners:
        none = cars.chosen(np.zeros(len(cars.length), bool))
        return none, none
    beside = [_turn_beside(corner, cars, turns) for corner, turns in zip(corners, _turns(corners, cars), strict=True)]
    plan, own = _paths(corners, beside, parts, cars)
    rows = _as_rows(corners, beside, plan, own, cars)
    good = _passable(rows, own, cars, parts)
    return with_inner_lanes(rows.chosen(good), own[good], cars, parts, rule), rows.chosen(~good)


def _sidewalk(parts: RoadParts, margins: Margins, end: int, side: int) -> Sidewalk | None:
    """Return the sidewalk at one side (left 1, right -1, seen along the road) of a road end."""
    section = parts.at_end(end).section
    t = section.left_edge if side > 0 else section.right_edge
    inner: list[tuple[int, MarginSpec]] = []
    for lane, strip in strips_at_end(parts, margins, end, side):
        if strip.type is LaneType.SIDEWALK:
            return Sidewalk(lane, t + side * strip.width / 2, strip.width, strip.height, tuple(inner))
        inner.insert(0, (lane, strip))
        t += side * strip.width
    return None


def _corners(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule, junctions: IntArray | None
) -> Iterator[_Corner]:
    """Find the pairs of neighbouring arms whose facing sides both have a sidewalk, by junction."""
    end_junction = parts.end_junction.ravel()
    touched = np.union1d(cars.entry, cars.exit)
    if junctions is not None:
        touched = touched[np.isin(end_junction[touched], junctions)]
    walks = {
        (end, side): walk
        for end in touched.tolist()
        if margins[end // 2]
        for side in (1, -1)
        if (walk := _sidewalk(parts, margins[end // 2], end, side)) is not None
    }
    if not walks:
        return
    with_walks = np.unique(end_junction[np.array(sorted({end for end, _ in walks}), np.int64)])
    arms = np.flatnonzero(np.isin(end_junction, with_walks) & (end_junction >= 0))
    # Side on which traffic comes in, seen outwards: left with right-hand traffic, right with left-hand traffic.
    incoming = 1 if rule is Rule.RIGHT_HAND else -1
    connected = set(touched.tolist())
    for junction, around in _arms_in_order(parts, end_junction, arms, incoming):
        for end, following in zip(around, (*around[1:], around[0]), strict=True):
            if following == end or end not in connected or following not in connected:
                continue
            # Road ends run inwards, starts outwards.
            first = walks.get((end, incoming if end % 2 == 0 else -incoming))
            second = walks.get((following, -incoming if following % 2 == 0 else incoming))
            if first is not None and second is not None:
                yield _Corner(junction, end, following, first, second)


def _arms_in_order(
    parts: RoadParts, end_junction: IntArray, arms: IntArray, sense: int
) -> Iterator[tuple[int, list[int]]]:
    """Yield each junction with its arms in order around its middle, from the arm of the least number on.

    A pedestrian who keeps to the near side meets them in this order: counter-clockwise with right-hand traffic
    (sense 1), else clockwise (-1).
    """
    along = np.where(arms % 2 == 1, parts.length[arms // 2], 0.0)
    x, y, hdg = pose(parts.plan_view, arms // 2, along)
    sections = [parts.at_end(end).section for end in arms.tolist()]
    middle = np.array([(section.left_edge + section.right_edge) / 2 for section in sections])
    x, y = x - middle * np.sin(hdg), y + middle * np.cos(hdg)
    junction = end_junction[arms]
    _, group, count = np.unique(junction, return_inverse=True, return_counts=True)
    cx, cy = np.bincount(group, x) / count, np.bincount(group, y) / count
    angle = sense * wrapped(np.arctan2(y - cy[group], x - cx[group]))
    order = np.lexsort((arms, angle, junction))
    first = np.searchsorted(junction[order], np.unique(junction))
    for rows in np.split(order, first[1:]):
        listed = arms[rows].tolist()
        # A fixed start, so that rounding at half a turn does not matter.
        start = listed.index(min(listed))
        yield int(junction[rows[0]]), listed[start:] + listed[:start]


def _turns(corners: Sequence[_Corner], cars: ConnectingRoads) -> Iterator[tuple[list[int], list[int]]]:
    """Yield the connecting roads for cars between the arms of each corner: from the first to the second, and back."""
    wanted = {pair for corner in corners for pair in ((corner.entry, corner.exit), (corner.exit, corner.entry))}
    between: dict[tuple[int, int], list[int]] = {}
    for k, pair in enumerate(zip(cars.entry.tolist(), cars.exit.tolist(), strict=True)):
        if pair in wanted:
            between.setdefault(pair, []).append(k)
    for corner in corners:
        yield between.get((corner.entry, corner.exit), []), between.get((corner.exit, corner.entry), [])


@dataclass(frozen=True, slots=True)
class _Beside:
    """How a sidewalk runs beside a connecting road for cars."""

    row: int  # Index of the connecting road
    back: bool  # Whether the sidewalk's direction is against it
    # How far left of the connecting road's direction the sidewalk lies at that road's start and end, m
    start: float
    end: float

    def asides(self) -> tuple[float, float]:
        """Return how far left of the reference line, in its own direction, the sidewalk starts and ends, m."""
        return (-self.end, -self.start) if self.back else (self.start, self.end)


def _turn_beside(corner: _Corner, cars: ConnectingRoads, turns: tuple[list[int], list[int]]) -> _Beside | None:
    """Return the turn that a corner's sidewalk can run beside: the nearest that leaves it room."""
    found: list[tuple[float, int, _Beside]] = []
    for back, rows in enumerate(turns):
        first, last = (corner.second, corner.first) if back else (corner.first, corner.second)
        for row in rows:
            start = _left_of_travel(int(cars.entry[row]) % 2 == 1, first.t - float(cars.entry_t[row]))
            end = _left_of_travel(int(cars.exit[row]) % 2 == 0, last.t - float(cars.exit_t[row]))
            item = _Beside(row, bool(back), start, end)
            if _leaves_room(item, cars, first.width / 2, last.width / 2):
                found.append((abs(start) + abs(end), row, item))
    return min(found, key=lambda entry: entry[:2])[2] if found else None


def _against_cars(beside: Sequence[_Beside | None]) -> BoolArray:
    return np.array([item is not None and item.back for item in beside], bool)


def _left_of_travel(along: bool, t: float) -> float:
    return t if along else -t


def _leaves_room(item: _Beside, cars: ConnectingRoads, half_first: float, half_last: float) -> bool:
    """Say whether a sidewalk beside a turn neither folds, nor lies on its lane, nor leaves its direction too much."""
    row, length = item.row, float(cars.length[item.row])
    if item.start * item.end <= 0.0 or _STEP_SLOPE * abs(item.end - item.start) > _STEEPEST * length:
        return False
    inner = min(
        abs(item.start) - half_first - float(cars.entry_width[row]) / 2,
        abs(item.end) - half_last - float(cars.exit_width[row]) / 2,
    )
    if inner < -defaults.CORNER_ONTO_LANE:
        return False
    reach = max(abs(item.start) + half_first, abs(item.end) + half_last)
    plan, side = cars.plan_view, 1.0 if item.start > 0.0 else -1.0
    records = slice(int(plan.start[row]), int(plan.start[row + 1]))
    sharpest = max(float((side * k).max()) for k in (plan.curvature[records], end_curvature(plan, records)))
    return sharpest * (reach + defaults.CORNER_EDGE_RADIUS) <= 1.0


def _paths(
    corners: Sequence[_Corner], beside: Sequence[_Beside | None], parts: RoadParts, cars: ConnectingRoads
) -> tuple[PlanView, BoolArray]:
    """Return the reference line of each corner, and which of them have a curve of their own, in their middle."""
    own = np.array([item is None for item in beside], bool)
    source = np.array([0 if item is None else item.row for item in beside], np.int64)
    poses = []
    for ends, walks, inwards in (
        ([item.entry for item in corners], [item.first for item in corners], 1),
        ([item.exit for item in corners], [item.second for item in corners], 0),
    ):
        end = np.array(ends, np.int64)
        t = np.array([walk.t for walk in walks])
        x, y, hdg = pose(parts.plan_view, end // 2, np.where(end % 2 == 1, parts.length[end // 2], 0.0))
        poses += [x - t * np.sin(hdg), y + t * np.cos(hdg), hdg + np.where(end % 2 == inwards, 0.0, np.pi)]
    plan = cut_curves(cars.plan_view, np.zeros(len(corners)), cars.length[source], source)
    plan = reverse_curves(plan, _against_cars(beside))
    alone = np.flatnonzero(own)
    if len(alone):
        half = np.array([max(item.first.width, item.second.width) / 2 for item in corners])[alone]
        curves = _unfolded([column[alone] for column in poses], half)
        plan = replace_curves(plan, alone, curves, np.arange(len(alone)))
    return plan, own


def _unfolded(poses: Sequence[FloatArray], half: FloatArray) -> PlanView:
    """Return curves between poses; wider ones where a strip of half the width `half` (n,), m, would fold."""
    plan = connect(*poses)
    least = half + defaults.CORNER_EDGE_RADIUS
    tight = np.flatnonzero(smallest_radius(plan) < least)
    if not len(tight):
        return plan
    wide = dubins_without_slivers(*(column[tight] for column in poses), radius=least[tight] * _RADIUS_MARGIN)
    found = np.flatnonzero(lengths(wide) > 0)
    return replace_curves(plan, tight[found], wide, found)


def _as_rows(
    corners: Sequence[_Corner],
    beside: Sequence[_Beside | None],
    plan: PlanView,
    own: BoolArray,
    cars: ConnectingRoads,
) -> ConnectingRoads:
    """Return the corners as connecting roads whose lane is the sidewalk."""
    back = _against_cars(beside)
    first, last = [item.first for item in corners], [item.second for item in corners]
    source = np.array([0 if item is None else item.row for item in beside], np.int64)
    cars_first = np.where(back, cars.exit_t[source], cars.entry_t[source])
    cars_last = np.where(back, cars.entry_t[source], cars.exit_t[source])

    def of_walks(name: str, walks: list[Sidewalk]) -> FloatArray:
        return np.array([getattr(walk, name) for walk in walks])

    return ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=np.array([corner.junction for corner in corners], np.int64),
        entry=np.array([item.entry for item in corners], np.int64),
        exit=np.array([item.exit for item in corners], np.int64),
        entry_lane=np.array([walk.lane for walk in first], np.int64),
        exit_lane=np.array([walk.lane for walk in last], np.int64),
        entry_t=np.where(own, of_walks("t", first), cars_first),
        exit_t=np.where(own, of_walks("t", last), cars_last),
        entry_width=of_walks("width", first),
        exit_width=of_walks("width", last),
        against=np.zeros(len(corners), bool),
        entry_aside=np.array([0.0 if item is None else item.asides()[0] for item in beside]),
        exit_aside=np.array([0.0 if item is None else item.asides()[1] for item in beside]),
        height=of_walks("height", first),
        lane_type=(LaneType.SIDEWALK,) * len(corners),
        access=(Access.ALL,) * len(corners),
        inner=tuple(between(*walks) for walks in zip(first, last, strict=True)),
    )


def _passable(rows: ConnectingRoads, own: BoolArray, cars: ConnectingRoads, parts: RoadParts) -> BoolArray:
    """Say which sidewalks keep off carriageways and, on curves of their own, make no detours and do not fold."""
    plan, every = rows.plan_view, np.arange(len(rows.length))
    x0, y0, _ = pose(plan, every, np.zeros(len(every)))
    x1, y1, _ = pose(plan, every, rows.length)
    half = np.maximum(rows.entry_width, rows.exit_width) / 2
    good = rows.length <= defaults.CORNER_DETOUR * np.hypot(x1 - x0, y1 - y0) + defaults.CORNER_DETOUR_MORE
    good &= smallest_radius(plan) >= half + defaults.CORNER_EDGE_RADIUS
    # Turns back and forth, beyond the turn that the curve makes.
    owner, turn = owners(plan.start), record_turns(plan)
    whole, net = (np.bincount(owner, item, len(every)).astype(np.float64) for item in (np.abs(turn), turn))
    good &= whole - np.abs(wrapped(net)) <= defaults.CORNER_SWING
    good |= ~own
    x, y = probes(rows, rows.entry_aside, rows.exit_aside)
    # Beside a turn a lane that swings wider may cover its edge, but no more.
    good &= ~onto_lanes(rows, cars, x, y, np.where(own, half - defaults.CORNER_ONTO_LANE, 0.0))
    far = np.flatnonzero(good & (own | (rows.length > defaults.CORNER_FAR)))
    good[far] = ~onto_roads(rows.junction[far], parts, x[far], y[far])
    return good
