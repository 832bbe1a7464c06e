"""Materials of a scene, and the names that engines know its parts by.

Names that begin with ``Road_`` and ``Terrain`` are those that CARLA's importer sorts meshes by, for semantic
segmentation and for where walkers may go (documentation of CARLA 0.9.16, *Generate Pedestrian Navigation*).
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Final


@dataclass(frozen=True)
class Material:
    """How a surface looks: base colour, sRGB as #rrggbb, and the other factors of glTF's metallic-roughness model."""

    colour: str
    roughness: float = 0.9
    metallic: float = 0.0

    @property
    def linear(self) -> tuple[float, float, float]:
        """Red, green and blue of the base colour in linear light, 0 to 1 (IEC 61966-2-1)."""
        red, green, blue = (int(self.colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
        return _linear(red), _linear(green), _linear(blue)


def _linear(value: float) -> float:
    """Return a channel of sRGB in linear light."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


# Colours and finish are choices.
MATERIALS: Final = MappingProxyType(
    {
        "asphalt": Material("#4a4b4d"),
        "bus_lane": Material("#6b4a47"),
        "concrete": Material("#a5a29b"),
        "cycleway": Material("#8c4a3e"),
        "grass": Material("#6f8a4f", 1.0),
        "kerb": Material("#b9b6ae"),
        "marking_white": Material("#e8e8e4", 0.7),
        "marking_yellow": Material("#e0b63a", 0.7),
        "metal": Material("#8b9096", 0.5, 0.6),
        "paving": Material("#a9a399"),
        "rail": Material("#6a5f55"),
        "roof": Material("#96543f"),
        "roof_flat": Material("#9b978f"),
        "soil": Material("#84775f", 1.0),
        "sign_back": Material("#80868c", 0.6, 0.4),
        "vegetation": Material("#5d8a48", 1.0),
        "wall": Material("#d3cab8"),
        "water": Material("#4d7d9c", 0.2),
    }
)

# Name and material of lane types; all others are driven on.
_DRIVEN: Final = ("Road_Road", "asphalt")
_LANES: Final = MappingProxyType(
    {
        "biking": ("Road_Road_Cycleway", "cycleway"),
        "border": ("Road_Grass", "grass"),
        "bus": ("Road_Road_Bus", "bus_lane"),
        "curb": ("Road_Curb", "kerb"),
        "kerb": ("Road_Curb", "kerb"),
        "median": ("Road_Grass", "grass"),
        "none": ("Road_Grass", "grass"),
        "parking": ("Road_Road_Parking", "asphalt"),
        "rail": ("Road_Road_Rail", "rail"),
        "shoulder": ("Road_Gutter", "asphalt"),
        "sidewalk": ("Road_Sidewalk", "paving"),
        "tram": ("Road_Road_Rail", "rail"),
        "walking": ("Road_Sidewalk", "paving"),
    }
)
MARKING: Final = "Road_Marking"
CROSSWALK: Final = "Road_Crosswalk"


def lane_part(kind: str) -> tuple[str, str]:
    """Return name and material of the surface of a type of lanes."""
    return _LANES.get(kind, _DRIVEN)


def material_of(name: str) -> Material:
    """Return a material by its name, or one of a plain colour (#rrggbb)."""
    return Material(name) if name.startswith("#") else MATERIALS[name]
