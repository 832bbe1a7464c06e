"""Bridges that roads lead over, and tunnels that they lead through."""

from __future__ import annotations

import pytest
from object_cases import said, world_of
from street_cases import Case

from osm2xodr.furniture.objects.structures import place_structures
from osm2xodr.furniture.world.world import World
from osm2xodr.model import RoadStructure, Rule

EITHER = pytest.mark.parametrize("rule", list(Rule))
ALONG = {"w": (0.0, 0.0), "a": (60.0, 0.0), "b": (100.0, 0.0), "c": (150.0, 0.0), "e": (300.0, 0.0)}
CROSS = {**ALONG, "n": (100.0, 80.0), "s": (100.0, -80.0)}


def placed(world: World) -> list[tuple[str, str, float, float, tuple[int, ...]]]:
    return [(item.kind, item.type, item.s, item.length, item.osm_way_ids) for item in place_structures(world)]


def one(tags: str) -> RoadStructure:
    (found,) = place_structures(world_of(Case(ALONG, {1: ("w a", ""), 2: ("a c", tags), 3: ("c e", "")})))
    return found


def near(length: float) -> object:
    # Roads are smoothed, and OSM's degrees are rounded.
    return pytest.approx(length, abs=0.05)


@EITHER
def test_ways_in_a_row_make_one_bridge(rule: Rule) -> None:
    case = Case(
        ALONG, {1: ("w a", ""), 2: ("a b", "bridge=yes"), 3: ("c b", "bridge=viaduct lanes=2"), 4: ("c e", "")}
    )
    world = world_of(case, rule)
    assert placed(world) == [("bridge", "concrete", near(60.0), near(90.0), (2, 3))]
    assert said(world)["bridge-material"] == ["2 ways on bridges without a material: concrete assumed"]


def test_another_kind_of_structure_is_one_of_its_own() -> None:
    ways = {
        1: ("w a", "bridge=yes bridge:material=steel"),
        2: ("a b", "bridge=yes bridge:material=stone"),
        3: ("b c", "tunnel=yes"),
        4: ("c e", "tunnel=avalanche_protector"),
    }
    assert placed(world_of(Case(ALONG, ways))) == [
        ("bridge", "steel", 0.0, near(60.0), (1,)),
        ("bridge", "brick", near(60.0), near(40.0), (2,)),
        ("tunnel", "standard", near(100.0), near(50.0), (3,)),
        ("tunnel", "underpass", near(150.0), near(150.0), (4,)),
    ]


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("bridge=yes material=wood bridge:name=Holzsteg name=Weg", ("bridge", "wood", "Holzsteg", 0.0, 0.0)),
        ("bridge=yes material=marzipan name=Weg", ("bridge", "concrete", "", 0.0, 0.0)),
        ("tunnel=yes lit=yes tunnel:name=Berg", ("tunnel", "standard", "Berg", 1.0, 0.0)),
        ("tunnel=yes lit=no", ("tunnel", "standard", "", 0.0, 0.0)),
        # 90 m.
        ("tunnel=yes", ("tunnel", "standard", "", 1.0, 0.0)),
        ("tunnel=building_passage", ("tunnel", "standard", "", 1.0, 0.0)),
        ("tunnel=avalanche_protector lit=no", ("tunnel", "underpass", "", 0.0, 0.5)),
    ],
)
def test_what_tags_say(tags: str, expected: tuple[str, str, str, float, float]) -> None:
    found = one(tags)
    assert (found.kind, found.type, found.name, found.lighting, found.daylight) == expected


def test_short_tunnels_are_taken_as_dark() -> None:
    ways = {1: ("w a", "tunnel=yes"), 2: ("a c", ""), 3: ("c e", "tunnel=yes lit=no")}
    world = world_of(Case(ALONG, ways))
    assert [item.lighting for item in place_structures(world)] == [0.0, 0.0]
    assert said(world)["tunnel-lighting"] == ["1 way in tunnels without lit=*: assumed lit from a length of 80 m"]


@pytest.mark.parametrize("tags", ["", "bridge=no", "tunnel=no", "tunnel=culvert", "tunnel=flooded", "layer=1"])
def test_on_the_ground_there_is_none(tags: str) -> None:
    world = world_of(Case(ALONG, {1: ("w e", tags)}))
    assert placed(world) == []
    assert said(world).keys() <= {"flat"}


def test_a_junction_on_a_bridge_is_part_of_it_where_both_roads_are() -> None:
    bridge = "bridge=yes layer=1"
    ways = {1: ("w a b", bridge), 2: ("b c e", bridge), 3: ("b n", ""), 4: ("s b", bridge)}
    world = world_of(Case(CROSS, ways))
    found = {item.road: item for item in place_structures(world)}
    by_id = {road.id: road for road in world.road_map.roads}
    north = next(road.id for road in by_id.values() if road.osm_way_ids == (3,))
    for road in by_id.values():
        links = {link.id for link in (road.predecessor, road.successor) if link is not None and not link.to_junction}
        expected = road.id != north and north not in links
        assert (road.id in found) == expected, road
        if road.id in found:
            assert (found[road.id].s, found[road.id].length) == (0.0, near(world.lanes.length(road.id)))
    assert len({item.id for item in found.values()}) == len(found)
    assert len(found) > 3


def test_a_tunnel_is_as_long_as_all_of_its_roads() -> None:
    """Of 40 + 50 m in two roads, with a junction between them in the tunnel, none is dark."""
    tunnel = "tunnel=yes layer=-1"
    ways = {1: ("w a", ""), 2: ("a b c", tunnel), 3: ("c e", ""), 4: ("b n", tunnel + " lit=no")}
    nodes = {**CROSS, "n": (100.0, 20.0)}
    world = world_of(Case(nodes, ways))
    by_id = {road.id: road for road in world.road_map.roads}
    found = place_structures(world)
    straight = [item for item in found if item.osm_way_ids == (2,)]
    assert len(straight) >= 4
    assert all(item.length < 80.0 for item in straight)
    assert {item.lighting for item in straight} == {1.0}
    assert {item.lighting for item in found if item.osm_way_ids == (4,)} == {0.0}
    assert any(by_id[item.road].junction is not None for item in straight)
