"""Types that all stages share: arrays, sides, directions, types of lanes, the local frame, the ground."""

from __future__ import annotations

from enum import Enum
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from osm2xodr.system import record

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def freeze_arrays(record: object) -> None:
    """Make every array of a dataclass read-only."""
    for name in type(record).__dataclass_fields__:  # type: ignore[attr-defined]
        value = getattr(record, name)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


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

    # In C, unlike that of `Enum`: sets and tables of types are asked a million times.
    __hash__ = str.__hash__

    DRIVING = "driving"
    BIDIRECTIONAL = "bidirectional"
    BUS = "bus"
    TAXI = "taxi"
    BIKING = "biking"
    SIDEWALK = "sidewalk"
    PARKING = "parking"
    RESTRICTED = "restricted"  # Level with the carriageway, and nobody may drive or park there
    SHOULDER = "shoulder"
    MEDIAN = "median"
    BORDER = "border"
    CURB = "curb"
    TRAM = "tram"
    NONE = "none"


class Access(str, Enum):
    """Which cars may drive on a lane, in OpenDRIVE's words."""

    __hash__ = str.__hash__

    ALL = ""
    HOV = "HOV"  # High-occupancy vehicles: cars with several people in them, and buses


# Types of lanes that all cars may use.
CAR_LANES: Final = frozenset({LaneType.DRIVING, LaneType.BIDIRECTIONAL})
# Types of lanes for motor vehicles.
VEHICLE_LANES: Final = CAR_LANES | {LaneType.BUS, LaneType.TAXI}


class Structure(int, Enum):
    """What a piece of road lies on."""

    GROUND = 0
    BRIDGE = 1
    TUNNEL = 2


@record
class LocalFrame:
    """The position of local x and y on Earth."""

    proj: str  # PROJ text of the projection, also the georeference that is written
    lat_0_deg: float  # Origin of x and y, WGS 84
    lon_0_deg: float  # Likewise


@record(eq=False)
class SurfaceQuality(ReadOnlyArrays):
    """How far heights can be trusted, point by point."""

    # (n,) Distance between the heights that the surface is made from there, m (0 for an exact surface)
    cell_size: FloatArray
    sigma: FloatArray  # (n,) Standard error of the heights, m (0 for an exact surface)
    # (n,) Whether the heights are those of a surface model, which lies on canopy and roofs rather than on the ground
    covered: BoolArray


class Surface(Protocol):
    """Height of the ground at local positions."""

    @property
    def cell_size(self) -> float:
        """Distance between the heights that most of the surface is made from, m (0 for an exact surface)."""

    @property
    def sigma(self) -> float:
        """Standard error of most of its heights, m (0 for an exact surface)."""

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return z (n,), m, at local x, y (n,), m, and where it is measured.

        Where it is not measured (voids, outside of the elevation model) z is the surface's best guess.
        """

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        """Return where the heights at local x, y (n,), m, are measured, in less time than `heights`."""

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        """Return how far the heights at local x, y (n,), m, can be trusted."""
