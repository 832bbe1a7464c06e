"""Where things of a file are: what several checks measure with."""

from __future__ import annotations

import dataclasses
import gzip
from pathlib import Path

import numpy as np

from osm2xodr.curves import wrapped
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, pose

_GZIP = b"\x1f\x8b"


def file_bytes(path: Path) -> bytes:
    """Return a file's content, unpacked."""
    data = path.read_bytes()
    return gzip.decompress(data) if data.startswith(_GZIP) else data


def owners(start: IntArray) -> IntArray:
    """Return the index of each row's owner."""
    return np.repeat(np.arange(len(start) - 1), np.diff(start))


def joints(start: IntArray) -> IntArray:
    """Return the rows that follow another of the same owner."""
    owner = owners(start)
    return 1 + np.flatnonzero(owner[1:] == owner[:-1])


def record_poses(drive: OpenDrive, row: IntArray, ds: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and heading at ds of plan-view records, whatever s they state."""
    plan = drive.plan_view
    alone = dataclasses.replace(plan, start=np.arange(len(plan.s) + 1), s=np.zeros(len(plan.s)))
    return pose(dataclasses.replace(drive, plan_view=alone), row, ds)


def record_ends(profile: CubicProfile, row: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return value and slope of cubics of records where the next record begins."""
    ds = profile.s[row + 1] - profile.s[row]
    a, b, c, d = profile.a[row], profile.b[row], profile.c[row], profile.d[row]
    return a + ds * (b + ds * (c + ds * d)), b + ds * (2 * c + 3 * ds * d)


def spans(profile: CubicProfile, length: FloatArray) -> FloatArray:
    """Return how far each record of a profile holds, (records,), m: to the next, or to the end of its curve.

    Parameters
    ----------
    profile
        Piecewise cubics.
    length : (curves,)
        m.
    """
    end = length[owners(profile.start)]
    follows = joints(profile.start)
    end[follows - 1] = profile.s[follows]
    return np.asarray(np.maximum(np.nan_to_num(end - profile.s), 0.0))


def worst_of(group: IntArray, value: FloatArray) -> IntArray:
    """Return the row with the largest value of each group, in order of the groups."""
    order = np.lexsort((-value, group))
    first = np.concatenate([[True], np.diff(group[order]) > 0])[: len(order)]
    worst: IntArray = np.asarray(order[first], np.int64)
    return worst


def degrees(turn: FloatArray) -> FloatArray:
    """Return the size of turns, degrees, from 0 to 180."""
    size: FloatArray = np.degrees(np.abs(wrapped(turn)))
    return size
