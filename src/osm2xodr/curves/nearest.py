"""The places on curves that are nearest to points."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.curves.plan_views import places_along
from osm2xodr.curves.point_tree import PointTree
from osm2xodr.curves.ragged import sorted_unique
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
        return self._projected(x, y, reach, *self._tree.within(np.column_stack([x, y]), reach + SAMPLE_SPACING))

    def nearest(
        self, x: FloatArray, y: FloatArray, reach: float, samples: int
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
        """Return what `near` does, but only of those curves that have the nearest of their samples, so many."""
        _, found = self._tree.neighbours(np.column_stack([x, y]), samples, reach + SAMPLE_SPACING)
        place, rank = np.nonzero(found >= 0)
        return self._projected(x, y, reach, place, found[place, rank])

    def _projected(
        self, x: FloatArray, y: FloatArray, reach: float, place: IntArray, sample: IntArray
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
        """Project points on the curves of samples, each once; the samples of a point are given by pairs."""
        curves = len(self._plan.start)
        point, curve = np.divmod(sorted_unique(place * curves + self._curve[sample]), curves)
        s, t, distance = project(self._plan, curve, x[point], y[point])
        inside = distance <= reach
        return point[inside], curve[inside], s[inside], t[inside], distance[inside]
