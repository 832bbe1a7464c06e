"""How far CARLA would misplace crosswalks.

The standard counts t from the reference line. CARLA 0.9.16 (measured) counts that of crosswalks, and of them alone,
from lane 0, which the lane offset puts beside it.
"""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import cubic_value
from osm2xodr.model import RoadMap


def crosswalk_offsets(road_map: RoadMap) -> dict[int, float]:
    """Return the lane offset at each crosswalk with an outline, m, by the id of its object.

    Parameters
    ----------
    road_map
        Its objects stand on roads that are there.
    """
    crosswalks = [item for item in road_map.furniture.objects if item.type == "crosswalk" and item.outline]
    if not crosswalks:
        return {}
    index = {road.id: k for k, road in enumerate(road_map.roads)}
    curve = np.array([index[item.road] for item in crosswalks], dtype=np.int64)
    s = np.array([item.s for item in crosswalks])
    offsets = cubic_value(road_map.lane_offset, curve, s).tolist()
    return {item.id: offset for item, offset in zip(crosswalks, offsets, strict=True)}
