"""From heights and grades at knots to the records that are written."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import cubic_slope, cubic_value
from osm2xodr.geometry.heights.defaults import (
    RECORD_DECIMALS,
    RECORD_S_DECIMALS,
    RECORD_SLOPE_DECIMALS,
    RECORD_SLOPE_TOLERANCE,
    RECORD_TOLERANCE,
)
from osm2xodr.geometry.heights.problem import Pins
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray

# Knots closer to a pin than this make way for it, m.
_KNOT_DISTANCE: Final = 0.1
# Shorter intervals count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1e-12
# A knot is only rounded along the road if its neighbours are this many units of the last decimal away.
_ROOM: Final = 10


def hermite_records(start: IntArray, s: FloatArray, value: FloatArray, slope: FloatArray) -> CubicProfile:
    """Return the cubics through values and slopes at the knots of many curves.

    Parameters
    ----------
    start : (curves + 1,)
        Index of each curve's first knot; every curve has at least two.
    s, value, slope : (knots,)
        Where the knots lie, and what holds there.
    """
    last = np.zeros(len(s), bool)
    last[start[1:] - 1] = True
    a = np.flatnonzero(~last)
    b = a + 1
    h = s[b] - s[a]
    secant = (value[b] - value[a]) / h
    c = (3 * secant - 2 * slope[a] - slope[b]) / h
    d = (slope[a] + slope[b] - 2 * secant) / (h * h)
    first = start - np.arange(len(start))
    return CubicProfile(first.astype(np.int64), s[a].copy(), value[a].copy(), slope[a].copy(), c, d)


def short_numbers(start: IntArray, s: FloatArray, value: FloatArray, slope: FloatArray) -> tuple[FloatArray, ...]:
    """Return s, value and slope of knots with few digits, save for those at both ends of each curve.

    Cubics on both sides of a knot share the rounded numbers: they stay continuous, and files become shorter.
    """
    inner = np.ones(len(s), bool)
    inner[start[:-1]] = inner[start[1:] - 1] = False
    room = np.zeros(len(s), bool)
    room[1:-1] = np.minimum(s[1:-1] - s[:-2], s[2:] - s[1:-1]) > _ROOM * 10.0**-RECORD_S_DECIMALS
    near = np.where(inner & room, np.round(s, RECORD_S_DECIMALS), s)
    level = np.where(inner, np.round(value + slope * (near - s), RECORD_DECIMALS), value)
    return near, level, np.where(inner, np.round(slope, RECORD_SLOPE_DECIMALS), slope)


def thin_knots(
    start: IntArray,
    s: FloatArray,
    value: FloatArray,
    slope: FloatArray,
    value_tolerance: float = RECORD_TOLERANCE,
    slope_tolerance: float = RECORD_SLOPE_TOLERANCE,
    held: BoolArray | None = None,
) -> BoolArray:
    """Return which knots to keep so that the cubics between them still fit all knots; those `held`, (knots,), stay.

    Kept knots are kept exactly, so that value and slope stay continuous there. In each round every other knot is
    tried, odd and even ones in turn: neighbouring cubics are joined pair by pair, so that the cost is linear in the
    number of knots.
    """
    curve = np.repeat(np.arange(len(start) - 1), np.diff(start))
    keep = np.ones(len(s), bool)
    fixed = np.zeros(len(s), bool) if held is None else held.copy()
    fixed[start[:-1]] = fixed[start[1:] - 1] = True
    failed = 0
    phase = 1
    for _ in range(2 * int(np.ceil(np.log2(max(2, len(s)))))):
        kept = np.flatnonzero(keep)
        first = np.searchsorted(kept, start[:-1])
        place = np.arange(len(kept)) - first[curve[kept]]
        candidate = (place % 2 == phase) & ~fixed[kept]
        trial = kept[~candidate]
        misfit = _misfit(trial, s, value, slope, value_tolerance, slope_tolerance)
        # A candidate goes if no knot between its two neighbours is missed by the cubic that spans them.
        ends = np.searchsorted(trial, kept[candidate]) - 1
        good = ~misfit[ends]
        keep[kept[candidate][good]] = False
        failed = 0 if good.any() else failed + 1
        if failed == 2:
            break
        phase = 1 - phase
    return keep


def _misfit(
    trial: IntArray,
    s: FloatArray,
    value: FloatArray,
    slope: FloatArray,
    value_tolerance: float,
    slope_tolerance: float,
) -> BoolArray:
    """Return for each interval between trial knots whether its cubic misses a knot within."""
    interval = np.clip(np.searchsorted(trial, np.arange(len(s)), side="right") - 1, 0, len(trial) - 2)
    a, b = trial[interval], trial[interval + 1]
    h = np.maximum(s[b] - s[a], _SHORTEST)
    u = np.clip((s - s[a]) / h, 0.0, 1.0)
    u2, u3 = u * u, u * u * u
    blend = 3 * u2 - 2 * u3
    z = value[a] * (1 - blend) + value[b] * blend + h * (slope[a] * (u - 2 * u2 + u3) + slope[b] * (u3 - u2))
    g = 6 * (u - u2) * (value[b] - value[a]) / h + slope[a] * (1 - 4 * u + 3 * u2) + slope[b] * (3 * u2 - 2 * u)
    bad = (np.abs(z - value) > value_tolerance) | (np.abs(g - slope) > slope_tolerance)
    out = np.zeros(len(trial), bool)
    out[interval[bad]] = True
    return out


def thin_records(
    start: IntArray,
    s: FloatArray,
    value: FloatArray,
    slope: FloatArray,
    value_tolerance: float = RECORD_TOLERANCE,
    slope_tolerance: float = RECORD_SLOPE_TOLERANCE,
    held: BoolArray | None = None,
) -> CubicProfile:
    """Return few cubics that fit all knots, as of `hermite_records`, and are continuous in value and slope.

    Knots that are `held`, (knots,), stay.
    """
    keep = thin_knots(start, s, value, slope, value_tolerance, slope_tolerance, held)
    counts = np.add.reduceat(keep, start[:-1]) if len(start) > 1 else np.zeros(0, np.int64)
    kept_start = np.r_[0, np.cumsum(counts)].astype(np.int64)
    return hermite_records(kept_start, *short_numbers(kept_start, s[keep], value[keep], slope[keep]))


def with_knots(
    start: IntArray,
    s: FloatArray,
    value: FloatArray,
    slope: FloatArray,
    pins: Pins,
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Return the knots of many curves, as of `hermite_records`, with those of pins, and which are new.

    Pins lie apart from each other and from the ends of curves. A pin without a height or grade gets that of the cubic
    there.
    """
    records = hermite_records(start, s, value, slope)
    there = [
        np.where(np.isfinite(given), given, cubic(records, pins.road, pins.s))
        for given, cubic in ((pins.z, cubic_value), (pins.grade, cubic_slope))
    ]
    # A knot at the same place makes way.
    owner = np.repeat(np.arange(len(start) - 1), np.diff(start))
    ends = np.zeros(len(s), bool)
    ends[start[:-1]] = ends[start[1:] - 1] = True
    left = np.ones(len(s), bool)
    for number, place in zip(pins.road.tolist(), pins.s.tolist(), strict=True):
        part = slice(start[number], start[number + 1])
        left[part] &= ends[part] | (np.abs(s[part] - place) > _KNOT_DISTANCE)
    owner = np.concatenate([owner[left], pins.road])
    all_s = np.concatenate([s[left], pins.s])
    order = np.lexsort((all_s, owner))
    count = np.bincount(owner, minlength=len(start) - 1)
    held = np.zeros(len(order), bool)
    held[int(left.sum()) :] = True
    return (
        np.concatenate([[0], np.cumsum(count)]).astype(np.int64),
        all_s[order],
        np.concatenate([value[left], there[0]])[order],
        np.concatenate([slope[left], there[1]])[order],
        held[order],
    )


def only_curves(profile: CubicProfile, wanted: BoolArray) -> CubicProfile:
    """Return the profile with the records of the wanted curves, (curves,), only."""
    count = np.diff(profile.start)
    keep = np.repeat(wanted, count)
    start = np.r_[0, np.cumsum(np.where(wanted, count, 0))].astype(np.int64)
    return CubicProfile(start, profile.s[keep], profile.a[keep], profile.b[keep], profile.c[keep], profile.d[keep])
