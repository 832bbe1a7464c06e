"""Ways that run over arms of their junction, which have no room to give, and long turns back are drawn tighter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from osm2xodr.curves import (
    chosen_curves,
    curve_ends,
    dubins_without_slivers,
    lengths,
    replace_curves,
    smallest_radius,
)
from osm2xodr.defaults import MOST_SWING_BACK
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.defaults import (
    LEAST_REDRAWN_RADIUS,
    LONGEST_REDRAWN,
    LONGEST_TURN_BACK,
    OFF_CARRIAGEWAY,
    TURNING_RADIUS,
    TURNING_RADIUS_ACUTE,
)
from osm2xodr.geometry.connections.overrun_arms import beyond_streets, ways_over_arms
from osm2xodr.geometry.connections.street_paths import Poses
from osm2xodr.geometry.connections.turn_backs import turned_back, turns_back
from osm2xodr.geometry.defaults import U_TURN_RADIUS
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import PlanView


def draw_tighter(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> ConnectingRoads:
    """Return the connecting roads, those drawn again that run over an arm, or are too long to turn back.

    A curve counts if it does neither. It is no sharper than before, or than what most cars manage, and leaves the
    carriageways no more than before, or than curves may.
    """
    plan = connecting.plan_view
    turned, radius = turns_back(plan), smallest_radius(plan)
    found = turned & (connecting.length > LONGEST_TURN_BACK)
    found[ways_over_arms(ends, layout, parts, connecting)[0]] = True
    row = np.flatnonzero(found & connecting.for_vehicles() & (connecting.entry != connecting.exit))
    for draw in _TIGHTER:
        if not len(row):
            break
        start, end = curve_ends(plan, row)
        drawn = draw(start, end)
        # Where there is no such curve, its length is 0.
        back = np.zeros(len(row), bool)
        there = np.flatnonzero(lengths(drawn) > 0)
        back[there] = turns_back(chosen_curves(drawn, there))
        least = np.where(back, U_TURN_RADIUS, np.minimum(radius[row], TURNING_RADIUS_ACUTE)) * (1 - 1e-6)
        longest = np.where(back, LONGEST_TURN_BACK, LONGEST_REDRAWN * lengths(plan, row))
        fits = (lengths(drawn) > 0) & (lengths(drawn) < longest) & (smallest_radius(drawn) >= least)
        fits &= (back == turned[row]) & (back | (draw is not _at_once))
        new = np.flatnonzero(fits)
        tried = replace_curves(plan, row[new], drawn, new)
        chosen = replace(connecting, plan_view=tried, length=lengths(tried)).chosen(row[new])
        # Turns back lead over what lies between carriageways.
        turns = np.flatnonzero(~back[new])
        most = np.maximum(beyond_streets(ends, layout, parts, connecting.chosen(row[new[turns]])), OFF_CARRIAGEWAY)
        leave = turns[beyond_streets(ends, layout, parts, chosen.chosen(turns)) > most]
        new = np.delete(new, np.union1d(ways_over_arms(ends, layout, parts, chosen)[0], leave))
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
