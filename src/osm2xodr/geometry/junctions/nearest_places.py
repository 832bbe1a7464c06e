"""Which places are nearest to points."""

from __future__ import annotations

import math
from typing import Final

from osm2xodr.model import FloatArray, IntArray

_INFINITE: Final = math.inf


def nearest_places(px: FloatArray, py: FloatArray, x: FloatArray, y: FloatArray, out: IntArray) -> None:
    """Write which of the places x, y, (n, m), of its row is nearest to each point, (n, points)."""
    for row in range(px.shape[0]):
        for point in range(px.shape[1]):
            least = _INFINITE
            for place in range(x.shape[1]):
                dx, dy = float(px[row, point]) - float(x[row, place]), float(py[row, point]) - float(y[row, place])
                square = dx * dx + dy * dy
                if square < least:
                    least = square
                    out[row, point] = place
