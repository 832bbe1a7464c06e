"""Ways that still run over arms of their junction, which have no room to give, are drawn tighter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.curves import dubins_without_slivers, lengths, pose, replace_curves, smallest_radius
from osm2xodr.defaults import MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import (
    LEAST_REDRAWN_RADIUS,
    LONGEST_REDRAWN,
    TURNING_RADIUS,
    TURNING_RADIUS_ACUTE,
)
from osm2xodr.geometry.connections.overrun_arms import ways_over_arms
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.turn_backs import turned_back, turns_back
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import PlanView


def keep_off_arms(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> ConnectingRoads:
    """Return the connecting roads, those that run over an arm drawn again where a tighter curve does not.

    It is no sharper than before, or than what most cars manage, and not much longer.
    """
    row = np.unique(ways_over_arms(ends, layout, parts, connecting)[0])
    row = row[connecting.for_vehicles()[row] & (connecting.entry[row] != connecting.exit[row])]
    plan = connecting.plan_view
    for draw in _TIGHTER:
        if not len(row):
            break
        start, end = pose(plan, row, np.zeros(len(row))), pose(plan, row, lengths(plan, row))
        drawn = draw(start, end)
        least = np.minimum(smallest_radius(plan)[row], TURNING_RADIUS_ACUTE) * (1 - 1e-6)
        fits = (lengths(drawn) > 0) & (lengths(drawn) < LONGEST_REDRAWN * lengths(plan, row))
        back = turns_back(drawn)
        fits &= (smallest_radius(drawn) >= least) & (back == turns_back(plan)[row])
        fits &= back | (draw is not _at_once)
        new = np.flatnonzero(fits)
        tried = replace_curves(plan, row[new], drawn, new)
        chosen = replace(connecting, plan_view=tried, length=lengths(tried)).at_rows(row[new])
        new = np.delete(new, np.unique(ways_over_arms(ends, layout, parts, chosen)[0]))
        plan = replace_curves(plan, row[new], drawn, new)
        row = np.delete(row, new)
    return connecting if plan is connecting.plan_view else replace(connecting, plan_view=plan, length=lengths(plan))


def _at_once(start: Poses, end: Poses) -> PlanView:
    """Turn back where both lanes are abreast, however far ahead the way across lies."""
    return turned_back(start, end, np.full(len(start[0]), -np.inf))


def _shortest(radius: float, start: Poses, end: Poses) -> PlanView:
    """Take the shortest curve of a radius, m."""
    size = np.full(len(start[0]), radius)
    return dubins_without_slivers(*start, *end, radius=size, most_swing=MOST_SWING_BACK)


# What is tried, the best first: turns back as all of them are drawn, and shortest curves.
_TIGHTER: Final[tuple[Callable[[Poses, Poses], PlanView], ...]] = (
    _at_once,
    *(partial(_shortest, radius) for radius in (TURNING_RADIUS, LEAST_REDRAWN_RADIUS, TURNING_RADIUS_ACUTE)),
)
