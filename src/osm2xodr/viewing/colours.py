"""What roads can be coloured by (types, heights, grades, height errors, speeds, findings), and these colours.

Ramps grow lighter or darker from end to end, so that they keep their order for colour-blind readers and in print.
The stops of the ramps for heights and speeds are those of matplotlib's cividis and viridis, which are in the public
domain (CC0); the ones for grades and errors were chosen here. Colours of categories differ in lightness as well as
in hue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import owners
from osm2xodr.furniture_shapes import colours_by_name
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive
from osm2xodr.system import record
from osm2xodr.viewing.scene import Scene

# m/s to km/h.
_KMH: Final = 3.6
# Percentiles of the values at the ends of ramps: a few outliers must not use up the colours.
_HEIGHT_ENDS: Final = (1.0, 99.0)
_GRADE_END: Final = 98.0
_ERROR_END: Final = 90.0
_NO_FINDING_COLOUR: Final = "#9aa5af"

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


@record
class Categories:
    """Kinds, each with a colour."""

    # Of each kind
    names: tuple[str, ...]
    colours: tuple[str, ...]
    labels: tuple[str, ...]
    present: tuple[bool, ...]  # Whether it occurs and has an entry in the legend


@record
class Mode:
    """A way to colour roads."""

    key: str  # ``type``, ``class``, ``height``, ``grade``, ``error``, ``speed`` or ``finding``
    # For the switch, and for the legend with its unit
    label: str
    title: str
    scale: Categories | Ramp  # Colours
    digits: int = 0  # After the point of the legend's numbers


def lane_speeds(file: OpenDrive, scene: Scene) -> FloatArray:
    """Return the speed limit of each lane of a scene, (lanes,), km/h: its own, or that of the road at mid-strip."""
    strip_of_lane = owners(scene.lane_start)
    row = _type_rows(file, scene)[strip_of_lane]
    road_speed = np.full(len(row), np.nan)
    road_speed[row >= 0] = file.types.speed[row[row >= 0]]
    own = file.lanes.speed[scene.lane]
    speed = np.where(np.isfinite(own), own, road_speed) * _KMH
    return np.where(np.isfinite(speed), speed, np.nan)


def strip_classes(file: OpenDrive, scene: Scene) -> tuple[tuple[str, ...], IntArray]:
    """Return names of road types, and the index of each strip's type, (strips,): that at its middle."""
    names = tuple(sorted({*file.types.type, "unknown"}))
    row = _type_rows(file, scene)
    number = {name: k for k, name in enumerate(names)}
    of_row = np.array([number[name] for name in file.types.type] or [0], np.int64)
    return names, np.where(row >= 0, of_row[np.maximum(row, 0)] if len(file.types.type) else 0, number["unknown"])


def _type_rows(file: OpenDrive, scene: Scene) -> IntArray:
    """Return the row of the ``<type>`` that holds at the middle of each strip, (strips,); -1 without one."""
    first, last = scene.station_start[:-1], scene.station_start[1:] - 1
    middle = 0.5 * (scene.s[first] + scene.s[last])
    start = file.types.start
    out = np.full(len(middle), -1)
    for k, road in enumerate(scene.strip_road.tolist()):
        a, b = int(start[road]), int(start[road + 1])
        if b > a:
            out[k] = a + max(0, int(np.searchsorted(file.types.s[a:b], middle[k], "right")) - 1)
    return out


def lane_types(file: OpenDrive, scene: Scene) -> tuple[tuple[str, ...], IntArray]:
    """Return names of lane types, and the index of the type of each lane of a scene, (lanes,)."""
    found = [file.lanes.type[row] for row in scene.lane.tolist()]
    names = tuple(sorted(set(found) | {"driving"}))
    number = {name: k for k, name in enumerate(names)}
    return names, np.array([number[name] for name in found], np.int64)


def drawn_types(file: OpenDrive, scene: Scene) -> tuple[tuple[str, ...], IntArray]:
    """Return lane types as pictures show them: pavement between the lanes of a junction is as these are.

    It consists of shoulders of connecting roads that are as high as the road and lead nowhere, or lie beside a
    sidewalk as it passes a driveway.
    """
    names, type_of = lane_types(file, scene)
    if "shoulder" not in names:
        return names, type_of
    lanes, row = file.lanes, scene.lane
    paved = (type_of == names.index("shoulder")) & ~lanes.height[row].any(1)
    road = file.sections.road[lanes.section[row]]
    walked = (
        np.isin(road, road[type_of == names.index("sidewalk")]) if "sidewalk" in names else np.zeros(len(row), bool)
    )
    paved &= file.roads.junction[road] >= 0
    paved &= walked | ((lanes.predecessor[row] == ABSENT) & (lanes.successor[row] == ABSENT))
    return names, np.where(paved, names.index("driving"), type_of)


def make_modes(
    file: OpenDrive, scene: Scene, types: tuple[tuple[str, ...], IntArray], *, has_findings: bool
) -> list[Mode]:
    """Return the ways to colour a scene, the default first; `types` are those of its lanes that are shown."""
    names, type_of = types
    used = {names[k] for k in type_of.tolist()}
    classes, class_of = strip_classes(file, scene)
    class_used = {classes[k] for k in class_of.tolist()}
    grades = np.abs(scene.grade[np.isfinite(scene.grade)])
    steepest = 100.0 * float(np.percentile(grades, _GRADE_END)) if len(grades) else 0.0
    steep = round_range(0.0, steepest, 4.0)[1]
    modes = [
        Mode("type", "lane type", "Lanes", _categories(names, LANE_TYPES, LANE_OTHER, used)),
        Mode("class", "road class", "Roads", _categories(classes, ROAD_TYPES, ROAD_OTHER, class_used)),
        Mode("height", "height", "Height, m", _ramp(CIVIDIS, scene.z, *_HEIGHT_ENDS, 10.0, "m")),
        Mode("grade", "grade", "Grade, %", Ramp(STEEPNESS, 0.0, steep, "%")),
    ]
    if np.isfinite(scene.ground).any():
        error = np.abs(scene.z - scene.ground)
        far = round_range(0.0, float(np.nanpercentile(error, _ERROR_END)), 1.0)[1]
        title = "Road less elevation model, m"
        modes.append(Mode("error", "height error", title, Ramp(ERROR, -far, far, "m"), 1))
    speed = lane_speeds(file, scene)
    if np.isfinite(speed).any():
        modes.append(Mode("speed", "speed", "Speed, km/h", _ramp(VIRIDIS, speed, 0.0, 100.0, 20.0, "km/h")))
    if has_findings:
        kinds = ("none", *reversed(SEVERITIES))
        shades = (_NO_FINDING_COLOUR, *reversed(tuple(SEVERITIES.values())))
        labels = ("nothing found", *(f"road with {name}" for name in reversed(SEVERITIES)))
        scale = Categories(kinds, shades, labels, (True,) * len(kinds))
        modes.append(Mode("finding", "findings", "Findings", scale))
    return modes


def _categories(names: tuple[str, ...], table: Mapping[str, str], other: str, used: set[str]) -> Categories:
    """Return kinds with their colours; those of the same colour share one entry of the legend."""
    shades = tuple(table.get(name, other) for name in names)
    labels, present = [], []
    for name, shade in zip(names, shades, strict=True):
        alike = [item for item, colour in zip(names, shades, strict=True) if colour == shade and item in used]
        labels.append(", ".join(alike))
        present.append(bool(alike) and name == alike[0])
    return Categories(names, shades, tuple(labels), tuple(present))


def _ramp(stops: tuple[str, ...], values: FloatArray, low: float, high: float, least: float, unit: str) -> Ramp:
    """Return a ramp from one percentile of the values to another, at least `least` wide."""
    known = values[np.isfinite(values)]
    ends = np.percentile(known, (low, high)) if len(known) else (np.nan, np.nan)
    return Ramp(stops, *round_range(float(ends[0]), float(ends[1]), least), unit)


@record
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
