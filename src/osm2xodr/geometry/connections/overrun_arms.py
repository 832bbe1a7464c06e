"""Arms that ways through their own junction run over are cut back to where these have left them.

Trims say where the areas of arms are apart. Ways through a junction may lie outside of all of these: on the outside
of a bend from arm to arm, or where they swing out. What they cover belongs to the junction.
"""

from __future__ import annotations

from itertools import chain
from typing import Final

import numpy as np

from osm2xodr.curves import (
    Table,
    blocks,
    cosine,
    owners,
    pose,
    project,
    ranks,
    repeated,
    runs,
    sine,
    sorted_unique,
    starts,
    unique_inverse,
)
from osm2xodr.geometry.connections.connecting_roads import ConnectingRoads
from osm2xodr.geometry.connections.corner_paths import half_carriageways
from osm2xodr.geometry.connections.pose_to_pose import detours
from osm2xodr.geometry.defaults import SHORTEST_ROAD, SHORTEST_STREET, SNAPPED
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts, end_poses
from osm2xodr.geometry.plan_view import StreetEnds
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.system import map_parallel, record

# Ways are looked at at places this far apart, m.
_SPACING: Final = 1.0
# Pieces of ways, at most this long, m, are first looked at as a whole. A choice, for speed alone.
_PIECE: Final = 4.0
# They run over an arm where their lane reaches farther into its carriageway than this, m, farther out than the first
# and not as far as the second of these, m. Choices.
_OVERLAP: Final = 0.2
_FIRST: Final = 1.5
_FARTHEST: Final = 40.0
# Arms on another layer lie at the height of their junction up to here, m. A choice: a steep ramp rises 0.5 m on it.
_AT_JUNCTION: Final = 5.0
# Arms may bend aside by this much up to there, m.
_BEND: Final = 10.0
# Ways and streets are compared at these shares of the ways.
_SHARES: Final = np.linspace(0.02, 0.98, 25)
# What is left between an arm and the ways that ran over it, m. A choice.
_CLEARANCE: Final = 0.5
# Cuts of a short street below this, m, are not worth it.
_LEAST_CUT: Final = 0.3
# Pairs of ways and arms that a process looks at: enough to be worth a copy of it.
_PAIRS_PER_SHARE: Final = 15000


def clear_arms(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads, jobs: int = 1
) -> FloatArray:
    """Return how much each street end gives so that no way runs over its arm, (ends,), m, even of a short street.

    An end may take what the other end of its street has not, but for the shortest street, and the ramp of a tunnel:
    what runs over that lies at its height. `layout` is that of the parts; `jobs` processes work on it.
    """
    trim = layout.trim
    far = np.zeros(len(trim))
    arm, out = ways_over_arms(ends, layout, parts, connecting, jobs)
    np.maximum.at(far, arm, out)
    more = np.where(far > 0, far + _CLEARANCE, 0.0).reshape(-1, 2)
    least = np.where((layout.junction.reshape(-1, 2) >= 0).all(1), SHORTEST_STREET, SHORTEST_ROAD) + SNAPPED
    spare = np.maximum(ends.length[0::2] - trim.reshape(-1, 2).sum(1) - least, 0.0)
    share = np.minimum(1.0, spare / np.maximum(more.sum(1), 1e-9))
    given = (more * share[:, None]).ravel()
    cut: FloatArray = trim + np.where(given > _LEAST_CUT, given, 0.0)
    return cut


def ways_over_arms(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads, jobs: int = 1
) -> tuple[IntArray, FloatArray]:
    """Return the street ends that ways through their junction run over, and how far out from the arm's end, (n,), m.

    There is a row for each place found. Detours, which may be as long as the earth is large, are left out: nobody
    drives them. `jobs` processes look for them.
    """
    connecting = connecting.chosen(~detours(connecting.plan_view) | (connecting.entry == connecting.exit))
    row, arm, farthest = _others(ends, layout, parts, connecting)
    if not len(row):
        return arm, np.zeros(0)
    shares = list(blocks(len(row), _PAIRS_PER_SHARE))
    found = list(map_parallel(lambda share: _overrun(parts, connecting, row[share], arm[share]), shares, jobs))
    pair = np.concatenate([share.start + pair for share, (pair, _) in zip(shares, found, strict=True)])
    out = np.concatenate([out for _, out in found])
    near = out < farthest[pair]
    return arm[pair[near]], out[near]


def beyond_streets(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> FloatArray:
    """Return how far ways leave the carriageways of all streets at the nodes of their junction, (n,), m."""
    if not len(connecting.junction):
        return np.zeros(0)
    first, street = _streets_at(ends, layout)
    count = np.diff(first)[connecting.junction]
    row, street = repeated(count), street[runs(first[connecting.junction], count)]
    every, places = np.arange(len(count)), len(_SHARES)
    x, y, _ = pose(connecting.plan_view, np.repeat(every, places), (connecting.length[:, None] * _SHARES).ravel())
    x, y = (np.reshape(column, (-1, places))[row].ravel() for column in (x, y))
    distance = project(ends.lines, np.repeat(street, places), x, y)[2].reshape(-1, places)
    nearest = np.full((len(count), places), np.inf)
    np.minimum.at(nearest, row, distance)
    arms = parts.street_end()[np.stack([connecting.entry, connecting.exit])]
    half = np.maximum(half_carriageways(ends, arms[0]), half_carriageways(ends, arms[1]))
    return np.asarray(nearest.max(axis=1) - half)


def _streets_at(ends: StreetEnds, layout: JunctionLayout) -> tuple[IntArray, IntArray]:
    """Return the streets at the nodes of each junction, and where those of each begin, (junctions + 1,)."""
    junction = np.full(ends.node.max(initial=0) + 2, -1)  # By node; the last one stands for none
    junction[list(chain.from_iterable(layout.nodes))] = owners(starts([len(nodes) for nodes in layout.nodes]))
    at = junction[ends.node]
    streets = len(at) // 2
    number, street = np.divmod(sorted_unique((at * streets + np.arange(len(at)) // 2)[at >= 0]), streets)
    return starts(np.bincount(number, minlength=len(layout.nodes))), street


def _others(
    ends: StreetEnds, layout: JunctionLayout, parts: RoadParts, connecting: ConnectingRoads
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return pairs of connecting roads and street ends of their junction that they do not join.

    The third item is how far from its end the arm is at their level, m.
    """
    street_end = parts.street_end()
    count = np.array([len(arms) for arms in layout.arms], np.int64)
    first = starts(count)[:-1]
    arms = np.array([end for group in layout.arms for end in group], np.int64)
    each = count[connecting.junction]
    row = repeated(each)
    arm = arms[first[connecting.junction][row] + ranks(each)]
    entry, exit_ = street_end[connecting.entry][row], street_end[connecting.exit][row]
    level = np.zeros(len(row), bool)
    for own in (entry, exit_):
        level |= (ends.layer[own] == ends.layer[arm]) | (ends.node[own] == ends.node[arm])
    keep = (arm != entry) & (arm != exit_) & (parts.road_end[arm] >= 0)
    return row[keep], arm[keep], np.where(level, _FARTHEST, _AT_JUNCTION)[keep]


@record(eq=False)
class _Arms(Table):
    """Arms seen from their junction, one for each pair with a way, (n,)."""

    road: IntArray
    at_end: BoolArray  # Whether the junction is at the road's end
    # Edges of the carriageway there, t, m
    left: FloatArray
    right: FloatArray
    # Where the road ends, local, m, and the way outwards
    x: FloatArray
    y: FloatArray
    cos: FloatArray
    sin: FloatArray

    @classmethod
    def of(cls, parts: RoadParts, end: IntArray) -> _Arms:
        """Return the arms at road ends, (n,)."""
        end, each = unique_inverse(end)
        road, at_end = end // 2, end % 2 == 1
        sections = [parts.at_end(number).section for number in end.tolist()]
        left, right = np.array([(section.left_edge, section.right_edge) for section in sections]).reshape(-1, 2).T
        x, y, hdg = end_poses(parts, end)
        hdg = hdg + np.where(at_end, np.pi, 0.0)
        return cls(road, at_end, left, right, x, y, cosine(hdg), sine(hdg)).chosen(each)

    def near(self, pair: IntArray, x: FloatArray, y: FloatArray, reach: FloatArray, more: float = 0.0) -> IntArray:
        """Return which places lie ahead of the road end of their pair and not far aside, or nearly so.

        `reach`, (n,), is that of each pair, and `more` is how far out of there they may be, all m.
        """
        dx, dy, cos, sin = x - self.x[pair], y - self.y[pair], self.cos[pair], self.sin[pair]
        reach = reach[pair] + more
        ahead, aside = dx * cos + dy * sin, dy * cos - dx * sin
        return np.flatnonzero((ahead > -reach) & (ahead < _FARTHEST + more) & (np.abs(aside) < reach + _BEND))


def _overrun(
    parts: RoadParts, connecting: ConnectingRoads, row: IntArray, arm: IntArray
) -> tuple[IntArray, FloatArray]:
    """Return for each place of a way on the arm of its pair the pair, and how far from the arm's end it lies, m."""
    arms = _Arms.of(parts, parts.road_end[arm])
    half = np.maximum(connecting.entry_width, connecting.exit_width)[row] / 2 - _OVERLAP
    reach = half + np.maximum(arms.left, -arms.right)
    # Most ways keep off the arm. No place is farther from the middle of its piece than half of its length.
    piece, x, y, _ = _places(connecting, row, (connecting.length / _PIECE).astype(np.int64) + 1)
    close = sorted_unique(piece[arms.near(piece, x, y, reach, _PIECE / 2)])
    arms, half, reach = arms.chosen(close), half[close], reach[close]
    pair, x, y, hdg = _places(connecting, row[close], np.maximum((connecting.length / _SPACING).astype(np.int64), 1))
    near = arms.near(pair, x, y, reach)
    # Both edges of the lane and its middle
    pair, x, y, hdg = (np.repeat(column[near], 3) for column in (pair, x, y, hdg))
    aside = half[pair] * np.tile([-1.0, 0.0, 1.0], len(near))
    x, y = x - aside * sine(hdg), y + aside * cosine(hdg)
    road = arms.road[pair]
    s, t, distance = project(parts.plan_view, road, x, y)
    out = np.where(arms.at_end[pair], parts.length[road] - s, s)
    on = (t < arms.left[pair]) & (t > arms.right[pair]) & (distance < np.abs(t) + 1e-3)
    on &= (out > _FIRST) & (out < _FARTHEST)
    return close[pair[on]], out[on]


def _places(
    connecting: ConnectingRoads, row: IntArray, count: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Return the middles of `count`, (ways,), equal pieces of each pair's way: the pair, x, y, m, and hdg, rad."""
    way, each = unique_inverse(row)
    length, count = connecting.length[way], count[way]
    one = repeated(count)
    x, y, hdg = pose(connecting.plan_view, way[one], (ranks(count) + 0.5) * (length / count)[one])
    pair, place = repeated(count[each]), runs(starts(count)[:-1][each], count[each])
    return pair, x[place], y[place], hdg[place]
