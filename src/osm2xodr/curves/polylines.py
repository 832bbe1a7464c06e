"""Polylines: how far along one its points are."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves.trigonometry import hypot
from osm2xodr.model import FloatArray


def running_lengths(points: FloatArray) -> FloatArray:
    """Return how far along a polyline each of its points (n, 2) is, (n,), from 0 at the first, in their unit."""
    return np.concatenate([[0.0], np.cumsum(hypot(*np.diff(points, axis=0).T))])
