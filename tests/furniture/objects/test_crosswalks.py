"""What the objects of crossings look like."""

from __future__ import annotations

import numpy as np
import pytest
from light_cases import point, with_tags
from object_cases import has_corners, said, world_of
from street_cases import Case

from osm2xodr.furniture.objects.calming import crossing_objects
from osm2xodr.furniture.objects.crossings import find_crossings
from osm2xodr.model import LaneType, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
STREET = {"w": (0.0, 0.0), "a": (50.0, 0.0), "b": (51.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w a b e", "lanes=2 width=7")})


def test_unmarked_and_zebra_crossings_differ() -> None:
    names = {}
    for tags in ("crossing=unmarked", "crossing=uncontrolled crossing_ref=zebra", "crossing:markings=lines:paired"):
        world = world_of(with_tags(ROAD, a=f"highway=crossing {tags}"))
        (item,) = crossing_objects(world, find_crossings(world))
        names[tags.split("=")[-1]] = item.subtype, item.name
    assert names == {
        "unmarked": ("virtual", "unmarked crossing"),
        "zebra": ("zebra", "zebra crossing"),
        "lines:paired": ("lines", "lines crossing"),
    }


@EITHER
def test_an_island_splits_the_crossing_where_lanes_are_wide(rule: Rule) -> None:
    wide = Case(STREET, {1: ("w a b e", "lanes=2 width=7")}, node_tags={"a": "highway=crossing crossing:island=yes"})
    world = world_of(wide, rule)
    items = crossing_objects(world, find_crossings(world))
    assert [item.type for item in items] == ["crosswalk", "trafficIsland", "crosswalk"]
    left, island, right = items
    assert has_corners(island, [(47.5, -1.0), (52.5, -1.0), (52.5, 1.0), (47.5, 1.0)])
    assert island.height == 0.12
    assert has_corners(left, [(48.5, 1.0), (51.5, 1.0), (51.5, 3.5), (48.5, 3.5)])
    assert has_corners(right, [(48.5, -3.5), (51.5, -3.5), (51.5, -1.0), (48.5, -1.0)])
    for lane in world.lanes.at(island.road, 50.0):
        if lane.type is LaneType.DRIVING:
            spare = lane.left - lane.right - 1.0
            assert spare == pytest.approx(2.5)


@EITHER
def test_narrow_lanes_and_one_ways_have_no_island(rule: Rule) -> None:
    narrow = Case(STREET, {1: ("w a b e", "lanes=2 width=5.5")}, node_tags={"a": "highway=crossing crossing=island"})
    world = world_of(narrow, rule)
    assert [item.type for item in crossing_objects(world, find_crossings(world))] == ["crosswalk", "crosswalk"]
    assert "can spare only 0.5 m" in said(world)["crossing-island"][0]
    one_way = Case(STREET, {1: ("w a b e", "oneway=yes")}, node_tags={"a": "highway=crossing crossing=island"})
    world = world_of(one_way, rule)
    assert [item.type for item in crossing_objects(world, find_crossings(world))] == ["crosswalk"]
    assert "all lanes run the same way" in said(world)["crossing-island"][0]


@EITHER
def test_corners_follow_a_bend(rule: Rule) -> None:
    """A quarter of a circle of 40 m, drawn by chords; the corners lie on the carriageway's edges."""
    angle = np.radians(np.arange(0.0, 91.0, 7.5))
    nodes = {f"p{k}": (40.0 * np.sin(a), 40.0 * (1.0 - np.cos(a))) for k, a in enumerate(angle.tolist())}
    case = Case(nodes, {1: (" ".join(nodes), "")}, node_tags={"p6": "highway=crossing crossing=traffic_signals"})
    world = world_of(case, rule)
    (item,) = crossing_objects(world, find_crossings(world))
    middle = point(world.road_map, item.road, item.s, item.t)
    ahead = point(world.road_map, item.road, item.s + 1e-6, item.t) - middle
    along = ahead / abs(ahead)
    begin, end = item.s - 2.0, item.s + 2.0
    for (u, v, _, _), s, left in zip(item.outline, (begin, end, end, begin), (0, 0, 1, 1), strict=True):
        edges = world.lanes.carriageway(item.road, s)
        there = point(world.road_map, item.road, s, edges[0] if left else edges[1])
        assert abs(middle + complex(u, v) * along - there) < 1e-4
