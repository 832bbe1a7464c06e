"""What calms traffic, as objects on the carriageway."""

from __future__ import annotations

import pytest
from object_cases import has_corners, road_of_way, said, world_of
from street_cases import Case

from osm2xodr.furniture.objects.calming import calming_objects
from osm2xodr.furniture.world.world import World
from osm2xodr.model import RoadObject, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
STREET = {"w": (0.0, 0.0), "a": (50.0, 0.0), "z": (99.0, 0.0), "e": (100.0, 0.0)}


def placed(world: World) -> list[RoadObject]:
    return calming_objects(world)


def road(tags: str, way: str = "lanes=2 width=7", node: str = "a") -> Case:
    return Case(STREET, {1: ("w a z e", way)}, node_tags={node: tags})


@EITHER
@pytest.mark.parametrize(
    ("value", "kind", "length", "height"),
    [
        ("bump", "bump", 0.6, 0.08),
        ("hump", "hump", 3.7, 0.08),
        ("table", "table", 6.7, 0.08),
        ("rumble_strip", "rumble_strip", 3.0, 0.01),
        ("dip", "dip", 2.0, 0.0),
    ],
)
def test_humps_lie_across_the_carriageway(rule: Rule, value: str, kind: str, length: float, height: float) -> None:
    (item,) = placed(world_of(road(f"traffic_calming={value}"), rule))
    assert (item.type, item.subtype, item.length, item.height) == ("patch", kind, length, height)
    assert (item.s, item.t, item.width) == pytest.approx((50.0, 0.0, 7.0), abs=0.02)
    assert item.osm_id == "node/1002"


@EITHER
def test_cushions_lie_in_the_middle_of_each_lane(rule: Rule) -> None:
    found = placed(world_of(road("traffic_calming=cushion"), rule))
    assert [(round(item.t, 6), round(item.width, 6)) for item in found] == [(1.75, 1.8), (-1.75, 1.8)]


def test_a_table_at_the_end_of_a_road_stays_on_it() -> None:
    world = world_of(road("traffic_calming=table", node="z"))
    (item,) = placed(world)
    assert item.s + 0.5 * item.length == pytest.approx(world.lanes.length(road_of_way(world, 1)))


@EITHER
def test_an_island_lies_between_the_directions(rule: Rule) -> None:
    (item,) = placed(world_of(road("traffic_calming=island"), rule))
    assert item.type == "trafficIsland"
    assert has_corners(item, [(47.0, -1.0), (53.0, -1.0), (53.0, 1.0), (47.0, 1.0)])


def test_what_cannot_be_placed_is_counted() -> None:
    for tags, way, why in (
        ("traffic_calming=chicane", "lanes=2", "chicane left out: it changes the carriageway"),
        ("traffic_calming=island", "lanes=2 width=5.5", "island left out: the lanes cannot spare the room"),
        ("traffic_calming=island", "oneway=yes", "island left out: all lanes run the same way"),
    ):
        world = world_of(road(tags, way))
        assert placed(world) == []
        (message,) = said(world)["traffic-calming"]
        assert message.startswith(f"1 node with traffic_calming={why}")


def test_a_table_on_a_junction_is_left_out() -> None:
    nodes = {"w": (-99.0, 0.0), "o": (0.0, 0.0), "e": (99.0, 0.0), "n": (0.0, 99.0)}
    ways = {1: ("w o", ""), 2: ("o e", ""), 3: ("o n", "")}
    world = world_of(Case(nodes, ways, node_tags={"o": "traffic_calming=table"}))
    assert placed(world) == []
    assert said(world)["traffic-calming"] == ["1 node with traffic_calming=table left out: it lies in a junction"]


def test_an_island_of_a_crossing_is_left_to_the_crossing() -> None:
    assert placed(world_of(road("traffic_calming=island highway=crossing"))) == []
