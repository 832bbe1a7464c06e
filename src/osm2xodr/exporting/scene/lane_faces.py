"""The lanes of all roads as four-cornered faces, road by road and interval by interval between stations."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import runs
from osm2xodr.exporting.scene.model import Level
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive, lane_ribbons, sample_roads

# Faces of damaged files may lie anywhere, m.
_FARTHEST = 1e7


@dataclass(frozen=True, eq=False)
class LaneFaces:
    """Faces of lanes between two stations, and the intervals of roads that they make up.

    Corners are the lane's right and left border at the first station, then left and right at the second, in the
    order right begin, right end, left end, left begin: counter-clockwise from above.
    """

    corners: FloatArray  # (n, 4, 3) inertial x, y, z of the road's surface, without lane heights, m
    lift: FloatArray  # (n, 4) Height of the lane above it, m
    uv: FloatArray  # (n, 4, 2) s and t, m
    lane: IntArray  # (n,) Row of the table of lanes
    interval: IntArray  # (n,) The interval it is part of
    # (intervals,)
    road: IntArray
    level: IntArray  # `Level`
    outline: FloatArray  # (intervals, 4, 3) Outermost corners, as those of faces


def lane_faces(file: OpenDrive, tolerance: float, step: float) -> LaneFaces:
    """Return the faces of all lanes; see `sample_roads` for `tolerance` and `step`, m.

    Intervals stand road by road in ascending s. Lanes without width at both ends have no face.
    """
    spans = _spans(file)
    more = (
        np.array([road for road, _, _, _ in spans for _ in range(2)], np.int64),
        np.array([s for _, _, low, high in spans for s in (low, high)], np.float64),
    )
    stations = sample_roads(file, tolerance, step, more)
    ribbons = lane_ribbons(file, stations)
    lanes = np.flatnonzero(ribbons.left != ABSENT)
    left, right = ribbons.start[ribbons.left[lanes]], ribbons.start[ribbons.right[lanes]]
    count = np.maximum(ribbons.start[ribbons.left[lanes] + 1] - left - 1, 0)
    lane, l0, r0 = np.repeat(lanes, count), runs(left, count), runs(right, count)
    points = np.column_stack([r0, r0 + 1, l0 + 1, l0])
    xyz = np.column_stack([ribbons.x, ribbons.y, ribbons.z])
    corners = xyz[points]
    width = np.hypot(*np.moveaxis(corners[:, [3, 2], :2] - corners[:, [0, 1], :2], 2, 0))
    kept = (np.abs(corners) < _FARTHEST).all((1, 2)) & (width > 1e-4).any(1)
    lane, points, corners = lane[kept], points[kept], corners[kept]
    inner, outer = np.nan_to_num(file.lanes.height[lane]).T
    is_left = file.lanes.id[lane] > 0
    at_left, at_right = np.where(is_left, outer, inner), np.where(is_left, inner, outer)
    lift = np.column_stack([at_right, at_right, at_left, at_left])
    uv = np.stack([stations.s[ribbons.station[points]], ribbons.t[points]], axis=2)
    first, interval = np.unique(ribbons.station[points[:, 0]], return_inverse=True)
    middle = np.empty(len(first))
    middle[interval] = 0.5 * (uv[:, 0, 0] + uv[:, 1, 0])
    road = stations.road[first]
    outline = _outlines(corners, uv, interval, len(first))
    return LaneFaces(corners, lift, uv, lane, interval, road, _levels(spans, road, middle), outline)


def _spans(file: OpenDrive) -> list[tuple[int, Level, float, float]]:
    """Return road, level, begin and end (s, m) of each bridge and tunnel; those after others win."""
    kinds = {"bridge": Level.BRIDGE, "tunnel": Level.TUNNEL}
    return [
        (item.road, kinds[item.kind], item.s, item.s + item.length)
        for item in file.furniture
        if item.kind in kinds and item.road >= 0 and math.isfinite(item.s + item.length)
    ]


def _levels(spans: list[tuple[int, Level, float, float]], road: IntArray, middle: FloatArray) -> IntArray:
    """Return the level of each interval by its road and the s of its middle."""
    level = np.full(len(road), int(Level.GROUND))
    first = np.searchsorted(road, np.arange(int(road[-1]) + 2 if len(road) else 1))
    for at, kind, low, high in spans:
        if at + 1 < len(first):
            rows = slice(first[at], first[at + 1])
            level[rows][(low <= middle[rows]) & (middle[rows] <= high)] = int(kind)
    return level


def _outlines(corners: FloatArray, uv: FloatArray, interval: IntArray, count: int) -> FloatArray:
    """Return the outermost corners of each interval."""
    out = np.empty((count, 4, 3))
    for side, sign in (((0, 1), 1.0), ((3, 2), -1.0)):
        t = sign * uv[:, side, 1].sum(1)
        order = np.lexsort((t, interval))
        row = order[np.searchsorted(interval[order], np.arange(count))]
        out[:, side] = corners[row][:, side]
    return out
