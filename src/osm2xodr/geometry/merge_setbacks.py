"""Stems of splits and merges are set back until cars shift to their branches at speed."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import heading_change, lengths, slope_of, smallest_radius, sorted_unique, unique_counts, wrapped
from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections import ConnectingRoads, Poses, Turns, connect, tangents
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import Direction, FloatArray, IntArray

# Stems are set back in at most so many rounds, in each by this much at most, m, and by this much at least.
_ROUNDS: Final = 8
_MOST_AT_ONCE: Final = 15.0
_LEAST_AT_ONCE: Final = 0.5
# Ways that turn by less are no single arc, rad (1 degree). A choice.
_LEAST_TURN: Final = 0.02


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
    rows = np.flatnonzero((stem >= 0) & (speed * 3.6 >= defaults.MERGE_SPEED_KMH - 1e-6))
    if not len(rows):
        return trim
    stem = parts.street_end()[stem[rows]]
    turns = replace(Turns.of(parts, connecting), radius=speed**2 / defaults.MERGE_ACCELERATION).chosen(rows)
    trim = trim.copy()
    farthest = np.full(len(trim), defaults.MERGE_BRANCH_MAX)
    farthest[stem] = defaults.MERGE_SETBACK_MAX
    farthest = np.minimum(layout.trim + farthest, defaults.MERGE_SHARE_MAX * _first_ways(parts))
    most = np.maximum(np.minimum(layout.most, farthest), trim)
    for _ in range(_ROUNDS):
        room = most - trim
        before, behind, in_all = _lacking(*turns.poses(ends, trim), turns.radius, room[turns.entry], room[turns.exit])
        give = np.zeros(len(trim))
        np.maximum.at(give, turns.entry, before)
        np.maximum.at(give, turns.exit, behind)
        np.maximum.at(give, stem, in_all)
        give = np.minimum(np.minimum(give, _MOST_AT_ONCE), room)
        if give.max() < _LEAST_AT_ONCE:
            break
        trim += give
    return trim


def _lacking(
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
    arc = sharp & (before > 0) & (after > 0) & (angle > _LEAST_TURN)
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
    sharp[connecting.junction[cars & (turn > defaults.MERGE_TURN)]] = True
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
    return np.asarray(np.nan_to_num(np.minimum(speed, defaults.SHIFT_SPEED), nan=0.0))
