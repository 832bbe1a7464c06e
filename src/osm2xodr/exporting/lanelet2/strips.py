"""Strips: stretches of a road along which nothing changes that lanelets have words for."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from osm2xodr.checking import contacts_of, lane_index
from osm2xodr.curves import owners, wrapped
from osm2xodr.exporting.lanelet2.document import (
    KERB_LOW,
    LANELETS,
    LONGEST,
    MOST_TURN,
    NARROWEST,
    Mark,
    location_of,
    mark_of,
)
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, OpenDrive, Ribbons, Stations, lane_ribbons, sample_roads
from osm2xodr.system import record

# Places closer together than this along a road are one, m.
_SAME = 1e-6


@record
class StripLane:
    """A lane of a strip that becomes a lanelet."""

    id: int
    kind: str  # Its type in OpenDRIVE
    direction: int  # 1 along s, -1 against s, 0 both ways
    speed: float  # m/s; NaN unknown, infinite without a limit
    left: int  # Its left border along s, counted from the leftmost border of the section; its right one is the next


@record
class Words:
    """What must be the same all along a strip."""

    lanes: tuple[StripLane, ...]
    marks: tuple[tuple[int, Mark], ...]  # Of the borders that bound these lanes
    borders: int  # How many the section has
    road_type: str

    @property
    def location(self) -> str:
        """Whether the road is in a town, as Lanelet2 says it."""
        return location_of(self.road_type)


@record
class Strip:
    """A stretch of a road from one change to the next."""

    road: int
    words: Words
    pieces: tuple[tuple[int, int, int], ...]  # Section, and the first and last station in it, in order
    s: tuple[float, float]


@record(eq=False)
class Cut:
    """All strips of a file, and what they were made from."""

    file: OpenDrive
    stations: Stations
    ribbons: Ribbons
    border_start: IntArray  # (sections,) Index of the first border of each section
    strips: tuple[Strip, ...]
    # Links between lanes of strips: lane (a row), `End`, and the same of the other, (n,) each
    contacts: tuple[IntArray, IntArray, IntArray, IntArray]

    def line(self, strip: Strip, border: int) -> FloatArray:
        """Return the points of a border of a strip, x, y, z, (n, 3), m."""
        rows: list[IntArray] = []
        for section, first, last in strip.pieces:
            begin = int(self.ribbons.start[self.border_start[section] + border])
            rows.append(np.arange(begin + first + bool(rows), begin + last + 1))
        row = np.concatenate(rows)
        points = np.column_stack([self.ribbons.x[row], self.ribbons.y[row], self.ribbons.z[row]])
        return _unfolded(points, self.stations.hdg[self.ribbons.station[row]])


def cut_into_strips(file: OpenDrive, tolerance: float, step: float) -> Cut:
    """Return the strips of a file; for `tolerance` and `step`, m, see `osm2xodr.opendrive.sample_roads`."""
    cuts = _cuts(file)
    stations = sample_roads(file, tolerance, step, cuts)
    ribbons = lane_ribbons(file, stations)
    border_start = np.searchsorted(ribbons.section, np.arange(len(file.sections.s))).astype(np.int64)
    contacts = contacts_of(file)
    maker = _Maker(file, stations, ribbons, border_start, contacts, cuts)
    return Cut(file, stations, ribbons, border_start, tuple(maker.strips()), contacts)


def _unfolded(points: FloatArray, hdg: FloatArray) -> FloatArray:
    """Return a border, (n, 3), without the points between its ends at which it runs back.

    A border on the inside of a bend does so where it lies beyond the bend's centre.
    """
    while len(points) > 2:
        step, along = np.diff(points[:, :2], axis=0), hdg[:-1] + 0.5 * wrapped(np.diff(hdg))
        back = step[:, 0] * np.cos(along) + step[:, 1] * np.sin(along) < 0.0
        kept = np.ones(len(points), np.bool_)
        kept[1:-1] = ~(back[:-1] | back[1:])
        if kept.all():
            break
        points, hdg = points[kept], hdg[kept]
    return points


def _cuts(file: OpenDrive) -> tuple[IntArray, FloatArray]:
    """Return the places, roads and s, where marks and types of roads change, and lanes begin or end."""
    marks, types, width = file.lanes.marks, file.types, file.lanes.width
    # Records of no width, and those after them.
    none = (width.a == 0.0) & (width.b == 0.0) & (width.c == 0.0) & (width.d == 0.0)
    none[1:] |= none[:-1]
    lane = np.concatenate([owners(marks.start), owners(width.start)[none]])
    section = file.lanes.section[lane]
    road = np.concatenate([file.sections.road[section], owners(types.start)])
    s = np.concatenate([file.sections.s[section] + np.concatenate([marks.s, width.s[none]]), types.s])
    end = np.concatenate([file.sections.end[section], file.roads.length[owners(types.start)]])
    with np.errstate(invalid="ignore"):
        inside = (s > 0.0) & (s < end)
    return road[inside], s[inside]


class _Maker:
    """Makes strips, road by road."""

    def __init__(
        self,
        file: OpenDrive,
        stations: Stations,
        ribbons: Ribbons,
        border_start: IntArray,
        contacts: tuple[IntArray, IntArray, IntArray, IntArray],
        cuts: tuple[IntArray, FloatArray],
    ) -> None:
        self._file, self._stations, self._ribbons = file, stations, ribbons
        self._border_start = border_start
        turn = np.abs(wrapped(np.diff(stations.hdg)))
        # What lies between two roads is of no interest; damaged files have places that are no numbers.
        extent = np.nan_to_num(np.abs(np.diff(stations.s)) / LONGEST + turn / MOST_TURN)
        self._extents = np.cumsum(np.append(0.0, extent))
        index = lane_index(file)
        self._direction = np.where(index.both_ways, 0, np.where(index.forward, 1, -1))
        self._kept = _kept(file, ribbons)
        self._cuts: dict[int, list[float]] = defaultdict(list)
        for road, s in zip(*(column.tolist() for column in cuts), strict=True):
            self._cuts[road].append(s)
        # Links from each section to the next one, by the former.
        self._onward: dict[int, set[tuple[int, int]]] = defaultdict(set)
        section = file.lanes.section
        for a, end_a, b, end_b in zip(*(column.tolist() for column in contacts), strict=True):
            if self._kept[a] and self._kept[b]:
                if (end_a, end_b) == (End.END, End.START) and section[b] == section[a] + 1:
                    self._onward[int(section[a])].add((a, b))
                if (end_a, end_b) == (End.START, End.END) and section[a] == section[b] + 1:
                    self._onward[int(section[b])].add((b, a))

    def strips(self) -> Iterator[Strip]:
        """Yield the strips of all roads."""
        for road in range(len(self._file.roads.id)):
            last: Strip | None = None
            for piece in self._pieces(road):
                if last is not None and self._goes_on(last, piece):
                    last = replace(last, pieces=last.pieces + piece.pieces, s=(last.s[0], piece.s[1]))
                    continue
                if last is not None:
                    yield last
                last = piece
            if last is not None:
                yield last

    def _pieces(self, road: int) -> Iterator[Strip]:
        """Yield the pieces of a road from one section or cut to the next."""
        starts = self._file.sections.start
        for section in range(int(starts[road]), int(starts[road + 1])):
            border = int(self._border_start[section])
            if border >= len(self._ribbons.section) or self._ribbons.section[border] != section:
                continue
            rows = self._ribbons.station[self._ribbons.start[border] : self._ribbons.start[border + 1]]
            s = self._stations.s[rows]
            inner = [int(np.argmin(np.abs(s - at))) for at in self._cuts.get(road, ()) if s[0] < at < s[-1]]
            # Lanes of both ways that open from nothing begin a little later: traffic would turn round there.
            shared = [row for row in self._rows(section).values() if self._direction[row] == 0]
            inner += [k for row in shared for k, w in ((1, 0), (len(s) - 2, -1)) if self._width(row)[w] <= NARROWEST]
            extent = self._extents[rows] - self._extents[rows[0]]
            shares = np.linspace(0.0, extent[-1], int(np.ceil(extent[-1] - _SAME)) + 1)[1:-1]
            inner += [int(np.argmin(np.abs(extent - at))) for at in shares]
            marks = sorted({0, len(s) - 1, *inner})
            for first, last in pairwise(marks):
                words = self._words(road, section, slice(first, last + 1), float(s[first]))
                if words.lanes:
                    yield Strip(road, words, ((section, first, last),), (float(s[first]), float(s[last])))

    def _goes_on(self, strip: Strip, piece: Strip) -> bool:
        """Return whether a piece goes on where a strip ends, with nothing changed."""
        if strip.words != piece.words or abs(strip.s[1] - piece.s[0]) > _SAME:
            return False
        if self._extent(strip) + self._extent(piece) > 1.0 + _SAME:
            return False
        (before, _, _), (section, _, _) = strip.pieces[-1], piece.pieces[0]
        if before == section:
            return True
        rows = [self._rows(part) for part in (before, section)]
        one, other = ([row[lane.id] for lane in piece.words.lanes] for row in rows)
        found = {(a, b) for a, b in self._onward[before] if a in one and b in other}
        return found == set(zip(one, other, strict=True))

    def _extent(self, strip: Strip) -> float:
        """Return how long a strip is as a share of what it may be."""
        out = 0.0
        for section, first, last in strip.pieces:
            begin = self._ribbons.start[self._border_start[section]]
            one, other = self._ribbons.station[[begin + first, begin + last]]
            out += float(self._extents[other] - self._extents[one])
        return out

    def _rows(self, section: int) -> dict[int, int]:
        """Return the rows of the lanes of a section that become lanelets, by id."""
        start = self._file.lanes.start
        rows = [row for row in range(int(start[section]), int(start[section + 1])) if self._kept[row]]
        return {int(self._file.lanes.id[row]): row for row in reversed(rows)}

    def _width(self, lane: int) -> FloatArray:
        """Return the width of a lane at the stations of its section, m."""
        start, t = self._ribbons.start, self._ribbons.t
        left, right = int(self._ribbons.left[lane]), int(self._ribbons.right[lane])
        return np.asarray(t[start[left] : start[left + 1]] - t[start[right] : start[right + 1]])

    def _words(self, road: int, section: int, part: slice, s: float) -> Words:
        """Return what there is to say of the lanes of a section at a part of its stations, which begins at s."""
        file = self._file
        road_type, road_speed = _type_at(file, road, s)
        lanes, bounds = [], set[int]()
        for number, row in sorted(self._rows(section).items(), reverse=True):
            width = self._width(row)[part]
            if (width.max() if self._direction[row] else width.min()) <= NARROWEST:
                continue
            left = int(self._ribbons.left[row] - self._border_start[section])
            bounds |= {left, left + 1}
            speed = float(file.lanes.speed[row])
            speed = road_speed if math.isnan(speed) else speed
            lanes.append(StripLane(number, file.lanes.type[row], int(self._direction[row]), speed, left))
        count = int(np.searchsorted(self._ribbons.section, section, side="right")) - int(self._border_start[section])
        inside = {lane.left for lane in lanes} & {lane.left + 1 for lane in lanes}
        marks = tuple((border, self._mark(section, border, s, border in inside)) for border in sorted(bounds))
        # NaN is not equal to itself.
        same = tuple(replace(lane, speed=math.inf if math.isnan(lane.speed) else lane.speed) for lane in lanes)
        return Words(same, marks, count, road_type)

    def _mark(self, section: int, border: int, s: float, inside: bool) -> Mark:
        """Return the road mark on a border of a section at s; `inside` says that lanelets lie on both sides."""
        file, lanes = self._file, self._file.lanes
        rows = list(range(int(lanes.start[section]), int(lanes.start[section + 1])))
        owner = _mark_owner([int(lanes.id[row]) for row in rows], border)
        kind, change = ("", "") if owner is None else _mark_at(file, rows[owner], s)
        left = owner is not None and int(lanes.id[rows[owner]]) > 0
        beside = [row for row in rows if lanes.id[row] != 0][max(border - 1, 0) : border + 1]
        low = 0.0 < float(np.nanmax(np.abs(lanes.height[beside]), initial=0.0)) < KERB_LOW
        bare = inside or int(file.roads.junction[file.sections.road[section]]) != -1
        return mark_of(kind, change, outwards_left=left, low=low, bare="virtual" if bare else "road_border")


def _mark_owner(ids: list[int], border: int) -> int | None:
    """Return which lane of a section, from left to right, has the mark on a border; None where none has."""
    left = sum(number > 0 for number in ids)
    if border < left:
        return border
    if border == left:
        return ids.index(0) if 0 in ids else None
    return border if 0 in ids else border - 1


def _mark_at(file: OpenDrive, lane: int, s: float) -> tuple[str, str]:
    """Return type and lane change of a lane's road mark at s of the road."""
    marks = file.lanes.marks
    begin = float(file.sections.s[file.lanes.section[lane]])
    best = ("", "")
    best_s = -math.inf
    for k in range(int(marks.start[lane]), int(marks.start[lane + 1])):
        at = begin + float(marks.s[k])
        if best_s <= at <= s + _SAME:
            best, best_s = (marks.type[k], marks.lane_change[k]), at
    return best


def _type_at(file: OpenDrive, road: int, s: float) -> tuple[str, float]:
    """Return type and speed limit (m/s, NaN where unknown) of a road at s."""
    types = file.types
    out = ("", math.nan)
    for k in range(int(types.start[road]), int(types.start[road + 1])):
        if types.s[k] <= s + _SAME:
            out = (types.type[k], float(types.speed[k]))
    return out


def _kept(file: OpenDrive, ribbons: Ribbons) -> list[bool]:
    """Return which lanes become lanelets, (lanes,)."""
    out = []
    for row, kind in enumerate(file.lanes.type):
        left, right = int(ribbons.left[row]), int(ribbons.right[row])
        if kind not in LANELETS or left == ABSENT:
            out.append(False)
            continue
        one, other = (slice(ribbons.start[k], ribbons.start[k + 1]) for k in (left, right))
        width = ribbons.t[one] - ribbons.t[other]
        places = ribbons.x[one] + ribbons.y[one] + ribbons.z[one] + width
        out.append(bool(np.isfinite(places).all() and width.max() > NARROWEST))
    return out
