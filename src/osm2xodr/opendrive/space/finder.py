"""Which roads and lanes lie at a place, and where on them; files with too many roads on each other are refused."""

from __future__ import annotations

from typing import Final, NoReturn

import numpy as np

from osm2xodr.curves import PointTree, ranks, repeated, unique_rows
from osm2xodr.defaults import SAMPLE_TOLERANCE
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive.space.positions import (
    lane_borders,
    lane_middles,
    lanes_of,
    outermost_lanes,
    pose,
    pose_and_curvature,
    section_at,
    superelevation,
)
from osm2xodr.opendrive.space.sampling import Stations, sample_roads
from osm2xodr.opendrive.tables import ABSENT, OpenDrive
from osm2xodr.system import record

# Distance between the points by which roads are looked up, m: so small that the nearest place of a curve lies next to
# the nearest of them.
_FIND_STEP: Final = 4.0
# Roads are looked up at most this far beside their reference lines, m; no sound file has wider ones.
_FIND_REACH: Final = 100.0
# How far beyond a lane's border a place still counts as on the lane, m: coordinates that are typed in are rounded.
_FIND_SLACK: Final = 1e-6

# Rounds of the search for the foot of a perpendicular, and the step after which it ends, m; bisection alone narrows
# the first 8 m to 1e-9 m in 33 rounds.
_ROUNDS: Final = 40
_LAST_STEP: Final = 1e-10
# Feet nearer to each other than this are the same, m.
_SAME_FOOT: Final = 1e-4

# Pieces of this length of all roads are counted in cells of this size, m.
_STEP: Final = 4.0
_CELL: Final = 12.0
# The sum of the squares of their numbers, or that for each record of the plan view if it is larger, is what is
# compared at most. Choices: of 20 files of this program and 4 of another one the densest has 51 for each record.
_CROWD: Final = 2e6
_CROWD_EACH: Final = 300.0
# Most cells at all, likewise: the same files have up to 8 for each record.
_CELLS: Final = 3e6
_CELLS_EACH: Final = 1e3
# Places farther away than this are left out, m: they come from damaged numbers.
_FARTHEST: Final = 1e9


@record(eq=False)
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
    # (n,) Rows of the lane section, and of the lane that the place is on or else the nearest; `ABSENT` without one
    section: IntArray
    lane: IntArray
    inside: BoolArray  # (n,) Whether the place is on the lane
    # (n,) From the point to the nearest point of the road's lanes across from it, level, m; 0 inside
    distance: FloatArray


class RoadFinder:
    """Finds the road coordinates of inertial ones; keeps an index of all roads of a file for many queries."""

    def __init__(self, file: OpenDrive) -> None:
        self._file = file
        self._stations: Stations = sample_roads(file, SAMPLE_TOLERANCE, _FIND_STEP)
        self._usable = np.flatnonzero(np.isfinite(self._stations.x) & np.isfinite(self._stations.y))
        points = np.column_stack([self._stations.x, self._stations.y])[self._usable]
        self._tree = PointTree(points)
        section = section_at(file, self._stations.road, self._stations.s)
        lanes = outermost_lanes(file, section)
        borders = [border for has, lane in lanes for border in lane_borders(file, lane, self._stations.s[has])]
        lateral = np.abs(np.concatenate(borders))
        self._reach = min(float(np.max(lateral[np.isfinite(lateral)], initial=0.0)), _FIND_REACH)

    def find(self, x: FloatArray, y: FloatArray) -> Places:
        """Return all roads whose lanes lie at inertial x, y, (points,), m, or else the nearest road, for each point.

        Points that are not finite have no places.
        """
        asked = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        point, station = self._near(x[asked], y[asked])
        point, road = asked[point], self._stations.road[station]
        places = self._places(x, y, point, road, self._feet(x[point], y[point], road, station))
        return _selected(places, _best(self._file, places), len(x))

    def _near(self, x: FloatArray, y: FloatArray) -> tuple[IntArray, IntArray]:
        """Return pairs of points and stations near possible perpendiculars: the nearest of each pass of a road."""
        points = np.column_stack([x, y])
        nearest, _ = self._tree.nearest(points)
        point, found = self._tree.within(points, np.maximum(nearest, self._reach) + _FIND_STEP)
        found = found[np.lexsort((found, point))]
        station = self._usable[found]
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
        todo = np.arange(len(s))
        for _ in range(_ROUNDS):
            at = s[todo]
            px, py, hdg, bend = pose_and_curvature(self._file, road[todo], at)
            dx, dy = x[todo] - px, y[todo] - py
            cos, sin = np.cos(hdg), np.sin(hdg)
            ahead, beside = dx * cos + dy * sin, dy * cos - dx * sin
            low[todo] = np.where(ahead > 0, at, low[todo])
            high[todo] = np.where(ahead > 0, high[todo], at)
            slope = 1 - bend * beside
            with np.errstate(divide="ignore", invalid="ignore"):
                new = at + ahead / slope
            # At the very ends of a road the bracket closes on the end itself.
            good = (slope > 0) & (low[todo] <= new) & (new <= high[todo])
            s[todo] = np.where(good, new, 0.5 * (low[todo] + high[todo]))
            todo = todo[np.abs(s[todo] - at) > _LAST_STEP]
            if not len(todo):
                break
        return s

    def _places(self, x: FloatArray, y: FloatArray, point: IntArray, road: IntArray, s: FloatArray) -> Places:
        """Return the places at the feet of perpendiculars."""
        file = self._file
        px, py, hdg = pose(file, road, s)
        dx, dy = x[point] - px, y[point] - py
        along = dx * np.cos(hdg) + dy * np.sin(hdg)
        across = dy * np.cos(hdg) - dx * np.sin(hdg)
        level = np.cos(superelevation(file, road, s))
        t = across / level
        # Beside a kink a point lies ahead of one piece and behind the next, by less than a chord's error. Only points
        # beyond the road's end, and those without a perpendicular here, lie farther ahead or behind.
        at_end = (s <= 0) | (s >= file.roads.length[road])
        beyond = np.where(at_end | (np.abs(along) > SAMPLE_TOLERANCE), along, 0.0)
        section, lane, outside = _nearest_lane(file, road, s, t)
        lateral = np.where(np.isfinite(outside), outside * level, np.abs(across))
        inside = (lane != ABSENT) & (outside <= _FIND_SLACK) & (np.abs(beyond) <= _FIND_SLACK)
        distance = np.where(inside, 0.0, np.hypot(lateral, beyond))
        return Places(np.zeros(0, np.int64), point, road, s, t, section, lane, inside, distance)


def _nearest_lane(
    file: OpenDrive, road: IntArray, s: FloatArray, t: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return section and lane at or nearest to s, t of roads, and how far t lies outside the lane, m; all (n,)."""
    section = section_at(file, road, s)
    lanes = np.full(len(s), ABSENT)
    outside = np.full(len(s), np.inf)
    place, lane = lanes_of(file, section)
    beside = np.flatnonzero((file.lanes.id[lane] != 0) & (file.lanes.id[lane] != ABSENT))
    place, lane = place[beside], lane[beside]
    inner, outer = lane_borders(file, lane, s[place])
    low, high = np.minimum(inner, outer), np.maximum(inner, outer)
    off = np.maximum(np.maximum(low - t[place], t[place] - high), 0.0)
    middle = np.abs(t[place] - 0.5 * (low + high))
    off, middle = np.where(np.isfinite(off), off, np.inf), np.where(np.isfinite(middle), middle, np.inf)
    # The best of each place comes last and stays.
    order = np.lexsort((lane, middle, off, place))[::-1]
    lanes[place[order]], outside[place[order]] = lane[order], off[order]
    lanes[~np.isfinite(outside)] = ABSENT
    return section, lanes, outside


def _best(file: OpenDrive, places: Places) -> IntArray:
    """Return the rows to keep, in order: for each point all that are inside, or else the nearest."""
    lateral = np.abs(places.t - lane_middles(file, places.lane, places.s))
    lateral[places.lane == ABSENT] = np.inf
    order = np.lexsort((places.s, places.road, lateral, places.distance, ~places.inside, places.point))
    first = np.diff(places.point[order], prepend=-1) != 0
    kept = order[places.inside[order] | first]
    # A foot can be found from two stations.
    point, road, s = places.point[kept], places.road[kept], places.s[kept]
    by_road = np.lexsort((s, road, point))
    again = np.zeros(len(kept), np.bool_)
    same = (np.diff(point[by_road]) == 0) & (np.diff(road[by_road]) == 0) & (np.diff(s[by_road]) < _SAME_FOOT)
    again[np.maximum(by_road[1:], by_road[:-1])[same]] = True
    out: IntArray = kept[~again]
    return out


def places_on(file: OpenDrive, road: IntArray, s: FloatArray, t: FloatArray) -> Places:
    """Return places that are given in road coordinates, each for a point of its own, all (n,)."""
    section, lane, outside = _nearest_lane(file, road, s, t)
    inside = (lane != ABSENT) & (outside <= _FIND_SLACK)
    level = np.cos(superelevation(file, road, s))
    distance = np.where(inside, 0.0, np.where(np.isfinite(outside), outside, np.abs(t)) * level)
    return Places(np.arange(len(s) + 1), np.arange(len(s)), road, s, t, section, lane, inside, distance)


def _selected(places: Places, rows: IntArray, points: int) -> Places:
    """Return some rows of a table."""
    point = places.point[rows]
    start = np.searchsorted(point, np.arange(points + 1)).astype(np.int64)
    columns = ("road", "s", "t", "section", "lane", "inside", "distance")
    return Places(start, point, *(getattr(places, name)[rows] for name in columns))


def refuse_crowds(file: OpenDrive) -> None:
    """Raise `InputError`, with the road, where too many roads lie on each other, or they cover too much."""
    length = np.maximum(np.nan_to_num(file.roads.length), 0.0)
    count = np.where(np.diff(file.plan_view.start) > 0, np.ceil(length / _STEP), 0.0).astype(np.int64)
    road = repeated(count)
    s = (ranks(count) + 0.5) * np.repeat(length / np.maximum(count, 1), count)
    x, y, hdg = pose(file, road, s)
    low, high = np.zeros(len(s)), np.zeros(len(s))
    for has, lane in outermost_lanes(file, section_at(file, road, s)):
        _, outer = lane_borders(file, lane, s[has])
        low[has], high[has] = np.fmin(low[has], outer), np.fmax(high[has], outer)
    good = (np.abs(x) < _FARTHEST) & (np.abs(y) < _FARTHEST) & np.isfinite(hdg)
    across = np.where(good, np.maximum(np.ceil((high - low) / _CELL), 1.0), 0.0).astype(np.int64)
    records = len(file.plan_view.s)
    if across.sum() > max(_CELLS, _CELLS_EACH * records):
        _refuse(file, road, s, int(across.argmax()), "roads cover too large an area to compare them, most")
    of = repeated(across)
    t = low[of] + (ranks(across) + 0.5) * ((high - low) / np.maximum(across, 1))[of]
    places = x[of] - np.sin(hdg[of]) * t, y[of] + np.cos(hdg[of]) * t
    cells = unique_rows(np.column_stack([np.floor(axis / _CELL).astype(np.int64) for axis in places]))
    if float((cells.counts.astype(np.float64) ** 2).sum()) > max(_CROWD, _CROWD_EACH * records):
        worst = int(of[cells.first[cells.counts.argmax()]])
        _refuse(file, road, s, worst, "too many roads lie on each other to compare them, most")


def _refuse(file: OpenDrive, road: IntArray, s: FloatArray, row: int, words: str) -> NoReturn:
    place = f"road {file.roads.id[int(road[row])]!r}, s = {s[row]:.0f} m"
    raise InputError(f"{file.path}: {words} at {place}; look at the file there, or choose a part of it")
