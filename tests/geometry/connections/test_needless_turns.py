"""Turns that hardly any car drives, and that nobody needs, are left out."""

from __future__ import annotations

import pytest
from street_cases import Case

from osm2xodr.curves import smallest_radius
from osm2xodr.model import RoadMap, Rule


def triangle(side: float, branch: float) -> Case:
    """Return a main street to the east and a side street to the north that splits before it, at places some way off.

    Each corner of the small triangle has an acute angle.
    """
    return Case(
        {
            "w": (-150.0, 0.0), "a": (-side, 0.0), "b": (side, 0.0), "e": (150.0, 0.0),
            "c": (0.0, branch), "n": (0.0, 150.0),
        },
        {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("a c", ""), 5: ("b c", ""), 6: ("c n", "")},
    )  # fmt: skip


def turns(roads: RoadMap) -> set[tuple[int, int]]:
    """Return the OSM ways that connecting roads join."""
    way = {road.id: road.osm_way_ids[0] for road in roads.roads if road.junction is None and road.osm_way_ids}
    joined = ((road.predecessor, road.successor) for road in roads.roads if road.junction is not None)
    return {(way[one.id], way[other.id]) for one, other in joined if one is not None and other is not None}


SIDES = {(2, 4), (4, 2), (4, 5), (5, 4), (5, 2), (2, 5)}


@pytest.mark.parametrize("rule", list(Rule))
def test_nobody_turns_sharply_within_a_small_triangle(rule: Rule) -> None:
    """Its inner lanes are not linked at its corners, all other turns are."""
    case = triangle(10.0, 18.0)
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert SIDES - turns(roads) == {(2, 4), (4, 5), (5, 2)}
    assert len(turns(roads)) == 15
    assert smallest_radius(roads.plan_view).min() > 4.2


def test_cars_turn_at_the_corners_of_a_block() -> None:
    """However sharp they are: people live there."""
    roads = triangle(20.0, 14.0).build()
    assert turns(roads) >= SIDES
    assert smallest_radius(roads.plan_view).min() < 4.2


def test_cars_turn_where_only_that_leads_on() -> None:
    """Without the side along the main street, its traffic has no other way."""
    small = triangle(10.0, 18.0)
    case = Case(small.nodes, {**small.ways, 2: ("a b", "oneway=yes"), 5: ("b c", "oneway=yes")})
    assert (2, 5) in turns(case.build())
