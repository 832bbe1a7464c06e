"""Where no elevation model measures the heights of roads."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, pose, ranks, repeated
from osm2xodr.model import RoadMap, Stretches, Surface

# Distance of the places along a road that are looked up, m: a fraction of the cells of most elevation models.
_STEP: Final = 5.0
# Stretches are known no better than that: they are rounded to centimetres, as they are written.
_DECIMALS: Final = 2


def mark_unmeasured(road_map: RoadMap, surface: Surface) -> RoadMap:
    """Return a road map that knows on which stretches its reference lines have no measured height (`unmeasured`).

    A stretch ends halfway between a place that the surface measures and one that it does not, at most 5 m apart.
    """
    plan = road_map.plan_view
    length = lengths(plan)
    count = np.ceil(length / _STEP).astype(np.int64) + 1
    road = repeated(count)
    share = ranks(count) / np.maximum(count - 1, 1)[road]
    s = share * length[road]
    x, y, _ = pose(plan, road, s)
    gap = ~surface.measured(x, y)
    same = road[1:] == road[:-1]
    first = np.flatnonzero(gap & ~np.append(False, same & gap[:-1]))
    last = np.flatnonzero(gap & ~np.append(same & gap[1:], False))
    # The ends of roads end stretches as well.
    begin = np.where(share[first] == 0.0, 0.0, 0.5 * (s[first] + s[first - 1]))
    end = np.where(share[last] == 1.0, s[last], 0.5 * (s[last] + np.append(s, 0.0)[last + 1]))
    start = np.searchsorted(road[first], np.arange(len(length) + 1)).astype(np.int64)
    return replace(road_map, unmeasured=Stretches(start, begin.round(_DECIMALS), end.round(_DECIMALS)))
