"""Points along streets, close enough to tell what an elevation model covers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from osm2xodr.curves import ranks
from osm2xodr.model import FloatArray, Street

# Distance between the points at which roads are held against an elevation model, m: below the cells of the coarsest
# ones in use (90 m).
_COVERAGE_STEP: Final = 50.0


def points_along(streets: Sequence[Street], step: float = _COVERAGE_STEP) -> tuple[FloatArray, FloatArray]:
    """Return local x, y (n,) of points evenly spaced along all streets, the ends of each among them.

    Parameters
    ----------
    streets
        At least one.
    step
        Largest distance of neighbours along a street, m.
    """
    points = np.concatenate([street.points for street in streets])
    counts = np.array([len(street.points) for street in streets])
    first = np.concatenate([[0], np.cumsum(counts)])
    # All streets end to end on one line, with a gap between them, so that one interpolation does for all.
    pieces = np.hypot(*np.diff(points, axis=0).T)
    pieces[first[1:-1] - 1] = 1.0
    along = np.concatenate([[0.0], np.cumsum(pieces)])
    start, end = along[first[:-1]], along[first[1:] - 1]
    steps = np.maximum(np.ceil((end - start) / step).astype(np.int64), 1)
    index = ranks(steps + 1)
    at = np.repeat(start, steps + 1) + index * np.repeat((end - start) / steps, steps + 1)
    return np.interp(at, along, points[:, 0]), np.interp(at, along, points[:, 1])
