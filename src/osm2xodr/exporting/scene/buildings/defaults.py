"""Numbers of buildings: meaning, unit, source."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

# Height of a storey, m: OSM wiki, Key:building:levels, and most renderers of it.
STOREY: Final = 3.0
# Storeys of buildings without any height by the value of ``building``, and of all others. Orders of magnitude of
# what most of them have where OSM says it; choices.
STOREYS: Final = MappingProxyType(
    {
        **dict.fromkeys(("apartments", "hotel", "office", "hospital", "dormitory", "residential"), 4.0),
        **dict.fromkeys(("garage", "garages", "carport", "shed", "hut", "kiosk", "roof", "service", "toilets"), 1.0),
        **dict.fromkeys(("bungalow", "cabin", "greenhouse", "static_caravan", "bunker", "container"), 1.0),
        **dict.fromkeys(
            ("allotment_house", "boathouse", "transformer_tower", "stable", "sty", "farm_auxiliary"), 1.0
        ),
        **dict.fromkeys(("house", "detached", "semidetached_house", "terrace", "farm", "school"), 2.0),
        **dict.fromkeys(("church", "cathedral", "mosque", "temple"), 4.0),
        **dict.fromkeys(("industrial", "warehouse", "retail", "supermarket", "barn", "hangar"), 2.0),
    }
)
STOREYS_OTHER: Final = 2.0
# Heights of roofs without one, as a share of half of their width: 30 degrees; at most, m. Choices.
ROOF_SLOPE: Final = 0.577
ROOF_MOST: Final = 6.0
# Least height of walls, m, so that a roof's height cannot be more than the building's.
WALL_LEAST: Final = 0.5
# How far walls reach into the ground below their lowest corner, m. A choice.
BELOW_GROUND: Final = 0.5
# Buildings of which roads take more than this share of the area are left out, and less than this, m², is too small
# to be a building, a part of one or an overlap. Choices.
LOST_SHARE: Final = 0.5
AREA_LEAST: Final = 1.0
# Share of a building's outline that its parts cover if they stand for all of it. A choice.
PARTS_SHARE: Final = 0.9
# Height of passages through buildings above their road, m: RABT's clearance of 4.5 m.
PASSAGE: Final = 4.5
