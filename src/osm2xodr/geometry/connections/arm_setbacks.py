"""Arms are set back from junctions until the turns between them have the radius that their corners are built with.

Stems of splits and merges are set back until cars shift to their branches at speed.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    cosine,
    heading_change,
    lengths,
    sine,
    slope_of,
    smallest_radius,
    sorted_unique,
    unique_counts,
    wrapped,
)
from osm2xodr.defaults import LEAST_TURN_BACK
from osm2xodr.geometry.connections import defaults
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.corner_paths import turning_radii
from osm2xodr.geometry.connections.pose_to_pose import connect, detours, swings_out, tangents
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.turn_backs import lanes_apart
from osm2xodr.geometry.defaults import (
    ARM_SETBACK_STEP,
    MERGE_ACCELERATION,
    MERGE_BRANCH_MAX,
    MERGE_SETBACK_MAX,
    MERGE_SHARE_MAX,
    MERGE_SPEED_KMH,
    MERGE_TURN,
    SHIFT_SPEED,
    SHORTEST_STREET_BETWEEN_JUNCTIONS,
    SNAPPED,
    U_TURN_RADIUS,
)
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds, outward_pose
from osm2xodr.model import BoolArray, Direction, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# Arms are set back in at most so many rounds: where they are straight, one is enough.
_ROUNDS: Final = 8
# Turns by more than this, rad (12 degrees), are one arc whose tangents say what they lack, if they do not turn back.
_LEAST_TURN: Final = 0.2
# Setbacks below this, m, are not worth a cut.
_LEAST_SETBACK: Final = 0.05
# One arm of an acute fork is set back by at most this much more than the other one, m. A choice: one car.
_LARGEST_STAGGER: Final = 6.0
# The lanes of a fork are so far apart where a car turns from one to the other without swinging out, m: its turning
# circle, and a bit for lanes that are not quite parallel.
_FORK_APART: Final = 2 * U_TURN_RADIUS / 0.96
# Stems are set back in at most so many rounds, in each by this much at most, m, and by this much at least.
_STEM_ROUNDS: Final = 8
_MOST_AT_ONCE: Final = 15.0
_LEAST_AT_ONCE: Final = 0.5
# Ways that turn by less are no single arc, rad (1 degree). A choice.
_LEAST_BEND: Final = 0.02


@record(eq=False)
class Turns(Table):
    """Turns from one street end to another, all (n,)."""

    entry: IntArray  # Street ends
    exit: IntArray
    # Lanes in the outward frame of their street end, m: left of it is right of traffic that comes in
    t_in: FloatArray
    t_out: FloatArray
    radius: FloatArray  # What the turn should have, m

    @classmethod
    def of(cls, parts: RoadParts, connecting: ConnectingRoads) -> Turns:
        """Return those of connecting roads, with no radius that they should have."""
        street_end = parts.street_end()
        t_in = np.where(connecting.entry % 2 == 1, -connecting.entry_t, connecting.entry_t)
        t_out = np.where(connecting.exit % 2 == 1, -connecting.exit_t, connecting.exit_t)
        return cls(street_end[connecting.entry], street_end[connecting.exit], t_in, t_out, np.zeros(len(t_in)))

    def poses(self, ends: StreetEnds, trim: FloatArray) -> tuple[Poses, Poses]:
        """Return where cars leave their entry lanes and reach their exit lanes if streets are trimmed like this."""
        x0, y0, h0 = outward_pose(ends, self.entry, trim[self.entry])
        x1, y1, h1 = outward_pose(ends, self.exit, trim[self.exit])
        start = x0 - self.t_in * sine(h0), y0 + self.t_in * cosine(h0), h0 + np.pi
        return start, (x1 - self.t_out * sine(h1), y1 + self.t_out * cosine(h1), h1)


def set_back_arms(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> FloatArray:
    """Return how much each street end gives to its junction so that its turns have room, (ends,), m.

    Both arms of a turn that is sharper than its corner, too long, or swings out are set back as far as it needs and
    as their streets have room, and farther at acute forks. Where a turn is still sharper than most cars drive, less
    of a short street is kept.
    """
    turns = _without_room(ends, layout, parts, connecting)
    trim = layout.trim.copy()
    forks = _part_forks(ends, trim, layout.most, turns)
    trim = np.maximum(forks, _set_back(ends, trim, np.minimum(layout.most, _farthest(layout)), turns))
    most, just = defaults.LEAST_REDRAWN_RADIUS, defaults.TURNING_RADIUS_ACUTE
    usual = _at_last(ends, layout, trim, turns, most)
    # What cars just manage comes first where that is more than the sharpest turn of a short street has otherwise.
    short = (_most_at_last(ends, layout, trim) > trim).reshape(-1, 2).any(1)
    sharpest = _sharpest(ends, usual, turns, just)
    tried = short & (sharpest < just)
    turns = turns.chosen(tried[turns.entry // 2] | tried[turns.exit // 2])
    first = _at_last(ends, layout, _at_last(ends, layout, trim, turns, just), turns, most)
    better = np.repeat(tried & (_sharpest(ends, first, turns, just) > sharpest * (1 + 1e-3)), 2)
    return np.where(np.repeat(short, 2), np.where(better, first, usual), np.maximum(first, usual))


def _sharpest(ends: StreetEnds, trim: FloatArray, turns: Turns, radius: float) -> FloatArray:
    """Return the smallest radius of the turns at either end of streets, a radius at most, (streets,), m."""
    out = np.full(len(trim) // 2, radius)
    size = smallest_radius(_curves(*turns.poses(ends, trim)))
    for end in (turns.entry, turns.exit):
        np.minimum.at(out, end // 2, size)
    return out


def _at_last(ends: StreetEnds, layout: JunctionLayout, trim: FloatArray, turns: Turns, radius: float) -> FloatArray:
    """Return how much street ends give, down to the shortest streets, for turns sharper than a radius, (ends,), m."""
    most = _most_at_last(ends, layout, trim)
    short = most > trim
    least = replace(turns, radius=np.minimum(turns.radius, radius))
    sharp = smallest_radius(_curves(*least.poses(ends, trim))) < least.radius * (1 - 1e-3)
    least = least.chosen(sharp & (short[turns.entry] | short[turns.exit]))
    room = (most - trim).reshape(-1, 2).max(1)
    return _set_back(ends, trim, np.minimum(most, _farthest(layout)), least, room)


def _farthest(layout: JunctionLayout) -> FloatArray:
    """Return how far street ends may be set back if their streets have room, (ends,), m."""
    return layout.trim + defaults.ARM_SETBACK_MAX


def _most_at_last(ends: StreetEnds, layout: JunctionLayout, trim: FloatArray) -> FloatArray:
    """Return how much street ends may give where turns need it, down to the shortest streets, (ends,), m.

    Either end of a street may take all that both have left.
    """
    # Streets with more to spare give no more because a bridge or tunnel begins there.
    kept = ends.length[0::2] - layout.most.reshape(-1, 2).sum(1)
    short = kept <= SHORTEST_STREET_BETWEEN_JUNCTIONS + 2 * SNAPPED
    spare = np.maximum(ends.length[0::2] - trim.reshape(-1, 2).sum(1) - layout.least - SNAPPED, 0.0)
    most: FloatArray = trim + np.where(layout.junction >= 0, np.repeat(np.where(short, spare, 0.0), 2), 0.0)
    return most


def _set_back(
    ends: StreetEnds, trim: FloatArray, most: FloatArray, turns: Turns, room: FloatArray | float = np.inf
) -> FloatArray:
    """Return how much each street end gives so that turns have room, at most so much, (ends,), m.

    `room` (streets,), m, is what both ends of a street give together at most.
    """
    trim, most = trim.copy(), np.maximum(most, trim)
    for _ in range(_ROUNDS):
        if not len(turns.entry):
            break
        give = np.minimum(_lacking(ends, trim, most, turns), most - trim)
        both = give.reshape(-1, 2).sum(1)
        given = np.minimum(both, room)
        give *= np.repeat(given / np.maximum(both, 1e-9), 2)
        room = room - given
        if give.max() < _LEAST_SETBACK:
            break
        trim += give
        turns = turns.chosen(_lack_room(_curves(*turns.poses(ends, trim)), turns.radius))
    return trim


def _without_room(ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads) -> Turns:
    """Return the turns that lack room."""
    every = Turns.of(parts, connecting)
    lanes = every.entry, every.exit, every.t_in, every.t_out
    width = np.minimum(connecting.entry_width, connecting.exit_width)
    hdg_in, hdg_out = (outward_pose(ends, end, layout.trim[end])[2] for end in lanes[:2])
    radius = turning_radii(ends, *lanes, width, wrapped(hdg_out - hdg_in - np.pi))[0]
    every = replace(every, radius=radius)
    # Loops that turn back on their arm have their own room; bicycles need less than cars.
    plain = (connecting.entry != connecting.exit) & connecting.for_vehicles()
    lacking = _lack_room(connecting.plan_view, radius) & plain
    return every.chosen(lacking)


def _lack_room(plan: PlanView, radius: FloatArray) -> BoolArray:
    """Say which curves would be better if their arms ended farther away, (curves,)."""
    return (smallest_radius(plan) < radius * (1 - 1e-3)) | detours(plan) | swings_out(plan)


def _curves(start: Poses, end: Poses) -> PlanView:
    """Return the direct curves between poses."""
    return connect(*start, *end)


def _lacking(ends: StreetEnds, trim: FloatArray, most: FloatArray, turns: Turns) -> FloatArray:
    """Return how far each arm would have to be set back for its turns, as far as that helps, (ends,), m."""
    (x0, y0, h0), (x1, y1, h1) = turns.poses(ends, trim)
    before, after = tangents(x0, y0, h0, x1, y1, h1)
    angle = np.abs(wrapped(h1 - h0))
    room = most - trim
    # The arc is no larger than the shorter tangent allows: neither arm gives what is of no use without the other.
    wanted = turns.radius * slope_of(np.minimum(angle, LEAST_TURN_BACK) / 2)
    wanted = np.minimum(wanted, np.minimum(before + room[turns.entry], after + room[turns.exit]))
    one_arc = (angle > _LEAST_TURN) & (angle < LEAST_TURN_BACK)
    one_arc &= np.maximum(wanted - before, wanted - after) < defaults.ARM_SETBACK_MAX
    out = np.zeros(len(trim))
    for end, tangent in ((turns.entry, before), (turns.exit, after)):
        np.maximum.at(out, end, np.where(one_arc, wanted - tangent, 2 * ARM_SETBACK_STEP))
    return out


def _part_forks(ends: StreetEnds, trim: FloatArray, most: FloatArray, turns: Turns) -> FloatArray:
    """Return how much each street end gives so that turns at acute forks are driven directly, (ends,), m.

    The arms of a fork end where their lanes are as far apart as a car's turning circle, if both streets have room.
    """
    out = trim.copy()
    most = np.minimum(most, defaults.FORK_SHARE_MAX * ends.length)
    (_, _, h0), (_, _, h1) = turns.poses(ends, trim)
    turns = turns.chosen(np.abs(wrapped(h1 - h0)) >= LEAST_TURN_BACK)
    for setback in np.arange(0.0, defaults.FORK_SETBACK_MAX, ARM_SETBACK_STEP):
        if not len(turns.entry):
            break
        farther = np.maximum(np.minimum(trim + setback, most), trim)
        done = lanes_apart(*turns.poses(ends, farther)) >= _FORK_APART
        # Where one arm alone has room, cars would drive along the other one to and fro.
        given = farther - trim
        done &= np.abs(given[turns.entry] - given[turns.exit]) <= _LARGEST_STAGGER
        for arm in (turns.entry[done], turns.exit[done]):
            np.maximum.at(out, arm, farther[arm])
        turns = turns.chosen(~done)
    return out


def set_back_stems(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads, trim: FloatArray
) -> FloatArray:
    """Return how much each street end gives to its junction, (ends,), m, from how much it gave before.

    At a split or merge of one-way carriageways all ways of a junction lead from or to one arm, its stem, and hardly
    turn: cars leave the stem's lanes, or reach them, within the junction. Where that is sharper than they drive at
    their limit, arms are set back as far as their streets have room: both where one arc lacks tangents, else the
    stem.
    """
    stem = merge_stems(parts, connecting)
    speed = _speeds(parts, connecting)
    rows = np.flatnonzero((stem >= 0) & (speed * 3.6 >= MERGE_SPEED_KMH - 1e-6))
    if not len(rows):
        return trim
    stem = parts.street_end()[stem[rows]]
    turns = replace(Turns.of(parts, connecting), radius=speed**2 / MERGE_ACCELERATION).chosen(rows)
    trim = trim.copy()
    farthest = np.full(len(trim), MERGE_BRANCH_MAX)
    farthest[stem] = MERGE_SETBACK_MAX
    farthest = np.minimum(layout.trim + farthest, MERGE_SHARE_MAX * _first_ways(parts))
    most = np.maximum(np.minimum(layout.most, farthest), trim)
    for _ in range(_STEM_ROUNDS):
        room = most - trim
        before, behind, in_all = _lacking_of_stems(
            *turns.poses(ends, trim), turns.radius, room[turns.entry], room[turns.exit]
        )
        give = np.zeros(len(trim))
        np.maximum.at(give, turns.entry, before)
        np.maximum.at(give, turns.exit, behind)
        np.maximum.at(give, stem, in_all)
        give = np.minimum(np.minimum(give, _MOST_AT_ONCE), room)
        if give.max() < _LEAST_AT_ONCE:
            break
        trim += give
    return trim


def _lacking_of_stems(
    start: Poses, end: Poses, radius: FloatArray, room_in: FloatArray, room_out: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what ways between poses lack of their radius before and behind them, or in all, (n,), m.

    `room_in` and `room_out` are what both arms have.
    """
    curves = connect(*start, *end)
    now = smallest_radius(curves)
    sharp = now < radius * (1 - 1e-3)
    before, after = tangents(*start, *end)
    angle = np.abs(wrapped(end[2] - start[2]))
    arc = sharp & (before > 0) & (after > 0) & (angle > _LEAST_BEND)
    # Neither arm gives what is of no use without the other.
    wanted = np.minimum(radius * slope_of(angle / 2), np.minimum(before + room_in, after + room_out))
    # The radius of a shift to the side grows with the square of its length.
    longer = lengths(curves) * (np.sqrt(np.maximum(radius / now, 1.0)) - 1.0)
    return (
        np.where(arc, np.maximum(wanted - before, 0.0), 0.0),
        np.where(arc, np.maximum(wanted - after, 0.0), 0.0),
        np.where(arc | ~sharp, 0.0, longer),
    )


def merge_stems(parts: RoadParts, connecting: ConnectingRoads) -> IntArray:
    """Return of each connecting road the road end that is the stem of its split or merge, (n,), -1 for none."""
    turn = np.abs(heading_change(connecting.plan_view, np.arange(len(connecting.length))))
    cars = connecting.for_vehicles()
    junctions = int(connecting.junction.max(initial=-1)) + 1
    sharp = np.zeros(junctions, bool)
    sharp[connecting.junction[cars & (turn > MERGE_TURN)]] = True
    ways = np.bincount(connecting.junction[cars], minlength=junctions)
    arms = np.column_stack([connecting.entry, connecting.exit])[cars]
    junction = np.repeat(connecting.junction[cars], 2)
    many = int(arms.max(initial=0)) + 1
    keys, count = unique_counts(junction * many + arms.ravel())
    of, arm = np.divmod(keys, many)
    three = np.bincount(of, minlength=junctions) >= 3
    one_way = np.array([len(parts.at_end(end).attributes.car_directions()) == 1 for end in arm.tolist()], bool)
    stem = np.full(junctions, -1, np.int64)
    in_all = (count == ways[of]) & three[of] & ~sharp[of] & one_way
    stem[of[in_all]] = arm[in_all]
    return np.where(cars, stem[connecting.junction], -1)


def _first_ways(parts: RoadParts) -> FloatArray:
    """Return how long the OSM way at each street end is, (ends,), m."""
    length = lengths(parts.fitted.plan_view)
    out = np.repeat(length, 2)
    for street, pieces in enumerate(parts.fitted.pieces):
        borders = [s for (_, one, _), (s, two, _) in pairwise(pieces) if one.osm_way_id != two.osm_way_id]
        if borders:
            out[2 * street], out[2 * street + 1] = borders[0], length[street] - borders[-1]
    return out


def _speeds(parts: RoadParts, connecting: ConnectingRoads) -> FloatArray:
    """Return how fast cars drive on connecting roads by the limits of their arms, (n,), m/s; 0 if none is known."""
    limit = np.full((2 * len(parts.length), 2), np.nan)
    for end in sorted_unique([connecting.entry, connecting.exit]).tolist():
        attributes = parts.at_end(end).attributes
        for way, direction in enumerate((Direction.FORWARD, Direction.BACKWARD)):
            known = attributes.speed_along(direction)
            limit[end, way] = np.nan if known is None else known
    # Cars drive along their road at its end as they come in, and at its start as they go out.
    speed = np.fmin(
        limit[connecting.entry, np.where(connecting.entry % 2 == 1, 0, 1)],
        limit[connecting.exit, np.where(connecting.exit % 2 == 0, 0, 1)],
    )
    return np.asarray(np.nan_to_num(np.minimum(speed, SHIFT_SPEED), nan=0.0))
