"""Arcs and spirals that are too flat for readers to compute with, written as lines and arcs.

CARLA goes to the centre of an arc and back (``GeometryArc::PosFromDist``) in numbers of single precision: with a
radius of 30,000 km the places along such a road lie 2 m apart, with 1000 km still 3 cm beside it.

esmini 3.6 (``Spiral`` in ``RoadManager.cpp``) and libOpenDRIVE 0.6 (``OpenDriveMap.cpp``) take curvatures, and
changes of curvature, below 1e-6 / m for 0: a spiral is an arc or a line then, or begins straight. The end of a nearly
straight road of 784 m lay 5 cm aside.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import advance, cube_root, cut_records, lines_that_go_on, owners, ranks, wrapped
from osm2xodr.model import FloatArray, IntArray, PlanView

# Radius beyond which arcs become lines, m: numbers of single precision are 1.6 cm apart there.
LARGEST_RADIUS: Final = 200e3
# How far what is written may lie beside the curve, m; a choice. Headings of lines differ by less than 0.01 degrees.
_BESIDE: Final = 0.0007
# Curvatures that readers take for 0, 1/m, and a tenth more: what is written is rounded.
_STRAIGHT: Final = 1.1e-6
# Spirals that readers misplace by less stay as they are, and arcs lie no farther beside them, m. A choice.
_MISPLACED: Final = 1e-4
# Lines whose headings differ by less, rad, go on in the same direction. A choice: twice what ASAM's checker takes.
_SAME_HEADING: Final = 2e-6
# Where a part of a spiral is replaced, it is at least so long, m. A choice.
_SHORTEST: Final = 0.5


def without_flat_curves(plan: PlanView) -> PlanView:
    """Replace flat spirals by arcs, and arcs of large radii by lines."""
    out = _without_flat_arcs(_without_flat_spirals(plan))
    return plan if out is plan else _with_joined_lines(out)


def _without_flat_spirals(plan: PlanView) -> PlanView:
    """Replace spirals, or their first parts, that readers take for another curve by pairs of arcs.

    Two arcs of equal length, whose curvatures differ from the mean of the spiral by a third of its change, have the
    spiral's ends, its middle and its headings at the ends; in between they leave it by 1/324 of the change times the
    length squared.
    """
    part = _flat_part(plan)
    rows = np.flatnonzero(part)
    if not len(rows):
        return plan
    beside = np.abs(plan.rate[rows]) * part[rows] * np.square(part[rows]) / 324.0
    pairs = np.maximum(np.ceil(cube_root(beside / _MISPLACED)), 1.0).astype(np.int64)
    cuts = 2 * pairs - (part[rows] >= plan.length[rows])
    out = _cut_evenly(plan, rows, part[rows] / (2 * pairs), cuts)
    first = np.repeat(rows + np.cumsum(cuts) - cuts, pairs) + 2 * ranks(pairs)
    half, rate = out.length[first], out.rate[first]
    third = 2.0 * rate * half / 3.0
    mean = out.curvature[first] + rate * half
    x, y, hdg, curvature, rates = (item.copy() for item in (out.x, out.y, out.hdg, out.curvature, out.rate))
    curvature[first], curvature[first + 1] = mean - third, mean + third
    rates[first] = rates[first + 1] = 0.0
    start = x[first], y[first], hdg[first]
    x[first + 1], y[first + 1], hdg[first + 1] = advance(*start, curvature[first], half)
    return replace(out, x=x, y=y, hdg=hdg, curvature=curvature, rate=rates)


def _cut_evenly(plan: PlanView, rows: IntArray, every: FloatArray, cuts: IntArray) -> PlanView:
    """Cut records (n,) so many times each, at every so many metres from their starts."""
    return cut_records(plan, np.repeat(rows, cuts), np.repeat(every, cuts) * (ranks(cuts) + 1))


def _with_joined_lines(plan: PlanView) -> PlanView:
    """Make one line of lines that go on in the same direction: ASAM's checker calls them redundant."""
    goes_on = lines_that_go_on(plan, owners(plan.start), _SAME_HEADING)
    kept = np.flatnonzero(np.concatenate([[True], ~goes_on]))
    length = np.add.reduceat(plan.length, kept)
    more = wrapped(plan.hdg - np.repeat(plan.hdg[kept], np.diff(np.append(kept, len(plan.s)))))
    # From the first one's start to the last one's end.
    hdg = plan.hdg[kept] + np.add.reduceat(more * plan.length, kept) / length
    s, x, y, curvature, rate = (getattr(plan, name)[kept] for name in ("s", "x", "y", "curvature", "rate"))
    return PlanView(np.searchsorted(kept, plan.start), s, x, y, hdg, length, curvature, rate)


def _flat_part(plan: PlanView) -> FloatArray:
    """Return what readers misplace of each record, from its start on, (records,), m; 0 for nothing."""
    start, change = plan.curvature, plan.rate * plan.length
    straight = np.abs(start) < _STRAIGHT
    beside = np.where(np.abs(change) < _STRAIGHT, np.abs(change) / 6.0, 0.0)
    beside = np.maximum(beside, np.where(straight, np.abs(start) / 2.0, 0.0)) * plan.length**2
    # As far as curvature stays small; what is left then must change by more.
    with np.errstate(divide="ignore", invalid="ignore"):
        reached = np.maximum((np.copysign(_STRAIGHT, change) - start) / plan.rate, _SHORTEST)
    rest = np.abs(start + change) - _STRAIGHT
    whole = ~straight | (rest < _STRAIGHT)
    return np.where((plan.rate != 0.0) & (beside > _MISPLACED), np.where(whole, plan.length, reached), 0.0)


def _without_flat_arcs(plan: PlanView) -> PlanView:
    """Replace arcs of large radii by lines between places on them."""
    bent = (plan.rate == 0.0) & (plan.curvature != 0.0)
    flat = np.flatnonzero(bent & (np.abs(plan.curvature) * LARGEST_RADIUS < 1.0))
    if not len(flat):
        return plan
    count = np.ceil(plan.length[flat] * np.sqrt(np.abs(plan.curvature[flat]) / (8.0 * _BESIDE))).astype(np.int64)
    count = np.maximum(count, 1)
    out = _cut_evenly(plan, flat, plan.length[flat] / count, count - 1)
    lines = (out.rate == 0.0) & (np.abs(out.curvature) * LARGEST_RADIUS < 1.0)
    # Chords: the ends of arcs as flat as these lie less than a micrometre farther along the line.
    hdg = np.where(lines, out.hdg + 0.5 * out.curvature * out.length, out.hdg)
    return replace(out, hdg=hdg, curvature=np.where(lines, 0.0, out.curvature))
