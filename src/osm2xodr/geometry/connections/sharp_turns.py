"""Turns that are sharper than a car drives even when arms have been set back swing out where there is room."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    curve_ends,
    dubins_without_slivers,
    heading_at,
    lengths,
    pose,
    replace_curves,
    sine,
    smallest_radius,
)
from osm2xodr.defaults import CONNECTING_RADIUS, MOST_SWING, MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import LONGEST_REDRAWN, OFF_CARRIAGEWAY, TURNING_RADIUS_ACUTE
from osm2xodr.geometry.connections.pose_to_pose import curves_apart
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.turn_backs import turn_back_rows
from osm2xodr.geometry.defaults import CAR_WIDTH, HALF_NARROW_LANE, INNER_EDGE_RADIUS
from osm2xodr.geometry.junctions import RoadParts, end_poses
from osm2xodr.geometry.lanes import CrossSection
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView

# Turns that swing out must not run onto the first stretch of the junction's roads, of this length, m; places on both
# are compared at this spacing, m.
_CLEAR_ARM: Final = 25.0
_PLACE_SPACING: Final = 1.0
# Ways there and back are compared at this many places each.
_PLACES: Final = 32
# They may be longer than the sharp turn by this factor; by `LONGEST_REDRAWN`, unless they turn back, if no car turns
# more sharply.
_LONGEST_SWING: Final = 1.3
# The first of these radii, m, that leaves room is taken: most cars drive the first, some the second, and small ones,
# with care, the others. Choices.
_RADII: Final = (TURNING_RADIUS_ACUTE, 3.95, 3.6, 3.3, CONNECTING_RADIUS)
# Where the inner edge of a lane has no room for its full radius, one of these shares of it does.
_INNER_EDGE_SHARES: Final = (1.0, 0.5, 0.1)


def swing_out(
    connecting: ConnectingRoads, parts: RoadParts, beyond: Callable[[ConnectingRoads], FloatArray]
) -> ConnectingRoads:
    """Replace turns that are too sharp by the shortest curves that are not, where no road is in their way.

    `beyond` returns how far roads leave the carriageways, (n,), m: they do so no more than before, or than they may,
    unless no car drives the sharper turn.

    Those that would swing far for the radius that most cars need get the largest one with which they do not.
    """
    plan, pairs, back = connecting.plan_view, connecting.there_and_back(), turn_back_rows(connecting)
    for radius in _RADII:
        # Ways back have their own room; bicycles need less than cars.
        sharp = (smallest_radius(plan) < radius * (1 - 1e-9)) & connecting.for_vehicles()
        row = np.setdiff1d(np.flatnonzero(sharp & (connecting.entry != connecting.exit)), back)
        if not len(row):
            break
        wide, found = _wide_curves(plan, row, np.full(len(row), radius))
        longest = LONGEST_REDRAWN if radius <= CONNECTING_RADIUS else _LONGEST_SWING
        # A turn that a car just misses is better than a balloon.
        found = found[(lengths(wide) < longest * lengths(plan, row))[found]]
        free = _keep_off_roads(wide, found, connecting.junction[row[found]], parts)
        if radius > CONNECTING_RADIUS:
            free &= ~_meet(wide, found, plan, row[found], pairs)
            free[free] = _keeps_to_streets(wide, found[free], plan, row[found[free]], connecting, beyond)
        plan = replace_curves(plan, row[found[free]], wide, found[free])
    plan = _without_folds(plan, connecting)
    return replace(connecting, plan_view=plan, length=lengths(plan))


def runs_backwards(connecting: ConnectingRoads, parts: RoadParts) -> BoolArray:
    """Say which connecting roads set out against the lane that they come from or arrive against the next one, (n,).

    The exit lies straight behind the entry, or in the same place: the arms that they join lie on each other.
    """
    plan = connecting.plan_view
    out = np.zeros(len(connecting.entry), bool)
    row = np.flatnonzero(np.diff(plan.start) > 0)
    for end, inwards, s in (
        (connecting.entry[row], 1, np.zeros(len(row))),
        (connecting.exit[row], 0, lengths(plan, row)),
    ):
        hdg = end_poses(parts, end)[2] + np.where(end % 2 == inwards, 0.0, np.pi)
        out[row] |= cosine(heading_at(plan, row, s) - hdg) < 0.0
    return out


def _wide_curves(
    plan: PlanView, row: IntArray, radius: FloatArray, most_swing: float = MOST_SWING
) -> tuple[PlanView, IntArray]:
    """Return the shortest curves of a radius between the ends of some curves, (rows,), and which of them exist."""
    start, end = curve_ends(plan, row)
    wide = dubins_without_slivers(*start, *end, radius=radius, most_swing=most_swing)
    return wide, np.flatnonzero(lengths(wide) > 0)


def _meet(
    wide: PlanView, curve: IntArray, plan: PlanView, row: IntArray, pairs: tuple[IntArray, IntArray]
) -> BoolArray:
    """Say which curves, drawn for some rows of a plan, come nearer to a way back than the way before, and meet it."""
    place = np.full(len(plan.start) - 1, -1)
    place[row] = np.arange(len(row))
    way, other = np.concatenate(pairs), np.concatenate(pairs[::-1])
    drawn = place[way] >= 0
    way, other = way[drawn], other[drawn]
    before = curves_apart(plan, way, plan, other, _PLACES)
    out = np.zeros(len(row), bool)
    meets = curves_apart(wide, curve[place[way]], plan, other, _PLACES) < np.minimum(before, CAR_WIDTH)
    out[place[way[meets]]] = True
    return out


def _keeps_to_streets(
    drawn: PlanView,
    curve: IntArray,
    plan: PlanView,
    row: IntArray,
    connecting: ConnectingRoads,
    beyond: Callable[[ConnectingRoads], FloatArray],
) -> BoolArray:
    """Say which curves, drawn for rows of a plan, leave the carriageways no more than before, or than they may."""
    off = []
    for tried in (plan, replace_curves(plan, row, drawn, curve)):
        off.append(beyond(replace(connecting, plan_view=tried, length=lengths(tried)).chosen(row)))
    return np.asarray(off[1] <= np.maximum(off[0], OFF_CARRIAGEWAY))


def _without_folds(plan: PlanView, connecting: ConnectingRoads) -> PlanView:
    """Replace turns so sharp that their one lane folds over itself, even where the way out lies on another road."""
    half = np.maximum(connecting.entry_width, connecting.exit_width) / 2
    for share in _INNER_EDGE_SHARES:
        row = np.flatnonzero((smallest_radius(plan) < half) & (connecting.entry != connecting.exit))
        if not len(row):
            break
        # Any way round is better than a fold.
        wide, found = _wide_curves(plan, row, half[row] + share * INNER_EDGE_RADIUS, MOST_SWING_BACK)
        plan = replace_curves(plan, row[found], wide, found)
    return plan


def _keep_off_roads(plan: PlanView, curve: IntArray, junction: IntArray, parts: RoadParts) -> BoolArray:
    """Say which curves run onto none of the roads that end at their junction, (curves,)."""
    end_junction = parts.end_junction.ravel()
    here = np.flatnonzero(np.isin(end_junction, junction))
    ends_at: dict[int, list[int]] = {}
    for end, number in zip(here.tolist(), end_junction[here].tolist(), strict=True):
        ends_at.setdefault(number, []).append(end)
    near = [ends_at[number] for number in junction.tolist()]
    arms = _places_on_arms(sorted({end for ends in near for end in ends}), parts)
    stations = [
        np.linspace(0.0, length, max(int(length / (_PLACE_SPACING / 2)), 2))
        for length in lengths(plan, curve).tolist()
    ]
    x, y, _ = _places(plan, curve, stations)
    free = [
        not any(_runs_onto(here_x, here_y, arms[end], parts.at_end(end).section) for end in ends)
        for here_x, here_y, ends in zip(x, y, near, strict=True)
    ]
    return np.array(free, bool)


def _places_on_arms(ends: list[int], parts: RoadParts) -> dict[int, Poses]:
    """Return x, y and heading of places along the first stretch of the roads from each of their ends."""
    stations = []
    for end in ends:
        length = float(parts.length[end // 2])
        along = np.arange(_PLACE_SPACING, min(length, _CLEAR_ARM), _PLACE_SPACING)
        stations.append(length - along if end % 2 else along)
    found = _places(parts.plan_view, np.array(ends, np.int64) // 2, stations)
    return dict(zip(ends, zip(*found, strict=True), strict=True))


def _places(plan: PlanView, curve: IntArray, stations: list[FloatArray]) -> tuple[list[FloatArray], ...]:
    """Return x, y and heading at the stations of each curve."""
    if not stations:
        return [], [], []
    count = [len(s) for s in stations]
    found = pose(plan, np.repeat(curve, count), np.concatenate(stations))
    return tuple(np.split(column, np.cumsum(count)[:-1]) for column in found)


def _runs_onto(x: FloatArray, y: FloatArray, arm: Poses, section: CrossSection) -> bool:
    """Say whether places lie on the carriageway of an arm."""
    arm_x, arm_y, hdg = arm
    dx, dy = x[:, None] - arm_x, y[:, None] - arm_y
    cos, sin = cosine(hdg), sine(hdg)
    ds = dx * cos + dy * sin
    dt = dy * cos - dx * sin
    beside = (dt < section.left_edge + HALF_NARROW_LANE) & (dt > section.right_edge - HALF_NARROW_LANE)
    return bool((beside & (np.abs(ds) <= _PLACE_SPACING / 2)).any())
