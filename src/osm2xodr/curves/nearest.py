"""The places on curves that are nearest to points."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.plan_views import places_along
from osm2xodr.curves.point_tree import PointTree
from osm2xodr.curves.ragged import sorted_unique, unique_first
from osm2xodr.curves.records import pose, project
from osm2xodr.model import FloatArray, IntArray, PlanView

# Spacing of the points by which curves near a place are looked up, m: a choice of speed. The nearest place itself is
# exact.
SAMPLE_SPACING: Final = 4.0


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
        self._tree = PointTree(np.column_stack([x, y]))

    def near(
        self, x: FloatArray, y: FloatArray, reach: float
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
        """Return all curves within `reach`, m, of points (n,): point, curve, s, t and distance as of `project`, (m,).

        Points and curves are indices in ascending order, curves for each point.
        """
        curves = len(self._plan.start)
        place, sample = self._tree.within(np.column_stack([x, y]), reach + SAMPLE_SPACING)
        point, curve = np.divmod(sorted_unique(place * curves + self._curve[sample]), curves)
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
