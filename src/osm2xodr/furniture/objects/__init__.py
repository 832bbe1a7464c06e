"""Objects: what lies on the carriageway and stands beside it."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture.objects.bus_stops import bus_stop_objects
from osm2xodr.furniture.objects.calming import calming_objects, crossing_objects, island_objects as island_objects
from osm2xodr.furniture.objects.crossings import find_crossings as find_crossings, rail_crossing_objects
from osm2xodr.furniture.objects.road_marks import arrows, mini_roundabouts, stop_lines
from osm2xodr.furniture.objects.roadside_things import line_objects, point_objects, tram_objects
from osm2xodr.furniture.objects.structures import place_structures as place_structures
from osm2xodr.furniture.world import Approach, Crossing, RailStop, RoadsideFinder, Stop, World
from osm2xodr.model import RoadObject


def place_objects(
    world: World,
    approaches: Sequence[Approach],
    stops: Sequence[Stop],
    crossings: Sequence[Crossing] = (),
    rail_stops: Sequence[RailStop] = (),
) -> tuple[RoadObject, ...]:
    """Place crossings, lines across the lanes at stops, arrows on the lanes of approaches, and roadside objects."""
    finder = RoadsideFinder(world)
    return (
        *crossing_objects(world, crossings),
        *stop_lines(world, stops, crossings),
        *arrows(world, approaches, stops),
        *mini_roundabouts(world),
        *calming_objects(world),
        *rail_crossing_objects(world, rail_stops),
        *bus_stop_objects(world, finder),
        *line_objects(world, finder),
        *tram_objects(world, finder),
        *point_objects(world, finder),
    )
