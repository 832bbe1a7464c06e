"""Stems of splits and merges are set back until cars shift aside at speed."""

from __future__ import annotations

import pytest
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.geometry import defaults
from osm2xodr.model import RoadMap, Rule

_FAST = "highway=motorway oneway=yes lanes=2 maxspeed=100"
_RAMP = "highway=motorway_link oneway=yes lanes=1 maxspeed={}"


def split(speed: int = 100, *, merge: bool = False, stem: str = _FAST, length: float = 400.0) -> Case:
    """Return a carriageway from west to east, and a ramp that leaves it at 18 degrees and runs on beside it.

    A merge is the same in the other direction.
    """
    nodes = {"w": (-length, 0.0), "o": (0.0, 0.0), "e": (400.0, 0.0)}
    nodes |= {"a": (25.0, -8.0), "b": (150.0, -8.5), "c": (400.0, -9.0)}
    ways = {1: ("w o", stem), 2: ("o e", _FAST), 3: ("o a b c", _RAMP.format(speed))}
    if merge:
        ways = {way: (" ".join(reversed(refs.split())), tags) for way, (refs, tags) in ways.items()}
    return Case(nodes, ways)


def built(case: Case, rule: Rule = Rule.RIGHT_HAND) -> RoadMap:
    """Return the roads of a place without crossfall: connecting roads lie in the middle of their lanes."""
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule, superelevation="none")
    assert_sound(roads)
    return roads


def length_of(roads: RoadMap, way: int) -> float:
    """Return the length of the plain road of a way, m."""
    measures = RoadMeasures(roads)
    (found,) = (measures.length(road) for road in roads.roads if road.junction is None and way in road.osm_way_ids)
    return found


def wanted(speed: float) -> float:
    """Return the radius at which cars drive at a speed, km/h, without haste, m."""
    return (speed / 3.6) ** 2 / defaults.MERGE_ACCELERATION


def sharpest(roads: RoadMap) -> float:
    """Return the smallest radius of all connecting roads, m."""
    return min(
        smallest_radius_of(roads.plan_view, k) for k, road in enumerate(roads.roads) if road.junction is not None
    )


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize("merge", [False, True])
def test_cars_leave_and_join_a_carriageway_at_their_speed(merge: bool, rule: Rule) -> None:
    roads = built(split(merge=merge), rule)
    assert sharpest(roads) >= 0.8 * wanted(100)
    assert 400.0 - defaults.MERGE_SETBACK_MAX - 30.0 < length_of(roads, 1) < 370.0


def test_no_stem_gives_more_than_is_wanted_at_a_lower_limit() -> None:
    fast, slow, town = (built(split(speed)) for speed in (100, 70, 50))
    assert length_of(fast, 1) < length_of(slow, 1) - 5.0 < length_of(town, 1) - 10.0
    assert sharpest(town) < 0.5 * wanted(50)
    assert sharpest(slow) >= 0.95 * wanted(70)


def test_two_way_stems_stay() -> None:
    assert length_of(built(split(stem="highway=trunk oneway=no lanes=4 maxspeed=100")), 1) > 370.0


def test_no_way_is_swallowed() -> None:
    """The last 45 m of the stem are a way of their own."""
    case = split()
    nodes, ways = (
        {**case.nodes, "v": (-45.0, 0.0)},
        {**case.ways, 1: ("w v", _FAST), 4: ("v o", _FAST + " bridge=no")},
    )
    roads = built(Case(nodes, ways))
    (stem,) = (road for road in roads.roads if 4 in road.osm_way_ids)
    assert stem.osm_way_ids == (1, 4)
    assert length_of(roads, 1) == pytest.approx(400.0 - 45.0 * defaults.MERGE_SHARE_MAX, abs=0.1)


def test_a_short_street_gives_what_it_has() -> None:
    roads = built(split(length=35.0))
    assert 0.6 * 35.0 < length_of(roads, 1) < 30.0
    assert sharpest(built(split(50))) < sharpest(roads) < 0.8 * wanted(100)


def test_a_crossing_with_a_street_stays() -> None:
    """One way turns by more than 30 degrees: the junction is no split."""
    case = split()
    nodes, ways = {**case.nodes, "n": (0.0, 60.0)}, {**case.ways, 4: ("o n", "highway=residential oneway=yes")}
    assert length_of(built(Case(nodes, ways)), 1) > 370.0
