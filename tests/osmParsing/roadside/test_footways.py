from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from osm_builder import Area

from osm2xodr.osmParsing import ParseOptions, parse_ways_option

NODES = {
    1: (0.0, 0.0),
    2: (100.0, 0.0),
    3: (200.0, 0.0),
    5: (100.0, 8.0),
    6: (100.0, -8.0),
    7: (100.0, 60.0),
    8: (0.0, 60.0),
    9: (300.0, 400.0),
}
STREET = ([1, 2, 3], "highway=residential")


@pytest.mark.parametrize(
    ("tags", "kept", "crossing"),
    [
        ("highway=footway", True, False),
        ("highway=footway footway=crossing", True, True),
        ("highway=cycleway cycleway=crossing", True, True),
        ("highway=path path=crossing", True, True),
        ("highway=footway footway=sidewalk", True, False),
        ("highway=pedestrian", True, False),
        ("highway=pedestrian area=yes", False, False),
        ("highway=path", False, False),
        ("highway=path foot=designated", True, False),
        ("highway=path bicycle=designated segregated=no", True, False),
        ("highway=steps", False, False),
        ("highway=corridor", False, False),
    ],
)
def test_kinds(tmp_path: Path, tags: str, kept: bool, crossing: bool) -> None:
    area = Area(NODES, {20: STREET, 30: ([5, 6], f"{tags} layer=1 name=A width=3")})
    network, _ = area.parse(tmp_path)
    assert [footway.osm_way_id for footway in network.footways] == ([30] if kept else [])
    for footway in network.footways:
        assert footway.crossing is crossing
        assert footway.node_ids.tolist() == [5, 6]
        places = footway.points - network.streets[0].points[0]
        assert places == pytest.approx(np.array([[100.0, 8.0], [100.0, -8.0]]), abs=0.05)
        expected = {**dict(item.split("=") for item in tags.split()), "layer": "1", "width": "3"}
        assert footway.tags == expected


def test_within_reach_or_on_a_node_of_a_street(tmp_path: Path) -> None:
    area = Area(
        NODES,
        {
            20: STREET,
            30: ([9, 5], "highway=footway"),
            31: ([2, 7], "highway=footway"),
            32: ([7, 8], "highway=footway"),
            -33: ([6, 5], "highway=footway"),
        },
    )
    network, _ = area.parse(tmp_path)
    assert [footway.osm_way_id for footway in network.footways] == [-33, 30, 31]
    assert network.footways[2].node_ids.tolist() == [2, 7]


def test_a_way_that_is_a_street_is_no_footway(tmp_path: Path) -> None:
    area = Area(NODES, {20: STREET, 30: ([2, 7], "highway=pedestrian")})
    network, _ = area.parse(tmp_path, ParseOptions(parse_ways_option("residential,pedestrian"), include_private=True))
    assert network.footways == ()
    assert len(network.streets) == 3


def test_absent_and_repeated_nodes_are_left_out(tmp_path: Path) -> None:
    nodes = {**NODES, 10: NODES[5]}
    area = Area(nodes, {20: STREET, 30: ([5, 10, 99, 6], "highway=footway"), 31: ([5, 10], "highway=footway")})
    network, _ = area.parse(tmp_path)
    assert [(footway.osm_way_id, footway.node_ids.tolist()) for footway in network.footways] == [(30, [5, 6])]
