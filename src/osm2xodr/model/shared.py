"""Types that all stages share: arrays, sides, directions, types of lanes, the local frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def freeze_arrays(record: object) -> None:
    """Make every array of a dataclass read-only."""
    for name in type(record).__dataclass_fields__:  # type: ignore[attr-defined]
        value = getattr(record, name)
        if isinstance(value, np.ndarray):
            value.flags.writeable = False


class ReadOnlyArrays:
    """Base of dataclasses whose arrays are read-only, so that stages can share them."""

    __slots__ = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)


class Rule(str, Enum):
    """The side of the road that traffic drives on, in OpenDRIVE's words."""

    RIGHT_HAND = "RHT"
    LEFT_HAND = "LHT"


class Direction(int, Enum):
    """The direction of traffic on a lane, seen along its street."""

    FORWARD = 1
    BACKWARD = -1
    BOTH = 0


class LaneType(str, Enum):
    """Types of lanes, in OpenDRIVE's words."""

    DRIVING = "driving"
    BIDIRECTIONAL = "bidirectional"
    BUS = "bus"
    TAXI = "taxi"
    BIKING = "biking"
    SIDEWALK = "sidewalk"
    PARKING = "parking"
    SHOULDER = "shoulder"
    MEDIAN = "median"
    BORDER = "border"
    CURB = "curb"
    TRAM = "tram"
    NONE = "none"


class Structure(int, Enum):
    """What a piece of road lies on."""

    GROUND = 0
    BRIDGE = 1
    TUNNEL = 2


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """The position of local x and y on Earth."""

    proj: str  # PROJ text of the projection, also the georeference that is written
    # Origin of x and y, WGS 84
    lat_0_deg: float
    lon_0_deg: float
