"""Turns that two arcs would make sharper than a car drives swing out first, where the junction has room for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from osm2xodr.curves import dubins_without_slivers, lengths, pose, replace_curves, smallest_radius
from osm2xodr.defaults import CONNECTING_RADIUS, WIDE_TURN_REACH
from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.lanes import CrossSection
from osm2xodr.model import FloatArray, IntArray, PlanView

_STEP = 1.0
# Where there is no room for an inner edge of the full radius, one of these shares of it does.
_SHARES = (1.0, 0.5, 0.1)


def with_wide_turns(connecting: ConnectingRoads, parts: RoadParts) -> ConnectingRoads:
    """Replace turns that are too sharp by the shortest curves that are not, where no road is in their way.

    Parameters
    ----------
    connecting
        All connecting roads.
    parts
        The roads outside junctions.
    """
    plan = connecting.plan_view
    # Loops that turn back on their arm have their own room.
    sharp = smallest_radius(plan) < CONNECTING_RADIUS * (1 - 1e-9)
    row = np.flatnonzero(sharp & (connecting.entry != connecting.exit))
    if not len(row):
        return connecting
    poses = *pose(plan, row, np.zeros(len(row))), *pose(plan, row, connecting.length[row])
    wide = dubins_without_slivers(*poses, radius=np.full(len(row), CONNECTING_RADIUS))
    found = np.flatnonzero(lengths(wide) > 0)
    at = _road_ends(parts)
    near = [at[junction] for junction in connecting.junction[row[found]].tolist()]
    arms = _arms_along(sorted({end for ends in near for end in ends}), parts)
    paths = _paths_along(wide, found)
    free = [
        not any(_runs_onto(x, y, arms[end], parts.at_end(end).section) for end in ends)
        for (x, y), ends in zip(paths, near, strict=True)
    ]
    found = found[np.array(free, bool)]
    plan = replace_curves(plan, row[found], wide, found)
    plan = _unfolded(plan, connecting)
    return replace(connecting, plan_view=plan, length=lengths(plan))


def _unfolded(plan: PlanView, connecting: ConnectingRoads) -> PlanView:
    """Replace turns so sharp that their one lane folds over itself, even where the way out lies on another road."""
    half = np.maximum(connecting.entry_width, connecting.exit_width) / 2
    for share in _SHARES:
        row = np.flatnonzero((smallest_radius(plan) < half) & (connecting.entry != connecting.exit))
        if not len(row):
            break
        poses = *pose(plan, row, np.zeros(len(row))), *pose(plan, row, lengths(plan)[row])
        wide = dubins_without_slivers(*poses, radius=half[row] + share * defaults.INNER_EDGE_RADIUS)
        found = np.flatnonzero(lengths(wide) > 0)
        plan = replace_curves(plan, row[found], wide, found)
    return plan


def _road_ends(parts: RoadParts) -> dict[int, list[int]]:
    """Return the road ends at each junction."""
    out: dict[int, list[int]] = {}
    for end, junction in enumerate(parts.end_junction.ravel().tolist()):
        out.setdefault(junction, []).append(end)
    return out


def _paths_along(plan: PlanView, curve: IntArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return x and y of places along each curve."""
    stations = [
        np.linspace(0.0, length, max(int(length / (_STEP / 2)), 2)) for length in lengths(plan)[curve].tolist()
    ]
    x, y, _ = _poses(plan, curve, stations)
    return list(zip(x, y, strict=True))


def _arms_along(ends: list[int], parts: RoadParts) -> dict[int, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return x, y and heading of places along the roads from each of their ends."""
    stations = []
    for end in ends:
        length = float(parts.length[end // 2])
        along = np.arange(_STEP, min(length, WIDE_TURN_REACH), _STEP)
        stations.append(length - along if end % 2 else along)
    found = _poses(parts.plan_view, np.array(ends, np.int64) // 2, stations)
    return dict(zip(ends, zip(*found, strict=True), strict=True))


def _poses(plan: PlanView, curve: IntArray, stations: list[FloatArray]) -> tuple[list[FloatArray], ...]:
    """Return x, y and heading at the stations of each curve."""
    if not stations:
        return [], [], []
    count = [len(s) for s in stations]
    found = pose(plan, np.repeat(curve, count), np.concatenate(stations))
    return tuple(np.split(column, np.cumsum(count)[:-1]) for column in found)


def _runs_onto(
    x: FloatArray, y: FloatArray, arm: tuple[FloatArray, FloatArray, FloatArray], section: CrossSection
) -> bool:
    """Say whether places lie on the carriageway of an arm."""
    px, py, hdg = arm
    dx, dy = x[:, None] - px, y[:, None] - py
    cos, sin = np.cos(hdg), np.sin(hdg)
    ds = dx * cos + dy * sin
    dt = dy * cos - dx * sin
    beside = (dt < section.left_edge + defaults.HALF_NARROW_LANE) & (
        dt > section.right_edge - defaults.HALF_NARROW_LANE
    )
    return bool((beside & (np.abs(ds) <= _STEP / 2)).any())
