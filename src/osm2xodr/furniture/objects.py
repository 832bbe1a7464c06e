"""Objects on and beside the road apart from crossings."""

from __future__ import annotations

from collections.abc import Sequence

from osm2xodr.furniture.arrows import arrows
from osm2xodr.furniture.barriers import barrier_objects
from osm2xodr.furniture.bus_stops import bus_stop_objects
from osm2xodr.furniture.calming import calming_objects
from osm2xodr.furniture.roadside_places import RoadsideFinder
from osm2xodr.furniture.roadside_points import point_objects
from osm2xodr.furniture.stop_lines import stop_lines
from osm2xodr.furniture.tram_tracks import tram_objects
from osm2xodr.furniture.world import Approach, Stop, World
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
