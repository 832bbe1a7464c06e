"""Objects on and beside the road apart from crossings."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture.objects.arrows import arrows
from osm2xodr.furniture.objects.barriers import barrier_objects
from osm2xodr.furniture.objects.bus_stops import bus_stop_objects
from osm2xodr.furniture.objects.calming import calming_objects
from osm2xodr.furniture.objects.roadside_points import point_objects
from osm2xodr.furniture.objects.stop_lines import stop_lines
from osm2xodr.furniture.objects.tram_tracks import tram_objects
from osm2xodr.furniture.world import Approach, RoadsideFinder, Stop, World
from osm2xodr.model import RoadObject


def place_objects(world: World, approaches: Sequence[Approach], stops: Sequence[Stop]) -> tuple[RoadObject, ...]:
    """Place stop lines, arrows, and whatever stands beside the road.

    Parameters
    ----------
    world
        What is there.
    approaches
        The road ends whose lanes get arrows.
    stops
        Where there are lines across lanes.
    """
    things = world.network.roadside
    finder, nodes = RoadsideFinder(world), world.nodes
    return (
        *stop_lines(world, stops),
        *arrows(world, approaches, stops),
        *calming_objects(world, nodes),
        *bus_stop_objects(world, nodes, finder, things),
        *barrier_objects(world, finder, things),
        *tram_objects(world, finder, things),
        *point_objects(world, finder, things),
    )
