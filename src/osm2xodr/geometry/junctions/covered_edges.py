"""Up to where the edges of arms lie on other arms, one by one."""

from __future__ import annotations

import math
from typing import Final

from osm2xodr.geometry.defaults import PARALLEL_SINE
from osm2xodr.model import FloatArray, IntArray

# Edges count as apart from this distance on, m. A choice.
_GAP_BETWEEN_EDGES: Final = 0.3
# Arms that run along each other lie side by side up to here, m, where one of them has come to another level: widths
# are not known better.
_OVERLAP_OF_LEVELS: Final = 0.2
# Nearer to the node than this, m, no height is won: all levels are one there.
_LEVELS_PART_FROM: Final = 25.0
# An edge that has not reached the other arm up to here, m, never does: arms that come close again farther out are
# other places. A choice.
_FIRST_ENTRY: Final = 12.0
# Arms are open behind their ends from here on, m; a station before its first one no edge lies on an arm.
_BEHIND: Final = 1e-6
_BEYOND: Final = 1.0
_OUTSIDE: Final = 0.1
_PARALLEL: Final = PARALLEL_SINE
_INFINITE: Final = math.inf


def cover_edges(
    one: IntArray,
    other: IntArray,
    stations: FloatArray,
    poses: FloatArray,
    level: IntArray,
    left: FloatArray,
    right: FloatArray,
    out: FloatArray,
) -> None:
    """Write up to where along arms, and along the others of their pairs, edges of one lie on the other, (2, n), m.

    `poses`, (4, arms, stations), are x, y, cosine and sine of their headings, and `left` and `right` t of the edges,
    (arms,), m. What lies on the other arm only farther out does not count.
    """
    for k in range(len(one)):
        out[0, k] = out[1, k] = 0.0
        for side in range(2):
            _cover_edge(one[k], other[k], left if side == 0 else right, stations, poses, level, left, right, k, out)


def _cover_edge(
    arm: int,
    other: int,
    edge: FloatArray,
    stations: FloatArray,
    poses: FloatArray,
    level: IntArray,
    left: FloatArray,
    right: FloatArray,
    k: int,
    out: FloatArray,
) -> None:
    """Raise what `cover_edges` writes to where an edge first leaves the other arm."""
    entered, near, before, lower = False, 0, 0, 0.0
    for i in range(len(stations)):
        if not entered and stations[i] > _FIRST_ENTRY:
            return
        x = float(poses[0, arm, i]) - float(edge[arm]) * float(poses[3, arm, i])
        y = float(poses[1, arm, i]) + float(edge[arm]) * float(poses[2, arm, i])
        near = _nearest(x, y, other, poses)
        upper = _outside(x, y, arm, i, other, near, stations, poses, level, left, right)
        if entered and upper >= 0.0:
            share = min(max(-lower / max(upper - lower, 1e-9), 0.0), 1.0)
            here = float(stations[i - 1]) + share * (float(stations[i]) - float(stations[i - 1]))
            out[0, k] = max(float(out[0, k]), here)
            if here > 0.0:
                out[1, k] = max(float(out[1, k]), float(stations[near if here >= stations[i] else before]))
            return
        entered = upper < 0.0
        before, lower = near, upper
    out[0, k] = max(float(out[0, k]), float(stations[len(stations) - 1]))
    out[1, k] = max(float(out[1, k]), float(stations[near]))


def _nearest(x: float, y: float, arm: int, poses: FloatArray) -> int:
    """Return the station of an arm that is nearest to a place."""
    found, least = 0, _INFINITE
    for i in range(poses.shape[2]):
        dx, dy = x - float(poses[0, arm, i]), y - float(poses[1, arm, i])
        square = dx * dx + dy * dy
        if square < least:
            found, least = i, square
    return found


def _outside(
    x: float,
    y: float,
    arm: int,
    i: int,
    other: int,
    near: int,
    stations: FloatArray,
    poses: FloatArray,
    level: IntArray,
    left: FloatArray,
    right: FloatArray,
) -> float:
    """Return how far a place at a station of an arm lies off another one, whose station `near` is nearest, m."""
    cosine, sine = float(poses[2, other, near]), float(poses[3, other, near])
    dx, dy = x - float(poses[0, other, near]), y - float(poses[1, other, near])
    ds, dt = dx * cosine + dy * sine, dy * cosine - dx * sine
    gap = _GAP_BETWEEN_EDGES
    # Whether they have another level there than at their nodes.
    changed = level[arm, i] != level[arm, 0] and stations[i] > _LEVELS_PART_FROM
    other_changed = level[other, near] != level[other, 0] and stations[near] > _LEVELS_PART_FROM
    if level[arm, i] != level[other, near] and (changed or other_changed):
        across = float(poses[3, arm, i]) * cosine - float(poses[2, arm, i]) * sine
        if abs(across) < _PARALLEL:
            gap = -_OVERLAP_OF_LEVELS
    off = max(dt - float(left[other]), float(right[other]) - dt) - gap
    if (near == 0 and ds < -_BEHIND) or (near == poses.shape[2] - 1 and ds > _BEYOND):
        return max(off, _OUTSIDE)
    return off
