"""Lines beside roads become strips along them: runs of s over which t changes evenly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import RoadsideFinder, RoadsidePlaces
from osm2xodr.model import BoolArray, FloatArray, IntArray

_ROUNDING: Final = 0.01


@dataclass(frozen=True, slots=True)
class Strip:
    """Part of a line that runs along a road."""

    line: int  # Index of the line
    road: int  # Index of the road
    # Where it begins and how long it is, m
    s: float
    length: float
    # m
    t_start: float
    t_end: float


@dataclass(frozen=True, slots=True)
class Run:
    """Points of a line in a row that run along one road, in ascending s."""

    line: int
    road: int
    s: FloatArray
    t: FloatArray


def strips_outside(finder: RoadsideFinder, lines: Sequence[FloatArray], half_widths: Sequence[float]) -> list[Strip]:
    """Cut lines to the roads that they run along, and keep them off the carriageways.

    Parameters
    ----------
    finder
        The roads.
    lines
        Local x, y of the points of each, (n, 2), m.
    half_widths
        Half of the width of what is built along each line, m.
    """
    line, places = _sampled(finder, lines)
    half = np.array(half_widths)[line]
    beyond = places.beyond
    off = defaults.OBJECT_GAP + half
    kept = (places.road >= 0) & (beyond >= -defaults.OBJECT_INSIDE)
    leftwards = places.t - places.left > places.right - places.t
    t = np.where(leftwards, np.maximum(places.t, places.left + off), np.minimum(places.t, places.right - off))
    return [
        strip
        for run in _runs(line, places, t, kept, leftwards)
        for strip in simplified(run)
        if _stays_off(finder, strip, half_widths[run.line])
    ]


def strips_on(finder: RoadsideFinder, lines: Sequence[FloatArray], half_width: float) -> list[Strip]:
    """Cut lines to the carriageways on which they run; what is built along them is so wide, m."""
    line, places = _sampled(finder, lines)
    kept = (places.road >= 0) & (places.beyond <= -half_width)
    return [
        strip
        for run in _runs(line, places, places.t, kept, np.zeros(len(line), np.bool_))
        for strip in simplified(run)
    ]


def _sampled(finder: RoadsideFinder, lines: Sequence[FloatArray]) -> tuple[IntArray, RoadsidePlaces]:
    """Return points along lines, the vertices among them: index of the line, and the places."""
    xs, ys, owner = [], [], []
    for k, points in enumerate(lines):
        step = np.hypot(*np.diff(points, axis=0).T)
        along = np.concatenate([[0.0], np.cumsum(step)])
        count = max(int(np.ceil(along[-1] / defaults.OBJECT_SPACING)), 1) + 1
        at = np.unique(np.concatenate([np.linspace(0.0, along[-1], count), along]))
        xs.append(np.interp(at, along, points[:, 0]))
        ys.append(np.interp(at, along, points[:, 1]))
        owner.append(np.full(len(at), k, np.int64))
    if not xs:
        empty = np.zeros(0)
        return np.zeros(0, np.int64), finder.places(empty, empty)
    return np.concatenate(owner), finder.places(np.concatenate(xs), np.concatenate(ys))


def _runs(line: IntArray, places: RoadsidePlaces, t: FloatArray, kept: BoolArray, side: BoolArray) -> Iterator[Run]:
    """Cut points where the line, the road, its side or the direction along it changes."""
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
        & (np.abs(dt) <= defaults.OBJECT_SLOPE * np.abs(ds))
    )
    # Links in a row that run the same way are one run.
    turn = np.sign(ds)
    begins = linked & ~np.concatenate([[False], linked[:-1] & (turn[1:] == turn[:-1])])
    for first in np.flatnonzero(begins).tolist():
        last = first
        while last + 1 < len(linked) and linked[last + 1] and not begins[last + 1]:
            last += 1
        rows = slice(first, last + 2)
        s, aside = places.s[rows], t[rows]
        if s[-1] < s[0]:
            s, aside = s[::-1], aside[::-1]
        if s[-1] - s[0] >= defaults.OBJECT_SHORTEST:
            yield Run(int(line[first]), int(places.road[first]), s, aside)


def simplified(run: Run) -> Iterator[Strip]:
    """Return a run with as few points as the tolerance allows (Douglas and Peucker 1973, measured along t)."""
    kept = {0, len(run.s) - 1}
    todo = [(0, len(run.s) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        share = (run.s[first : last + 1] - run.s[first]) / (run.s[last] - run.s[first])
        off = np.abs(run.t[first : last + 1] - (run.t[first] + share * (run.t[last] - run.t[first])))
        worst = int(np.argmax(off))
        if off[worst] > defaults.OBJECT_TOLERANCE:
            kept.add(first + worst)
            todo += [(first, first + worst), (first + worst, last)]
    order = sorted(kept)
    for one, other in pairwise(order):
        yield Strip(
            run.line,
            run.road,
            float(run.s[one]),
            float(run.s[other] - run.s[one]),
            float(run.t[one]),
            float(run.t[other]),
        )


def _stays_off(finder: RoadsideFinder, strip: Strip, half: float) -> bool:
    """Say whether a strip stays off the carriageway, also where that becomes wider between its points."""
    count = max(int(np.ceil(strip.length)), 1) + 1
    share = np.linspace(0.0, 1.0, count)
    left, right = finder.edges(strip.road, strip.s + share * strip.length)
    t = strip.t_start + share * (strip.t_end - strip.t_start)
    return bool((np.maximum(t - left, right - t) >= half - _ROUNDING).all())
