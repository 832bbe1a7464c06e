"""How fast traffic drives along curves: the posted speed, in bends what cars take sideways."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves import heading_at, lengths, wrapped
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.problem import ProfileProblem, end_spans
from osm2xodr.model import FloatArray, IntArray, PlanView

# Speed where no limit is known, and the most where there is none, m/s: 50 and 130 km/h.
_UNKNOWN: Final = 50.0 / 3.6
_FASTEST: Final = 130.0 / 3.6
# Curvature of a bend is taken over the wheelbase of a car, m. Shorter curves count as the second length: keeps
# quotients finite.
WHEELBASE: Final = 2.7
_SHORTEST: Final = 1.0
# Where the middle of a car is beside a place, in wheelbases, when the fastest one around is looked for.
_CAR_AT: Final = (-0.5, -0.3, -0.15, 0.0, 0.15, 0.3, 0.5)
# Bends wider than 1000 km are straight, 1/m: keeps quotients finite.
_STRAIGHT: Final = 1e-6


def span_speeds(problem: ProfileProblem) -> FloatArray:
    """Return the speed that traffic may drive on each span, (K,), m/s."""
    if problem.span_speed is None:
        return np.full(len(problem.span_s), _UNKNOWN)
    return np.fmin(np.where(np.isnan(problem.span_speed), _UNKNOWN, problem.span_speed), _FASTEST)


def connector_speeds(problem: ProfileProblem, entry: IntArray, exit_: IntArray) -> FloatArray:
    """Return the speed limits between road ends, (n,), m/s: the lower ones of both."""
    at = span_speeds(problem)[end_spans(problem).ravel()]
    return np.asarray(np.minimum(at[entry], at[exit_]))


def fastest_around(plan: PlanView, curve: IntArray, s: FloatArray, posted: FloatArray) -> FloatArray:
    """Return the largest speed, (n,), m/s, of cars whose axles are on both sides of s of curves.

    Where bends in opposite directions follow each other the speed of `driven_speeds` rises for less than a metre.
    """
    length = lengths(plan, curve)
    around = (np.clip(s + at * WHEELBASE, 0.0, length) for at in _CAR_AT)
    return np.asarray(np.max([driven_speeds(plan, curve, place, posted) for place in around], axis=0))


def driven_speeds(plan: PlanView, curve: IntArray, s: FloatArray, posted: FloatArray) -> FloatArray:
    """Return the speed at s of curves with a posted speed, all (n,): less in bends than that, m/s.

    v² / R is at most `LATERAL_ACCELERATION`.
    """
    length = lengths(plan, curve)
    begin, end = (np.clip(s + side * WHEELBASE, 0.0, length) for side in (-0.5, 0.5))
    turn = wrapped(heading_at(plan, curve, end) - heading_at(plan, curve, begin))
    curvature = np.abs(turn) / np.maximum(end - begin, _SHORTEST)
    return np.minimum(posted, np.sqrt(defaults.LATERAL_ACCELERATION / np.maximum(curvature, _STRAIGHT)))
