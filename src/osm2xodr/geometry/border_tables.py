"""Parts of piecewise cubics, cut out so that they say the same as the whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from osm2xodr.curves import find_record
from osm2xodr.grouping import ranks
from osm2xodr.model import BoolArray, Cubic, CubicProfile, FloatArray, IntArray

# Shorter records are none, m: those around them say the same to less than is written.
_NO_RECORD = 1e-6


def part_of_profile(profile: CubicProfile, curve: IntArray, begin: FloatArray, end: FloatArray) -> CubicProfile:
    """Return parts of piecewise cubics as curves of their own; s of each starts at 0.

    Parameters
    ----------
    profile
        The cubics; parts of curves without records have none.
    curve, begin, end : (parts,)
        Index of the curve, and from where to where along it, m. A curve may be cut several times.
    """
    has: BoolArray = profile.start[curve + 1] > profile.start[curve]
    count, low = np.zeros(len(curve), np.int64), np.zeros(len(curve), np.int64)
    low[has] = find_record(profile.start, profile.s, curve[has], begin[has] + _NO_RECORD)
    high = find_record(profile.start, profile.s, curve[has], end[has] - _NO_RECORD)
    count[has] = np.maximum(high - low[has], 0) + 1
    part = np.repeat(np.arange(len(curve)), count)
    rank = ranks(count)
    k = low[part] + rank
    s, a, b, c, d = (getattr(profile, name)[k] for name in ("s", "a", "b", "c", "d"))
    u = np.where(rank == 0, begin[part] - s, 0.0)
    return CubicProfile(
        np.concatenate([[0], np.cumsum(count)]).astype(np.int64),
        np.where(rank == 0, 0.0, s - begin[part]),
        # Taylor's series about the new start, which ends with its third term.
        a + u * (b + u * (c + u * d)),
        b + u * (2 * c + 3 * u * d),
        c + 3 * u * d,
        d,
    )


def part_of_cubics(cubics: Sequence[Cubic], begin: float, end: float) -> tuple[Cubic, ...]:
    """Return what cubics say from s = begin to s = end, with s counted from there.

    `begin` may lie before the first record, which then holds from there on.
    """
    last = max((k for k, item in enumerate(cubics) if item.s < end - _NO_RECORD), default=0)
    first = max((k for k, item in enumerate(cubics[: last + 1]) if item.s <= begin + _NO_RECORD), default=0)
    return tuple(
        item.begun_later(begin - item.s, 0.0) if k == 0 else replace(item, s=item.s - begin)
        for k, item in enumerate(cubics[first : last + 1])
    )
