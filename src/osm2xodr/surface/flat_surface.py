"""The ground where there is no elevation model."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import BoolArray, FloatArray, SurfaceQuality
from osm2xodr.system import record


@record
class FlatSurface:
    """The ground where there is no elevation model: exact, at height 0."""

    cell_size: float = 0.0
    sigma: float = 0.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return 0 m for local x, y (n,), and that it is measured."""
        return np.zeros(len(x)), np.ones(len(x), bool)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return that heights at local x, y (n,), m, are measured."""
        return np.ones(len(x), bool)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return that heights at local x, y (n,), m, are exact."""
        return SurfaceQuality(np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x), np.bool_))
