"""Raised islands, which carriageways go round."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    cosine,
    pose,
    project,
    sine,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.objects.crosswalks import ISLAND_HEIGHT
from osm2xodr.model import RoadMap, RoadObject

# Decimals of the corners and the size of an island, m.
_DECIMALS: Final = 3


def island_objects(road_map: RoadMap, diagnostics: Diagnostics) -> list[RoadObject]:
    """Return the islands of a road map, at least one, as objects on roads beside them."""
    furniture, islands = road_map.furniture, road_map.islands
    used = (item.id for kind in (furniture.signals, furniture.objects, furniture.structures) for item in kind)
    number = max(used, default=0)
    road = np.array([item.road for item in islands], np.int64)
    x, y = np.array([item.corners.mean(axis=0) for item in islands]).T
    s, t, _ = project(road_map.plan_view, road, x, y)
    at_x, at_y, hdg = pose(road_map.plan_view, road, s)
    x, y = at_x - t * sine(hdg), at_y + t * cosine(hdg)
    nodes = {item.id: item.osm_node_ids[0] for item in road_map.junctions}
    made: list[RoadObject] = []
    for k, item in enumerate(islands):
        dx, dy = (item.corners - (x[k], y[k])).T
        u, v = dx * cosine(hdg[k]) + dy * sine(hdg[k]), dy * cosine(hdg[k]) - dx * sine(hdg[k])
        corners = zip(u.round(_DECIMALS).tolist(), v.round(_DECIMALS).tolist(), strict=True)
        made.append(
            RoadObject(
                number + 1 + k,
                road_map.roads[item.road].id,
                *("trafficIsland", "", "island"),
                float(s[k]),
                float(t[k]),
                length=round(float(np.ptp(u)), _DECIMALS),
                width=round(float(np.ptp(v)), _DECIMALS),
                height=ISLAND_HEIGHT,
                outline=tuple((a, b, 0.0, ISLAND_HEIGHT) for a, b in corners),
                osm_id=item.osm_id,
            )
        )
        if item.osm_id:
            continue
        text = "a place that its carriageways go round is raised as an island"
        diagnostics.guessed("junction-island", f"node/{nodes[item.junction]}", text)
    return made
