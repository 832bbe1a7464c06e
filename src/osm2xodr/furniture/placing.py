"""The steps of this stage in order."""

from __future__ import annotations

from dataclasses import replace

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.lights import cut_sections, place_lights
from osm2xodr.furniture.objects import crossing_objects, find_crossings, place_objects, place_structures
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.signs import place_signs
from osm2xodr.furniture.world import LaneTable, World, find_approaches
from osm2xodr.model import Furniture, RoadMap, RoadObject, Signal, StreetNetwork


def place(network: StreetNetwork, road_map: RoadMap, options: FurnitureOptions, diagnostics: Diagnostics) -> RoadMap:
    """Do what `osm2xodr.furniture.place_furniture` says."""
    if not options.enabled or road_map.places is None:
        return road_map
    world = World(network, road_map, road_map.places, LaneTable(road_map), options, diagnostics)
    crossings = find_crossings(world)
    approaches = find_approaches(world, crossings)
    lights = place_lights(world, approaches, crossings)
    signs = place_signs(world, approaches, lights.signalled, crossings)
    objects = (
        *crossing_objects(world, crossings),
        *place_objects(world, approaches, (*lights.stops, *signs.stops)),
    )
    signals = (*lights.signals, *signs.signals)
    furniture = Furniture(
        signals=tuple(sorted(signals, key=_place)),
        references=tuple(sorted(lights.references, key=lambda item: (item.road, item.s, item.signal))),
        controllers=lights.controllers,
        objects=tuple(sorted(objects, key=_place)),
        structures=place_structures(world),
        statistics={
            "traffic_lights": float(sum(item.dynamic for item in signals)),
            "signs": float(sum(not item.dynamic for item in signals)),
            "controllers": float(len(lights.controllers)),
            "crossings": float(len(crossings)),
            "objects": float(len(objects)),
        },
    )
    return replace(cut_sections(road_map, lights.section_breaks), furniture=furniture)


def _place(item: Signal | RoadObject) -> tuple[int, float, int]:
    return item.road, item.s, item.id
