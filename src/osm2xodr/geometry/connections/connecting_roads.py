"""Connecting roads: one for each lane that leads to a lane through a junction, or sidewalk round a corner."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from osm2xodr.curves import cut_curves, lengths, stack_plan_views
from osm2xodr.geometry.connections.corner_paths import follow_corners
from osm2xodr.geometry.connections.lane_links import LaneLinks
from osm2xodr.geometry.connections.pose_to_pose import connect
from osm2xodr.geometry.connections.street_paths import follow_streets, street_paths
from osm2xodr.geometry.junctions import Movement, with_loops
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray, LaneType, PlanView, Rule

_NO_CURVES = PlanView(np.zeros(1, np.int64), *(np.zeros(0) for _ in range(6)))


@dataclass(frozen=True, slots=True)
class InnerLane:
    """A lane of a corner between its sidewalk and the carriageway."""

    type: LaneType  # What it is for
    # m
    entry_width: float
    exit_width: float
    height: float  # Above the road, m
    # Lane ids on the roads that it goes on as; None for what only fills the corner
    entry_lane: int | None = None
    exit_lane: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ConnectingRoads:
    """All connecting roads, grouped by junction."""

    plan_view: PlanView  # Their reference lines, along the middle of the lane (of a lane for cars beside a sidewalk)
    length: FloatArray  # (n,) m
    junction: IntArray  # (n,) Index of the junction
    # (n,) Road ends that they touch with their start and their end
    entry: IntArray
    exit: IntArray
    # (n,) Lane ids on those roads
    entry_lane: IntArray
    exit_lane: IntArray
    # (n,) Where the reference line touches, t in those roads' frames, m
    entry_t: FloatArray
    exit_t: FloatArray
    # (n,) Widths of those lanes, m
    entry_width: FloatArray
    exit_width: FloatArray
    # (n,) Whether the lane lies on the side of the reference line that traffic against it drives on: it goes on lanes
    # for both directions, and their ids say the other one.
    against: BoolArray
    # (n,) How far left of the reference line the lane's middle lies at its start and end, m; 0 but for sidewalks
    entry_aside: FloatArray
    exit_aside: FloatArray
    height: FloatArray  # (n,) Of the lane above the road, m
    # The type of those lanes where both are set apart for the same kind of traffic, else that of cars' lanes
    set_apart: tuple[LaneType, ...]
    # What lies between a sidewalk and the carriageway, from the sidewalk inwards; nothing beside cars' lanes
    inner: tuple[tuple[InnerLane, ...], ...]

    def chosen(self, keep: BoolArray) -> ConnectingRoads:
        """Return some of them."""
        rows = np.flatnonzero(keep)
        plan = cut_curves(self.plan_view, np.zeros(len(rows)), self.length[rows], rows) if len(rows) else _NO_CURVES
        columns = {name: getattr(self, name)[rows] for name in _FLAT}
        kinds = tuple(self.set_apart[k] for k in rows.tolist())
        inner = tuple(self.inner[k] for k in rows.tolist())
        return ConnectingRoads(plan, **columns, set_apart=kinds, inner=inner)

    def joined(self, other: ConnectingRoads) -> ConnectingRoads:
        """Return these and others, the others behind."""
        if not len(other.length):
            return self
        columns = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _FLAT}
        plan = stack_plan_views(self.plan_view, other.plan_view)
        kinds, inner = self.set_apart + other.set_apart, self.inner + other.inner
        return ConnectingRoads(plan, **columns, set_apart=kinds, inner=inner)


_LISTED = ("set_apart", "inner")
_FLAT = tuple(item.name for item in fields(ConnectingRoads) if item.name not in ("plan_view", *_LISTED))


def build_connecting_roads(
    links: LaneLinks,
    movements: list[Movement],
    ends: StreetEnds,
    trim: FloatArray,
    inner_lanes: Callable[[int, bool], tuple[float, float]],
    rule: Rule,
) -> ConnectingRoads:
    """Draw a curve for each lane link.

    Parameters
    ----------
    links
        Which lane leads to which.
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
    rows = links.rows
    entry = np.array([row.entry for row in rows], np.int64)
    exit_ = np.array([row.exit for row in rows], np.int64)
    entry_t = np.array([row.lane_in.t for row in rows])
    exit_t = np.array([row.lane_out.t for row in rows])
    hdg0, hdg1 = links.hdg[entry], links.hdg[exit_]
    plan = connect(
        links.x[entry] - entry_t * np.sin(hdg0),
        links.y[entry] + entry_t * np.cos(hdg0),
        hdg0 + np.where(entry % 2 == 1, 0.0, np.pi),
        links.x[exit_] - exit_t * np.sin(hdg1),
        links.y[exit_] + exit_t * np.cos(hdg1),
        hdg1 + np.where(exit_ % 2 == 0, 0.0, np.pi),
    )
    paths = street_paths(movements, ends, trim, inner_lanes)
    movement = np.array([row.movement for row in rows], np.int64)
    on_streets = (
        paths,
        ends.plan_view,
        movement,
        np.where(entry % 2 == 1, entry_t, -entry_t),
        np.where(exit_ % 2 == 0, exit_t, -exit_t),
    )
    plan = follow_corners(follow_streets(plan, *on_streets), *on_streets)
    round_ = [(k, loop) for k, number in enumerate(movement.tolist()) if (loop := movements[number].loop)]
    turning = np.array([k for k, _ in round_], np.int64)
    half = np.abs(entry_t - exit_t)[turning] / 2
    plan = with_loops(plan, turning, movement[turning], [loop for _, loop in round_], half, rule is Rule.LEFT_HAND)
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
        against=np.array([row.against for row in rows], bool),
        entry_aside=np.zeros(len(rows)),
        exit_aside=np.zeros(len(rows)),
        height=np.zeros(len(rows)),
        set_apart=tuple(row.lane_type() for row in rows),
        inner=((),) * len(rows),
    )
