"""Piecewise cubics: evaluated, stacked and cut, many curves at once."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Final

import numpy as np

from osm2xodr.curves.ragged import blocks, ranks, repeated, starts
from osm2xodr.curves.records import find_record
from osm2xodr.model import BoolArray, Cubic, CubicProfile, FloatArray, IntArray

_COLUMNS: Final = ("s", "a", "b", "c", "d")
# A cut leaves no record shorter than this, m: its neighbours say the same to less than is written.
_SHORTEST_RECORD: Final = 1e-6


def smooth_step(share: FloatArray) -> FloatArray:
    """Return what rises from 0 to 1 as a share does, any shape, level at both ends: the cubic 3 u^2 - 2 u^3."""
    out: FloatArray = share * share * (3.0 - 2.0 * share)
    return out


def smooth_cubic(s: float, length: float, start: float, end: float) -> Cubic:
    """Return the cubic from one value to another over a length with no slope at either end."""
    rise = end - start
    return Cubic(s, start, 0.0, 3 * rise / (length * length), -2 * rise / (length * length * length))


def cubic_value(
    profile: CubicProfile, curve: IntArray, s: FloatArray, *, order: int = 0, before: bool = False
) -> FloatArray:
    """Return piecewise cubics, or their first or second derivatives by `order`, at s of curves, (n,), m.

    Curves without records have 0. `before` asks for the limit from the left.
    """
    out = np.zeros(len(s))
    every = np.flatnonzero(profile.start[curve + 1] > profile.start[curve])
    for rows in blocks(len(every)):
        has = every[rows]
        k = find_record(profile.start, profile.s, curve[has], s[has], before=before)
        ds = s[has] - profile.s[k]
        if order == 0:
            out[has] = profile.a[k] + ds * (profile.b[k] + ds * (profile.c[k] + ds * profile.d[k]))
        elif order == 1:
            out[has] = profile.b[k] + ds * (2 * profile.c[k] + 3 * ds * profile.d[k])
        else:
            out[has] = 2 * profile.c[k] + 6 * ds * profile.d[k]
    return out


def cubic_slope(profile: CubicProfile, curve: IntArray, s: FloatArray, *, before: bool = False) -> FloatArray:
    """Return the first derivative of piecewise cubics; see `cubic_value`."""
    return cubic_value(profile, curve, s, order=1, before=before)


def stack_profiles(first: CubicProfile, second: CubicProfile) -> CubicProfile:
    """Return the curves of both tables in one, the second's after the first's."""
    return CubicProfile(
        np.concatenate([first.start, second.start[1:] + first.start[-1]]),
        *(np.concatenate([getattr(first, name), getattr(second, name)]) for name in _COLUMNS),
    )


def profile_of(curves: Sequence[Sequence[Cubic]]) -> CubicProfile:
    """Return a table of the cubics of many curves."""
    start = starts([len(cubics) for cubics in curves])
    flat = np.array([(c.s, c.a, c.b, c.c, c.d) for cubics in curves for c in cubics]).reshape(-1, 5)
    return CubicProfile(start, *(np.ascontiguousarray(column) for column in flat.T))


def part_of_profile(profile: CubicProfile, curve: IntArray, begin: FloatArray, end: FloatArray) -> CubicProfile:
    """Return parts from begin to end of piecewise cubics, (parts,), m, as curves of their own; s of each starts at 0.

    `curve` holds the index of each part's curve, which may be cut several times. Curves without records give none.
    """
    has: BoolArray = profile.start[curve + 1] > profile.start[curve]
    count, low = np.zeros(len(curve), np.int64), np.zeros(len(curve), np.int64)
    low[has] = find_record(profile.start, profile.s, curve[has], begin[has] + _SHORTEST_RECORD)
    high = find_record(profile.start, profile.s, curve[has], end[has] - _SHORTEST_RECORD)
    count[has] = np.maximum(high - low[has], 0) + 1
    part = repeated(count)
    rank = ranks(count)
    k = low[part] + rank
    s, a, b, c, d = (getattr(profile, name)[k] for name in _COLUMNS)
    u = np.where(rank == 0, begin[part] - s, 0.0)
    return CubicProfile(
        starts(count),
        np.where(rank == 0, 0.0, s - begin[part]),
        # The Taylor series about the new start, which ends with the third derivative.
        a + u * (b + u * (c + u * d)),
        b + u * (2 * c + 3 * u * d),
        c + 3 * u * d,
        d,
    )


def value_of_cubics(cubics: Sequence[Cubic], s: float, *, before: bool = False) -> float:
    """Return piecewise cubics at s, extrapolated before the first one; `before` asks for the limit from the left."""
    held = (item for item in cubics if item.s < s or (item.s == s and not before))
    holding = max(held, key=attrgetter("s"), default=cubics[0])
    return holding.at(s - holding.s)


def part_of_cubics(cubics: Sequence[Cubic], begin: float, end: float) -> tuple[Cubic, ...]:
    """Return the cubics from s = begin to s = end, with s counted from there.

    `begin` may lie before the first record, which is then extrapolated backwards.
    """
    last = max((k for k, item in enumerate(cubics) if item.s < end - _SHORTEST_RECORD), default=0)
    first = max((k for k, item in enumerate(cubics[: last + 1]) if item.s <= begin + _SHORTEST_RECORD), default=0)
    return tuple(
        item.begun_later(begin - item.s, 0.0) if k == 0 else Cubic(item.s - begin, item.a, item.b, item.c, item.d)
        for k, item in enumerate(cubics[first : last + 1])
    )
