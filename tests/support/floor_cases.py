"""Connecting roads along straight lines, for the floor of junctions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.model import Access, FloatArray, LaneType, PlanView

Line = tuple[float, float, float, float]


def connecting(lines: Sequence[Line], junctions: Sequence[int] | None = None) -> ConnectingRoads:
    """Return connecting roads of 3 m along lines from x, y to x, y, all through one junction if not said."""
    n = len(lines)
    x0, y0, x1, y1 = np.array(lines, float).T
    length = np.hypot(x1 - x0, y1 - y0)
    zero, none = np.zeros(n), np.zeros(n, np.int64)
    hdg = np.arctan2(y1 - y0, x1 - x0)
    lane: FloatArray = np.full(n, 3.0)
    return ConnectingRoads(
        plan_view=PlanView(np.arange(n + 1), zero, x0, y0, hdg, length, zero),
        length=length,
        junction=none if junctions is None else np.array(junctions, np.int64),
        entry=none,
        exit=none,
        entry_lane=none,
        exit_lane=none,
        entry_t=zero,
        exit_t=zero,
        entry_width=lane,
        exit_width=lane,
        against=np.zeros(n, bool),
        joins_cars=np.zeros(n, bool),
        entry_aside=zero,
        exit_aside=zero,
        height=zero,
        lane_type=(LaneType.DRIVING,) * n,
        access=(Access.ALL,) * n,
        inner=((),) * n,
    )
