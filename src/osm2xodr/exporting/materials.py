"""What the surfaces of lanes look like."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from osm2xodr.exporting.mesh import KERB

_ASPHALT: Final = (0.22, 0.22, 0.24)
_PAVING: Final = (0.55, 0.53, 0.50)
_GRASS: Final = (0.30, 0.42, 0.20)

# Linear red, green, blue from 0 to 1 by OpenDRIVE's types of lanes.
_COLORS: Final = MappingProxyType(
    {
        "biking": (0.45, 0.18, 0.14),
        "border": _GRASS,
        "bus": (0.30, 0.22, 0.22),
        "curb": _PAVING,
        KERB: _PAVING,
        "median": _GRASS,
        "none": _GRASS,
        "parking": (0.32, 0.32, 0.36),
        "rail": (0.28, 0.22, 0.18),
        "restricted": (0.40, 0.38, 0.30),
        "shoulder": (0.36, 0.35, 0.33),
        "sidewalk": _PAVING,
        "stop": (0.30, 0.30, 0.33),
        "tram": (0.28, 0.22, 0.18),
        "walking": _PAVING,
    }
)


def color_of(kind: str) -> tuple[float, float, float]:
    """Return the colour of a type of lanes; what is not known is driven on."""
    return _COLORS.get(kind, _ASPHALT)
