"""What several checks measure with."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from osm2xodr.checking.findings import Findings, Place
from osm2xodr.checking.rules import RULES
from osm2xodr.curves import owners, repeated, wrapped
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive import End, Furniture, OpenDrive, pose


def above(rule: str, value: FloatArray) -> BoolArray:
    """Whether values are above a rule's limit, (n,); never where they are unknown."""
    limit = RULES[rule].limit
    assert limit is not None
    return np.asarray(np.nan_to_num(value, nan=-np.inf) > limit.value)


def first_rows(start: IntArray) -> IntArray:
    """Return the first row of each owner that has rows."""
    return start[:-1][np.diff(start) > 0]


def followers(start: IntArray) -> IntArray:
    """Return the rows that follow another row of the same owner."""
    owner = owners(start)
    return 1 + np.flatnonzero(owner[1:] == owner[:-1])


def end_station(drive: OpenDrive, road: IntArray, end: IntArray | End) -> FloatArray:
    """Return s of ends of roads, (n,), m."""
    return np.where(end == End.END, drive.roads.length[road], 0.0)


def road_place(drive: OpenDrive, road: IntArray, s: FloatArray | None = None) -> Place:
    """Return where roads are, for findings: at s, or as a whole."""
    place: Place = {"road": road, "line": drive.roads.line[road]}
    return place if s is None else {**place, "s": s}


def record_poses(drive: OpenDrive, row: IntArray, ds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y (m) and heading (rad) at ds of plan-view records, whatever s they state, (n,)."""
    plan = drive.plan_view
    alone = dataclasses.replace(plan, start=np.arange(len(plan.s) + 1), s=np.zeros(len(plan.s)))
    return pose(dataclasses.replace(drive, plan_view=alone), row, ds)


def record_ends(profile: CubicProfile, row: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return value and slope of the cubics of records where the next record begins, (n,)."""
    ds = profile.s[row + 1] - profile.s[row]
    a, b, c, d = profile.a[row], profile.b[row], profile.c[row], profile.d[row]
    return a + ds * (b + ds * (c + ds * d)), b + ds * (2 * c + 3 * ds * d)


def spans(profile: CubicProfile, length: FloatArray) -> FloatArray:
    """Return how far each record holds, (records,), m: to the next one, or to the end of its curve.

    `length` is that of each curve, (curves,), m.
    """
    end = length[owners(profile.start)]
    follows = followers(profile.start)
    end[follows - 1] = profile.s[follows]
    return np.asarray(np.maximum(np.nan_to_num(end - profile.s), 0.0))


def worst_of(group: IntArray, value: FloatArray) -> IntArray:
    """Return the row with the largest value of each group, in order of the groups."""
    order = np.argsort(group, kind="stable")
    begin = np.flatnonzero(np.diff(group[order], prepend=group[order[:1]] - 1))
    if not len(begin):
        return order
    sorted_, size = value[order], np.diff(np.append(begin, len(order)))
    largest = np.repeat(np.fmax.reduceat(sorted_, begin), size)
    # Of groups whose values are all unknown the first row.
    best = np.flatnonzero((sorted_ == largest) | np.isnan(largest))
    of = repeated(size)[best]
    return np.asarray(order[best[np.diff(of, prepend=-1) > 0]], np.int64)


def degrees(turn: FloatArray) -> FloatArray:
    """Return the size of turns (rad) in degrees, from 0 to 180."""
    return np.asarray(np.degrees(np.abs(wrapped(turn))))


def add_furniture(
    rule: str,
    items: Sequence[Furniture],
    findings: Findings,
    other: Sequence[str] = "",
    value: Sequence[float] | None = None,
) -> None:
    """Add findings about signals and objects."""
    findings.add(
        rule,
        road=[item.road for item in items],
        s=[item.s for item in items],
        value=value,
        line=[item.line for item in items],
        other=other,
    )
