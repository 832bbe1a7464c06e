"""Strokes across roads whose heights were not measured."""

from __future__ import annotations

from typing import Final

import numpy as np

from osm2xodr.model import FloatArray
from osm2xodr.viewing.picture.shapes import HATCHING, Line

# Distance of strokes along the road: m, and pixels, at least; half of the length of a stroke, pixels, at least.
_APART: Final = 4.0
_APART_PIXELS: Final = 9.0
_HALF: Final = 4.0
# How far the left end of a stroke is ahead of its middle, as a share of what it is beside it.
_SLANT: Final = 0.7
# Width, pixels.
_WIDTH: Final = 1.5


def hatch_lines(grid: FloatArray, s: FloatArray, stretches: list[tuple[float, float]], scale: float) -> list[Line]:
    """Return strokes on a strip, `grid` (stations, borders, 2), pixels, at s (stations,), m, from left to right.

    `stretches` are begin and end of what is hatched, m, and `scale` is pixels per metre.
    """
    apart = max(_APART, _APART_PIXELS / scale)
    # Counted from the start of the road, so that strokes of neighbouring strips are apart as well.
    places = apart * (0.5 + np.arange(int(s[0] / apart), int(s[-1] / apart) + 1))
    inside = (places >= s[0]) & (places <= s[-1])
    places = places[inside & np.any([(places >= a) & (places <= b) for a, b in stretches], axis=0)]
    edges = [np.column_stack([np.interp(places, s, grid[:, k, axis]) for axis in (0, 1)]) for k in (0, -1)]
    middle, beside = 0.5 * (edges[0] + edges[1]), 0.5 * (edges[0] - edges[1])
    size = np.hypot(*beside.T)[:, None]
    beside = beside * np.fmax(_HALF / np.fmax(size, 1e-9), 1.0)
    # Left of the road is up where it leads to the right: y counts down.
    ahead = _SLANT * np.column_stack([-beside[:, 1], beside[:, 0]])
    ends = zip(middle + beside + ahead, middle - beside - ahead, strict=True)
    return [Line(np.stack(pair), HATCHING, _WIDTH) for pair in ends]
