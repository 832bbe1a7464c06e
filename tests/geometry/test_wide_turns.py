"""Turns back between lanes that lie close together swing out where there is room for it."""

from __future__ import annotations

import math

import pytest
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr import defaults
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
    assert smallest_radius_of(roads.plan_view, k) == pytest.approx(defaults.CONNECTING_RADIUS)
    turned = RoadMeasures(roads).length(roads.roads[k]) / defaults.CONNECTING_RADIUS
    assert math.pi < turned < math.pi + defaults.MOST_SWING_BACK
