"""What stands beside the roads of a real place stands beside them."""

from __future__ import annotations

import numpy as np
import pytest
from scene_files import scene_named

from osm2xodr.curves.nearest import CurveFinder
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.furniture.objects import find_crossings, place_objects
from osm2xodr.furniture.options import FurnitureOptions
from osm2xodr.furniture.world.approaches import find_approaches
from osm2xodr.furniture.world.lane_table import LaneTable
from osm2xodr.furniture.world.world import World
from osm2xodr.geometry import build_roads
from osm2xodr.model import VEHICLE_LANES, RoadObject
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.surface import FlatSurface

# What lies on lanes by its nature.
ON_LANES = ("crosswalk", "patch", "roadMark", "trafficIsland")
ALL = frozenset({"lamps", "trees"})
# Half of the thinnest thing, m.
THIN = 0.05


@pytest.fixture(scope="module")
def world() -> World:
    network = parse_osm(scene_named("i5_exit_ramp").osm, ParseOptions(extra_objects=ALL), Diagnostics())
    road_map = build_roads(network, FlatSurface(), Diagnostics())
    assert road_map.places is not None
    options = FurnitureOptions(extra_objects=ALL)
    return World(network, road_map, road_map.places, LaneTable(road_map), options, Diagnostics())


@pytest.fixture(scope="module")
def objects(world: World) -> tuple[RoadObject, ...]:
    crossings = find_crossings(world)
    return place_objects(world, find_approaches(world, crossings), (), crossings)


def along(item: RoadObject) -> list[tuple[float, float]]:
    """Return s and t of places on an object, a metre apart."""
    if item.repeat is None:
        return [(item.s, item.t)]
    share = np.linspace(0.0, 1.0, int(item.repeat.length) + 2)
    s = item.repeat.s + share * item.repeat.length
    t = item.repeat.t_start + share * (item.repeat.t_end - item.repeat.t_start)
    return list(zip(s.tolist(), t.tolist(), strict=True))


def test_all_kinds_are_there(objects: tuple[RoadObject, ...]) -> None:
    kinds = {item.type for item in objects}
    assert kinds >= {"crosswalk", "roadMark", "barrier", "railing", "pole", "streetLamp", "tree"}


def test_objects_lie_on_their_roads_and_have_ids_of_their_own(world: World, objects: tuple[RoadObject, ...]) -> None:
    assert len({item.id for item in objects}) == len(objects)
    for item in objects:
        length = world.lanes.length(item.road)
        assert 0.0 <= item.s <= length
        if item.repeat is not None:
            assert item.repeat.length > 0.0
            assert item.repeat.s + item.repeat.length <= length + 1e-9


def test_nothing_stands_on_lanes_for_cars(world: World, objects: tuple[RoadObject, ...]) -> None:
    standing = [(item, s, t) for item in objects if item.type not in ON_LANES for s, t in along(item)]
    assert len(standing) > 100
    curve = np.array([world.lanes.index(item.road) for item, _, _ in standing])
    s, t = np.array([s for _, s, _ in standing]), np.array([t for _, _, t in standing])
    x, y, hdg = pose(world.road_map.plan_view, curve, s)
    near = CurveFinder(world.road_map.plan_view).near(x - t * np.sin(hdg), y + t * np.cos(hdg), 15.0)
    for point, road, at, aside, distance in zip(*(item.tolist() for item in near), strict=True):
        if distance - abs(aside) > 0.01:
            continue
        for lane in world.lanes.at(world.road_map.roads[road].id, at):
            if lane.type in VEHICLE_LANES:
                assert not lane.right + THIN < aside < lane.left - THIN, standing[point][0]
