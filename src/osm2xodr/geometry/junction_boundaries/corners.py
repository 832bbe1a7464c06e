"""The arms of junctions, counter-clockwise, and what bounds a junction between one arm and the next."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    cosine,
    cubic_value,
    hypot,
    lengths,
    pose,
    ranks,
    repeated,
    sine,
    starts,
    unique_all,
    unique_first,
)
from osm2xodr.geometry.junction_boundaries import defaults
from osm2xodr.geometry.junction_boundaries.edges import Edges, crossings, edge_lines, near_segments, products
from osm2xodr.model import BoolArray, FloatArray, IntArray, Lane, RoadMap
from osm2xodr.system import record

# Narrower lanes are none, m.
_NO_WIDTH: Final = 0.01


@record(eq=False)
class Arms:
    """Arms of junctions, and the ends of connecting roads there.

    End number 2 k is the start of the k-th connecting road, 2 k + 1 its end. An arm is seen outwards, away from its
    junction: u is how far to the left a place on its end face lies, m.
    """

    road: IntArray  # (arms,) Index of the plain road in the road map
    at_start: BoolArray  # (arms,) Whether its start touches the junction
    # (arms,) Next arm counter-clockwise, the arms of the junction and the rank among them
    following: IntArray
    count: IntArray
    rank: IntArray
    junction: IntArray  # (arms,) Id of the junction
    arm: IntArray  # (ends,) The arm at each end of a connecting road
    # (ends,) u of the edges of the connecting road there
    left: FloatArray
    right: FloatArray
    # (arms,) u of the outermost edges of all connecting roads, and where these are, local
    outer_left: FloatArray
    outer_right: FloatArray
    x: FloatArray
    y: FloatArray
    # (arms,) Direction of u
    nx: FloatArray
    ny: FloatArray

    @classmethod
    def of(cls, road_map: RoadMap, edges: Edges) -> Arms:
        """Return the arms that the connecting roads of a road map touch."""
        index = {road.id: k for k, road in enumerate(road_map.roads)}
        keys, junction = [], []
        for k in edges.road.tolist():
            road = road_map.roads[k]
            for link in (road.predecessor, road.successor):
                if link is not None:
                    keys.append(2 * index[link.id] + (not link.at_start))
                    junction.append(road.junction)
        known, first, arm, _ = unique_all(np.array(keys, np.int64))
        road, at_end = known // 2, known % 2 == 1
        s = np.where(at_end, lengths(road_map.plan_view, road), 0.0)
        x, y, hdg = pose(road_map.plan_view, road, s)
        outwards = np.where(at_end, -1.0, 1.0)
        nx, ny = -sine(hdg) * outwards, cosine(hdg) * outwards
        left, right = _reached(edges, arm, (x, y), (nx, ny))
        outer_left, outer_right = np.full(len(known), -np.inf), np.full(len(known), np.inf)
        np.maximum.at(outer_left, arm, left)
        np.minimum.at(outer_right, arm, right)
        of = np.array(junction, np.int64)[first]
        middle = 0.5 * (outer_left + outer_right)
        following, count, rank = _in_order(of, x + middle * nx, y + middle * ny)
        columns = following, count, rank, of, arm, left, right, outer_left, outer_right, x, y, nx, ny
        return cls(road, ~at_end, *columns)

    def at(self, arm: IntArray, u: FloatArray) -> FloatArray:
        """Return x, y (n, 2) at u (n,) of end faces, m."""
        return np.column_stack([self.x[arm] + u * self.nx[arm], self.y[arm] + u * self.ny[arm]])


def _reached(
    edges: Edges, arm: IntArray, place: tuple[FloatArray, FloatArray], normal: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return u of the left and the right edge of connecting roads at their ends, (ends,), m."""
    end = np.arange(2 * len(edges.road))
    s = np.where(end % 2 == 1, edges.length[end // 2], 0.0)
    found = []
    for left in (0, 1):
        x, y = edges.at(end // 2 * 2 + left, s).T
        found.append((x - place[0][arm]) * normal[0][arm] + (y - place[1][arm]) * normal[1][arm])
    return np.maximum(*found), np.minimum(*found)


def _in_order(junction: IntArray, x: FloatArray, y: FloatArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the next arm counter-clockwise, the number of arms of the junction, and each arm's rank, (arms,)."""
    _, _, group, count = unique_all(junction)
    angle = arctan2(y - (np.bincount(group, y) / count)[group], x - (np.bincount(group, x) / count)[group])
    order = np.lexsort((angle, group))
    first = starts(count)[group[order]]
    rank = np.arange(len(order)) - first
    following = np.empty(len(order), np.int64)
    following[order] = order[first + (rank + 1) % count[group[order]]]
    ranks = np.empty(len(order), np.int64)
    ranks[order] = rank
    return following, count[group], ranks


def lanes_across(road_map: RoadMap, arms: Arms) -> tuple[list[tuple[int, int] | None], FloatArray, FloatArray]:
    """Return the lanes of each arm that its junction's roads reach, and u of these lanes' right and left edges, m.

    Lanes are the rightmost and the leftmost one, seen outwards; None for all.
    """
    offset = cubic_value(
        road_map.lane_offset, arms.road, np.where(arms.at_start, 0.0, lengths(road_map.plan_view, arms.road))
    ).tolist()
    length = lengths(road_map.plan_view, arms.road).tolist()
    lanes: list[tuple[int, int] | None] = []
    right, left = [], []
    rows = zip(*(c.tolist() for c in (arms.road, arms.at_start, arms.outer_right, arms.outer_left)), strict=True)
    for k, (road, at_start, low, high) in enumerate(rows):
        section = road_map.roads[road].lane_sections[0 if at_start else -1]
        found = _borders(section.lanes, 0.0 if at_start else length[k] - section.s, offset[k])
        if not at_start:
            found = [(lane, -b, -a) for lane, a, b in found]
        found.sort(key=lambda item: item[1])
        # The joint ends where lanes do that are nearest to the edges of the roads.
        across = [item for item in found if low < 0.5 * (item[1] + item[2]) < high] or [
            item for item in found if item[2] > low + defaults.SAME_EDGE and item[1] < high - defaults.SAME_EDGE
        ]
        if not across:
            lanes.append(None)
            right.append(low)
            left.append(high)
            continue
        lanes.append(None if len(across) == len(found) else (across[0][0], across[-1][0]))
        right.append(across[0][1])
        left.append(across[-1][2])
    return lanes, np.array(right), np.array(left)


def _borders(lanes: tuple[Lane, ...], ds: float, offset: float) -> list[tuple[int, float, float]]:
    """Return the id and t of the right and the left edge of all lanes with a width at ds in their section, m."""
    out: list[tuple[int, float, float]] = []
    for side in (1, -1):
        t = offset
        for lane in sorted((item for item in lanes if item.id * side > 0), key=lambda item: abs(item.id)):
            record = next((w for w in reversed(lane.widths) if w.s <= ds), lane.widths[0])
            beyond = t + side * record.at(ds - record.s)
            if abs(beyond - t) > _NO_WIDTH:
                out.append((lane.id, min(t, beyond), max(t, beyond)))
            t = beyond
    return out


@record(eq=False)
class Pieces:
    """Pieces of edges, in the order of arms and counter-clockwise behind each of them, (n,)."""

    arm: IntArray
    edge: IntArray  # Number of the edge, as of `Edges`
    # s where they begin and end, m
    begin: FloatArray
    end: FloatArray
    gap: FloatArray  # (arms,) Distance between the ends of pieces that should meet, m

    def replaced(self, arms: IntArray, other: Pieces) -> Pieces:
        """Return pieces in which those behind some arms are others."""
        keep = ~np.isin(self.arm, arms)
        arm = np.concatenate([self.arm[keep], other.arm])
        order = np.argsort(arm, kind="stable")
        edge, begin, end = (
            np.concatenate([getattr(self, k)[keep], getattr(other, k)])[order] for k in ("edge", "begin", "end")
        )
        gap = self.gap.copy()
        gap[arms] = other.gap[arms]
        return Pieces(arm[order], edge, begin, end, gap)


def first_edges(arms: Arms) -> tuple[IntArray, IntArray, BoolArray]:
    """Return the edges that bound junctions where they leave an arm and reach the next, and which are the same."""
    near = defaults.SAME_EDGE
    leaves = arms.left >= arms.outer_left[arms.arm] - near
    arrives = arms.right <= arms.outer_right[arms.arm] + near
    # The other end of each connecting road, and how many arms farther counter-clockwise that lies.
    other = np.arange(len(arms.arm)) ^ 1
    count = arms.count[arms.arm]
    ahead = (arms.rank[arms.arm[other]] - arms.rank[arms.arm]) % count
    back = np.where(ahead == 0, count, count - ahead)
    ahead = np.where(ahead == 0, count, ahead)
    direct = leaves & arrives[other] & (arms.arm[other] == arms.following[arms.arm])
    # The outermost ones: those that lead to the nearest arm, then those that reach farthest aside.
    first = _best(arms, leaves, (arms.left - arms.right[other], -ahead, direct))
    second = _best(arms, arrives, (arms.left[other] - arms.right, -back))[arms.following]
    along = direct[first]
    # An edge has the number of the end that it leaves with the junction on its left.
    return first, np.where(along, first, second ^ 1), along


def _best(arms: Arms, good: BoolArray, keys: tuple[FloatArray | IntArray | BoolArray, ...]) -> IntArray:
    """Return for each arm the end with the greatest keys, the last one first, of those that are good, (arms,)."""
    rounded = [np.round(np.asarray(key, float), 1) for key in keys]
    order = np.lexsort((-np.arange(len(good)), *rounded, good, arms.arm))
    return np.asarray(order[np.searchsorted(arms.arm[order], np.arange(len(arms.road)), side="right") - 1])


def find_pieces(arms: Arms, edges: Edges) -> Pieces:
    """Return what bounds junctions between neighbouring arms: one edge, or one and another that it meets."""
    first, second, along = first_edges(arms)
    split = np.flatnonzero(~along)
    leave, join, gap = np.zeros((3, len(first)))
    leave[split], join[split], gap[split] = _meetings(first[split], second[split], edges)
    count = np.where(along, 1, 2)
    arm = repeated(count)
    last = ranks(count) > 0
    edge = np.where(last, second[arm], first[arm])
    length = edges.length[edge // 2]
    whole = np.where(edge % 2 == 0, length, 0.0)
    begin = np.where(last, join[arm], length - whole)
    return Pieces(arm, edge, begin, np.where(last | along[arm], whole, leave[arm]), gap)


def _meetings(first: IntArray, second: IntArray, edges: Edges) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where edges meet others, s on either, and their distance there, (n,), m: the first crossing on the way.

    Those that do not cross meet where they are nearest, or as near as `SAME_EDGE` first.
    """
    one, other = edge_lines(edges, first), edge_lines(edges, second)
    every = np.arange(len(first))
    a, b, pair = near_segments(one, other, every, every)
    u, v, _ = crossings(one, other, a, b)
    rows = np.flatnonzero(~np.isnan(u))
    rows = rows[np.lexsort((a[rows] + u[rows], pair[rows]))]
    crossing, best = unique_first(pair[rows])
    best = rows[best]
    leave, join, distance = np.zeros((3, len(first)))
    leave[crossing], join[crossing] = one.between(a[best], u[best]), other.between(b[best], v[best])
    apart = np.setdiff1d(every, crossing)
    a, b, pair = products(one.start[apart], one.start[apart + 1], other.start[apart], other.start[apart + 1])
    between = hypot(*(other.xy[b] - one.xy[a]).T)
    nearest = np.lexsort((a, np.maximum(between, defaults.SAME_EDGE), pair))
    nearest = nearest[unique_first(pair[nearest])[1]]
    leave[apart], join[apart], distance[apart] = one.s[a[nearest]], other.s[b[nearest]], between[nearest]
    return leave, join, distance
