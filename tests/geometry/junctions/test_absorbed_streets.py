"""Streets that are too short to be roads: they go, and it is told; what is left holds together."""

from __future__ import annotations

import math

import pytest
from road_measures import RoadMeasures, assert_sound
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import InputError
from osm2xodr.geometry import build_roads
from osm2xodr.model import RoadMap, Rule
from osm2xodr.surface import FlatSurface

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)


def built(case: Case) -> tuple[RoadMap, list[tuple[Kind, str, str]]]:
    """Return the roads of a case, and what was dropped."""
    found = Diagnostics()
    roads = build_roads(case.stages().network, FlatSurface(), found)
    assert_sound(roads)
    return roads, [(item.kind, item.code, item.osm_id) for item in found if item.kind is Kind.DROPPED]


def ring(radius: float, name: str = "r") -> dict[str, tuple[float, float]]:
    angles = [math.tau * k / 8 for k in range(8)]
    return {f"{name}{k}": (50 + radius * math.cos(a), 50 + radius * math.sin(a)) for k, a in enumerate(angles)}


def round_(nodes: dict[str, tuple[float, float]]) -> str:
    return " ".join([*nodes, next(iter(nodes))])


def test_an_area_of_a_metre_is_refused() -> None:
    """A triangle of streets of less than a metre, all between junctions."""
    case = Case(
        {"a": (0.0, 0.0), "b": (0.8, 0.1), "c": (0.3, 0.7)}, {1: ("a b", ""), 2: ("b c", ""), 3: ("c a b", "")}
    )
    with pytest.raises(InputError, match=r"within a few metres of each other.*choose a larger area"):
        built(case)


def test_stubs_at_a_dead_end_are_dropped() -> None:
    nodes = {"a": (0.0, 0.0), "b": (80.0, 0.0), "c": (80.3, 0.2), "d": (80.3, -0.2)}
    roads, dropped = built(Case(nodes, {1: ("a b", ""), 2: ("b c", ""), 3: ("b d", "")}))
    assert [road.osm_way_ids for road in roads.roads] == [(1,)]
    assert dropped == [(Kind.DROPPED, "within-junction", f"way/{way}") for way in (2, 3)]


@pytest.mark.parametrize(("radius", "kept"), [(0.01, False), (2.0, False), (8.0, True)])
def test_rings_too_small_to_drive_round_are_dropped(radius: float, kept: bool) -> None:
    nodes = ring(radius)
    roads, dropped = built(
        Case({"a": (0.0, 0.0), "b": (80.0, 0.0), **nodes}, {1: ("a b", ""), 2: (round_(nodes), "")})
    )
    assert [road.osm_way_ids for road in roads.roads] == [(1,), *[(2,)] * (2 * kept)]
    assert dropped == ([] if kept else [(Kind.DROPPED, "within-junction", "way/2")])


def test_streets_within_a_junction_that_is_driven_through_are_not_lost() -> None:
    nodes = {
        "w": (-80.0, 0.0),
        "a": (0.0, 0.0),
        "b": (0.4, 0.0),
        "e": (80.0, 0.0),
        "n": (0.0, 80.0),
        "s": (0.4, -80.0),
    }
    ways = {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("a n", ""), 5: ("b s", "")}
    roads, dropped = built(Case(nodes, ways))
    assert dropped == []
    assert len(roads.junctions) == 1
    assert roads.places is not None
    assert roads.places.inner.sum() == 1


@EITHER
def test_halves_of_a_street_that_comes_back_have_the_same_lanes_where_they_meet(rule: Rule) -> None:
    """Way 3 is short and lies where the street would be cut in the middle."""
    nodes = {
        "w": (-90.0, 0.0),
        "o": (0.0, 0.0),
        "a": (40.0, 40.0),
        "b": (80.0, 40.0),
        "c": (86.0, 34.0),
        "d": (86.0, -34.0),
        "e": (40.0, -40.0),
    }
    wide, narrow = "highway=tertiary", "highway=unclassified"
    case = Case(nodes, {1: ("w o", wide), 2: ("o a b", wide), 3: ("b c", narrow), 4: ("c d e o", wide)})
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    measures = RoadMeasures(roads)
    (one, other) = (road for road in roads.roads if road.junction is None and road.osm_way_ids != (1,))
    assert one.successor is not None
    assert (one.successor.id, one.successor.at_start) == (other.id, True)
    before, after = measures.at_end(one, False)[1], measures.at_end(other, True)[1]
    assert before.keys() == after.keys()
    assert all(before[lane] == pytest.approx(after[lane], abs=1e-9) for lane in before)
    # The short one is part of a longer stretch, and still known.
    assert {way for road in (one, other) for way in road.osm_way_ids} == {2, 3, 4}
