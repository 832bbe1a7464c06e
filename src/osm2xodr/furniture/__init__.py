"""Stage 4: places signals, signs and objects on and beside the roads of a `RoadMap`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from osm2xodr.furniture.options import (
    EXTRA_OBJECTS as EXTRA_OBJECTS,
    FurnitureOptions as FurnitureOptions,
    parse_objects_option as parse_objects_option,
)
from osm2xodr.system import record

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.furniture.lane_sections import NoParking
    from osm2xodr.model import Furniture, RoadMap, RoadObject, Signal, StreetNetwork


@record
class Placed:
    """What stands on and beside roads, and where these need it to cut their lane sections."""

    furniture: Furniture
    section_breaks: tuple[tuple[int, float], ...]  # Id of a road, and s, m
    no_parking: tuple[NoParking, ...]


def find_furniture(
    network: StreetNetwork, road_map: RoadMap, options: FurnitureOptions, diagnostics: Diagnostics
) -> Placed | None:
    """Return everything that stands on and beside roads; None where none is wanted.

    Parameters
    ----------
    network
        What OSM says.
    road_map
        The roads, with their heights and `RoadMap.places`; the floor of junctions may be missing.
    options
        What the user chose.
    diagnostics
        Gets what is guessed, and what is dropped and why.
    """
    # Here, so that the command line starts without numpy.
    from osm2xodr.furniture.lane_sections import no_parking
    from osm2xodr.furniture.lights import place_lights
    from osm2xodr.furniture.objects import find_crossings, place_objects, place_structures
    from osm2xodr.furniture.signs import place_signs
    from osm2xodr.furniture.world import LaneTable, World, find_approaches, find_rail_stops
    from osm2xodr.model import Furniture

    if not options.enabled or road_map.places is None:
        return None
    world = World(network, road_map, road_map.places, LaneTable(road_map), options, diagnostics)
    crossings = find_crossings(world)
    approaches = find_approaches(world, crossings)
    lights = place_lights(world, approaches, crossings)
    rail_stops = find_rail_stops(world)
    signs = place_signs(world, approaches, lights.signalled, crossings, rail_stops)
    objects = place_objects(world, approaches, (*lights.stops, *signs.stops), crossings, rail_stops)
    signals = (*lights.signals, *signs.signals)
    furniture = Furniture(
        signals=tuple(sorted(signals, key=_place)),
        references=tuple(sorted(lights.references, key=lambda item: (item.road, item.s, item.signal))),
        controllers=tuple(lights.controllers),
        programmes=tuple(lights.programmes),
        objects=tuple(sorted(objects, key=_place)),
        structures=place_structures(world),
        statistics={
            "traffic_lights": float(sum(item.dynamic for item in signals)),
            "signs": float(sum(not item.dynamic and not item.derived for item in signals)),
            "derived_signs": float(sum(item.derived for item in signals)),
            "controllers": float(len(lights.controllers)),
            "crossings": float(len(crossings)),
            "objects": float(len(objects)),
        },
    )
    return Placed(furniture, tuple(lights.section_breaks), no_parking(world, crossings))


def with_furniture(road_map: RoadMap, placed: Placed | None) -> RoadMap:
    """Return the road map that furniture was found for, with it."""
    from osm2xodr.furniture.lane_sections import cut_sections, without_parking

    if placed is None:
        return road_map
    road_map = without_parking(cut_sections(road_map, placed.section_breaks), placed.no_parking)
    return replace(road_map, furniture=placed.furniture)


def with_islands(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return a road map whose furniture has the islands in its junctions; they are counted in diagnostics."""
    if not road_map.islands:
        return road_map
    from osm2xodr.furniture.objects import island_objects

    furniture = road_map.furniture
    objects = sorted((*furniture.objects, *island_objects(road_map, diagnostics)), key=_place)
    statistics = {**furniture.statistics, "objects": float(len(objects))}
    return replace(road_map, furniture=replace(furniture, objects=tuple(objects), statistics=statistics), islands=())


def _place(item: Signal | RoadObject) -> tuple[int, float, int]:
    return item.road, item.s, item.id
