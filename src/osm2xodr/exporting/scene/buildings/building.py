"""Buildings as parts of a scene: walls between their outlines and their roofs, on the ground and off the roads."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from osm2xodr.exporting.scene.buildings.defaults import (
    BELOW_GROUND,
    ROOF_MOST,
    ROOF_SLOPE,
    STOREY,
    STOREYS,
    STOREYS_OTHER,
    WALL_LEAST,
)
from osm2xodr.exporting.scene.buildings.meshes import Block, meshes_of
from osm2xodr.exporting.scene.buildings.outlines import Footprint, footprints_of
from osm2xodr.exporting.scene.buildings.roofs import SHAPES, box_of
from osm2xodr.exporting.scene.ground import Ground
from osm2xodr.exporting.scene.model import Part, RoadSurface
from osm2xodr.model import BoolArray, Building
from osm2xodr.opendrive import Frame


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


# ---------------------------------------------------------------- steps

# Between points of an outline at which the ground below it is looked up, m: half of its smallest squares.
_STEP = 2.5


@dataclass(frozen=True, eq=False)
class Buildings:
    """Buildings of a scene, and what became of those that were given."""

    parts: tuple[Part, ...]  # ``Building`` of the materials ``wall``, ``roof`` and ``roof_flat``
    # OSM ids of buildings: ``drawn``; of these ``guessed`` (no tag gives a height), ``flat`` (whose roof has another
    # shape), ``clipped`` (roads take some of their area) and ``repaired`` (outlines that cross themselves); left out
    # ``on_roads`` (these take most of their area) and ``off_ground``
    ids: Mapping[str, tuple[str, ...]]


def building_parts(
    buildings: Sequence[Building], frame: Frame, surface: RoadSurface, passage: BoolArray, ground: Ground
) -> Buildings:
    """Return buildings that stand on the ground and leave roads free.

    `frame` turns their places into inertial x, y. `passage`, (triangles of `surface`,), are roads on the ground that
    lead through buildings, which go on above them.
    """
    found: defaultdict[str, list[str]] = defaultdict(list)
    blocks = []
    for item in footprints_of(buildings, frame, surface, passage, found):
        building = buildings[item.row]
        block = _block(building, item, ground, found)
        if block is None:
            found["off_ground"].append(building.osm_id)
            continue
        found["drawn"].append(building.osm_id)
        blocks += block
    ids = {name: tuple(dict.fromkeys(rows)) for name, rows in sorted(found.items())}
    return Buildings(meshes_of(blocks), ids)


def _block(
    building: Building, item: Footprint, ground: Ground, found: defaultdict[str, list[str]]
) -> list[Block] | None:
    """Return the blocks of a building, one for each area that is left of it; None off the ground."""
    corners = shapely.get_coordinates(shapely.segmentize(item.whole, _STEP))
    below = ground.heights(corners[:, 0], corners[:, 1])
    # At shores the elevation model may end below a building.
    below = below[np.isfinite(below)]
    if not len(below):
        return None
    low, high = float(below.min()), float(below.max())
    shape = SHAPES.get(building.roof_shape, "flat")
    if building.roof_shape not in ("", "flat", *SHAPES):
        found["flat"].append(building.osm_id)
    box = box_of(item.whole, building)
    if min(box.half_length, box.half_width) <= 0.0:
        shape = "flat"
    heights = heights_of(building, min(box.half_length, box.half_width), shape != "flat")
    eaves, ridge = low + heights.eaves, low + heights.ridge
    if heights.guessed:
        found["guessed"].append(building.osm_id)
        # A guess must not be buried on a slope.
        more = max(high + STOREY - eaves, 0.0) if heights.floor == 0.0 else 0.0
        eaves, ridge = eaves + more, ridge + more
    floor = low + heights.floor if heights.floor > 0.0 else low - BELOW_GROUND
    blocks = [Block(area, box, shape, floor, eaves, ridge, heights.floor > 0.0) for area in _polygons(item.areas)]
    for over, lowest in item.above:
        # What is above a passage is as high as the rest, but hangs.
        if lowest < eaves:
            blocks += [Block(area, box, shape, max(lowest, floor), eaves, ridge, True) for area in _polygons(over)]
    return blocks


def _polygons(shape: Any) -> list[Any]:
    """Return the polygons of a shape."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if shapely.get_type_id(part) == shapely.GeometryType.POLYGON]
