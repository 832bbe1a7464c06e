"""Junctions get more of their arms where a turn would be sharper than a car drives."""

from __future__ import annotations

import numpy as np

from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.pose_to_pose import connect, wanting
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds, outward_pose
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView


def widened_trims(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> FloatArray:
    """Return how much each street end gives to its junction so that turns have a radius that cars drive, (ends,), m.

    Arms with a turn that is too sharp are cut back step by step while their streets have room.
    """
    street_end = np.full(2 * len(parts.length), -1, np.int64)
    used = np.flatnonzero(parts.road_end >= 0)
    street_end[parts.road_end[used]] = used
    entry, exit_ = street_end[connecting.entry], street_end[connecting.exit]
    # Lanes in the outward frame of their street end: left of it is right of traffic that comes in.
    t_in = np.where(connecting.entry % 2 == 1, -connecting.entry_t, connecting.entry_t)
    t_out = np.where(connecting.exit % 2 == 1, -connecting.exit_t, connecting.exit_t)
    trim = layout.trim.copy()
    # Loops that turn back on their arm have their own room.
    rows = np.flatnonzero(wanting(connecting.plan_view) & (connecting.entry != connecting.exit))
    for _ in range(defaults.TURNING_ROOM_STEPS):
        if not len(rows):
            break
        one, other = np.unique(entry[rows]), np.unique(exit_[rows])
        more = np.union1d(one, other)
        more = more[_has_room(ends, trim, more)]
        if not len(more):
            break
        trim[more] += defaults.TURNING_ROOM
        rows = rows[wanting(_curves(ends, trim, entry[rows], exit_[rows], t_in[rows], t_out[rows]))]
    return trim


def _has_room(ends: StreetEnds, trim: FloatArray, end: IntArray) -> BoolArray:
    left = ends.length[end] - trim[end] - trim[end ^ 1]
    out: BoolArray = left > 2 * defaults.TURNING_ROOM + defaults.SHORTEST_STREET_BETWEEN_JUNCTIONS
    return out


def _curves(
    ends: StreetEnds, trim: FloatArray, entry: IntArray, exit_: IntArray, t_in: FloatArray, t_out: FloatArray
) -> PlanView:
    x0, y0, h0 = outward_pose(ends, entry, trim[entry])
    x1, y1, h1 = outward_pose(ends, exit_, trim[exit_])
    return connect(
        x0 - t_in * np.sin(h0),
        y0 + t_in * np.cos(h0),
        h0 + np.pi,
        x1 - t_out * np.sin(h1),
        y1 + t_out * np.cos(h1),
        h1,
    )
