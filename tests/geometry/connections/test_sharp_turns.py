"""Turns that are sharper than a car drives swing out where there is room for it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.defaults import CONNECTING_RADIUS, MOST_SWING_BACK
from osm2xodr.geometry import defaults
from osm2xodr.model import RoadMap, Rule

# Two carriageways, 4.6 m apart, and a street that crosses them, where one may turn back.
DUAL = Case(
    {
        "w1": (-80.0, 2.3), "w2": (-80.0, -2.3), "e1": (80.0, 2.3), "e2": (80.0, -2.3),
        "o1": (0.0, 2.3), "o2": (0.0, -2.3), "n": (0.0, 60.0), "s": (0.0, -60.0),
    },
    {
        1: ("o1 w1", "oneway=yes"), 2: ("w2 o2", "oneway=yes"),
        3: ("e1 o1", "oneway=yes"), 4: ("o2 e2", "oneway=yes"),
        5: ("s o2", ""), 6: ("o2 o1", ""), 7: ("o1 n", ""),
    },
)  # fmt: skip


def turn_back(roads: RoadMap) -> int:
    """Return the index of the connecting road between the carriageways."""
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    (found,) = (
        k
        for k, road in enumerate(roads.roads)
        if road.junction
        and road.predecessor is not None
        and road.successor is not None
        and (ways[road.predecessor.id], ways[road.successor.id]) == ((2,), (1,))
    )
    return found


@pytest.mark.parametrize("rule", list(Rule))
def test_a_turn_back_has_the_radius_that_cars_drive(rule: Rule) -> None:
    case = DUAL if rule is Rule.RIGHT_HAND else DUAL.mirrored()
    roads = case.build(rule)
    assert_sound(roads)
    k = turn_back(roads)
    assert smallest_radius_of(roads.plan_view, k) == pytest.approx(CONNECTING_RADIUS)
    turned = RoadMeasures(roads).length(roads.roads[k]) / CONNECTING_RADIUS
    assert math.pi < turned < math.pi + MOST_SWING_BACK


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("apart", [2.2, 2.8, 3.4, 4.0])
def test_no_turn_back_folds_its_lane(apart: float, rule: Rule) -> None:
    """Even where there is no room to swing out, the inner edge keeps a radius."""
    nodes = {name: (x, math.copysign(apart / 2, y) if abs(y) < 10 else y) for name, (x, y) in DUAL.nodes.items()}
    case = replace(DUAL, nodes=nodes)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    widths = {road.id: lane.widths[0].a for road in roads.roads for lane in road.lane_sections[0].lanes if lane.id}
    inner = [
        smallest_radius_of(roads.plan_view, k) - widths[road.id] / 2
        for k, road in enumerate(roads.roads)
        if road.junction is not None
    ]
    assert min(inner) > 0.1 * defaults.INNER_EDGE_RADIUS - 1e-9
