"""Superelevation that spares lanes a step of their grade where a climbing road goes from straight into a tight arc.

A lane at t has the grade (z' + t χ') / (1 - k t), with the superelevation χ. Where the reference line's curvature k
steps, so would the grades of all lanes beside it. The surface of a road that turned gradually has no such step: with
the curvature k* that is k averaged over some metres, χ' = z' (k* - k). Formulas: docs/method/heights.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from osm2xodr.curves import cubic_slope, end_curvature, lengths, owners, profile_of
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at, span_sides
from osm2xodr.geometry.heights.speeds import WHEELBASE, fastest_around, span_speeds
from osm2xodr.model import BoolArray, Cubic, CubicProfile, FloatArray, IntArray

# From the edge of a carriageway to the middle of its outer lane, m.
_EDGE_TO_LANE: Final = 1.6
# Length on either side of a step over which curvature is averaged, m; where there is less than the second, the step
# stays. Choices: tight arcs are not much longer.
_REACH: Final = 4.0
_LEAST_REACH: Final = 1.0
# Largest slope of superelevation, rad/m. A choice: 1.5 times that of connecting roads, over a few metres.
_LARGEST_TWIST: Final = 0.018
# Least length of a lane beside that of the reference line: keeps quotients finite in bends that fold.
_LEAST_LENGTH_SHARE: Final = 0.1
# Places closer to each other than this are one, m.
_SAME_PLACE: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """Places where the reference line's curvature steps, sorted by roads and along them."""

    road: IntArray  # (n,)
    s: FloatArray  # (n,) m
    change: FloatArray  # (n,) Grade times step of curvature: what χ' has to make up for, 1/m
    reach: FloatArray  # (n,) m


def ease_lane_grades(problem: ProfileProblem, elevation: CubicProfile) -> CubicProfile | None:
    """Return superelevation of roads, R curves, rad, 0 with slope 0 at their ends; None where no road needs any.

    `elevation` has the heights of the roads. The steps count where they would be felt at the speed that cars drive.
    """
    steps = _felt_steps(problem, elevation)
    if not len(steps.road):
        return None
    curves: list[list[Cubic]] = [[] for _ in range(len(problem.end_junction))]
    for road in np.unique(steps.road).tolist():
        curves[road] = _records(steps, np.flatnonzero(steps.road == road))
    return profile_of(curves)


def _felt_steps(problem: ProfileProblem, elevation: CubicProfile) -> _Steps:
    plan, length = problem.plan_view, lengths(problem.plan_view)
    record = np.setdiff1d(np.arange(len(plan.s)), plan.start[:-1])
    before, after = end_curvature(plan, record - 1), plan.curvature[record]
    road, s = owners(plan.start)[record], plan.s[record]
    grade = cubic_slope(elevation, road, s)
    span = span_at(problem, road, s)
    half, middle = (side[span] for side in span_sides(problem))
    outer = np.maximum(half - _EDGE_TO_LANE, 0.0)
    step = np.zeros(len(s))
    for t in (middle - outer, middle + outer):
        shorter = [1.0 / np.maximum(1.0 - k * t, _LEAST_LENGTH_SHARE) for k in (before, after)]
        step = np.maximum(step, np.abs(grade * (shorter[1] - shorter[0])))
    posted = span_speeds(problem)[span]
    least = defaults.VERTICAL_ACCELERATION_MAX * WHEELBASE
    felt: BoolArray = step * posted**2 > least
    # Bends only make cars slower.
    at = np.flatnonzero(felt)
    felt[at] = step[at] * fastest_around(plan, road[at], s[at], posted[at]) ** 2 > least
    reach = np.minimum(_REACH, np.minimum(s, length[road] - s))
    if problem.pins is not None:
        for pin_road, pin_s in zip(problem.pins.road.tolist(), problem.pins.s.tolist(), strict=True):
            reach = np.where(road == pin_road, np.minimum(reach, np.abs(s - pin_s)), reach)
    used = np.flatnonzero(_with_neighbours(road, s, felt) & (reach > _LEAST_REACH))
    return _Steps(road[used], s[used], (grade * (after - before))[used], reach[used])


def _with_neighbours(road: IntArray, s: FloatArray, felt: BoolArray) -> BoolArray:
    """Return the steps that are felt, and those whose reach holds one of these, (n,), sorted along roads."""
    # Roads one after the other, with more than the reach between them.
    place = s + road * (float(s.max(initial=0.0)) + 2 * _REACH)
    here = np.concatenate([[-np.inf], place[felt], [np.inf]])
    after = np.searchsorted(here, place)
    out: BoolArray = np.minimum(place - here[after - 1], here[after] - place) < _REACH
    return out


def _records(steps: _Steps, of_road: IntArray) -> list[Cubic]:
    """Return the superelevation of one road: parabolas between the places where a step's reach begins or ends.

    A step of k at 0, averaged over a on both sides, leaves k* - k = (u + a) / 2a before it and (u - a) / 2a behind.
    """
    s, change, reach = steps.s[of_road], steps.change[of_road], steps.reach[of_road]
    knots = np.unique(np.concatenate([[0.0], s - reach, s, s + reach]))
    knots = knots[np.r_[True, np.diff(knots) > _SAME_PLACE]]
    value, slope, bend = (np.zeros(len(knots)) for _ in range(3))
    for at, size, a in zip(s.tolist(), change.tolist(), reach.tolist(), strict=True):
        u = knots - at
        side = np.where(u < -_SAME_PLACE, a, -a)
        inside = (u > -a - _SAME_PLACE) & (u < a - _SAME_PLACE)
        value += np.where(inside, size * (u + side) ** 2 / (4 * a), 0.0)
        slope += np.where(inside, size * (u + side) / (2 * a), 0.0)
        bend += np.where(inside, size / (4 * a), 0.0)
    # Twist is largest where pieces begin or end.
    end = slope[:-1] + 2 * bend[:-1] * np.diff(knots)
    share = min(1.0, _LARGEST_TWIST / max(float(np.abs(np.r_[slope, end]).max()), _LARGEST_TWIST))
    columns = (
        np.round(share * v, d)
        for v, d in (
            (value, defaults.RECORD_DECIMALS + 3),
            (slope, defaults.RECORD_SLOPE_DECIMALS + 2),
            (bend, defaults.RECORD_SLOPE_DECIMALS + 4),
        )
    )
    rows = zip(knots.tolist(), *(column.tolist() for column in columns), strict=True)
    return [Cubic(at, a, b, c, 0.0) for at, a, b, c in rows]
