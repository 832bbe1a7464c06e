"""From a file of OpenDRIVE to what is drawn of it: stations, borders of lanes, and the road marks on them.

A *strip* is one lane section: rows of stations, each with the same borders from left to right. Its surface is the
grid that they span. Page and picture share all this, and what the file's header says of its heights and its sources.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from osm2xodr.curves import ranks, repeated, runs, starts
from osm2xodr.defaults import UNMEASURED_HEIGHTS
from osm2xodr.model import BoolArray, FloatArray, IntArray, Stretches
from osm2xodr.opendrive import (
    ABSENT,
    OpenDrive,
    elevation,
    grade,
    lane_borders,
    lane_offset,
    pose,
    sample_roads,
    section_at,
    superelevation,
)
from osm2xodr.system import record

# How far chords of drawn roads lie from their curves at most, m, and the longest chord, m: less than a pixel up to 30
# pixels per metre; and between stations of a profile a grade is as good as straight. Choices.
_TOLERANCE: Final = 0.03
_LONGEST_CHORD: Final = 10.0
# Borders that are found at once, about: more would take much memory on the way.
_BLOCK: Final = 1 << 17
# How road marks are drawn (0 not at all, 1 solid, 2 broken), and in which colour; others are solid and white.
_MARK_STYLES: Final = {
    "none": 0,
    "": 0,
    "solid": 1,
    "broken": 2,
    "botts dots": 2,
    "broken broken": 2,
    "broken solid": 1,
}
_MARK_COLOURS: Final = {
    "yellow": "#e8b400",
    "orange": "#e08a00",
    "red": "#d03a32",
    "blue": "#4f8fd0",
    "green": "#4aa564",
}

_WORD = "attribution"


@record(eq=False)
class Scene:
    """Stations, strips and lanes of all roads, in the order of the file."""

    strip_road: IntArray  # (strips,) Index of the road
    station_start: IntArray  # (strips + 1,) Into the stations
    lane_start: IntArray  # (strips + 1,) Into the lanes
    # (stations,) On the reference line: m, rad, rise per metre; NaN where unknown. A positive roll lowers the right
    # side, as OpenDRIVE's superelevation does.
    s: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    heading: FloatArray
    roll: FloatArray
    grade: FloatArray
    ground: FloatArray  # (stations,) Height of the elevation model, m; NaN where there is none
    # (stations x borders,) t of the borders, m: strip after strip, station after station, from left to right. A strip
    # has one border more than lanes.
    border: FloatArray
    lane: IntArray  # (lanes,) Rows in the file's table of lanes, from left to right, without centre lanes
    centre: IntArray  # (strips,) Row of the centre lane, -1 without one

    @property
    def strip_stations(self) -> IntArray:
        """Number of stations of each strip."""
        return np.diff(self.station_start)

    @property
    def strip_borders(self) -> IntArray:
        """Number of borders of each strip."""
        return np.diff(self.lane_start) + 1

    @property
    def border_start(self) -> IntArray:
        """Where the borders of each strip begin, and those of the last one end."""
        return starts(self.strip_stations * self.strip_borders)

    @property
    def station_strip(self) -> IntArray:
        """Strip of each station."""
        return repeated(self.strip_stations)

    @property
    def station_road(self) -> IntArray:
        """Road of each station."""
        return self.strip_road[self.station_strip]

    def border_station(self) -> IntArray:
        """Return the station of each border."""
        return repeated(self.strip_borders[self.station_strip])

    def border_places(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y, z of the borders, m."""
        at = self.border_station()
        across = self.border * np.cos(self.roll)[at]
        return (
            self.x[at] - across * np.sin(self.heading)[at],
            self.y[at] + across * np.cos(self.heading)[at],
            self.z[at] + self.border * np.sin(self.roll)[at],
        )

    def only(self, strips: IntArray) -> Scene:
        """Return the scene of some of the strips, in the order in which they are given."""
        parts = {
            ("strip_road", "centre"): strips,
            ("s", "x", "y", "z", "heading", "roll", "grade", "ground"): _rows(self.station_start, strips),
            ("border",): _rows(self.border_start, strips),
            ("lane",): _rows(self.lane_start, strips),
        }
        return replace(
            self,
            # Where the rows of each strip begin, and those of the last one end.
            station_start=starts(self.strip_stations[strips]),
            lane_start=starts(np.diff(self.lane_start)[strips]),
            **{name: getattr(self, name)[rows] for names, rows in parts.items() for name in names},
        )


def junction_places(file: OpenDrive, scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the middle of each junction's roads, (junctions,), m; NaN for junctions without roads."""
    n = len(file.junctions.id)
    junction = file.roads.junction[scene.station_road]
    rows = np.flatnonzero((junction >= 0) & (junction < n))
    count = np.bincount(junction[rows], minlength=n)
    with np.errstate(invalid="ignore"):
        x = np.bincount(junction[rows], weights=scene.x[rows], minlength=n) / count
        y = np.bincount(junction[rows], weights=scene.y[rows], minlength=n) / count
    return x, y


def _rows(start: IntArray, strips: IntArray) -> IntArray:
    """Return the rows of some strips, one strip after the other."""
    return runs(start[strips], np.diff(start)[strips])


def make_scene(file: OpenDrive, tolerance: float = _TOLERANCE, step: float = _LONGEST_CHORD) -> Scene:
    """Sample all roads, and all borders of their lanes; `tolerance` and `step` are as for `sample_roads`, m.

    Roads that cannot be drawn (no plan view, no lane section, unreadable numbers) have no strips.
    """
    road, s, section, is_end = _stations(file, tolerance, step)
    strip_first = np.flatnonzero(np.diff(section, prepend=ABSENT))
    strip_section = section[strip_first]
    station_start = np.append(strip_first, len(s)).astype(np.int64)
    lane, lane_start, left_lanes = _lanes(file, strip_section)
    x, y, heading = _both(pose, file, road, s, is_end)
    (z,) = _both(elevation, file, road, s, is_end)
    (roll,) = _both(superelevation, file, road, s, is_end)
    (slope,) = _both(grade, file, road, s, is_end)
    border = _borders(file, s, is_end, station_start, lane_start, lane, left_lanes, road)
    centre_rows = np.flatnonzero(file.lanes.id == 0)
    of_section = np.full(len(file.sections.s), -1)
    of_section[file.lanes.section[centre_rows][::-1]] = centre_rows[::-1]
    return Scene(
        strip_road=file.sections.road[strip_section],
        station_start=station_start,
        lane_start=lane_start,
        s=s,
        x=x,
        y=y,
        z=z,
        heading=heading,
        roll=np.nan_to_num(roll),
        grade=slope,
        ground=np.full(len(s), np.nan),
        border=border,
        lane=lane,
        centre=of_section[strip_section],
    )


def _stations(file: OpenDrive, tolerance: float, step: float) -> tuple[IntArray, FloatArray, IntArray, BoolArray]:
    """Return road, s and lane section of all stations, and which are the end of a section that another one follows.

    There are two stations where one section follows another: the end of the first and the start of the second.
    """
    found = sample_roads(file, tolerance, step)
    drawn = np.isfinite(found.x) & np.isfinite(found.y) & np.isfinite(found.hdg)
    road, s = found.road[drawn], found.s[drawn]
    section = section_at(file, road, s)
    known = section != ABSENT
    road, s, section = road[known], s[known], section[known]
    # Where row k is the last of its section, the first station of the next section ends it as well.
    ends = np.flatnonzero((road[1:] == road[:-1]) & (section[1:] != section[:-1]))
    at = np.concatenate((np.arange(len(s)), ends + 1))
    owner = np.concatenate((section, section[ends]))
    is_end = np.concatenate((np.zeros(len(s), np.bool_), np.ones(len(ends), np.bool_)))
    order = np.lexsort((is_end, s[at], owner))
    at, owner, is_end = at[order], owner[order], is_end[order]
    # A section of a single station has no surface.
    count = np.bincount(owner, minlength=len(file.sections.s))
    kept = count[owner] > 1
    return road[at[kept]], s[at[kept]], owner[kept], is_end[kept]


def _both(
    function: Callable[..., Any], file: OpenDrive, road: IntArray, s: FloatArray, before: BoolArray
) -> list[FloatArray]:
    """Evaluate a function at stations, as the limit from the left where `before` is true."""
    after = function(file, road, s)
    columns = list(after) if isinstance(after, tuple) else [after]
    left = function(file, road[before], s[before], before=True)
    for column, values in zip(columns, left if isinstance(left, tuple) else (left,), strict=True):
        column[before] = values
    return columns


def _lanes(file: OpenDrive, section: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the lanes of sections from left to right without centre lanes, their starts, and how many are left."""
    ids = file.lanes.id
    first, last = file.lanes.start[section], file.lanes.start[section + 1]
    row = runs(first, last - first)
    strip = repeated(last - first)
    kept = (ids[row] != 0) & (ids[row] != ABSENT)
    row, strip = row[kept], strip[kept]
    lane_start = np.searchsorted(strip, np.arange(len(section) + 1)).astype(np.int64)
    left = np.bincount(strip[ids[row] > 0], minlength=len(section))
    return row, lane_start, left.astype(np.int64)


def _borders(
    file: OpenDrive,
    s: FloatArray,
    is_end: BoolArray,
    station_start: IntArray,
    lane_start: IntArray,
    lane: IntArray,
    left_lanes: IntArray,
    road: IntArray,
) -> FloatArray:
    """Return t of all borders: strip after strip, station after station, from left to right."""
    border_start = starts(np.diff(station_start) * (np.diff(lane_start) + 1))
    out = np.empty(int(border_start[-1]))
    first = 0
    while first < len(lane_start) - 1:
        last = max(first + 1, int(np.searchsorted(border_start, border_start[first] + _BLOCK, "right")) - 1)
        rows = slice(int(station_start[first]), int(station_start[last]))
        begins = station_start[first : last + 1] - rows.start, lane_start[first : last + 1]
        out[border_start[first] : border_start[last]] = _borders_of_strips(
            file, s[rows], is_end[rows], *begins, lane, left_lanes[first:last], road[rows]
        )
        first = last
    return out


def _borders_of_strips(
    file: OpenDrive,
    s: FloatArray,
    is_end: BoolArray,
    station_start: IntArray,
    lane_start: IntArray,
    lane: IntArray,
    left_lanes: IntArray,
    road: IntArray,
) -> FloatArray:
    """Return t of all borders of some strips, as `_borders` does."""
    stations, lanes = np.diff(station_start), np.diff(lane_start)
    borders = np.repeat(lanes + 1, stations)
    strip = repeated(stations)
    station, rank = repeated(borders), ranks(borders)
    left = left_lanes[strip[station]]
    out = np.empty(len(station))
    centre = rank == left
    out[centre] = _both(lane_offset, file, road, s, is_end)[0]
    # Left of the centre, border k is the outer one of lane k; right of it, of lane k - 1.
    side = np.flatnonzero(~centre)
    which = lane[lane_start[strip[station[side]]] + rank[side] - (rank[side] > left[side])]
    at, ends = s[station[side]], is_end[station[side]]
    outer = lane_borders(file, which, at)[1]
    outer[ends] = lane_borders(file, which[ends], at[ends], before=True)[1]
    out[side] = outer
    return out


def border_marks(file: OpenDrive, scene: Scene) -> tuple[list[list[Any]], IntArray]:
    """Return name, style (`_MARK_STYLES`) and colour of each kind of road mark, and the kind on each border.

    The mark of a lane is on its outer border, that of the centre lane on the border between left and right. Borders
    are those of each strip, from left to right, one strip after the other, (borders,).
    """
    lanes = file.lanes
    kinds: dict[tuple[str, str], int] = {("none", ""): 0}
    code = np.array(
        [kinds.setdefault(pair, len(kinds)) for pair in zip(lanes.mark, lanes.mark_color, strict=True)], np.int64
    )
    strips = np.arange(len(scene.strip_road))
    strip, rank = np.repeat(strips, scene.strip_borders), ranks(scene.strip_borders)
    owner = np.repeat(strips, np.diff(scene.lane_start))
    left = np.bincount(owner[lanes.id[scene.lane] > 0], minlength=len(strips))
    out = np.zeros(len(strip), np.int64)
    centre = rank == left[strip]
    has_centre = centre & (scene.centre[strip] >= 0)
    out[has_centre] = code[scene.centre[strip[has_centre]]]
    side = np.flatnonzero(~centre)
    out[side] = code[scene.lane[scene.lane_start[strip[side]] + rank[side] - (rank[side] > left[strip[side]])]]
    rows = [[name, _MARK_STYLES.get(name, 1), _MARK_COLOURS.get(colour, "#ffffff")] for name, colour in kinds]
    return rows, out


def unmeasured(file: OpenDrive) -> Stretches:
    """Return the stretches of roads without measured heights, as their ``<userData>`` says.

    Only files that osm2xodr wrote say so; what cannot be read says nothing.
    """
    found: list[list[tuple[float, float]]] = [[] for _ in file.roads.id]
    for (road, code), text in file.provenance.items():
        if code == UNMEASURED_HEIGHTS and road >= 0:
            found[road] = _pairs(text, float(file.roads.length[road]))
    rows = np.array([pair for pairs in found for pair in pairs], np.float64).reshape(-1, 2)
    return Stretches(starts([len(pairs) for pairs in found]), rows[:, 0].copy(), rows[:, 1].copy())


def unmeasured_share(file: OpenDrive) -> tuple[float, float]:
    """Return the length of roads without measured heights, m, and their share of the length of all roads."""
    lengths = np.where(file.roads.length > 0.0, file.roads.length, 0.0)
    length = unmeasured(file).total(lengths)
    return length, length / max(float(lengths.sum()), 1.0) if math.isfinite(length) else 0.0


def _pairs(text: str, length: float) -> list[tuple[float, float]]:
    """Return begin and end of stretches on a road, m; none if the text is anything else."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return []
    # Comparisons with NaN are false.
    rising = all(a < b for a, b in pairwise(values))
    if len(values) % 2 or not rising or not values or not 0.0 <= values[0] <= values[-1] <= length + 1.0:
        return []
    return list(zip(values[::2], values[1::2], strict=True))


def credits_of(file: OpenDrive) -> str:
    """Return all attributions in ``userData`` of the header, each once; empty without any.

    They are those whose code contains the word, so that data of several sources may each have one.
    """
    found = [value.strip() for (road, code), value in file.provenance.items() if road == -1 and _WORD in code.lower()]
    return "; ".join(dict.fromkeys(value for value in found if value))
