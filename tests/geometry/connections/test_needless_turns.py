"""Turns that hardly any car drives, and that nobody needs, are left out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from street_cases import Case

from osm2xodr.curves import dubins_without_slivers, lengths, smallest_radius
from osm2xodr.geometry.connections import ConnectingRoads, long_turns_back
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


def turns_back(apart: float, stagger: list[float], entries: list[int]) -> ConnectingRoads:
    """Draw turns back onto lanes some way apart, each of which begins that far ahead, m, from these road ends."""
    ahead = np.array(stagger)
    zero, west = np.zeros(len(ahead)), np.full(len(ahead), np.pi)
    plan = dubins_without_slivers(zero, zero, zero, ahead, zero + apart, west, radius=zero + 4.0)
    entry = np.array(entries, np.int64)
    columns = {
        "plan_view": plan,
        "length": lengths(plan),
        "for_vehicles": lambda: np.ones(len(entry), bool),
        "entry": entry,
        "exit": np.full(len(entry), 9, np.int64),
        "entry_lane": 0 * entry,
        "exit_lane": 0 * entry,
    }
    return cast("ConnectingRoads", SimpleNamespace(**columns))


@pytest.mark.parametrize(
    ("apart", "entries", "on_ring", "left_out"),
    [
        (5.0, [1, 1], False, [True, False]),
        # Wide enough to turn in one go: it goes round something.
        (12.0, [1, 1], False, [False, False]),
        (5.0, [1, 1], True, [False, False]),
        # Nothing else leads on from the end of its lane.
        (5.0, [1, 3], False, [False, False]),
    ],
)
def test_turns_back_that_swing_out_and_are_long_are_left_out(
    apart: float, entries: list[int], on_ring: bool, left_out: list[bool]
) -> None:
    roads = turns_back(apart, [30.0, 0.0], entries)
    assert (roads.length > 40.0).tolist() == [True, False]
    assert long_turns_back(roads, np.full(2, on_ring)).tolist() == left_out
