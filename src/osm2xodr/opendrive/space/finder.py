"""Which roads and lanes lie at a place, and where on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves import runs
from osm2xodr.defaults import SAMPLE_TOLERANCE
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive.space.curves import pose, pose_and_curvature
from osm2xodr.opendrive.space.lanes import lane_borders, lane_ranks, section_at
from osm2xodr.opendrive.space.profiles import superelevation
from osm2xodr.opendrive.space.sampling import Stations, sample_roads
from osm2xodr.opendrive.tables import ABSENT, OpenDrive

# Distance between the points by which roads are looked up, m: near enough that the nearest point of a curve lies
# next to the nearest of them.
_FIND_STEP: Final = 4.0
# Roads are looked up so far beside their reference lines at most, m; wider ones are a damage of the file.
_FIND_REACH: Final = 100.0
# How far from a lane's border a place still lies on the lane, m: rounding of what is typed in.
_FIND_SLACK: Final = 1e-6

# Rounds of the search for the foot of a perpendicular; bisection alone narrows the first 8 m to 1e-9 m in 33.
_ROUNDS: Final = 40
_CLOSE: Final = 1e-10
# Feet nearer to each other than this are the same, m.
_SAME_FOOT: Final = 1e-4


@dataclass(frozen=True, eq=False)
class Places:
    """Places on roads near points that were asked for, best first for each point.

    Places on a lane come before those beside all lanes, near the middle of their lane before those at its edge.
    """

    start: IntArray  # (points + 1,) Index of each point's first place
    point: IntArray  # (n,) Which point each place belongs to
    road: IntArray  # (n,) Index of the road
    # (n,) m
    s: FloatArray
    t: FloatArray
    # (n,) Rows of the tables: the lane that the place is on, else the nearest; `ABSENT` where there is none
    section: IntArray
    lane: IntArray
    inside: BoolArray  # (n,) Whether the place is on the lane
    # (n,) From the point to the nearest point of the road's lanes across from it, level, m; 0 inside
    distance: FloatArray
    # (n,) How far the point lies beyond the road's end (behind its start: negative), level, m; 0 beside the road
    along: FloatArray


class RoadFinder:
    """Finds road coordinates of inertial ones; keeps an index of all roads, so that it can be asked again and again.

    Parameters
    ----------
    file
        The network.
    """

    def __init__(self, file: OpenDrive) -> None:
        self._file = file
        self._stations: Stations = sample_roads(file, SAMPLE_TOLERANCE, _FIND_STEP)
        self._usable = np.flatnonzero(np.isfinite(self._stations.x) & np.isfinite(self._stations.y))
        points = np.column_stack([self._stations.x, self._stations.y])[self._usable]
        self._tree = cKDTree(points) if len(points) else None
        self._reach = min(_reach(file, self._stations), _FIND_REACH)

    def find(self, x: FloatArray, y: FloatArray) -> Places:
        """Return all roads whose lanes lie at points, or else the nearest road, for each point.

        Parameters
        ----------
        x, y : (points,)
            Inertial, m. Points that are not finite have no places.
        """
        asked = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        if self._tree is None or not len(asked):
            return _selected(_no_places(len(x)), np.zeros(0, np.int64), len(x))
        point, station = self._near(x[asked], y[asked])
        point = asked[point]
        road = self._stations.road[station]
        s = self._feet(x[point], y[point], road, station)
        places = self._places(x, y, point, road, s)
        return _selected(places, _best(self._file, places), len(x))

    def _near(self, x: FloatArray, y: FloatArray) -> tuple[IntArray, IntArray]:
        """Return pairs of points and stations where a perpendicular may stand: the nearest of each pass of a road."""
        assert self._tree is not None
        points = np.column_stack([x, y])
        nearest, _ = self._tree.query(points)
        radius = np.maximum(nearest, self._reach) + _FIND_STEP
        found = self._tree.query_ball_point(points, radius, return_sorted=True)
        count = np.array([len(item) for item in found], np.int64)
        point = np.repeat(np.arange(len(x)), count)
        station = self._usable[np.concatenate([np.asarray(item, np.int64) for item in found])]
        dx, dy = x[point] - self._stations.x[station], y[point] - self._stations.y[station]
        away = dx * dx + dy * dy
        # A local minimum within a run of stations that follow each other on one road.
        road = self._stations.road[station]
        joined = (np.diff(point) == 0) & (np.diff(station) == 1) & (np.diff(road) == 0)
        least = np.ones(len(point), np.bool_)
        least[1:] &= ~joined | (away[1:] <= away[:-1])
        least[:-1] &= ~joined | (away[:-1] <= away[1:])
        return point[least], station[least]

    def _feet(self, x: FloatArray, y: FloatArray, road: IntArray, station: IntArray) -> FloatArray:
        """Return s where the reference line is nearest to points, between the stations beside given ones.

        Newton's method on the distance along the tangent, (p - r) · e, whose slope is curvature · (p - r) · n - 1;
        a bisection where it would leave the bracket.
        """
        begin, end = self._stations.start[road], self._stations.start[road + 1] - 1
        low = self._stations.s[np.maximum(station - 1, begin)]
        high = self._stations.s[np.minimum(station + 1, end)]
        s = self._stations.s[station]
        open_ = np.arange(len(s))
        for _ in range(_ROUNDS):
            at = s[open_]
            px, py, hdg, bend = pose_and_curvature(self._file, road[open_], at)
            dx, dy = x[open_] - px, y[open_] - py
            cos, sin = np.cos(hdg), np.sin(hdg)
            ahead, beside = dx * cos + dy * sin, dy * cos - dx * sin
            low[open_] = np.where(ahead > 0, at, low[open_])
            high[open_] = np.where(ahead > 0, high[open_], at)
            slope = 1 - bend * beside
            with np.errstate(divide="ignore", invalid="ignore"):
                new = at + ahead / slope
            # At the very ends of a road the bracket closes on the end itself.
            good = (slope > 0) & (low[open_] <= new) & (new <= high[open_])
            s[open_] = np.where(good, new, 0.5 * (low[open_] + high[open_]))
            open_ = open_[np.abs(s[open_] - at) > _CLOSE]
            if not len(open_):
                break
        return s

    def _places(self, x: FloatArray, y: FloatArray, point: IntArray, road: IntArray, s: FloatArray) -> Places:
        """Return t, lane and distance of the feet of perpendiculars."""
        file = self._file
        px, py, hdg = pose(file, road, s)
        dx, dy = x[point] - px, y[point] - py
        along = dx * np.cos(hdg) + dy * np.sin(hdg)
        across = dy * np.cos(hdg) - dx * np.sin(hdg)
        level = np.cos(superelevation(file, road, s))
        t = across / level
        # Beside a kink a point lies ahead of one piece and behind the next, by less than a chord may be off; only
        # points beyond the road's end lie farther ahead or behind, and those that have no perpendicular here.
        at_end = (s <= 0) | (s >= file.roads.length[road])
        beyond = np.where(at_end | (np.abs(along) > SAMPLE_TOLERANCE), along, 0.0)
        section, lane, outside = _nearest_lane(file, road, s, t)
        aside = np.where(np.isfinite(outside), outside * level, np.abs(across))
        inside = (lane != ABSENT) & (outside <= _FIND_SLACK) & (np.abs(beyond) <= _FIND_SLACK)
        distance = np.where(inside, 0.0, np.hypot(aside, beyond))
        return Places(np.zeros(0, np.int64), point, road, s, t, section, lane, inside, distance, beyond)


def _reach(file: OpenDrive, stations: Stations) -> float:
    """Return how far any lane lies from its reference line at most, m."""
    ranks = lane_ranks(file)
    section = section_at(file, stations.road, stations.s)
    known = np.flatnonzero(section >= 0)
    reach = 0.0
    for count, first, sign in ((ranks.left_count, ranks.left, -1), (ranks.right_count, ranks.right, 1)):
        has = known[count[section[known]] > 0]
        lane = first[section[has]] + sign * (count[section[has]] - 1)
        for border in lane_borders(file, lane, stations.s[has]):
            finite = np.abs(border[np.isfinite(border)])
            reach = max(reach, float(np.max(finite, initial=0.0)))
    return reach


def _nearest_lane(
    file: OpenDrive, road: IntArray, s: FloatArray, t: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return section and lane at or nearest to s, t of roads, and how far t lies outside of the lane, m."""
    section = section_at(file, road, s)
    lanes = np.full(len(s), ABSENT)
    outside = np.full(len(s), np.inf)
    known = np.flatnonzero(section != ABSENT)
    first = file.lanes.start[section[known]]
    count = file.lanes.start[section[known] + 1] - first
    place = np.repeat(known, count)
    lane = runs(first, count)
    beside = np.flatnonzero((file.lanes.id[lane] != 0) & (file.lanes.id[lane] != ABSENT))
    place, lane = place[beside], lane[beside]
    inner, outer = lane_borders(file, lane, s[place])
    low, high = np.minimum(inner, outer), np.maximum(inner, outer)
    off = np.maximum(np.maximum(low - t[place], t[place] - high), 0.0)
    middle = np.abs(t[place] - 0.5 * (low + high))
    off, middle = np.where(np.isfinite(off), off, np.inf), np.where(np.isfinite(middle), middle, np.inf)
    # The best of each place comes last and stays.
    order = np.lexsort((lane, middle, off, place))[::-1]
    lanes[place[order]] = lane[order]
    outside[place[order]] = off[order]
    lanes[~np.isfinite(outside)] = ABSENT
    return section, lanes, outside


def _best(file: OpenDrive, places: Places) -> IntArray:
    """Return the rows to keep, in order: for each point all that are inside, or else the nearest."""
    middle = np.full(len(places.s), np.inf)
    has = np.flatnonzero(places.lane != ABSENT)
    inner, outer = lane_borders(file, places.lane[has], places.s[has])
    middle[has] = np.abs(places.t[has] - 0.5 * (inner + outer))
    order = np.lexsort((places.s, places.road, middle, places.distance, ~places.inside, places.point))
    point, road, s = places.point[order], places.road[order], places.s[order]
    first = np.ones(len(order), np.bool_)
    first[1:] = np.diff(point) != 0
    kept = order[places.inside[order] | first]
    # A foot can be found from two stations.
    point, road, s = places.point[kept], places.road[kept], places.s[kept]
    by_road = np.lexsort((s, road, point))
    again = np.zeros(len(kept), np.bool_)
    same = (np.diff(point[by_road]) == 0) & (np.diff(road[by_road]) == 0) & (np.diff(s[by_road]) < _SAME_FOOT)
    again[np.maximum(by_road[1:], by_road[:-1])[same]] = True
    rows: IntArray = kept[~again]
    return rows


def places_on(file: OpenDrive, road: IntArray, s: FloatArray, t: FloatArray) -> Places:
    """Return places that are given in road coordinates, each for a point of its own, all (n,)."""
    section, lane, outside = _nearest_lane(file, road, s, t)
    inside = (lane != ABSENT) & (outside <= _FIND_SLACK)
    level = np.cos(superelevation(file, road, s))
    distance = np.where(inside, 0.0, np.where(np.isfinite(outside), outside, np.abs(t)) * level)
    point = np.arange(len(s))
    start = np.arange(len(s) + 1)
    return Places(start, point, road, s, t, section, lane, inside, distance, np.zeros(len(s)))


def _no_places(points: int) -> Places:
    """Return a table without places."""
    none, flat, never = np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.bool_)
    return Places(np.zeros(points + 1, np.int64), none, none, flat, flat, none, none, never, flat, flat)


def _selected(places: Places, rows: IntArray, points: int) -> Places:
    """Return some rows of a table."""
    point = places.point[rows]
    start = np.searchsorted(point, np.arange(points + 1)).astype(np.int64)
    return Places(
        start,
        point,
        *(
            getattr(places, name)[rows]
            for name in ("road", "s", "t", "section", "lane", "inside", "distance", "along")
        ),
    )
