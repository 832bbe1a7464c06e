"""Lines along roads become strips, over which t changes linearly with s, and objects along these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import running_lengths
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import RoadsideFinder, RoadsidePlaces, World
from osm2xodr.model import BoolArray, FloatArray, IntArray, ObjectRepeat, RoadObject

# Distance of the points of a line that are placed beside roads, m; a choice.
POINT_SPACING: Final = 3.0
# Distance of those of lines on carriageways, m, so that they run on through junctions without gaps; a choice.
_SPACING_ON_ROADS: Final = 0.5
# Shorter parts of lines are left out, m; a choice.
SHORTEST_RUN: Final = 1.0
# How far lines are moved at most to have fewer points, m; a choice.
_TOLERANCE: Final = 0.1
# Parts that turn away from the road by more do not run along it, m per m; a choice.
_SLOPE_MAX: Final = 1.0
# How far objects may reach onto the carriageway, m: rounding, and the tolerance of lines between their points.
_ON_CARRIAGEWAY: Final = 0.01


@dataclass(frozen=True, slots=True)
class Strip:
    """Part of a line that runs along a road."""

    line: int  # Index of the line
    road: int  # Index of the road
    s: float  # Where it begins, m
    length: float  # m
    t_start: float  # At its start, m
    t_end: float  # At its end, m


@dataclass(frozen=True, slots=True)
class Run:
    """Consecutive points of a line that run along one road, in ascending s."""

    line: int  # Index of the line
    road: int  # Index of the road
    s: FloatArray  # m
    t: FloatArray  # m


def strips_outside(finder: RoadsideFinder, lines: Sequence[FloatArray], half_widths: Sequence[float]) -> list[Strip]:
    """Cut lines to the roads that they run along, and move them off the carriageways.

    Lines are local x, y of their points, (n, 2), m; half widths are those of what is built along each, m.
    """
    line, x, y = _points_along(lines, POINT_SPACING)
    places = finder.places(x, y)
    half = np.array(half_widths)[line]
    off = defaults.OBJECT_GAP + half
    kept = (places.road >= 0) & (places.beyond >= -defaults.OBJECT_INSIDE)
    leftwards = places.t - places.left > places.right - places.t
    t = np.where(leftwards, np.maximum(places.t, places.left + off), np.minimum(places.t, places.right - off))
    return [
        strip
        for run in _runs(line, places, t, kept, leftwards)
        for strip in simplified(run)
        if _stays_off(finder, strip, half_widths[run.line])
    ]


def strips_on(finder: RoadsideFinder, lines: Sequence[FloatArray], half_width: float) -> list[Strip]:
    """Cut lines (n, 2) to the carriageways on which they run with their half width, m, and on through junctions."""
    line, x, y = _points_along(lines, _SPACING_ON_ROADS)
    places = finder.places(x, y, -half_width)
    on = places.road >= 0
    places = _through_junctions(finder, line, x, y, places)
    on |= np.isnan(places.left) & (places.road >= 0)
    one_side = np.zeros(len(line), np.bool_)
    return [strip for run in _runs(line, places, places.t, on, one_side) for strip in simplified(run)]


def _through_junctions(
    finder: RoadsideFinder, line: IntArray, x: FloatArray, y: FloatArray, places: RoadsidePlaces
) -> RoadsidePlaces:
    """Give points that have no place outside of junctions one on a connecting road that runs along their line.

    Of several roads that one is taken which the line follows farthest without a break.
    """
    inside = np.flatnonzero(places.road < 0)
    point, road, s, t = finder.on_connecting_roads(x[inside], y[inside])
    point = inside[point]
    order = np.lexsort((point, road))
    point, road, s, t = point[order], road[order], s[order], t[order]
    if not len(point):
        return places
    along = np.abs(np.diff(t)) <= _SLOPE_MAX * np.abs(np.diff(s))
    linked = (np.diff(point) == 1) & (np.diff(road) == 0) & (line[point[1:]] == line[point[:-1]]) & along
    begins = np.flatnonzero(np.concatenate([[True], ~linked]))
    groups = sorted(np.split(np.arange(len(point)), begins[1:]), key=len, reverse=True)
    columns = {name: np.array(getattr(places, name)) for name in ("road", "s", "t")}
    for rows in groups:
        free = rows[columns["road"][point[rows]] < 0]
        columns["road"][point[free]], columns["s"][point[free]], columns["t"][point[free]] = (
            road[free],
            s[free],
            t[free],
        )
    return replace(places, **columns)


def _points_along(lines: Sequence[FloatArray], spacing: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return points along lines, vertices included: the index of each one's line, x and y, (n,), m."""
    xs, ys, owner = [np.zeros(0)], [np.zeros(0)], [np.zeros(0, np.int64)]
    for k, points in enumerate(lines):
        along = running_lengths(points)
        count = max(int(np.ceil(along[-1] / spacing)), 1) + 1
        at = np.unique(np.concatenate([np.linspace(0.0, along[-1], count), along]))
        xs.append(np.interp(at, along, points[:, 0]))
        ys.append(np.interp(at, along, points[:, 1]))
        owner.append(np.full(len(at), k, np.int64))
    return np.concatenate(owner), np.concatenate(xs), np.concatenate(ys)


def _runs(line: IntArray, places: RoadsidePlaces, t: FloatArray, kept: BoolArray, side: BoolArray) -> Iterator[Run]:
    """Split points where the line, the road, its side or the direction along it changes."""
    if not len(line):
        return
    ds, dt = np.diff(places.s), np.diff(t)
    linked = (
        kept[1:]
        & kept[:-1]
        & (line[1:] == line[:-1])
        & (places.road[1:] == places.road[:-1])
        & (side[1:] == side[:-1])
        & (ds != 0.0)
        & (np.abs(dt) <= _SLOPE_MAX * np.abs(ds))
    )
    # Consecutive links in the same direction are one run.
    turn = np.sign(ds)
    begins = linked & ~np.concatenate([[False], linked[:-1] & (turn[1:] == turn[:-1])])
    stops = np.append(np.flatnonzero(begins | ~linked), len(linked))
    firsts = np.flatnonzero(begins)
    ends = stops[np.searchsorted(stops, firsts, side="right")]
    for first, end in zip(firsts.tolist(), ends.tolist(), strict=True):
        rows = slice(first, end + 1)
        s, lateral = places.s[rows], t[rows]
        if s[-1] < s[0]:
            s, lateral = s[::-1], lateral[::-1]
        if s[-1] - s[0] >= SHORTEST_RUN:
            yield Run(int(line[first]), int(places.road[first]), s, lateral)


def simplified(run: Run) -> Iterator[Strip]:
    """Yield a run as few strips as the tolerance allows (Douglas and Peucker 1973, measured along t)."""
    kept = {0, len(run.s) - 1}
    todo = [(0, len(run.s) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        share = (run.s[first : last + 1] - run.s[first]) / (run.s[last] - run.s[first])
        off = np.abs(run.t[first : last + 1] - (run.t[first] + share * (run.t[last] - run.t[first])))
        worst = int(np.argmax(off))
        if off[worst] > _TOLERANCE:
            kept.add(first + worst)
            todo += [(first, first + worst), (first + worst, last)]
    for one, other in pairwise(sorted(kept)):
        length, ends = float(run.s[other] - run.s[one]), (float(run.t[one]), float(run.t[other]))
        yield Strip(run.line, run.road, float(run.s[one]), length, *ends)


def _stays_off(finder: RoadsideFinder, strip: Strip, half: float) -> bool:
    """Return whether a strip stays off the carriageway where that widens between its points, too."""
    count = max(int(np.ceil(strip.length)), 1) + 1
    share = np.linspace(0.0, 1.0, count)
    left, right = finder.edges(strip.road, strip.s + share * strip.length)
    t = strip.t_start + share * (strip.t_end - strip.t_start)
    return bool((np.maximum(t - left, right - t) >= half - _ON_CARRIAGEWAY).all())


def object_along(
    world: World,
    strip: Strip,
    words: tuple[str, str, str],
    size: tuple[float, float],
    osm_id: str,
    lateral: float = 0.0,
    distance: float = 0.0,
) -> RoadObject:
    """Make an object of a type, subtype and name (words) along a strip of road.

    Size is its width and height; aside how far its middle lies to the left of the strip; distance that between round
    copies, 0 for one continuous object; all m.
    """
    width, height = size
    edges = strip.t_start + lateral, strip.t_end + lateral
    found = world.object_at(world.road_map.roads[strip.road].id, words, strip.s, edges[0], osm_id)
    repeat = ObjectRepeat(strip.s, strip.length, distance, *edges, width, height)
    if distance:
        return replace(found, height=height, radius=0.5 * width, repeat=repeat)
    return replace(found, length=strip.length, width=width, height=height, repeat=repeat)
