"""Arms that ways through their own junction run over are cut back to where these have left them.

Trims say where the areas of arms are apart. Ways through a junction may lie outside of all of these: on the outside
of a bend from arm to arm, or where they swing out. What they cover belongs to the junction.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import pose, project, ranks
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.pose_to_pose import detours
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Ways are looked at at places this far apart, m.
_SPACING: Final = 1.0
# They run over an arm where their lane reaches farther into its carriageway than this, m, farther out than the first
# and not as far as the second of these, m. Choices.
_OVERLAP: Final = 0.3
_FIRST: Final = 2.0
_FARTHEST: Final = 40.0
# Arms may bend aside by this much up to there, m.
_BEND: Final = 10.0
# What is left between an arm and the ways that ran over it, m. A choice.
_CLEARANCE: Final = 0.5


def clear_overrun_arms(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads, trim: FloatArray
) -> FloatArray:
    """Return how much each street end gives to its junction so that no way through it runs over the arm, (ends,), m.

    `layout` is that of the parts, `trim` what ends give at least.
    """
    # Detours, which may be as long as the earth is large, are left out: nobody drives them.
    connecting = connecting.chosen(~detours(connecting.plan_view) | (connecting.entry == connecting.exit))
    row, arm = _others(ends, layout, parts, connecting)
    far = np.zeros(len(trim))
    if len(row):
        np.maximum.at(far, *_overrun(parts, connecting, row, arm))
    wanted = np.where(far > 0, layout.trim + far + _CLEARANCE, 0.0)
    return np.maximum(trim, np.minimum(wanted, layout.most))


def _others(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> tuple[IntArray, IntArray]:
    """Return pairs of connecting roads and street ends of their junction, at one level, that they do not join."""
    street_end = parts.street_end()
    count = np.array([len(arms) for arms in layout.arms], np.int64)
    first = np.cumsum(count) - count
    arms = np.array([end for group in layout.arms for end in group], np.int64)
    each = count[connecting.junction]
    row = np.repeat(np.arange(len(connecting.junction)), each)
    arm = arms[first[connecting.junction][row] + ranks(each)]
    entry, exit_ = street_end[connecting.entry][row], street_end[connecting.exit][row]
    level = np.zeros(len(row), bool)
    for own in (entry, exit_):
        level |= (ends.layer[own] == ends.layer[arm]) | (ends.node[own] == ends.node[arm])
    keep = (arm != entry) & (arm != exit_) & (parts.road_end[arm] >= 0) & level
    return row[keep], arm[keep]


def _overrun(
    parts: RoadParts, connecting: ConnectingRoads, row: IntArray, arm: IntArray
) -> tuple[IntArray, FloatArray]:
    """Return street ends, and how far out from the end of their road places of connecting roads lie on it, m."""
    count = np.maximum((connecting.length / _SPACING).astype(np.int64), 1)
    curve = np.repeat(np.arange(len(count)), count)
    x, y, _ = pose(connecting.plan_view, curve, (ranks(count) + 0.5) * (connecting.length / count)[curve])
    start = np.cumsum(count) - count
    pair = np.repeat(np.arange(len(row)), count[row])
    place = start[row][pair] + ranks(count[row])
    x, y = x[place], y[place]
    half = np.maximum(connecting.entry_width, connecting.exit_width)[row][pair] / 2 - _OVERLAP
    end = parts.road_end[arm]
    sections = {number: parts.at_end(number).section for number in np.unique(end).tolist()}
    right, left = np.array([(sections[k].right_edge, sections[k].left_edge) for k in end.tolist()]).T
    road = end // 2
    at_end = end % 2 == 1
    near = _near(parts, road, at_end, pair, x, y, (half + np.maximum(left, -right)[pair]))
    pair, x, y, half = pair[near], x[near], y[near], half[near]
    s, t, distance = project(parts.plan_view, road[pair], x, y)
    out = np.where(at_end[pair], parts.length[road[pair]] - s, s)
    on = (t < left[pair] + half) & (t > right[pair] - half) & (distance < np.abs(t) + 1e-3)
    on &= (out > _FIRST) & (out < _FARTHEST)
    return arm[pair[on]], out[on]


def _near(
    parts: RoadParts,
    road: IntArray,
    at_end: BoolArray,
    pair: IntArray,
    x: FloatArray,
    y: FloatArray,
    reach: FloatArray,
) -> IntArray:
    """Return which places lie ahead of the road end of their pair and not far aside."""
    px, py, hdg = pose(parts.plan_view, road, np.where(at_end, parts.length[road], 0.0))
    hdg = hdg + np.where(at_end, np.pi, 0.0)
    dx, dy, cos, sin = x - px[pair], y - py[pair], np.cos(hdg)[pair], np.sin(hdg)[pair]
    ahead, aside = dx * cos + dy * sin, dy * cos - dx * sin
    return np.flatnonzero((ahead > 0) & (ahead < _FARTHEST) & (np.abs(aside) < reach + _BEND))
