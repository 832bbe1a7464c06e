"""Stretches of strips along a road: none too short, and their borders where the carriageway has its own."""

from __future__ import annotations

from margin_cases import BOTH, WALK, built, sections_of
from street_cases import Case

from osm2xodr.geometry.roadside.strips import MarginStretch, settled


def test_a_piece_too_short_for_a_section_joins_its_neighbour() -> None:
    nodes = {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (105.0, 0.0), "d": (160.0, 0.0)}
    case = Case(nodes, {1: ("a b", "lanes=2"), 2: ("b c", "lanes=2"), 3: ("c d", "lanes=2")})
    roads = built(case, {1: BOTH, 3: BOTH})
    (section,) = sections_of(roads)
    assert [lane.id for lane in section.lanes] == [2, 1, 0, -1, -2]


def test_a_border_near_that_of_the_carriageway_moves_there() -> None:
    both, none = ((WALK,), (WALK,)), ((), ())
    given = (MarginStretch(0.0, 95.0, *both, 1), MarginStretch(95.0, 200.0, *none, 2))
    assert [item.end for item in settled(given, [100.0])] == [100.0, 200.0]
    assert [item.end for item in settled(given, [120.0])] == [95.0, 200.0]
