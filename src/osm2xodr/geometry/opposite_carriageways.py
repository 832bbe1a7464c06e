"""How far roads may shift toward the opposite carriageway of their street."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import pose
from osm2xodr.geometry import defaults
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Ends that shift are compared over this length, m: about that over which their shift fades.
_END: Final = 20.0


def shares_with_room(parts: RoadParts, numbers: Mapping[int, Sequence[int]], shift: FloatArray) -> FloatArray:
    """Return which share of its shift each part may keep, (parts,), so that opposite carriageways stay apart.

    `shift` (parts,) is to the left, m. `numbers` has of each road the parts that its start, its stretches and its end
    are, -1 for what stays.
    """
    share = np.ones(len(shift))
    road, s, part, edge, motorway = _places(parts, numbers)
    aside = np.append(shift, 0.0)[part]
    moved = np.flatnonzero(aside)
    if not len(moved):
        return share
    x, y, hdg = pose(parts.plan_view, road, s)
    xy = np.column_stack([x, y])
    reach = 2 * float(edge.max()) + defaults.PARALLEL_SPACING
    near = [np.array(places, np.int64) for places in cKDTree(xy).query_ball_point(xy[moved], reach)]
    a, b = np.repeat(moved, [len(places) for places in near]), np.concatenate(near)
    (dx, dy), cos, sin = (xy[b] - xy[a]).T, np.cos(hdg[a]), np.sin(hdg[a])
    along, across, turn = dx * cos + dy * sin, dy * cos - dx * sin, hdg[b] - hdg[a]
    abreast = (np.abs(along) <= 0.5 * defaults.PARALLEL_SPACING) & (np.abs(np.sin(turn)) < defaults.PARALLEL_SINE)
    side, sign = (across < 0).astype(np.int64), np.sign(across)
    gap = np.where(motorway[a] & motorway[b], defaults.LEAST_MEDIAN, defaults.PARALLEL_GAP)
    room = np.abs(across) - edge[a, side] - edge[b, side] - gap
    own, other = np.maximum(sign * aside[a], 0.0), np.maximum(sign * aside[b], 0.0)
    tight = np.flatnonzero(abreast & (np.cos(turn) < 0) & (own > 0) & (own + other > room))
    np.minimum.at(share, part[a[tight]], np.maximum(room[tight], 0.0) / (own + other)[tight])
    return share


def _places(
    parts: RoadParts, numbers: Mapping[int, Sequence[int]]
) -> tuple[IntArray, FloatArray, IntArray, FloatArray, BoolArray]:
    """Return places along one-way roads.

    These are road, s, m, part, -1 for none, distance of both edges, (n, 2), m, and whether it is a motorway.
    """
    rows = [
        (road, item, part)
        for road, stretches in enumerate(parts.stretches)
        for item, part in zip(stretches, numbers.get(road, [-1] * (len(stretches) + 2))[1:-1], strict=True)
        if len(item.attributes.car_directions()) == 1
    ]
    steps = [np.arange(item.start, item.end, 0.5 * defaults.PARALLEL_SPACING) for _, item, _ in rows]
    count = [len(s) for s in steps]
    road = np.repeat(np.array([road for road, _, _ in rows], np.int64), count)
    part = np.repeat(np.array([part for _, _, part in rows], np.int64), count)
    edges = np.array([(item.section.left_edge, -item.section.right_edge) for _, item, _ in rows]).reshape(-1, 2)
    s = np.concatenate([np.zeros(0), *steps])
    ends = np.array([(own[0], own[-1]) for own in (numbers.get(k, (-1, -1)) for k in range(len(parts.length)))])
    for end, distance in enumerate((s, parts.length[road] - s)):
        part = np.where((part < 0) & (distance < _END), ends.reshape(-1, 2)[road, end], part)
    motorway = np.array([item.attributes.highway == "motorway" for _, item, _ in rows], bool)
    return road, s, part, np.repeat(edges, count, axis=0), np.repeat(motorway, count)
