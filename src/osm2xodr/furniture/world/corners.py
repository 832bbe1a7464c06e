"""Corners of things that follow a road."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from osm2xodr.curves import pose
from osm2xodr.furniture.world.world import World

Outline = tuple[tuple[float, float, float, float], ...]


def outline(
    world: World, road: int, s: float, t: float, corners: Sequence[tuple[float, float]], height: float = 0.0
) -> Outline:
    """Return the corners of an object in its own frame: u along the road at the object, v to its left.

    Parameters
    ----------
    world
        The roads.
    road, s, t
        Id of the road and the object's place on it, m.
    corners
        s, t of each corner, m.
    height
        Of the object there, m.

    Returns
    -------
    outline
        u, v, z, height of each corner, m. z is 0: the frame leans with the road, as CARLA 0.9.16 takes it (corners on
        roads of 10 % are then 0.01 m off; with heights of their own they are 0.2 m off).
    """
    at = np.array([s, *(corner[0] for corner in corners)])
    aside = np.array([t, *(corner[1] for corner in corners)])
    curve = np.full(len(at), world.lanes.index(road), np.int64)
    x, y, hdg = pose(world.road_map.plan_view, curve, at)
    x, y = x - aside * np.sin(hdg), y + aside * np.cos(hdg)
    dx, dy = x[1:] - x[0], y[1:] - y[0]
    u = dx * np.cos(hdg[0]) + dy * np.sin(hdg[0])
    v = dy * np.cos(hdg[0]) - dx * np.sin(hdg[0])
    return tuple((a, b, 0.0, height) for a, b in zip(u.tolist(), v.tolist(), strict=True))
