"""Ranges of lanes, and what is looked up once for all parts."""

from __future__ import annotations

import pytest
from object_cases import world_of
from street_cases import Case

from osm2xodr.furniture.world.lane_table import lane_ranges
from osm2xodr.model import Rule


@pytest.mark.parametrize(
    ("lanes", "expected"),
    [
        ((), ()),
        ((-1,), ((-1, -1),)),
        ((2, 1, 3), ((1, 3),)),
        ((-1, -2, -4), ((-4, -4), (-2, -1))),
        # The centre is no lane of either side.
        ((1, -1), ((-1, -1), (1, 1))),
        ((0,), ((0, 0),)),
        ((1, 1, 2), ((1, 2),)),
    ],
)
def test_ranges_of_lanes(lanes: tuple[int, ...], expected: tuple[tuple[int, int], ...]) -> None:
    assert lane_ranges(lanes) == expected


def test_places_of_nodes_are_found_once() -> None:
    world = world_of(Case({"w": (0.0, 0.0), "e": (100.0, 0.0)}, {1: ("w e", "")}), Rule.RIGHT_HAND)
    assert world.nodes is world.nodes
    first, last = world.network.streets[0].node_ids.tolist()
    found = world.nodes.on_streets([first, last])
    (begin,), (end,) = found[first], found[last]
    assert begin.s == 0.0
    assert end.s == pytest.approx(world.lanes.length(end.road))
    assert begin.road == end.road
