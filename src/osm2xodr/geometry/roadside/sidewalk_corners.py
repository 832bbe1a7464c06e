"""Sidewalks continue round the corners of junctions, from each arm to its neighbour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    chosen_curves,
    cosine,
    curve_ends,
    dubins_without_slivers,
    end_curvature,
    hypot,
    join_tables,
    lengths,
    owners,
    record_ends,
    record_turns,
    repeated,
    replace_curves,
    reverse_curves,
    runs,
    sine,
    smallest_radius,
    smooth_step,
    unique_first,
    wrapped,
)
from osm2xodr.geometry.connections import ConnectingRoads, InnerLane, connect, runs_backwards
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.corner_overlaps import at_probes, onto_lanes, onto_roads, probes
from osm2xodr.geometry.roadside.corner_pairs import Corners, find_corners
from osm2xodr.geometry.roadside.corner_strips import between, with_inner_lanes
from osm2xodr.geometry.roadside.corner_swings import swung_out
from osm2xodr.geometry.roadside.strips import Margins
from osm2xodr.model import Access, BoolArray, FloatArray, IntArray, LaneType, PlanView, Rule
from osm2xodr.system import record

# Greatest slope of a sidewalk against the direction of the curve that it runs beside. A choice.
_STEEPEST: Final = 0.5
# Greatest slope of a smooth step, in multiples of its mean slope.
_STEP_SLOPE: Final = 1.5
# Factor on a smallest radius that is asked for, so that rounding does not fall below it.
_RADIUS_MARGIN: Final = 1.001


def sidewalk_corners(
    parts: RoadParts, margins: Sequence[Margins], cars: ConnectingRoads, rule: Rule, junctions: IntArray | None = None
) -> tuple[ConnectingRoads, ConnectingRoads]:
    """Connect the sidewalks of neighbouring arms (of `junctions`, if given); return roads, and those without room.

    A sidewalk runs beside the turn of cars from one arm to the other, on that turn's own reference line, if the turn
    leaves it room, else on a curve of its own. It is drawn in the direction that the ids of its lanes stand for (ASAM
    OpenDRIVE 1.8, 12.4: lanes are linked only in that direction), if necessary against cars. Arms that no connecting
    road for `cars` touches are no part of the junction. Past driveways without sidewalks it runs on, as low as the
    carriageway: cars cross it there. Cycle tracks without sidewalks lead from arm to arm likewise, and shoulders
    without either, such as from a motorway to its exit.
    """
    if junctions is not None:
        cars = cars.chosen(np.isin(cars.junction, junctions))
    corners = find_corners(parts, margins, cars, rule)
    none = cars.chosen(np.zeros(len(cars.length), bool))
    if corners is None:
        return none, none
    past, led, failed = corners.past, none, none
    between_them = sorted({arm for arms in corners.passed for arm in arms})
    crossing = np.isin(cars.entry, between_them) | np.isin(cars.exit, between_them)
    for here, others in ((~past, cars), (past, cars.chosen(~crossing))):
        if not here.any():
            continue
        rows, own, good = draw_corners(corners.chosen(np.flatnonzero(here)), cars, others, parts, rule)
        led = led.joined(with_inner_lanes(rows.chosen(good), own[good], others, parts, rule))
        # Nobody misses a corner that leads past a driveway: sidewalks may end there.
        walks = np.array([kind is LaneType.SIDEWALK for kind in rows.lane_type], bool)
        failed = failed.joined(rows.chosen(~good & walks & ~past[here]))
    return led.chosen(np.argsort(led.junction, kind="stable")), failed


def draw_corners(
    corners: Corners, cars: ConnectingRoads, others: ConnectingRoads, parts: RoadParts, rule: Rule
) -> tuple[ConnectingRoads, BoolArray, BoolArray]:
    """Return the corners drawn in the first way that is clear of the carriageways, of the `others` as well.

    Returns them, the last way where none is clear, whether they are curves of their own, and whether they are clear.
    """
    corner, beside = _ways(corners, cars)
    first = unique_first(corner)[1]
    tried = np.zeros(len(corner), bool)
    clear = np.zeros(len(corner), bool)
    rows = [_as_rows(corners, beside.chosen(first), cars, parts)]
    tried[first] = True
    clear[first] = _passable(rows[0], beside.row[first] < 0, others, parts)
    again = np.flatnonzero(~tried & ~clear[first][corner])
    if len(again):
        rows.append(_as_rows(corners.chosen(corner[again]), beside.chosen(again), cars, parts))
        clear[again] = _passable(rows[1], beside.row[again] < 0, others, parts)
    number = np.concatenate([first, again])
    # The first that is clear, else the last.
    rank = np.where(clear[number], number, 2 * len(corner) - number)
    best = np.lexsort((rank, corner[number]))
    best = best[unique_first(corner[number][best])[1]]
    chosen = number[best]
    own, good = beside.row[chosen] < 0, clear[chosen]
    return _swung_out(rows[0].joined(*rows[1:]).chosen(best), own, good, others, parts, rule)


def _swung_out(
    rows: ConnectingRoads, own: BoolArray, good: BoolArray, cars: ConnectingRoads, parts: RoadParts, rule: Rule
) -> tuple[ConnectingRoads, BoolArray, BoolArray]:
    """Let those that lie on lanes, but do not fold, swing out round these, where that makes them good."""
    bad = np.flatnonzero(own & ~good)
    bad = bad[~_folds(rows.chosen(bad))]
    some, plan = swung_out(rows.chosen(bad), cars, rule)
    if not len(some):
        return rows, own, good
    tried = replace(rows.chosen(bad[some]), plan_view=plan, length=lengths(plan))
    clear = _passable(tried, np.ones(len(some), bool), cars, parts, defaults.CORNER_SWING_OUT)
    every = np.arange(len(own))
    every[bad[some[clear]]] = len(own) + np.flatnonzero(clear)
    good = good.copy()
    good[bad[some[clear]]] = True
    return rows.joined(tried).chosen(every), own, good


@record(eq=False)
class _Beside(Table):
    """How sidewalks run beside connecting roads for cars, (n,)."""

    row: IntArray  # Index of the connecting road; -1 for sidewalks with a curve of their own
    back: BoolArray  # Whether the sidewalk's direction is against it
    # How far left of the connecting road's direction the sidewalk lies at that road's start and end, m
    start: FloatArray
    end: FloatArray


def _ways(corners: Corners, cars: ConnectingRoads) -> tuple[IntArray, _Beside]:
    """Return the ways round the corners that may be drawn, with the index of the corner, (ways,), the best first.

    These are the turns that leave the sidewalk room beside them, from the nearest on, then a curve of its own.
    """
    many = int(max(cars.entry.max(initial=0), cars.exit.max(initial=0), corners.entry.max(), corners.exit.max())) + 1
    arms = cars.entry * many + cars.exit
    order = np.argsort(arms, kind="stable")
    found: list[tuple[IntArray, _Beside]] = []
    for back in (False, True):
        one, other = (corners.exit, corners.entry) if back else (corners.entry, corners.exit)
        first, last = (corners.second, corners.first) if back else (corners.first, corners.second)
        begin, end = (np.searchsorted(arms[order], one * many + other, side) for side in ("left", "right"))
        corner, row = repeated(end - begin), order[runs(begin, end - begin)]
        item = _Beside(
            row,
            np.full(len(row), back),
            np.where(cars.entry[row] % 2 == 1, 1.0, -1.0) * (first.t[corner] - cars.entry_t[row]),
            np.where(cars.exit[row] % 2 == 0, 1.0, -1.0) * (last.t[corner] - cars.exit_t[row]),
        )
        good = _leave_room(item, cars, first.width[corner] / 2, last.width[corner] / 2)
        found.append((corner[good], item.chosen(good)))
    many = len(corners.junction)
    found.append((np.arange(many), _Beside(np.full(many, -1), np.zeros(many, bool), np.zeros(many), np.zeros(many))))
    corner, ways = np.concatenate([rows for rows, _ in found]), join_tables(beside for _, beside in found)
    far = np.where(ways.row < 0, np.inf, np.abs(ways.start) + np.abs(ways.end))
    order = np.lexsort((ways.row, far, corner))
    return corner[order], ways.chosen(order)


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
    owner, record = repeated(count), runs(plan.start[row], count)
    side = np.sign(items.start)[owner]
    sharpest = np.full(len(row), -np.inf)
    np.maximum.at(sharpest, owner, np.maximum(side * plan.curvature[record], side * end_curvature(plan, record)))
    reach = np.maximum(start + half_first, end + half_last)
    return np.asarray(good & (sharpest * (reach + defaults.CORNER_EDGE_RADIUS) <= 1.0))


def _paths(corners: Corners, beside: _Beside, parts: RoadParts, cars: ConnectingRoads) -> PlanView:
    """Return the reference line of each corner: that of its turn, or a curve of its own beside its kerb."""
    poses = []
    sides = zip((corners.entry, corners.exit), _own_lines(corners), (1, 0), strict=True)
    for end, t, inwards in sides:
        x, y, hdg = end_poses(parts, end)
        x, y = x - t * sine(hdg), y + t * cosine(hdg)
        poses += [x, y, hdg + np.where(end % 2 == inwards, 0.0, np.pi)]
    source = np.maximum(beside.row, 0)
    plan = chosen_curves(cars.plan_view, source)
    plan = reverse_curves(plan, beside.back)
    alone = np.flatnonzero(beside.row < 0)
    if len(alone):
        half = np.minimum(corners.first.width, corners.second.width)[alone] / 2
        curves = _unfolded([column[alone] for column in poses], half)
        plan = replace_curves(plan, alone, curves, np.arange(len(alone)))
    return plan


def _own_lines(corners: Corners) -> tuple[FloatArray, FloatArray]:
    """Return t, m, where curves of their own begin and end: half of the narrower sidewalk's width from both kerbs."""
    first, second = corners.first, corners.second
    least = np.minimum(first.width, second.width)
    one, other = (walks.t - np.sign(walks.lane) * (walks.width - least) / 2 for walks in (first, second))
    return one, other


def _unfolded(poses: Sequence[FloatArray], half: FloatArray) -> PlanView:
    """Return curves between poses; wider ones where a strip of half the width `half` (n,), m, would fold."""
    plan = connect(*poses)
    least = half + defaults.CORNER_TIP_RADIUS
    tight = np.flatnonzero(smallest_radius(plan) < least)
    if not len(tight):
        return plan
    wide = dubins_without_slivers(*(column[tight] for column in poses), radius=least[tight] * _RADIUS_MARGIN)
    found = np.flatnonzero(lengths(wide) > 0)
    return replace_curves(plan, tight[found], wide, found)


def _as_rows(corners: Corners, beside: _Beside, cars: ConnectingRoads, parts: RoadParts) -> ConnectingRoads:
    """Return the corners as connecting roads whose lane is the sidewalk."""
    plan = _paths(corners, beside, parts, cars)
    first, last, back, own = corners.first, corners.second, beside.back, beside.row < 0
    source, count = np.maximum(beside.row, 0), len(corners.junction)
    line_first, line_last = _own_lines(corners)
    line_first = np.where(own, line_first, np.where(back, cars.exit_t[source], cars.entry_t[source]))
    line_last = np.where(own, line_last, np.where(back, cars.entry_t[source], cars.exit_t[source]))
    return ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=corners.junction,
        entry=corners.entry,
        exit=corners.exit,
        entry_lane=first.lane,
        exit_lane=last.lane,
        entry_t=line_first,
        exit_t=line_last,
        entry_width=first.width,
        exit_width=last.width,
        against=np.zeros(count, bool),
        joins_cars=np.zeros(count, bool),
        # Left of the reference line, in the sidewalk's own direction.
        entry_aside=np.where(corners.entry % 2 == 1, 1.0, -1.0) * (first.t - line_first),
        exit_aside=np.where(corners.exit % 2 == 0, 1.0, -1.0) * (last.t - line_last),
        height=np.where(corners.past, 0.0, first.height),
        lane_type=tuple(walk.type for walk in first.walks),
        access=(Access.ALL,) * count,
        inner=tuple(
            tuple(_crossed_by_cars(lane) for lane in lanes) if low else lanes
            for low, lanes in zip(corners.past.tolist(), map(between, first.walks, last.walks), strict=True)
        ),
    )


def _crossed_by_cars(lane: InnerLane) -> InnerLane:
    """Return a lane beside the sidewalk as it is where a driveway crosses it: low, and paved."""
    return replace(lane, height=0.0, type=LaneType.SHOULDER if lane.type is LaneType.BORDER else lane.type)


def _folds(rows: ConnectingRoads) -> BoolArray:
    """Say which sidewalks fold at the inner edge of a bend, (rows,)."""
    owner, s, curvature = record_ends(rows.plan_view)
    step = smooth_step(s / rows.length[owner])
    width = rows.entry_width[owner] + step * (rows.exit_width - rows.entry_width)[owner]
    aside = rows.entry_aside[owner] + step * (rows.exit_aside - rows.entry_aside)[owner]
    reach = width / 2 + np.sign(curvature) * aside + defaults.CORNER_TIP_RADIUS
    out = np.zeros(len(rows.length), bool)
    out[owner[np.abs(curvature) * reach > 1.0]] = True
    return out


def _passable(
    rows: ConnectingRoads,
    own: BoolArray,
    cars: ConnectingRoads,
    parts: RoadParts,
    swing: float = defaults.CORNER_SWING,
) -> BoolArray:
    """Say which sidewalks keep off carriageways, and run ahead where they begin and end.

    Those on curves of their own make no detours and do not fold either.
    """
    plan = rows.plan_view
    (x0, y0, _), (x1, y1, _) = curve_ends(plan)
    good = rows.length <= defaults.CORNER_DETOUR * hypot(x1 - x0, y1 - y0) + defaults.CORNER_DETOUR_MORE
    good &= ~_folds(rows)
    # Turns back and forth, beyond the turn that the curve makes.
    owner, turn = owners(plan.start), record_turns(plan)
    whole, net = (np.bincount(owner, item, len(own)).astype(np.float64) for item in (np.abs(turn), turn))
    good &= whole - np.abs(wrapped(net)) <= swing
    good |= ~own
    good &= ~runs_backwards(rows, parts)
    x, y = probes(rows, rows.entry_aside, rows.exit_aside)
    # Beside a turn a lane that swings wider may cover its edge, but no more.
    half = at_probes(rows.entry_width, rows.exit_width) / 2
    half = np.where(own[:, None], np.maximum(half - defaults.CORNER_ONTO_LANE, half / 2), 0.0)
    good &= ~onto_lanes(rows, cars, x, y, half)
    far = np.flatnonzero(good & (own | (rows.length > defaults.CORNER_FAR)))
    good[far] = ~onto_roads(rows.junction[far], parts, x[far], y[far])
    return good
