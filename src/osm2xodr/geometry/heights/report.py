"""What is worth saying about the heights that were found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import GRADE_SLACK
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.elements import Elements, Samples
from osm2xodr.geometry.heights.problem import ProfileProblem, span_at
from osm2xodr.geometry.heights.readings import Reading
from osm2xodr.geometry.heights.structures import Crossings
from osm2xodr.model import BoolArray, FloatArray, IntArray, Structure

# Roads whose heights are farthest from the ground are named: so many, if they are off by this much, m.
WORST = 10
WORST_FROM = 5.0
# Shorter pieces without heights are not worth a word, m.
GAP_FROM = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A solution, as the report needs it."""

    z: FloatArray  # (n,) Height of the road at each sample, m
    reading: Reading  # The ground there
    floating: BoolArray  # (R,) Roads that no measured ground holds
    grade: FloatArray  # (E,) Largest grade of each element
    limit: FloatArray  # (E,) Limit of its class
    # Where layers cross, and the height between them, m
    crossings: Crossings
    clearance: FloatArray
    chain: IntArray  # (E,) Chain of structures of each element, -1 on the ground
    tilt: FloatArray  # (J,) Slope of each junction's plane


def element_grades(elements: Elements, knots: FloatArray) -> FloatArray:
    """Return the largest grade of each element, from z and g of the knots (knots, 2)."""
    a, b = knots[elements.knot], knots[elements.knot + 1]
    secant = (b[:, 0] - a[:, 0]) / elements.h
    # The grade is a parabola in u; where its vertex lies within the element it may be the steepest place.
    curve, slope = 3 * (a[:, 1] + b[:, 1] - 2 * secant), 2 * (3 * secant - 2 * a[:, 1] - b[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.clip(np.nan_to_num(-slope / (2 * curve), nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
    vertex = a[:, 1] + slope * u + curve * u * u
    out: FloatArray = np.max(np.abs([a[:, 1], b[:, 1], vertex]), axis=0)
    return out


def too_close(outcome: Outcome) -> BoolArray:
    """Return which crossings have less clearance than they should."""
    out: BoolArray = outcome.clearance < outcome.crossings.clearance - defaults.CLEARANCE_TOLERANCE
    return out


def report(
    problem: ProfileProblem, elements: Elements, samples: Samples, outcome: Outcome, diagnostics: Diagnostics
) -> None:
    """Tell which heights are guesses and which limits could not be met."""
    _report_gaps(problem, elements, samples, outcome, diagnostics)
    _report_grades(problem, elements, outcome, diagnostics)
    _report_crossings(problem, outcome, diagnostics)
    _report_inclines(problem, diagnostics)
    _report_worst(problem, elements, samples, outcome, diagnostics)


def _by_way(problem: ProfileProblem, elements: Elements, element: IntArray, value: FloatArray) -> dict[int, float]:
    """Return the sum of values at elements by OSM way, in order of ways."""
    way, index = np.unique(problem.span_way[elements.span[element]], return_inverse=True)
    total = np.bincount(index, value, minlength=len(way))
    return dict(zip(way.tolist(), total.tolist(), strict=True))


def _report_gaps(
    problem: ProfileProblem, elements: Elements, samples: Samples, outcome: Outcome, diagnostics: Diagnostics
) -> None:
    ground = elements.structure[samples.element] == Structure.GROUND
    floating = outcome.floating[elements.road[samples.element]]
    gap = np.flatnonzero(~outcome.reading.measured & (ground | floating))
    for way, length in _by_way(problem, elements, samples.element[gap], samples.ds[gap]).items():
        if length >= GAP_FROM:
            diagnostics.guessed(
                "no-height",
                f"way/{way}",
                f"the elevation model has no heights along {length:.0f} m of it, they are filled from around",
            )
    buried = np.flatnonzero(outcome.reading.measured & floating)
    for way, length in _by_way(problem, elements, samples.element[buried], samples.ds[buried]).items():
        diagnostics.guessed(
            "no-ground",
            f"way/{way}",
            f"nothing it is connected to lies on the ground, {length:.0f} m of it take its height there",
        )


def _report_grades(problem: ProfileProblem, elements: Elements, outcome: Outcome, diagnostics: Diagnostics) -> None:
    steep = np.flatnonzero(outcome.grade > GRADE_SLACK * outcome.limit + 0.002)
    largest: dict[int, tuple[float, float]] = {}
    for e in steep.tolist():
        way = int(problem.span_way[elements.span[e]])
        found = (float(outcome.grade[e]), float(outcome.limit[e]))
        largest[way] = max(largest.get(way, found), found)
    for way, (grade, limit) in sorted(largest.items()):
        diagnostics.note(
            "steep",
            f"way/{way}",
            f"its grade reaches {100 * grade:.1f} %, more than the {100 * limit:.0f} % usual for its class",
        )


def _report_crossings(problem: ProfileProblem, outcome: Outcome, diagnostics: Diagnostics) -> None:
    crossings = outcome.crossings
    upper = problem.span_way[span_at(problem, crossings.upper, crossings.upper_s)]
    lower = problem.span_way[span_at(problem, crossings.lower, crossings.lower_s)]
    # Rounded, and 0 without a sign.
    clearance = np.round(outcome.clearance, 1) + 0.0
    for k in np.flatnonzero(too_close(outcome)).tolist():
        diagnostics.note(
            "clearance",
            f"way/{upper[k]}",
            f"it passes {clearance[k]:.1f} m above way/{lower[k]} instead of {crossings.clearance[k]:.1f} m, "
            "more would make the roads too steep",
        )


def _report_inclines(problem: ProfileProblem, diagnostics: Diagnostics) -> None:
    wrong = np.isfinite(problem.span_grade) & (np.abs(problem.span_grade) > defaults.INCLINE_MAX)
    for way in np.unique(problem.span_way[wrong]).tolist():
        diagnostics.dropped("incline", f"way/{way}", "its incline is steeper than any street, it is ignored")


def _report_worst(
    problem: ProfileProblem, elements: Elements, samples: Samples, outcome: Outcome, diagnostics: Diagnostics
) -> None:
    ground = elements.structure[samples.element] == Structure.GROUND
    held = np.flatnonzero(ground & outcome.reading.measured)
    way, index = np.unique(problem.span_way[elements.span[samples.element[held]]], return_inverse=True)
    off = np.zeros(len(way))
    np.maximum.at(off, index, np.abs(outcome.z - outcome.reading.z)[held])
    for k in np.argsort(-off, kind="stable")[:WORST].tolist():
        if off[k] >= WORST_FROM:
            diagnostics.note(
                "off-ground",
                f"way/{way[k]}",
                f"it lies up to {off[k]:.1f} m off the ground of the elevation model, to stay smooth and passable",
            )
