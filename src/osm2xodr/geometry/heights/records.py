"""From heights and grades at knots to the records that are written."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import cubic_slope, cubic_value
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.problem import Pins
from osm2xodr.model import BoolArray, CubicProfile, FloatArray, IntArray
from osm2xodr.system import record

# Knots closer to a pin than this make way for it, m.
_KNOT_DISTANCE: Final = 0.1
# Shorter intervals count as this long, m: keeps quotients finite.
_SHORTEST: Final = 1e-12
# A knot is only rounded along the road if its neighbours are this many units of the last decimal away.
_ROOM: Final = 10


@record(eq=False)
class Knots:
    """Values and slopes at the knots of many curves."""

    start: IntArray  # (curves + 1,) Index of each curve's first knot; every curve has at least two
    # (knots,) Where the knots lie, and value and slope there
    s: FloatArray
    value: FloatArray
    slope: FloatArray

    @property
    def curve(self) -> IntArray:
        """The curve of each knot, (knots,)."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))

    @property
    def is_end(self) -> BoolArray:
        """Whether each knot is the first or last of its curve, (knots,)."""
        out = np.zeros(len(self.s), bool)
        out[self.start[:-1]] = out[self.start[1:] - 1] = True
        return out


def level_profile(value: FloatArray) -> CubicProfile:
    """Return one constant for each curve, (curves,)."""
    zero = np.zeros(len(value))
    return CubicProfile(np.arange(len(value) + 1, dtype=np.int64), zero, value, zero, zero, zero)


def hermite_records(knots: Knots) -> CubicProfile:
    """Return the cubics through all knots."""
    return hermite_cubics(knots.start, knots.s, knots.value, knots.slope, knots.slope)


def hermite_cubics(
    start: IntArray, s: FloatArray, value: FloatArray, before: FloatArray, after: FloatArray
) -> CubicProfile:
    """Return the cubics from each knot to the next one of its curve.

    `start`, (curves + 1,), has the index of each curve's first knot. At the knots, (knots,), the slope is `before` up
    to them and `after` from them on.
    """
    a = np.setdiff1d(np.arange(len(s)), start[1:] - 1)
    b = a + 1
    h = s[b] - s[a]
    secant = (value[b] - value[a]) / h
    c = (3 * secant - 2 * after[a] - before[b]) / h
    d = (after[a] + before[b] - 2 * secant) / (h * h)
    first = (start - np.arange(len(start))).astype(np.int64)
    return CubicProfile(first, s[a], value[a], after[a], c, d)


def short_numbers(knots: Knots) -> Knots:
    """Return the knots with few digits, except at both ends of each curve.

    Cubics on both sides of a knot share the rounded numbers: they stay continuous, and files become shorter.
    """
    s, inner = knots.s, ~knots.is_end
    room = np.zeros(len(s), bool)
    room[1:-1] = np.minimum(s[1:-1] - s[:-2], s[2:] - s[1:-1]) > _ROOM * 10.0**-defaults.RECORD_S_DECIMALS
    near = np.where(inner & room, np.round(s, defaults.RECORD_S_DECIMALS), s)
    value = np.round(knots.value + knots.slope * (near - s), defaults.RECORD_DECIMALS)
    slope = np.round(knots.slope, defaults.RECORD_SLOPE_DECIMALS)
    return Knots(knots.start, near, np.where(inner, value, knots.value), np.where(inner, slope, knots.slope))


def thin_records(
    knots: Knots,
    value_tolerance: float = defaults.RECORD_TOLERANCE,
    slope_tolerance: float = defaults.RECORD_SLOPE_TOLERANCE,
    held: BoolArray | None = None,
) -> CubicProfile:
    """Return few cubics that fit all knots and are continuous in value and slope; those `held`, (knots,), stay.

    Kept knots are kept exactly. In each round every other knot is tried, odd and even ones in turn: neighbouring
    cubics are joined pair by pair, so that the cost is linear in the number of knots.
    """
    start, curve = knots.start, knots.curve
    keep = np.ones(len(knots.s), bool)
    fixed = knots.is_end if held is None else knots.is_end | held
    failed, phase = 0, 1
    for _ in range(2 * int(np.ceil(np.log2(max(2, len(keep)))))):
        kept = np.flatnonzero(keep)
        place = np.arange(len(kept)) - np.searchsorted(kept, start[:-1])[curve[kept]]
        candidate = (place % 2 == phase) & ~fixed[kept]
        trial = kept[~candidate]
        misfit = _misfit(trial, knots, value_tolerance, slope_tolerance)
        # A candidate goes if no knot between its two neighbours is missed by the cubic that spans them.
        good = ~misfit[np.searchsorted(trial, kept[candidate]) - 1]
        keep[kept[candidate][good]] = False
        failed = 0 if good.any() else failed + 1
        if failed == 2:
            break
        phase = 1 - phase
    kept_start = np.r_[0, np.cumsum(keep)][start].astype(np.int64)
    return hermite_records(short_numbers(Knots(kept_start, knots.s[keep], knots.value[keep], knots.slope[keep])))


def _misfit(trial: IntArray, knots: Knots, value_tolerance: float, slope_tolerance: float) -> BoolArray:
    """Return for each interval between trial knots whether its cubic misses a knot within."""
    s, value, slope = knots.s, knots.value, knots.slope
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


def add_pins(knots: Knots, pins: Pins) -> tuple[Knots, BoolArray]:
    """Return the knots with those of pins, and which are new, (knots,).

    Pins lie apart from each other, and right at the ends of curves or apart from these. A pin without a height or
    grade gets that of the cubic there.
    """
    records = hermite_records(knots)
    value, slope = (
        np.where(np.isfinite(given), given, cubic(records, pins.road, pins.s))
        for given, cubic in ((pins.z, cubic_value), (pins.grade, cubic_slope))
    )
    # A knot at the same place makes way.
    left, ends = np.ones(len(knots.s), bool), knots.is_end
    for road, s in zip(pins.road.tolist(), pins.s.tolist(), strict=True):
        part = slice(knots.start[road], knots.start[road + 1])
        # The end of a curve only for a pin that lies there itself.
        left[part] &= np.abs(knots.s[part] - s) > np.where(ends[part], 0.0, _KNOT_DISTANCE)
    curve = np.concatenate([knots.curve[left], pins.road])
    s, value, slope = (
        np.concatenate([old[left], new])
        for old, new in ((knots.s, pins.s), (knots.value, value), (knots.slope, slope))
    )
    order = np.lexsort((s, curve))
    start = np.r_[0, np.cumsum(np.bincount(curve, minlength=len(knots.start) - 1))].astype(np.int64)
    return Knots(start, s[order], value[order], slope[order]), order >= int(left.sum())


def only_curves(profile: CubicProfile, wanted: BoolArray) -> CubicProfile:
    """Return the profile with the records of the wanted curves, (curves,), only."""
    keep = np.repeat(wanted, np.diff(profile.start))
    start = np.r_[0, np.cumsum(keep)][profile.start].astype(np.int64)
    return CubicProfile(start, profile.s[keep], profile.a[keep], profile.b[keep], profile.c[keep], profile.d[keep])


def spread_curves(profile: CubicProfile, row: IntArray, curves: int) -> CubicProfile:
    """Return so many curves, of which those of ascending rows are the profile's; others have no records."""
    count = np.zeros(curves, np.int64)
    count[row] = np.diff(profile.start)
    return replace(profile, start=np.concatenate([[0], np.cumsum(count)]).astype(np.int64))


def either_profile(first: CubicProfile, second: CubicProfile) -> CubicProfile:
    """Return the curves of the first profile, and those of the second where the first has no records."""
    keep = only_curves(second, np.diff(first.start) == 0)
    start = (first.start + keep.start).astype(np.int64)
    owner = np.concatenate([np.repeat(np.arange(len(start) - 1), np.diff(part.start)) for part in (first, keep)])
    order = np.argsort(owner, kind="stable")
    columns = (np.concatenate([getattr(part, name) for part in (first, keep)])[order] for name in "sabcd")
    return CubicProfile(start, *columns)
