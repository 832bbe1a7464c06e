"""Roads end where their name or number changes, without a seam."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from road_measures import assert_sound
from street_cases import Case

from osm2xodr.curves import cubic_value, lengths, pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry import cut_at_names
from osm2xodr.model import Furniture, RoadLink, RoadMap, RoadStructure

# A street in a bend with three lanes from its third way on, which has one number with the fourth.
_NODES = {"a": (0.0, 0.0), "b": (150.0, 0.0), "c": (300.0, 40.0), "d": (450.0, 130.0), "e": (600.0, 250.0)}
_WAYS = {
    1: ("a b", "highway=primary lanes=2 name=Alte_Gasse ref=10"),
    2: ("b c", "highway=primary lanes=2 name=Alte_Gasse ref=11"),
    3: ("c d", "highway=primary lanes=3 lanes:forward=2 ref=11"),
    4: ("d e", "highway=primary lanes=3 lanes:forward=2 ref=11"),
}


def whole(ways: dict[int, tuple[str, str]] | None = None) -> RoadMap:
    return Case(_NODES, ways or _WAYS).build()


def test_each_name_has_its_road() -> None:
    roads = cut_at_names(whole(), Diagnostics())
    assert [(road.name, road.osm_way_ids) for road in roads.roads] == [
        ("Alte_Gasse", (1,)),
        ("Alte_Gasse", (2,)),
        ("11", (3, 4)),
    ]
    assert [road.id for road in roads.roads] == [1, 2, 3]
    assert all(not road.names for road in roads.roads)
    assert lengths(roads.plan_view).tolist() == pytest.approx([150.0, 155.2, 367.0], abs=5.0)


def test_the_joint_is_seamless() -> None:
    before = whole()
    roads = cut_at_names(before, Diagnostics())
    assert_sound(roads)
    length = lengths(roads.plan_view)
    assert length.sum() == pytest.approx(lengths(before.plan_view).sum(), abs=1e-9)
    one, two = np.arange(2), np.arange(1, 3)
    ends, begins = pose(roads.plan_view, one, length[:2]), pose(roads.plan_view, two, np.zeros(2))
    assert np.abs(np.array(ends) - np.array(begins)).max() < 1e-6
    heights = [cubic_value(roads.elevation, k, s) for k, s in ((one, length[:2]), (two, np.zeros(2)))]
    assert heights[0] == pytest.approx(heights[1], abs=1e-6)
    for before_cut, other in pairwise(roads.roads):
        assert before_cut.successor == RoadLink(False, other.id, True)
        assert other.predecessor == RoadLink(False, before_cut.id, False)
        last, first = before_cut.lane_sections[-1], other.lane_sections[0]
        there = {lane.id: lane for lane in first.lanes}
        linked = [lane for lane in last.lanes if lane.id and lane.successor is not None]
        assert linked
        for lane in linked:
            assert lane.successor is not None
            assert there[lane.successor].predecessor == lane.id


def test_short_pieces_bear_the_name_beside_them() -> None:
    nodes = {**_NODES, "x": (154.0, 1.0)}
    ways = {
        1: ("a b", "highway=primary name=One"),
        2: ("b x", "highway=primary name=Bridge"),
        3: ("x c", "highway=primary name=One"),
    }
    roads = cut_at_names(Case(nodes, ways).build(), Diagnostics())
    assert [(road.name, road.osm_way_ids) for road in roads.roads] == [("One", (1, 2, 3))]


def test_a_bridge_under_two_names_is_one_on_either_road() -> None:
    before = whole()
    bridge = RoadStructure(7, 1, 100.0, 120.0, "bridge", "concrete")
    before = replace(before, furniture=Furniture(structures=(bridge,)))
    roads = cut_at_names(before, Diagnostics())
    cut = float(lengths(roads.plan_view)[0])
    found = roads.furniture.structures
    assert [(item.road, item.s) for item in found] == [(1, 100.0), (2, 0.0)]
    assert [item.length for item in found] == pytest.approx([cut - 100.0, 220.0 - cut])
