"""Lanelet2's own library reads maps that are exported for it, and sees the lanes and links of the OpenDRIVE file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from lanelet_graph import PARTICIPANTS, ExpectedGraph, LaneletMap, height_errors, read_map
from scene_files import SCENES, Conversion, Conversions, Scene

import osm2xodr


@dataclass(frozen=True)
class Exported:
    """A conversion, the map made of it, and what Lanelet2 reads."""

    conversion: Conversion
    path: Path
    map: LaneletMap


@pytest.fixture(scope="module", params=SCENES, ids=str)
def exported(
    request: pytest.FixtureRequest, conversions: Conversions, tmp_path_factory: pytest.TempPathFactory
) -> Exported:
    scene: Scene = request.param
    conversion = conversions.of(scene)
    path = tmp_path_factory.mktemp("lanelet2") / "map.osm"
    osm2xodr.export(conversion.path, path)
    return Exported(conversion, path, read_map(path))


def test_it_loads_without_errors(exported: Exported) -> None:
    assert exported.map.errors == []
    driving = sum(
        section.end - section.s
        for road in exported.conversion.network.roads.values()
        for section in road.sections
        for lane in section.lanes.values()
        if lane.type == "driving"
    )
    spans = [one.tags["xodr:s"].split() for one in exported.map.lanelets.values() if one.tags["subtype"] == "road"]
    # All but what is not wide enough to be there.
    assert 0.95 * driving <= sum(float(high) - float(low) for low, high in spans) <= driving + 1e-3 * len(spans)


def test_the_routing_graph_is_that_of_the_lanes(exported: Exported) -> None:
    expected = ExpectedGraph(exported.conversion.path, exported.map.lanelets)
    for who in PARTICIPANTS:
        edges = exported.map.edges[who]
        assert edges.follow == expected.following(who)
        assert (edges.left, edges.right) == expected.changes(who)
    assert len(exported.map.edges["vehicle"].follow) > 20
    assert len(exported.map.edges["pedestrian"].follow) > 5


def test_heights_are_those_of_the_roads(exported: Exported) -> None:
    errors = height_errors(exported.path, exported.conversion.path, exported.map)
    assert len(errors) > 150
    assert errors.max() < 0.01


def test_lights_signs_and_priorities_are_regulatory_elements(exported: Exported) -> None:
    text = exported.conversion.path.read_text(encoding="utf-8")
    assert exported.map.rules.get("traffic_light", 0) == text.count('type="1000001"')
    assert (exported.map.rules.get("right_of_way", 0) > 0) == ("<priority" in text)
    held = {rule for lanelet in exported.map.lanelets.values() for rule in lanelet.rules}
    assert held == set(exported.map.rules)


def test_ways_through_junctions_say_where_they_turn(exported: Exported) -> None:
    network = exported.conversion.network
    for (road, _, _), lanelet in exported.map.lanelets.items():
        turns = network.roads[road].connecting and lanelet.tags["subtype"] == "road"
        assert ("turn_direction" in lanelet.tags) == turns
    words = {lanelet.tags.get("turn_direction") for lanelet in exported.map.lanelets.values()}
    assert {"left", "right", "straight"} <= words
