"""Curves as rows of points a few metres apart, which least squares move aside (docs/method/plan_view.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import (
    RaggedTable,
    advance,
    arctan2,
    cosine,
    cosine_sine,
    find_record,
    hypot,
    lengths,
    owners,
    ranks,
    record_turns,
    repeated,
    sine,
    starts,
    sum_before,
    wrapped,
)
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.model import FloatArray, IntArray, PlanView

# A curve has this many intervals at least: differences of the fourth order need them.
_FEWEST_INTERVALS: Final = 6
# Least distance of two points, m: keeps quotients finite.
_LEAST_CHORD: Final = 1e-9
# Bends count as corners of this turn at most, rad: half of it is 75 degrees. Curvatures above this, 1/m, are bends.
_LARGEST_HALF_TURN: Final = 1.3
_LEAST_CURVATURE: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class FinePoints(RaggedTable):
    """Points along curves, from end to end, curve after curve."""

    start: IntArray  # (curves + 1,) Index of each curve's first point; the last entry is the number of points
    # (points,) All of a point
    s: FloatArray  # Along the curve, m
    spacing: FloatArray  # Distance from its neighbours, m
    x: FloatArray  # m
    y: FloatArray
    hdg: FloatArray  # rad, continuous along each curve
    curvature: FloatArray  # Mean over half the way to both neighbours, 1/m
    cut: FloatArray  # How far the curve cuts the corner of its polyline there, m

    @classmethod
    def along(cls, plan: PlanView, rows: IntArray) -> FinePoints:
        """Return points evenly along some curves, at most `SMOOTH_STEP` apart."""
        length = lengths(plan, rows)
        count = np.maximum(np.ceil(length / defaults.SMOOTH_STEP).astype(np.int64), _FEWEST_INTERVALS) + 1
        owner = repeated(count)
        spacing = (length / (count - 1))[owner]
        s = spacing * ranks(count)
        record = find_record(plan.start, plan.s, rows[owner], s)
        begins = plan.x[record], plan.y[record], plan.hdg[record], plan.curvature[record]
        x, y, hdg = advance(*begins, s - plan.s[record], plan.rate[record])
        start = starts(count)
        first, last = start[:-1], start[1:] - 1
        # Headings half-way to the next point, at last at the end.
        half = s + 0.5 * spacing
        half[last] = length
        ahead = _headings(plan, rows[owner], half)
        turn, over = np.diff(ahead, prepend=0.0), spacing.copy()
        turn[first] = ahead[first] - hdg[first]
        over[first] *= 0.5
        over[last] *= 0.5
        turn = wrapped(turn)
        return cls(start, s, spacing, x, y, continuous(hdg, start), turn / over, _cuts(plan)[record])

    def nearest(self, curve: IntArray, s: FloatArray) -> IntArray:
        """Return the points nearest to places s along curves as they were taken, both (n,)."""
        first = self.start[curve]
        return np.asarray(first + np.rint(s / self.spacing[first]).astype(np.int64))

    def moved(self, aside: FloatArray) -> FinePoints:
        """Return the points moved to the left, (points,), m, with headings and curvatures that they have there."""
        cos, sin = cosine_sine(self.hdg)
        x, y = self.x - sin * aside, self.y + cos * aside
        first, last = self.start[:-1], self.start[1:] - 1
        dx, dy = np.diff(x, append=0.0), np.diff(y, append=0.0)
        dx[last], dy[last] = dx[last - 1], dy[last - 1]
        after = np.maximum(hypot(dx, dy), _LEAST_CHORD)
        ahead = continuous(arctan2(dy, dx), self.start)
        before, behind = np.roll(after, 1), np.roll(ahead, 1)
        before[first], behind[first] = after[first], ahead[first]
        spacing = 0.5 * (before + after)
        curvature = 2.0 * sine(0.5 * (ahead - behind)) / spacing
        curvature[first], curvature[last] = curvature[first + 1], curvature[last - 1]
        hdg = 0.5 * (ahead + behind)
        hdg[first] = ahead[first] - 0.5 * curvature[first] * after[first]
        hdg[last] = ahead[last] + 0.5 * curvature[last] * after[last]
        # An arc over its chord.
        step = after * (1.0 + (curvature * after) ** 2 / 24.0)
        return FinePoints(self.start, sum_before(step, self.start), spacing, x, y, hdg, curvature, self.cut)

    def bent(self, aside: FloatArray) -> FloatArray:
        """Return the curvature that the points have if they move to the left by a little, (points,), 1/m."""
        out = self.curvature.copy()
        second = (aside[2:] - 2 * aside[1:-1] + aside[:-2]) / self.spacing[1:-1] ** 2
        out[1:-1] += second + out[1:-1] ** 2 * aside[1:-1]
        first, last = self.start[:-1], self.start[1:] - 1
        out[first], out[last] = out[first + 1], out[last - 1]
        return out


def _headings(plan: PlanView, curve: IntArray, s: FloatArray) -> FloatArray:
    """Return the headings at s of curves, all (n,), rad."""
    record = find_record(plan.start, plan.s, curve, s)
    ds = s - plan.s[record]
    return np.asarray(plan.hdg[record] + ds * (plan.curvature[record] + 0.5 * plan.rate[record] * ds))


def _cuts(plan: PlanView) -> FloatArray:
    """Return how far arcs lie aside of the corners that they were fitted to, (records,), m; 0 for lines.

    Their vertices were moved outwards by half of what the arcs cut off, as far as `fit_polylines` moves them.
    """
    half = np.minimum(np.abs(record_turns(plan)) / 2, _LARGEST_HALF_TURN)
    off = (1.0 / cosine(half) - 1.0) / np.maximum(np.abs(plan.curvature), _LEAST_CURVATURE)
    return np.asarray(np.maximum(off / 2, off - defaults.CORNER_CUT_MAX / 2) * cosine(half))


def continuous(hdg: FloatArray, start: IntArray) -> FloatArray:
    """Return headings, (n,), rad, that nowhere step by more than half a turn within their curves."""
    step = wrapped(np.diff(hdg, prepend=0.0))
    return np.asarray(hdg[start[:-1]][owners(start)] + sum_before(np.append(step[1:], 0.0), start))
