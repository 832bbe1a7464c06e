"""Sidewalks that are too short for the step between the roads that they would connect."""

from __future__ import annotations

import numpy as np

from osm2xodr.geometry import defaults
from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.heights import ProfileSolution, end_state
from osm2xodr.model import BoolArray


def too_steep(corners: ConnectingRoads, solution: ProfileSolution) -> BoolArray:
    """Say which corners are steeper than a connecting road may be, and than the roads that they connect, (corners,).

    Roads are level across where they end: around a corner on a slope, the difference of their heights is left for
    the few metres between their sidewalks. The cubic that has both heights and grades is steepest half-way.

    Parameters
    ----------
    corners
        Connecting roads of sidewalks.
    solution
        The heights of the roads.
    """
    z0, g0 = end_state(solution, corners.entry, leaving=True)
    z1, g1 = end_state(solution, corners.exit, leaving=False)
    half_way = 1.5 * (z1 - z0) / np.maximum(corners.length, 1e-6) - 0.25 * (g0 + g1)
    arms = np.maximum(np.abs(g0), np.abs(g1))
    return np.asarray(np.abs(half_way) > np.maximum(defaults.CONNECTOR_STEEP, arms))
