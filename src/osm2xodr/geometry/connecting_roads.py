"""Connecting roads: one for each lane that leads to a lane through a junction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from itertools import groupby

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.connectors import connect
from osm2xodr.geometry.cross_section import EndLane, end_lanes
from osm2xodr.geometry.curves import lengths, pose
from osm2xodr.geometry.lane_assignment import ArmLanes, LaneMovement, assign_lanes
from osm2xodr.geometry.movements import Movement
from osm2xodr.geometry.plan_fit import cut_curves
from osm2xodr.geometry.road_parts import RoadParts
from osm2xodr.geometry.street_ends import StreetEnds
from osm2xodr.geometry.through_paths import follow_streets, street_paths
from osm2xodr.model import BoolArray, FloatArray, IntArray, LaneType, PlanView, Rule


@dataclass(frozen=True, slots=True, eq=False)
class ConnectingRoads:
    """All connecting roads, grouped by junction.

    Parameters
    ----------
    plan_view
        Their reference lines, along the middle of the lane.
    length : (n,)
        m.
    junction : (n,)
        Index of the junction.
    entry, exit : (n,)
        Road ends that they touch with their start and their end.
    entry_lane, exit_lane : (n,)
        Lane ids on those roads.
    entry_t, exit_t : (n,)
        Middle of those lanes, t in those roads' frames, m.
    entry_width, exit_width : (n,)
        Widths of those lanes, m.
    set_apart
        The type of those lanes where both are set apart for the same kind of traffic, else that of cars' lanes.
    """

    plan_view: PlanView
    length: FloatArray
    junction: IntArray
    entry: IntArray
    exit: IntArray
    entry_lane: IntArray
    exit_lane: IntArray
    entry_t: FloatArray
    exit_t: FloatArray
    entry_width: FloatArray
    exit_width: FloatArray
    set_apart: tuple[LaneType, ...]

    def chosen(self, keep: BoolArray) -> ConnectingRoads:
        """Return some of them."""
        rows = np.flatnonzero(keep)
        plan = cut_curves(self.plan_view, np.zeros(len(rows)), self.length[rows], rows)
        flat = [item.name for item in fields(self) if item.name not in ("plan_view", "set_apart")]
        columns = {name: getattr(self, name)[rows] for name in flat}
        return ConnectingRoads(plan, **columns, set_apart=tuple(self.set_apart[k] for k in rows.tolist()))


@dataclass(frozen=True, slots=True, eq=False)
class _EndPoses:
    """Pose of every road end, its heading along the road's s."""

    x: FloatArray
    y: FloatArray
    hdg: FloatArray


def build_connecting_roads(
    parts: RoadParts,
    movements: list[Movement],
    ends: StreetEnds,
    trim: FloatArray,
    inner_lanes: Callable[[int, bool], tuple[float, float]],
    rule: Rule,
) -> ConnectingRoads:
    """Assign lanes to all movements and draw a curve for each lane link.

    Parameters
    ----------
    parts
        The roads outside junctions.
    movements
        Grouped by junction.
    ends, trim
        The street ends and what they gave to their junctions, m.
    inner_lanes
        For a street and whether it is driven along, t of the middles of its outermost lanes, right and left in the
        direction of travel, m.
    rule
        Side of the road that one drives on.
    """
    at = _end_poses(parts)
    lanes = _Lanes(parts, rule)
    rows: list[_LaneRow] = []
    for junction, group in groupby(enumerate(movements), key=lambda item: item[1].junction):
        rows += _lane_rows(junction, list(group), parts, at, lanes, rule)
    entry = np.array([row.entry for row in rows], np.int64)
    exit_ = np.array([row.exit for row in rows], np.int64)
    entry_t = np.array([row.lane_in.t for row in rows])
    exit_t = np.array([row.lane_out.t for row in rows])
    hdg0, hdg1 = at.hdg[entry], at.hdg[exit_]
    plan = connect(
        at.x[entry] - entry_t * np.sin(hdg0),
        at.y[entry] + entry_t * np.cos(hdg0),
        hdg0 + np.where(entry % 2 == 1, 0.0, np.pi),
        at.x[exit_] - exit_t * np.sin(hdg1),
        at.y[exit_] + exit_t * np.cos(hdg1),
        hdg1 + np.where(exit_ % 2 == 0, 0.0, np.pi),
    )
    paths = street_paths(movements, ends, trim, inner_lanes)
    movement = np.array([row.movement for row in rows], np.int64)
    plan = follow_streets(
        plan,
        paths,
        ends.plan_view,
        movement,
        np.where(entry % 2 == 1, entry_t, -entry_t),
        np.where(exit_ % 2 == 0, exit_t, -exit_t),
    )
    return ConnectingRoads(
        plan_view=plan,
        length=lengths(plan),
        junction=np.array([row.junction for row in rows], np.int64),
        entry=entry,
        exit=exit_,
        entry_lane=np.array([row.lane_in.id for row in rows], np.int64),
        exit_lane=np.array([row.lane_out.id for row in rows], np.int64),
        entry_t=entry_t,
        exit_t=exit_t,
        entry_width=np.array([row.lane_in.spec.width for row in rows]),
        exit_width=np.array([row.lane_out.spec.width for row in rows]),
        set_apart=tuple(
            row.lane_in.spec.type if row.lane_in.spec.type is row.lane_out.spec.type else LaneType.DRIVING
            for row in rows
        ),
    )


@dataclass(frozen=True, slots=True)
class _LaneRow:
    """One lane link: index of its movement, road ends, lanes."""

    junction: int
    movement: int
    entry: int
    exit: int
    lane_in: EndLane
    lane_out: EndLane


def _end_poses(parts: RoadParts) -> _EndPoses:
    roads = len(parts.length)
    road = np.repeat(np.arange(roads), 2)
    s = np.column_stack([np.zeros(roads), parts.length]).ravel()
    return _EndPoses(*pose(parts.plan_view, road, s))


class _Lanes:
    """Lanes at road ends, by direction of travel; worked out once for each end."""

    def __init__(self, parts: RoadParts, rule: Rule) -> None:
        self._parts = parts
        self._rule = rule
        self._known: dict[tuple[int, bool], tuple[EndLane, ...]] = {}

    def into_junction(self, end: int) -> tuple[EndLane, ...]:
        return self._at(end, end % 2 == 1)

    def out_of_junction(self, end: int) -> tuple[EndLane, ...]:
        return self._at(end, end % 2 == 0)

    def _at(self, end: int, along: bool) -> tuple[EndLane, ...]:
        key = (end, along)
        if key not in self._known:
            stretch = self._parts.stretches[end // 2][-1 if end % 2 else 0]
            self._known[key] = end_lanes(stretch.section, self._rule, along)
        return self._known[key]


def _lane_rows(
    junction: int,
    group: list[tuple[int, Movement]],
    parts: RoadParts,
    at: _EndPoses,
    lanes: _Lanes,
    rule: Rule,
) -> list[_LaneRow]:
    """Return every lane link of one junction."""
    numbers: list[int] = []
    entries: dict[int, ArmLanes] = {}
    exits: dict[int, ArmLanes] = {}
    moves: list[LaneMovement] = []
    for number, item in group:
        entry, exit_ = int(parts.road_end[item.entry]), int(parts.road_end[item.exit])
        into, out = lanes.into_junction(entry), lanes.out_of_junction(exit_)
        if not into or not out:
            continue
        sign_out = 1.0 if exit_ % 2 == 0 else -1.0
        entries[entry] = ArmLanes(tuple(lane.spec for lane in into), tuple(lane.t for lane in into))
        exits[exit_] = ArmLanes(tuple(lane.spec for lane in out), tuple(sign_out * lane.t for lane in out))
        hdg_in = at.hdg[entry] + (0.0 if entry % 2 else np.pi)
        hdg_out = at.hdg[exit_] + (0.0 if exit_ % 2 == 0 else np.pi)
        turn = _turn(at, entry, exit_, float(hdg_in), float(hdg_out))
        lateral = tuple(_lateral(at, entry, lane.t, exit_, float(hdg_out)) for lane in into)
        moves.append(LaneMovement(entry, exit_, turn, lateral))
        numbers.append(number)
    found = assign_lanes(moves, entries, exits, rule is Rule.LEFT_HAND)
    return [
        _LaneRow(
            junction,
            numbers[k],
            moves[k].entry,
            moves[k].exit,
            lanes.into_junction(moves[k].entry)[lane_in],
            lanes.out_of_junction(moves[k].exit)[lane_out],
        )
        for k, lane_in, lane_out in found
    ]


def _turn(at: _EndPoses, entry: int, exit_: int, hdg_in: float, hdg_out: float) -> float:
    """Return the change of heading, left positive; of a turn back, the side that the exit lies on tells its sign."""
    turn = float((hdg_out - hdg_in + np.pi) % (2 * np.pi) - np.pi)
    if abs(turn) < defaults.TURN_BACK:
        return turn
    dx, dy = at.x[exit_] - at.x[entry], at.y[exit_] - at.y[entry]
    return float(np.copysign(abs(turn), dy * np.cos(hdg_in) - dx * np.sin(hdg_in)))


def _lateral(at: _EndPoses, entry: int, t: float, exit_: int, hdg_out: float) -> float:
    """Return how far left of the exit's reference line an entry lane's middle lies, looking along the exit."""
    x = at.x[entry] - t * np.sin(at.hdg[entry]) - at.x[exit_]
    y = at.y[entry] + t * np.cos(at.hdg[entry]) - at.y[exit_]
    return float(y * np.cos(hdg_out) - x * np.sin(hdg_out))
