"""Which piece of a street a place on its road lies in."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import project
from osm2xodr.furniture.world.world import World
from osm2xodr.model import Street, StreetAttributes

# What is left of a piece at a road's end counts as nothing if it is shorter, m.
_NOTHING = 0.5


def pieces_on_road(world: World, street: Street, road: int) -> list[tuple[float, float, StreetAttributes]]:
    """Return from where to where on a road, s, m, which attributes of its street hold, in ascending s.

    Parameters
    ----------
    world
        The roads.
    street
        The street.
    road
        Id of a road that was cut from it.
    """
    length = world.lanes.length(road)
    pieces = street.pieces
    if len(pieces) == 1:
        return [(0.0, length, pieces[0][1])]
    points = street.points[[first for first, _ in pieces[1:]]]
    curve = np.full(len(points), world.lanes.index(road), np.int64)
    at: list[float] = project(world.road_map.plan_view, curve, points[:, 0], points[:, 1])[0].tolist()
    bounds = [0.0, *at, length]
    found = [
        (bounds[k], bounds[k + 1], attributes)
        for k, (_, attributes) in enumerate(pieces)
        if bounds[k + 1] - bounds[k] > min(_NOTHING, 0.5 * length)
    ]
    if found:
        return found
    return [(0.0, length, pieces[0][1])]


def way_at(street: Street, x: float, y: float) -> StreetAttributes:
    """Return the attributes of the part of a street that is nearest to a place."""
    start, step = street.points[:-1], np.diff(street.points, axis=0)
    off = np.array([x, y]) - start
    share = np.clip((off * step).sum(1) / np.maximum((step * step).sum(1), 1e-12), 0.0, 1.0)
    nearest = int(np.argmin(np.hypot(*(off - share[:, None] * step).T)))
    return street.attributes_at(nearest)
