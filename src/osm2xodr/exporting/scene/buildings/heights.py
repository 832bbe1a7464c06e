"""How high buildings are: by their tags, and where these say nothing by what most buildings are."""

from __future__ import annotations

from dataclasses import dataclass

from osm2xodr.exporting.scene.buildings.defaults import (
    ROOF_MOST,
    ROOF_SLOPE,
    STOREY,
    STOREYS,
    STOREYS_OTHER,
    WALL_LEAST,
)
from osm2xodr.model import Building


@dataclass(frozen=True, slots=True)
class Heights:
    """Heights of a building above the ground, m."""

    floor: float  # Of its lowest floor: above 0 for parts that stand on others or hang between them
    eaves: float  # Of the top of its walls
    ridge: float  # Of the highest point of its roof
    guessed: bool  # Whether no tag says how high it is


def heights_of(building: Building, half_width: float, pitched: bool) -> Heights:
    """Return the heights of a building of which half of the shorter side is given, m.

    `pitched` says whether its roof has a shape that is not flat.
    """
    roof = _roof(building, half_width) if pitched else 0.0
    guessed = building.height is None and building.levels is None
    if building.height is not None:
        ridge = building.height
    else:
        storeys = STOREYS.get(building.kind, STOREYS_OTHER) if building.levels is None else building.levels
        # Storeys in the roof are not among those below.
        ridge = storeys * STOREY + roof
    floor = building.min_height
    if floor is None:
        floor = 0.0 if building.min_level is None else building.min_level * STOREY
    floor = min(floor, max(ridge - WALL_LEAST, 0.0))
    ridge = max(ridge, floor + WALL_LEAST)
    eaves = max(ridge - roof, floor if building.is_part and floor > 0.0 else floor + WALL_LEAST)
    return Heights(floor, min(eaves, ridge), ridge, guessed)


def _roof(building: Building, half_width: float) -> float:
    """Return the height of a building's roof, m."""
    if building.roof_height is not None:
        return building.roof_height
    if building.roof_levels:
        return building.roof_levels * STOREY
    return min(ROOF_SLOPE * half_width, ROOF_MOST)
