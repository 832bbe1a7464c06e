"""Sidewalks continue round the corners of junctions, from each arm to its neighbour."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile
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
    runs,
    smallest_radius,
    wrapped,
)
from osm2xodr.geometry.connections import STRAIGHT_ON, ConnectingRoads, connect
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


@dataclass(frozen=True, slots=True, eq=False)
class _Walks:
    """Sidewalks at road ends, as columns: see `Sidewalk`."""

    walks: tuple[Sidewalk, ...]
    lane: IntArray
    t: FloatArray
    width: FloatArray
    height: FloatArray

    @classmethod
    def of(cls, walks: Sequence[Sidewalk]) -> _Walks:
        """Return the columns of sidewalks, (n,)."""
        t, width, height = np.array([(walk.t, walk.width, walk.height) for walk in walks]).T
        return cls(tuple(walks), np.array([walk.lane for walk in walks], np.int64), t, width, height)


@dataclass(frozen=True, slots=True, eq=False)
class _Corners:
    """Neighbouring arms whose sidewalks face each other, in the direction of the roads that connect them, (n,).

    By their lane ids, the first sidewalks lead into the junctions, the second ones out of them.
    """

    junction: IntArray
    # Road ends of the first and the second arms
    entry: IntArray
    exit: IntArray
    first: _Walks
    second: _Walks
    past: BoolArray  # Whether arms lie between them


def sidewalk_corners(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule, junctions: IntArray | None = None
) -> tuple[ConnectingRoads, ConnectingRoads]:
    """Connect the sidewalks of neighbouring arms (of `junctions`, if given); return roads, and those without room.

    A sidewalk runs beside the turn of cars from one arm to the other, on that turn's own reference line, if the turn
    leaves it room, else on a curve of its own. It is drawn in the direction that the ids of its lanes stand for (ASAM
    OpenDRIVE 1.8, 12.4: lanes are linked only in that direction), if necessary against cars. Arms that no connecting
    road for `cars` touches are no part of the junction. Past driveways without sidewalks it runs on, as low as the
    carriageway: cars cross it there. So do cycle tracks without sidewalks, past all streets that have none.
    """
    found = list(_pairs(parts, margins, cars, rule, junctions))
    none = cars.chosen(np.zeros(len(cars.length), bool))
    if not found:
        return none, none
    *ends, first, second, passed = zip(*found, strict=True)
    junction, entry, exit_ = (np.array(column, np.int64) for column in ends)
    past = np.array([bool(arms) for arms in passed], bool)
    corners = _Corners(junction, entry, exit_, _Walks.of(first), _Walks.of(second), past)
    beside = _turns_beside(corners, cars)
    rows = _as_rows(corners, beside, _paths(corners, beside, parts, cars), cars)
    good, led = np.zeros(len(past), bool), none
    between_them = sorted({arm for arms in passed for arm in arms})
    crossing = np.isin(cars.entry, between_them) | np.isin(cars.exit, between_them)
    for chosen, others in ((~past, cars), (past, cars.chosen(~crossing))):
        own = beside.row[chosen] < 0
        clear = _passable(rows.chosen(chosen), own, others, parts)
        good[chosen] = clear
        led = led.joined(with_inner_lanes(rows.chosen(chosen).chosen(clear), own[clear], others, parts, rule))
    # Nobody misses a corner that leads past a driveway: sidewalks may end there.
    walks = np.array([kind is LaneType.SIDEWALK for kind in rows.lane_type], bool)
    return led.at_rows(np.argsort(led.junction, kind="stable")), rows.chosen(~good & ~past & walks)


def _sidewalk(parts: RoadParts, margins: Margins, end: int, side: int) -> Sidewalk | None:
    """Return the sidewalk at one side (left 1, right -1, seen along the road) of a road end, else the cycle track."""
    section = parts.at_end(end).section
    t = section.left_edge if side > 0 else section.right_edge
    inner: list[tuple[int, MarginSpec]] = []
    track: Sidewalk | None = None
    for lane, strip in strips_at_end(parts, margins, end, side):
        if strip.type in (LaneType.SIDEWALK, LaneType.BIKING):
            track = Sidewalk(lane, t + side * strip.width / 2, strip.width, strip.height, tuple(inner), strip.type)
        if strip.type is LaneType.SIDEWALK:
            return track
        inner.insert(0, (lane, strip))
        t += side * strip.width
    return track


def _pairs(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule, junctions: IntArray | None
) -> Iterator[tuple[int, int, int, Sidewalk, Sidewalk, tuple[int, ...]]]:
    """Find the pairs of neighbouring arms whose facing sides both have a sidewalk: the values of `_Corners`.

    The last value are the arms between them.
    """
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
        for k, end in enumerate(around):
            # Road ends run inwards, starts outwards.
            first = walks.get((end, incoming if end % 2 == 0 else -incoming))
            if first is None or end not in connected:
                continue
            beyond = [*around[k + 1 :], *around[:k]]
            passed = tuple(takewhile(partial(_is_passed, parts, walks, first.type), beyond))
            following = beyond[len(passed)] if len(passed) < len(beyond) else end
            second = walks.get((following, -incoming if following % 2 == 0 else incoming))
            # A sidewalk leads back to its own arm round the loop of a dead end alone.
            if (following == end and len(around) > 1) or following not in connected or second is None:
                continue
            if first.type is LaneType.BIKING and passed and not _is_straight_on(parts, end, following):
                continue
            if first.type is second.type:
                yield junction, end, following, first, second, passed


def _is_passed(parts: RoadParts, walks: Mapping[tuple[int, int], Sidewalk], kind: LaneType, end: int) -> bool:
    """Whether sidewalks run on past a road end, a driveway's without any, or cycle tracks, any's without such."""
    here = [walk.type for side in (1, -1) if (walk := walks.get((end, side))) is not None]
    if kind is LaneType.BIKING:
        return kind not in here
    return not here and parts.at_end(end).attributes.highway in defaults.PASSED_HIGHWAYS


def _is_straight_on(parts: RoadParts, end: int, following: int) -> bool:
    """Whether the way from one road end into a junction leads straight on to another one."""
    ends = np.array([end, following])
    _, _, hdg = pose(parts.plan_view, ends // 2, np.where(ends % 2 == 1, parts.length[ends // 2], 0.0))
    # Road ends run inwards, starts outwards.
    turn = hdg[1] - hdg[0] + (0.0 if end % 2 != following % 2 else np.pi)
    return bool(np.abs(wrapped(turn)) < STRAIGHT_ON)


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


@dataclass(frozen=True, slots=True, eq=False)
class _Beside:
    """How sidewalks run beside connecting roads for cars, (n,)."""

    row: IntArray  # Index of the connecting road; -1 for sidewalks with a curve of their own
    back: BoolArray  # Whether the sidewalk's direction is against it
    # How far left of the connecting road's direction the sidewalk lies at that road's start and end, m
    start: FloatArray
    end: FloatArray

    def rows(self, rows: IntArray | BoolArray) -> _Beside:
        """Return some of them."""
        return _Beside(self.row[rows], self.back[rows], self.start[rows], self.end[rows])


def _turns_beside(corners: _Corners, cars: ConnectingRoads) -> _Beside:
    """Return the turns that the corners' sidewalks can run beside: the nearest that leave them room."""
    many = int(max(cars.entry.max(initial=0), cars.exit.max(initial=0), corners.entry.max(), corners.exit.max())) + 1
    arms = cars.entry * many + cars.exit
    order = np.argsort(arms, kind="stable")
    found: list[tuple[IntArray, _Beside]] = []
    for back in (False, True):
        one, other = (corners.exit, corners.entry) if back else (corners.entry, corners.exit)
        first, last = (corners.second, corners.first) if back else (corners.first, corners.second)
        begin, end = (np.searchsorted(arms[order], one * many + other, side) for side in ("left", "right"))
        corner, row = np.repeat(np.arange(len(one)), end - begin), order[runs(begin, end - begin)]
        item = _Beside(
            row,
            np.full(len(row), back),
            np.where(cars.entry[row] % 2 == 1, 1.0, -1.0) * (first.t[corner] - cars.entry_t[row]),
            np.where(cars.exit[row] % 2 == 0, 1.0, -1.0) * (last.t[corner] - cars.exit_t[row]),
        )
        good = _leave_room(item, cars, first.width[corner] / 2, last.width[corner] / 2)
        found.append((corner[good], item.rows(good)))
    corner = np.concatenate([rows for rows, _ in found])
    row, against, start, finish = (
        np.concatenate([getattr(item, name) for _, item in found]) for name in _Beside.__slots__
    )
    best = np.lexsort((row, np.abs(start) + np.abs(finish), corner))
    best = best[np.unique(corner[best], return_index=True)[1]]
    count = len(corners.junction)
    out = _Beside(np.full(count, -1, np.int64), np.zeros(count, bool), np.zeros(count), np.zeros(count))
    at = corner[best]
    out.row[at], out.back[at], out.start[at], out.end[at] = row[best], against[best], start[best], finish[best]
    return out


def _leave_room(items: _Beside, cars: ConnectingRoads, half_first: FloatArray, half_last: FloatArray) -> BoolArray:
    """Say which sidewalks beside turns neither fold, nor lie on their lanes, nor leave their direction too much.

    `half_first` and `half_last` are half of the sidewalks' widths where the turns start and end, all (n,), m.
    """
    row, start, end = items.row, np.abs(items.start), np.abs(items.end)
    good = (items.start * items.end > 0.0) & (
        _STEP_SLOPE * np.abs(items.end - items.start) <= _STEEPEST * cars.length[row]
    )
    for off, half, width in ((start, half_first, cars.entry_width), (end, half_last, cars.exit_width)):
        good &= off - half - width[row] / 2 >= -defaults.CORNER_ONTO_LANE
    plan = cars.plan_view
    count = np.diff(plan.start)[row]
    owner, record = np.repeat(np.arange(len(row)), count), runs(plan.start[row], count)
    side = np.sign(items.start)[owner]
    sharpest = np.full(len(row), -np.inf)
    np.maximum.at(sharpest, owner, np.maximum(side * plan.curvature[record], side * end_curvature(plan, record)))
    reach = np.maximum(start + half_first, end + half_last)
    return np.asarray(good & (sharpest * (reach + defaults.CORNER_EDGE_RADIUS) <= 1.0))


def _paths(corners: _Corners, beside: _Beside, parts: RoadParts, cars: ConnectingRoads) -> PlanView:
    """Return the reference line of each corner: that of its turn, or a curve of its own, in its middle."""
    poses = []
    for end, walks, inwards in ((corners.entry, corners.first, 1), (corners.exit, corners.second, 0)):
        x, y, hdg = pose(parts.plan_view, end // 2, np.where(end % 2 == 1, parts.length[end // 2], 0.0))
        x, y = x - walks.t * np.sin(hdg), y + walks.t * np.cos(hdg)
        poses += [x, y, hdg + np.where(end % 2 == inwards, 0.0, np.pi)]
    source = np.maximum(beside.row, 0)
    plan = cut_curves(cars.plan_view, np.zeros(len(source)), cars.length[source], source)
    plan = reverse_curves(plan, beside.back)
    alone = np.flatnonzero(beside.row < 0)
    if len(alone):
        half = np.maximum(corners.first.width, corners.second.width)[alone] / 2
        curves = _unfolded([column[alone] for column in poses], half)
        plan = replace_curves(plan, alone, curves, np.arange(len(alone)))
    return plan


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


def _as_rows(corners: _Corners, beside: _Beside, plan: PlanView, cars: ConnectingRoads) -> ConnectingRoads:
    """Return the corners as connecting roads whose lane is the sidewalk."""
    first, last, back, own = corners.first, corners.second, beside.back, beside.row < 0
    source, count = np.maximum(beside.row, 0), len(corners.junction)
    cars_first = np.where(back, cars.exit_t[source], cars.entry_t[source])
    cars_last = np.where(back, cars.entry_t[source], cars.exit_t[source])
    return ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=corners.junction,
        entry=corners.entry,
        exit=corners.exit,
        entry_lane=first.lane,
        exit_lane=last.lane,
        entry_t=np.where(own, first.t, cars_first),
        exit_t=np.where(own, last.t, cars_last),
        entry_width=first.width,
        exit_width=last.width,
        against=np.zeros(count, bool),
        # Left of the reference line, in the sidewalk's own direction.
        entry_aside=np.where(back, -beside.end, beside.start),
        exit_aside=np.where(back, -beside.start, beside.end),
        height=np.where(corners.past, 0.0, first.height),
        lane_type=tuple(walk.type for walk in first.walks),
        access=(Access.ALL,) * count,
        inner=tuple(
            tuple(replace(lane, height=0.0) for lane in lanes) if low else lanes
            for low, lanes in zip(corners.past.tolist(), map(between, first.walks, last.walks), strict=True)
        ),
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
