"""Colours on the page and in pictures.

Ramps grow lighter or darker from end to end, so that they keep their order for colour-blind readers and in print.
The stops of the ramps for heights and speeds are those of matplotlib's cividis and viridis, which are in the public
domain (CC0); the ones for grades and errors were chosen here. Colours of categories differ in lightness as well as
in hue.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.furniture_shapes import colours_by_name
from osm2xodr.model import FloatArray

Colour = str
Pixels = npt.NDArray[np.uint8]

_CIVIDIS_TEXT = "#00224e #123570 #3b496c #575d6d #707173 #8a8678 #a59c74 #c3b369 #e1cc55 #fee838"
_VIRIDIS_TEXT = "#440154 #482878 #3e4a89 #31688e #26828e #1f9e89 #35b779 #6ece58 #b5de2b #fde725"
CIVIDIS: Final = tuple(_CIVIDIS_TEXT.split())
VIRIDIS: Final = tuple(_VIRIDIS_TEXT.split())
# Level is pale, steep is dark red-brown.
STEEPNESS: Final = ("#dfe7ea", "#c3d2c4", "#e8d48a", "#f0a94e", "#d9663a", "#a5283a", "#5b0f35")
# Too low is blue, too high is orange; what fits is nearly white.
ERROR: Final = ("#0b3c7f", "#2f74b9", "#86b6da", "#e9ecec", "#f2b577", "#cf6a1c", "#7c3304")
UNKNOWN_COLOUR: Final = "#b9a7c9"
# Least difference between the ends of a ramp, in its unit, so that equal ends divide nothing by 0.
_LEAST_RANGE: Final = 1e-12

# Types of lanes; others have the colour `LANE_OTHER`.
LANE_TYPES: Final = colours_by_name(
    {
        "#5d6b7a": "driving entry exit onRamp offRamp connectingRamp slipLane",
        "#7b6a8f": "bidirectional",
        "#b5543c": "bus taxi HOV",
        "#2f8f83": "biking",
        "#4f7fbf": "parking",
        "#d9c7a3": "sidewalk walking",
        "#76828e": "shoulder stop",
        "#b7bfa6": "border",
        "#8f8f8f": "curb",
        "#a9c08f": "median",
        "#c9b5c6": "restricted",
        "#8a4f7d": "tram rail",
        "#cfd4d8": "none",
    }
)
LANE_OTHER: Final = "#aeb4ba"
# Types of roads.
ROAD_TYPES: Final = MappingProxyType(
    {
        "motorway": "#173f6b",
        "rural": "#2f8f83",
        "town": "#5d6b7a",
        "townExpressway": "#4f7fbf",
        "townArterial": "#b5543c",
        "townCollector": "#d09a3c",
        "townLocal": "#7f8b96",
        "townPrivate": "#c9b5c6",
        "townPlayStreet": "#a9c08f",
        "lowSpeed": "#c8a2bd",
        "pedestrian": "#d9c7a3",
        "bicycle": "#57b0a5",
        "unknown": "#aeb4ba",
    }
)
ROAD_OTHER: Final = "#aeb4ba"
# Findings, the worst first.
SEVERITIES: Final = MappingProxyType({"error": "#c1272d", "warning": "#e08a00", "info": "#7b3fa0"})


@dataclass(frozen=True)
class Ramp:
    """A scale of colours between two values; beyond them the colours at the ends hold."""

    stops: Sequence[Colour]  # Evenly spaced
    # Values at the first and the last stop, in `unit`
    low: float
    high: float
    unit: str
    unknown: Colour = UNKNOWN_COLOUR  # Of values that are not finite

    def colours(self, values: FloatArray) -> Pixels:
        """Return red, green and blue, (..., 3), of values of any shape."""
        table = np.array([rgb(stop) for stop in self.stops], np.float64)
        values = np.asarray(values, np.float64)
        place = (values - self.low) / max(self.high - self.low, _LEAST_RANGE) * (len(table) - 1)
        place = np.clip(np.nan_to_num(place), 0.0, len(table) - 1)
        at = np.arange(len(table))
        mixed = np.stack([np.interp(place, at, table[:, k]) for k in range(3)], axis=-1)
        mixed[~np.isfinite(values)] = rgb(self.unknown)
        return np.asarray(np.rint(mixed).astype(np.uint8))


def rgb(colour: Colour) -> tuple[int, int, int]:
    """Return red, green and blue of ``#rrggbb``."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def round_range(low: float, high: float, least: float) -> tuple[float, float]:
    """Widen a range to round numbers (multiples of 1, 2 or 5 times a power of ten) and to a least width."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return 0.0, least
    if high - low < least:
        middle = (low + high) / 2.0
        low, high = middle - least / 2.0, middle + least / 2.0
    step = nice_step((high - low) / 5.0)
    return float(np.floor(low / step) * step), float(np.ceil(high / step) * step)


def nice_step(width: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that is not above a width."""
    power = 10.0 ** np.floor(np.log10(width))
    for factor in (5.0, 2.0, 1.0):
        if factor * power <= width * (1.0 + 1e-9):
            return float(factor * power)
    return float(power)
