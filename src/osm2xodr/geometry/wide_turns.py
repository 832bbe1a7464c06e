"""Turns that two arcs would make sharper than a car drives swing out first, where the junction has room for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from osm2xodr import defaults
from osm2xodr.geometry.connecting_roads import ConnectingRoads
from osm2xodr.geometry.curves import lengths, pose, smallest_radius
from osm2xodr.geometry.plan_fit import replaced
from osm2xodr.geometry.road_parts import RoadParts
from osm2xodr.geometry.shortest_curves import shortest_curves
from osm2xodr.model import PlanView

_STEP = 1.0


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
    sharp = smallest_radius(plan) < defaults.CONNECTING_RADIUS * (1 - 1e-9)
    row = np.flatnonzero(sharp & (connecting.entry != connecting.exit))
    if not len(row):
        return connecting
    begin = pose(plan, row, np.zeros(len(row)))
    end = pose(plan, row, connecting.length[row])
    wide = shortest_curves(*begin, *end, radius=defaults.CONNECTING_RADIUS)
    found = np.flatnonzero(lengths(wide) > 0)
    at = _road_ends(parts)
    free = [not _in_the_way(wide, k, at[int(connecting.junction[row[k]])], parts) for k in found.tolist()]
    found = found[np.array(free, bool)]
    plan = replaced(plan, row[found], wide, found)
    return replace(connecting, plan_view=plan, length=lengths(plan))


def _road_ends(parts: RoadParts) -> dict[int, list[int]]:
    """Return the road ends at each junction."""
    out: dict[int, list[int]] = {}
    for end, junction in enumerate(parts.end_junction.ravel().tolist()):
        out.setdefault(junction, []).append(end)
    return out


def _in_the_way(plan: PlanView, curve: int, ends: list[int], parts: RoadParts) -> bool:
    """Say whether a curve runs onto one of the roads that end at its junction."""
    last = int(plan.start[curve + 1]) - 1
    length = float(plan.s[last] + plan.length[last])
    s = np.linspace(0.0, length, max(int(length / (_STEP / 2)), 2))
    x, y, _ = pose(plan, np.full(len(s), curve), s)
    for end in ends:
        number = end // 2
        along = np.arange(_STEP, min(float(parts.length[number]), defaults.WIDE_TURN_REACH), _STEP)
        at = float(parts.length[number]) - along if end % 2 else along
        px, py, hdg = pose(parts.plan_view, np.full(len(at), number), at)
        dx, dy = x[:, None] - px, y[:, None] - py
        ds = dx * np.cos(hdg) + dy * np.sin(hdg)
        dt = dy * np.cos(hdg) - dx * np.sin(hdg)
        section = parts.at_end(end).section
        beside = (dt < section.left_edge + defaults.HALF_LANE) & (dt > section.right_edge - defaults.HALF_LANE)
        if (beside & (np.abs(ds) <= _STEP / 2)).any():
            return True
    return False
