"""Curves as rows of points, and how far least squares move these aside (docs/method/plan_view.md)."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import (
    RaggedTable,
    advance,
    arctan2,
    cosine,
    cosine_sine,
    cube_root,
    find_record,
    hypot,
    lengths,
    owners,
    ranks,
    record_turns,
    repeated,
    sine,
    sorted_unique,
    starts,
    sum_before,
    wrapped,
)
from osm2xodr.geometry.plan_view import defaults
from osm2xodr.geometry.plan_view.banded import add_squares, average, grade, solve_banded
from osm2xodr.model import BoolArray, FloatArray, IntArray, PlanView
from osm2xodr.system import record

# A curve has this many intervals at least: differences of the fourth order need them.
_FEWEST_INTERVALS: Final = 6
# Least distance of two points, m: keeps quotients finite.
_LEAST_CHORD: Final = 1e-9
# Bends count as corners of this turn at most, rad: half of it is 75 degrees. Curvatures above this, 1/m, are bends.
_LARGEST_HALF_TURN: Final = 1.3
_LEAST_CURVATURE: Final = 1e-9

# Weights of points that stay where they are (stiff short curves weigh 1e10), and of a curvature that is even between
# knots, against that of a metre.
_HELD: Final = 1e15
_EVEN: Final = 1e6
# The length over which curves are smoothed, m: at most, at least, and by how much it grows along a curve, m per m.
_LONGEST: Final = 40.0
_SHORTEST: Final = 2.0
_GROWTH: Final = 0.12
# Rounds in which it shrinks where points move too far, by these factors at least and at most; where a curve is
# sharper than it was by more than this share it shrinks, too. Choices.
_ROUNDS: Final = 10
_SHRINK: Final = (0.4, 0.9)
_SHARPER: Final = 1.02
# Sharper than what lies this near, m, and than this radius, m.
_NEAR: Final = 15.0
GENTLE: Final = 25.0
# Smoothing where the curvature is to be even between knots, m: it only settles what these leave open.
_SETTLE: Final = 0.3


@record(eq=False)
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


def smoothest_offsets(points: FinePoints, held: BoolArray, nodes: FloatArray) -> FloatArray:
    """Return how far to the left points move, (points,), m: as smooth as `SMOOTH_SHIFT` allows.

    Minimises the sum of d² + λ⁶ κ'², where λ is the length over which a curve is smoothed: as long as, in the mean
    over λ, no point moves too far, none moves by more than `SMOOTH_SHIFT_MOST`, and no bend becomes sharper than
    what is near it. Ends stay; those that are `held`, (curves, 2), keep their heading. `nodes`, (points,), are
    weights beyond 1.
    """
    scale, aside = np.full(len(points.s), _LONGEST), np.zeros(len(points.s))
    share, curves, radius = room_share(points), np.arange(len(held)), 1.0 / sharpest_near(points)
    for _ in range(_ROUNDS):
        part, row = points.chosen(curves), points.rows(curves)
        owner = owners(part.start)
        aside[row] = found = _solved(part, scale[row], held[curves], nodes=nodes[row])
        mean = np.abs(_averaged(part, found, scale[row])) / defaults.SMOOTH_SHIFT
        excess = np.maximum(mean, np.abs(found) / defaults.SMOOTH_SHIFT_MOST) / share[row]
        sharper = np.abs(part.bent(found)) * radius[row] / _SHARPER
        bad = (excess > 1.0) | (sharper > 1.0)
        if not bad.any():
            break
        most = np.maximum(cube_root(excess[bad]), np.square(np.square(sharper[bad])))
        factor = np.clip(1.0 / np.maximum(most, 1.0), *_SHRINK)
        shrunk = scale[row]
        shrunk[bad] = np.maximum(shrunk[bad] * factor, _SHORTEST)
        scale[row] = _graded(part, shrunk)
        curves = curves[sorted_unique(owner[bad])]
    return aside


def sharpest_near(points: FinePoints) -> FloatArray:
    """Return the largest curvature within `_NEAR` of each point, at least that of `GENTLE`, (points,), 1/m."""
    owner = owners(points.start)
    same = np.append(owner[1:] == owner[:-1], False)
    bend = np.maximum(np.abs(points.curvature), 1.0 / GENTLE)
    for _ in range(round(_NEAR / defaults.SMOOTH_STEP)):
        after, before = np.where(same, np.roll(bend, -1), 0.0), np.where(np.roll(same, 1), np.roll(bend, 1), 0.0)
        bend = np.maximum(bend, np.maximum(before, after))
    return bend


def room_share(points: FinePoints) -> FloatArray:
    """Return which share of `SMOOTH_SHIFT` points may move, (points,): less in corners, which are cut already."""
    cut = np.maximum(points.cut, np.maximum(np.roll(points.cut, 1), np.roll(points.cut, -1)))
    return np.asarray(np.clip(1.0 - cut / defaults.SMOOTH_CUT, defaults.SMOOTH_SHARE_LEAST, 1.0))


def even_offsets(points: FinePoints, knot: IntArray, held: BoolArray) -> FloatArray:
    """Return how far to the left points move, (points,), m, for curvature to be even between knots, (knots,)."""
    free = np.zeros(len(points.s), bool)
    free[knot] = True
    return _solved(points, np.full(len(points.s), _SETTLE), held, free)


def _solved(
    points: FinePoints,
    scale: FloatArray,
    held: BoolArray,
    free: BoolArray | None = None,
    nodes: FloatArray | float = 0.0,
) -> FloatArray:
    """Return the offsets with the least squares, (points,), m; all but `free` points bend as their neighbours do.

    `nodes`, (points,), are weights beyond 1.
    """
    owner, h, k = owners(points.start), points.spacing, points.curvature
    matrix = np.zeros((4 if free is None else 5, len(owner)))
    matrix[0] = 1.0 + nodes
    first, last = points.start[:-1], points.start[1:] - 1
    for row in (first, last, first[held[:, 0]] + 1, last[held[:, 1]] - 1):
        matrix[0, row] = _HELD
    right = np.zeros(len(owner))
    # The change of curvature from each point to the next, by the offsets of four.
    shorter = np.minimum(scale[1:-2], scale[2:-1])
    cube = np.where(owner[3:] == owner[:-3], shorter * shorter * shorter, 0.0)
    step = h[1:-2]
    third, bend = cube / (step * step * step), cube / step
    change = [-third, 3 * third - bend * k[1:-2] ** 2, -3 * third + bend * k[2:-1] ** 2, third]
    add_squares(np.stack(change), bend * (k[2:-1] - k[1:-2]), matrix, right)
    if free is not None:
        # The change of that change, by the offsets of five.
        weight = np.where((owner[4:] == owner[:-4]) & ~free[2:-2], np.sqrt(_EVEN), 0.0)
        square = h[2:-2] ** 2
        a, b, c = (square * part**2 for part in (k[1:-3], k[2:-2], k[3:-1]))
        terms = [weight, weight * (a - 4), weight * (6 - 2 * b), weight * (c - 4), weight]
        add_squares(np.stack(terms), weight * square * (k[1:-3] - 2 * k[2:-2] + k[3:-1]), matrix, right)
    return solve_banded(matrix, right)


def _averaged(points: FinePoints, aside: FloatArray, scale: FloatArray) -> FloatArray:
    """Return the mean offsets over λ about each point, or as much of it as its curve has on both sides, (points,), m.

    Errors of nodes cancel out in it; a bend that is cut does not.
    """
    total, out = np.zeros(len(aside) + 1), np.empty(len(aside))
    np.cumsum(aside, out=total[1:])
    average(points.start, points.spacing, total, scale, out)
    return out


def _graded(points: FinePoints, scale: FloatArray) -> FloatArray:
    """Return lengths of smoothing, (points,), m, that grow along the curves by `_GROWTH` at most."""
    # Curves lie so far from each other that none counts for another.
    at = _GROWTH * points.spacing
    at[points.start[:-1]] = _LONGEST
    np.cumsum(at, out=at)
    out = np.empty(len(scale))
    grade(at, scale, out)
    return out
