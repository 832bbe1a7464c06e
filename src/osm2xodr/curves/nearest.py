"""The places on curves that are nearest to points."""

from __future__ import annotations

from itertools import chain
from typing import Any, Final

import numpy as np
from scipy.spatial import cKDTree

from osm2xodr.curves.plan_views import advance, places_along, pose
from osm2xodr.curves.ragged import blocks, repeated, runs, sorted_unique, starts, unique_first
from osm2xodr.curves.spirals import nearest_on_spirals
from osm2xodr.model import FloatArray, IntArray, PlanView

# Spacing of the points by which curves near a place are looked up, m: a choice of speed. The nearest place itself is
# exact.
SAMPLE_SPACING: Final = 4.0
# Records may end this far from where the next begins, m.
_GAP: Final = 0.01


def project(
    plan: PlanView, curve: IntArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Project points x, y, each on the curve of a given index: s, t (left positive) and distance, all (n,), m.

    Points before the start or beyond the end of a curve get its start or end; their distance is then more than |t|.
    """
    s, t, distance = np.empty((3, len(curve)))
    for rows in blocks(len(curve)):
        s[rows], t[rows], distance[rows] = _project(plan, curve[rows], x[rows], y[rows])
    return s, t, distance


def _project(
    plan: PlanView, curve: IntArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what `project` does, for not too many points."""
    owner, record = _records_near(plan, curve, x, y)
    along = _nearest_on_records(plan, record, x[owner], y[owner])
    s = plan.s[record] + along
    start = plan.x[record], plan.y[record], plan.hdg[record], plan.curvature[record]
    px, py, hdg = advance(*start, along, plan.rate[record])
    distance = np.hypot(x[owner] - px, y[owner] - py)
    if len(owner) > len(curve):
        # The nearest, of several the first; the rows of a point stand together.
        least = np.minimum.reduceat(distance, np.flatnonzero(np.diff(owner, prepend=-1)))
        rows = np.flatnonzero(distance == least[owner])
        best = rows[np.diff(owner[rows], prepend=-1) > 0]
        s, px, py, hdg, distance = s[best], px[best], py[best], hdg[best], distance[best]
    t = (y - py) * np.cos(hdg) - (x - px) * np.sin(hdg)
    return s, t, distance


def _records_near(plan: PlanView, curve: IntArray, x: FloatArray, y: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the records of each point's curve that may be nearest to it: indices of points and records."""
    count = (plan.start[curve + 1] - plan.start[curve]).astype(np.int64)
    owner = repeated(count)
    record = runs(plan.start[curve], count)
    if len(owner) == len(curve):
        return owner, record
    # No record is farther away than its start, nor nearer than half of what both of its ends are farther than its
    # length.
    start = np.hypot(x[owner] - plan.x[record], y[owner] - plan.y[record])
    least, goes_on = start - plan.length[record], owner[1:] == owner[:-1]
    least[:-1][goes_on] = 0.5 * (least[:-1] + start[1:])[goes_on]
    nearest = np.minimum.reduceat(start, starts(count)[:-1])
    near = np.flatnonzero(least <= nearest[owner] + _GAP)
    return owner[near], record[near]


def _nearest_on_records(plan: PlanView, record: IntArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return how far along its record the place nearest to each point lies, m.

    That on the arc of mean curvature is a guess for spirals.
    """
    dx, dy = x - plan.x[record], y - plan.y[record]
    cos, sin = np.cos(plan.hdg[record]), np.sin(plan.hdg[record])
    u, v = cos * dx + sin * dy, cos * dy - sin * dx
    k, rate, length = plan.curvature[record], plan.rate[record], plan.length[record]
    spiral = np.flatnonzero(rate)
    first = k[spiral]
    k = k + 0.5 * rate * length
    bent = k != 0
    safe = np.where(bent, k, 1.0)
    # Angle about the arc's centre (0, 1/k), counted along it, wrapped about the arc's middle.
    side = np.sign(safe)
    angle = np.arctan2(side * u, side * (1.0 / safe - v))
    middle = 0.5 * length * safe
    turn = middle + (angle - middle + np.pi) % (2 * np.pi) - np.pi
    along = np.clip(np.where(bent, turn / safe, u), 0.0, length)
    if len(spiral):
        rows = rate[spiral], length[spiral], u[spiral], v[spiral], along[spiral]
        along[spiral] = nearest_on_spirals(first, *rows)
    return along


def sample_curves(plan: PlanView, curves: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return points along curves of given indices, at most `SAMPLE_SPACING` apart: index of the curve, x, y, (n,)."""
    curve, s = places_along(plan, SAMPLE_SPACING, curves)
    x, y, _ = pose(plan, curve, s)
    return curve, x, y


class CurveFinder:
    """Finds those of a table's curves, all or those of given indices, that are near points."""

    def __init__(self, plan: PlanView, curves: IntArray | None = None) -> None:
        self._plan = plan
        self._curve, x, y = sample_curves(plan, np.arange(len(plan.start) - 1) if curves is None else curves)
        self._tree = cKDTree(np.column_stack([x, y])) if len(x) else None

    def near(
        self, x: FloatArray, y: FloatArray, reach: float
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
        """Return all curves within `reach`, m, of points (n,): point, curve, s, t and distance as of `project`, (m,).

        Points and curves are indices in ascending order, curves for each point.
        """
        if self._tree is None or not len(x):
            index, number = np.zeros(0, np.int64), np.zeros(0)
            return index, index, number, number, number
        found: Any = self._tree.query_ball_point(np.column_stack([x, y]), reach + SAMPLE_SPACING)
        curves = len(self._plan.start)
        sample = np.fromiter(chain.from_iterable(found), np.int64)
        pair = repeated([len(rows) for rows in found]) * curves + self._curve[sample]
        point, curve = np.divmod(sorted_unique(pair), curves)
        s, t, distance = project(self._plan, curve, x[point], y[point])
        inside = distance <= reach
        return point[inside], curve[inside], s[inside], t[inside], distance[inside]

    def nearest(self, x: FloatArray, y: FloatArray, reach: float) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return curve (-1 where none is within reach), s and t of the nearest place to each point, all (n,)."""
        point, curve, s, t, distance = self.near(x, y, reach)
        order = np.lexsort((curve, distance, point))
        first = order[unique_first(point[order])[1]]
        curves, at, aside = np.full(len(x), -1, np.int64), np.full(len(x), np.nan), np.full(len(x), np.nan)
        curves[point[first]], at[point[first]], aside[point[first]] = curve[first], s[first], t[first]
        return curves, at, aside
