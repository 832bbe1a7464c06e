"""Connecting roads: one for each lane that leads to another through a junction, or strip beside it round a corner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    cosine,
    lengths,
    repeated,
    runs,
    sine,
    stack_plan_views,
    unique_first,
    unique_inverse,
    wrapped,
)
from osm2xodr.geometry.connections.carriageways import carriageways, keep_to_carriageways
from osm2xodr.geometry.connections.corner_paths import turning_radii
from osm2xodr.geometry.connections.defaults import STEEPEST_JOIN, TAPER_PER_WIDTH
from osm2xodr.geometry.connections.lane_links import LaneLinks, LaneRow
from osm2xodr.geometry.connections.opposing_paths import draw_side_by_side, joined_arms
from osm2xodr.geometry.connections.pose_to_pose import connect
from osm2xodr.geometry.connections.street_paths import lane_paths, lay_out_paths
from osm2xodr.geometry.junctions import Movement, draw_loops
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import (
    VEHICLE_LANES,
    Access,
    BoolArray,
    Direction,
    FloatArray,
    IntArray,
    LaneType,
    PlanView,
    Rule,
)
from osm2xodr.system import map_parallel, record

# Connecting roads are drawn in parts of at most so many, from so many on, which are worth a copy of the process.
_AT_ONCE: Final = 10000
_SHARED_FROM: Final = 5000

# Types of lanes beside the carriageway that connecting roads of their own lead on.
BESIDE_CARS: Final = frozenset({LaneType.SIDEWALK, LaneType.SHOULDER})


@record
class InnerLane:
    """A lane of a corner, between its sidewalk and the carriageway."""

    type: LaneType  # What it is for
    # At its start and its end, m
    entry_width: float
    exit_width: float
    height: float  # Above the road, m
    # Ids of the lanes that it comes from and leads to; None for what only fills the corner
    entry_lane: int | None = None
    exit_lane: int | None = None


@record(eq=False)
class ConnectingRoads(Table):
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
    # (n,) Whether the lane lies on the side of the reference line where oncoming traffic drives: it joins lanes for
    # both directions, whose ids say the other direction.
    against: BoolArray
    joins_cars: BoolArray  # (n,) Whether it leads from a bicycle lane to a lane for cars
    # (n,) How far left of the reference line the lane's middle lies at its start and end, m; 0 for cars' lanes, but
    # where crossfall runs through the junction (`crossfall_lines`), and where bicycle lanes join them
    entry_aside: FloatArray
    exit_aside: FloatArray
    height: FloatArray  # (n,) Of the lane's surface above the road, m
    # The type of the lanes that it joins where both are alike, or one is for bicycles; else that of cars' lanes
    lane_type: tuple[LaneType, ...]
    access: tuple[Access, ...]  # Which cars may drive on it: as on both of these lanes, else all
    # What lies between a sidewalk and the carriageway, from the sidewalk inwards; nothing beside cars' lanes
    inner: tuple[tuple[InnerLane, ...], ...]

    def for_vehicles(self) -> BoolArray:
        """Return which of them are for motor vehicles, (n,)."""
        return np.array([kind in VEHICLE_LANES for kind in self.lane_type], bool)

    def beside_cars(self) -> BoolArray:
        """Return which of them lead sidewalks or shoulders on, which are no part of the carriageway, (n,)."""
        return np.array([kind in BESIDE_CARS for kind in self.lane_type], bool)

    def leads_among_cars(self) -> BoolArray:
        """Return which bicycle lanes have room to widen as lanes for cars do, and are such from there on, (n,)."""
        wider = self.exit_width - self.entry_width
        return self.joins_cars & (wider > 0.0) & (self.length > TAPER_PER_WIDTH * wider)

    def change_start(self) -> FloatArray:
        """Return from where on lanes change, in a smooth step to their ends, from one width to the other, s, (n,), m.

        That is their start; but bicycle lanes that join a wider lane for cars keep their width, along its edge, as
        long as they can.
        """
        # A smooth step is steepest in its middle.
        per_width = np.where(self.leads_among_cars(), TAPER_PER_WIDTH, 1.5 / STEEPEST_JOIN)
        needed = per_width * (self.exit_width - self.entry_width)
        return np.where(self.joins_cars & (needed > 0.0), np.maximum(self.length - needed, 0.0), 0.0)

    def entry_middle(self) -> FloatArray:
        """Return where the middles of their lanes are at their starts, t on the roads there, (n,), m."""
        middle: FloatArray = self.entry_t + np.where(self.entry % 2 == 1, self.entry_aside, -self.entry_aside)
        return middle

    def exit_middle(self) -> FloatArray:
        """Return where the middles of their lanes are at their ends, t on the roads there, (n,), m."""
        middle: FloatArray = self.exit_t + np.where(self.exit % 2 == 0, self.exit_aside, -self.exit_aside)
        return middle

    def there_and_back(self) -> tuple[IntArray, IntArray]:
        """Return the ways of cars there and back between the same two arms, by their rows, (pairs,)."""
        cars = np.flatnonzero(self.for_vehicles() & (self.entry != self.exit))
        one_way = np.array([self.lane_type[k] is not LaneType.BIDIRECTIONAL for k in cars.tolist()], bool)
        cars = cars[one_way]
        entry, exit_ = self.entry[cars], self.exit[cars]
        many = int(max(entry.max(initial=0), exit_.max(initial=0))) + 1
        there, back = entry * many + exit_, exit_ * many + entry
        order = np.argsort(there, kind="stable")
        first, last = (np.searchsorted(there[order], back, side) for side in ("left", "right"))
        row, other = repeated(last - first), order[runs(first, last - first)]
        once = entry[row] < exit_[row]
        return cars[row[once]], cars[other[once]]


@record(eq=False)
class _LinkColumns:
    """Lane links, as columns, (n,); see `LaneRow` and `ConnectingRoads`."""

    entry: IntArray
    exit: IntArray
    entry_t: FloatArray
    exit_t: FloatArray
    entry_width: FloatArray
    exit_width: FloatArray
    joins_cars: BoolArray
    exit_aside: FloatArray

    @classmethod
    def of(cls, rows: tuple[LaneRow, ...]) -> _LinkColumns:
        """Return the columns of lane links. Bicycles that join cars keep to the edge of their lane."""
        entry, exit_ = np.array([(row.entry, row.exit) for row in rows], np.int64).reshape(-1, 2).T
        ins, outs = [row.lane_in for row in rows], [row.lane_out for row in rows]
        entry_t, t = np.array([lane.t for lane in ins]), np.array([lane.t for lane in outs])
        entry_width, exit_width = (np.array([lane.spec.width for lane in lanes]) for lanes in (ins, outs))
        joins_cars = np.array([row.joins_cars() for row in rows], bool)
        aside = np.where(joins_cars, np.maximum(exit_width - entry_width, 0.0), 0.0) / 2
        aside = np.where(np.array([row.at_left for row in rows], bool), -aside, aside)
        exit_t = t + np.where(exit_ % 2, aside, -aside)
        return cls(entry, exit_, entry_t, exit_t, entry_width, exit_width, joins_cars, aside)


def _largest_radii(links: _LinkColumns, turn: FloatArray, street_ends: IntArray, ends: StreetEnds) -> FloatArray:
    """Return how large the arc of each lane link may be at most so that it does not cut its corner, (n,), m.

    `turn` (n,) are their changes of heading, rad, and `street_ends` (n, 2) those that they lead from and to. There is
    no corner on the ring of a roundabout.
    """
    out_of, into = np.where(links.entry % 2, 1.0, -1.0), np.where(links.exit % 2, -1.0, 1.0)
    width = np.minimum(links.entry_width, links.exit_width)
    t_in, t_out = -out_of * links.entry_t, into * links.exit_t
    largest = turning_radii(ends, street_ends[:, 0], street_ends[:, 1], t_in, t_out, width, turn)[1]
    return np.where(ends.roundabout[street_ends].all(axis=1), np.inf, largest)


def direct_roads(links: LaneLinks, movements: list[Movement], ends: StreetEnds) -> ConnectingRoads:
    """Return a connecting road for each lane link that leads there directly, wherever streets run.

    The movements are grouped by junction.
    """
    rows, columns = links.rows, _LinkColumns.of(links.rows)
    entry, exit_, entry_t, exit_t = columns.entry, columns.exit, columns.entry_t, columns.exit_t
    hdg0, hdg1 = links.hdg[entry], links.hdg[exit_]
    hdg_in, hdg_out = hdg0 + np.where(entry % 2 == 1, 0.0, np.pi), hdg1 + np.where(exit_ % 2 == 0, 0.0, np.pi)
    plan = connect(
        links.x[entry] - entry_t * sine(hdg0),
        links.y[entry] + entry_t * cosine(hdg0),
        hdg_in,
        links.x[exit_] - exit_t * sine(hdg1),
        links.y[exit_] + exit_t * cosine(hdg1),
        hdg_out,
        radius=_largest_radii(columns, wrapped(hdg_out - hdg_in), _street_ends(links, movements), ends),
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
        entry_width=columns.entry_width,
        exit_width=columns.exit_width,
        against=np.array([row.against for row in rows], bool),
        joins_cars=columns.joins_cars,
        entry_aside=np.zeros(len(rows)),
        exit_aside=columns.exit_aside,
        height=np.zeros(len(rows)),
        lane_type=tuple(row.lane_type() for row in rows),
        access=tuple(row.access() for row in rows),
        inner=((),) * len(rows),
    )


def _street_ends(links: LaneLinks, movements: list[Movement]) -> IntArray:
    """Return the street ends that lane links lead from and to, (n, 2)."""
    ends = np.array([(item.entry, item.exit) for item in movements], np.int64).reshape(-1, 2)
    return ends[[row.movement for row in links.rows]]


def build_connecting_roads(
    links: LaneLinks,
    movements: list[Movement],
    ends: StreetEnds,
    trim: FloatArray,
    outer_lanes: Callable[[int, bool], tuple[float, float]],
    rule: Rule,
) -> ConnectingRoads:
    """Draw a connecting road for each lane link.

    The movements are grouped by junction; `trim` (ends,) is what street ends give to their junctions, m.
    `outer_lanes` returns, for a street and whether it is driven along, t of the middles of its outermost lanes, right
    and left in the direction of travel, m.
    """
    roads, street_ends = direct_roads(links, movements, ends), _street_ends(links, movements)
    entry, exit_ = roads.entry, roads.exit
    used, movement = unique_inverse(np.array([row.movement for row in links.rows], np.int64))
    movements = [movements[k] for k in used.tolist()]
    lanes = lane_paths(
        lay_out_paths(movements, ends, trim, outer_lanes),
        ends.plan_view,
        movement,
        np.where(entry % 2 == 1, roads.entry_t, -roads.entry_t),
        np.where(exit_ % 2 == 0, roads.exit_t, -roads.exit_t),
    )
    streets = carriageways(lanes, ends, street_ends[:, 0], street_ends[:, 1])
    plan = keep_to_carriageways(roads.plan_view, streets)
    width = (roads.entry_width + roads.exit_width) / 2
    shared = np.array([row.lane_in.spec.direction is Direction.BOTH for row in links.rows], bool)
    one_way = np.zeros(len(links.x), bool)
    one_way[links.road_end[street_ends]] = (ends.enters != ends.leaves)[street_ends]
    arms = joined_arms(plan, roads.junction, entry, exit_, one_way)
    plan = draw_side_by_side(plan, *arms, width, shared, streets)
    looped = [(k, loop) for k, number in enumerate(movement.tolist()) if (loop := movements[number].loop)]
    turning = np.array([k for k, _ in looped], np.int64)
    half = np.abs(roads.entry_t - roads.exit_t)[turning] / 2
    plan = draw_loops(plan, turning, movement[turning], [loop for _, loop in looped], half, rule is Rule.LEFT_HAND)
    return replace(roads, plan_view=plan, length=lengths(plan))


def draw_in_parts(draw: Callable[[LaneLinks], ConnectingRoads], links: LaneLinks, jobs: int) -> ConnectingRoads:
    """Return what `draw` draws for lane links, some whole junctions at a time, by several processes.

    The parts do not depend on the number of processes, nor do the roads.
    """
    parts = _whole_junctions(np.array([row.junction for row in links.rows], np.int64))
    if len(parts) < 2:
        return draw(links)
    some = [replace(links, rows=links.rows[part]) for part in parts]
    first, *others = map_parallel(draw, some, jobs)
    return first.joined(*others)


def change_in_parts(
    change: Callable[[ConnectingRoads], ConnectingRoads], roads: ConnectingRoads, jobs: int
) -> ConnectingRoads:
    """Return roads with the curves that `change` gives them, as `draw_in_parts` does."""
    parts = _whole_junctions(roads.junction)
    if len(parts) < 2:
        return change(roads)

    def curves(part: slice) -> PlanView:
        return change(roads.chosen(np.arange(part.start, part.stop))).plan_view

    plan = stack_plan_views(*map_parallel(curves, parts, jobs))
    return replace(roads, plan_view=plan, length=lengths(plan))


def _whole_junctions(junction: IntArray) -> list[slice]:
    """Return rows that are worked on together, those of whole junctions each; `junction` (n,) is that of each row.

    They are about `_AT_ONCE` at most, in 2, 4, 6 … parts of equal size: most machines have an even number of cores.
    """
    count = 2 * math.ceil(len(junction) / (2 * _AT_ONCE)) if len(junction) > _SHARED_FROM else 1
    begin = np.flatnonzero(np.diff(junction, prepend=-1))
    first = begin[unique_first(begin * count // max(len(junction), 1))[1]].tolist()
    return [slice(a, b) for a, b in pairwise([*first, len(junction)])]


def redraw_connecting_roads(
    drawn: ConnectingRoads, before: LaneLinks, links: LaneLinks, draw: Callable[[LaneLinks], ConnectingRoads]
) -> ConnectingRoads:
    """Return a connecting road for each lane link: those `drawn` for the links `before` where these are still there.

    Junctions whose arms have not moved keep all of their links (`find_lane_links`); `draw` draws the roads of others.
    """
    known = {id(row): k for k, row in enumerate(before.rows)}
    place = np.array([known.get(id(row), -1) for row in links.rows], np.int64)
    new = np.flatnonzero(place < 0)
    place[new] = len(before.rows) + np.arange(len(new))
    if len(new):
        drawn = drawn.joined(draw(replace(links, rows=tuple(links.rows[k] for k in new.tolist()))))
    return drawn.chosen(place)
