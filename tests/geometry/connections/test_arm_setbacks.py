"""Arms are set back until turns have the radius of their corners, as far as streets have room.

Stems of splits and merges are set back until cars shift aside at speed.
"""

from __future__ import annotations

import math

import pytest
from road_measures import RoadMeasures, assert_sound, smallest_radius_of
from street_cases import Case

from osm2xodr.geometry import defaults
from osm2xodr.model import RoadMap, Rule


def fork(degrees: float, tags: str, length: float = 90.0) -> Case:
    """Make a street from west to east and one that leaves it backwards at an acute angle, all one-way."""
    angle = math.radians(degrees)
    nodes = {"w": (-90.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0)}
    nodes["x"] = (-length * math.cos(angle), length * math.sin(angle))
    return Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)})


def built(case: Case, rule: Rule) -> RoadMap:
    roads = (case if rule is Rule.RIGHT_HAND else case.mirrored()).build(rule)
    assert_sound(roads)
    return roads


def turn(roads: RoadMap, one: int, other: int) -> float:
    """Return the smallest radius of the connecting road from way to way, m."""
    ways = {road.id: road.osm_way_ids for road in roads.roads}
    (k,) = (
        k
        for k, road in enumerate(roads.roads)
        if road.junction is not None
        and road.predecessor is not None
        and road.successor is not None
        and (ways[road.predecessor.id], ways[road.successor.id]) == ((one,), (other,))
    )
    return smallest_radius_of(roads.plan_view, k)


def left_of(roads: RoadMap) -> dict[int, float]:
    """Return the lengths of plain roads by way, m."""
    measures = RoadMeasures(roads)
    return {road.osm_way_ids[0]: measures.length(road) for road in roads.roads if road.junction is None}


@pytest.mark.parametrize("rule", list(Rule))
@pytest.mark.parametrize(
    ("degrees", "highway", "radius"),
    [
        # A turn of 120 degrees at a kerb of 5 m: one that cuts off as much has 5 m x 0.293 / 0.5; 1.4 times that.
        (60.0, "residential", 1.4 * 5.0 * 0.2929 / 0.5 + 1.25),
        # One of 100 degrees, as at square corners.
        (80.0, "residential", 6.0),
        # One of 140 degrees would have less than cars manage.
        (40.0, "service", 4.2),
    ],
)
def test_turns_get_the_radius_of_their_corner(degrees: float, highway: str, radius: float, rule: Rule) -> None:
    roads = built(fork(degrees, f"highway={highway} oneway=yes lanes=1 width=2.5"), rule)
    assert turn(roads, 1, 3) >= radius - 0.01


@pytest.mark.parametrize("rule", list(Rule))
def test_both_arms_give_the_tangent_of_the_turn(rule: Rule) -> None:
    """At 33 degrees between lanes of 2.5 m, a kerb of 8 m leaves arms that end after 13.3 m."""
    left = left_of(built(fork(33.0, "highway=service oneway=yes lanes=1 width=2.5"), rule))
    tangent = 4.2 * math.tan(math.radians(73.5))
    assert (90.0 - left[1], 90.0 - left[3]) == pytest.approx((tangent, tangent), abs=0.05)


def test_arms_are_set_back_while_their_streets_have_room() -> None:
    """Of 12 m, 7.1 m are needed, and at a dead end 1 m must stay."""
    roads = fork(24.0, "oneway=yes lanes=1 width=2.5", 12.0).build()
    assert 1.0 <= left_of(roads)[3] < 3.0


def test_arms_that_cannot_give_more_are_not_answered_by_the_other() -> None:
    """The street has no room for the turn: the one it is turned from stays as it is, too."""
    short = left_of(fork(60.0, "highway=service oneway=yes lanes=1 width=2.5", 8.0).build())
    wide = left_of(fork(60.0, "highway=service oneway=yes lanes=1 width=2.5").build())
    assert short[1] >= wide[1] - 0.01


@pytest.mark.parametrize("rule", list(Rule))
def test_a_short_street_between_junctions_gives_what_most_cars_need(rule: Rule) -> None:
    """Two streets 12 m apart: of the one between them 3 m are left, for turns of 4.5 m at both ends."""
    case = Case(
        {
            "w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0),
            "u": (-80.0, 12.0), "v": (0.0, 12.0), "x": (80.0, 12.0),
        },
        {way: (nodes, "highway=service oneway=yes lanes=1 width=2.5") for way, nodes in
         enumerate(("w o", "o e", "o v", "u v", "v x"), 1)},
    )  # fmt: skip
    roads = built(case, rule)
    assert (turn(roads, 1, 3), turn(roads, 3, 5)) == pytest.approx((4.49, 4.49), abs=0.01)
    assert left_of(roads)[3] == pytest.approx(12.0 - 2 * 4.49, abs=0.05)


@pytest.mark.parametrize("rule", list(Rule))
def test_one_end_of_a_short_street_gives_what_the_other_does_not_need(rule: Rule) -> None:
    """Of 12 m, 3 m are left; the turns of its one end get more than half of the rest, up to 5.1 m."""
    case = Case(
        {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "v": (0.0, 12.0), "x": (0.0, 90.0), "y": (60.0, 90.0)},
        {way: (nodes, "highway=service oneway=yes lanes=1 width=2.5") for way, nodes in
         enumerate(("w o", "o e", "o v", "v x", "v y"), 1)},
    )  # fmt: skip
    roads = built(case, rule)
    assert turn(roads, 1, 3) == pytest.approx(5.1, abs=0.02)


@pytest.mark.parametrize("rule", list(Rule))
def test_both_ends_of_a_short_street_get_what_cars_just_manage_first(rule: Rule) -> None:
    """Turns of 90 and of 130 degrees need 4.2 m (tan 45 degrees + tan 65 degrees) = 13.2 m; of 15.5 m there are 12.5.

    So both lack little enough to swing out; neither gets more.
    """
    x, y = 90.0 * math.sin(math.radians(50.0)), 15.5 - 90.0 * math.cos(math.radians(50.0))
    case = Case(
        {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "v": (0.0, 15.5), "n": (0.0, 90.0), "x": (x, y)},
        {way: (nodes, "highway=service oneway=yes lanes=1 width=2.5") for way, nodes in
         enumerate(("w o", "o e", "o v", "v n", "v x"), 1)},
    )  # fmt: skip
    roads = built(case, rule)
    assert (turn(roads, 1, 3), turn(roads, 3, 5)) == pytest.approx((4.2, 4.2), abs=0.01)


@pytest.mark.parametrize("rule", list(Rule))
def test_arms_of_acute_forks_end_where_cars_turn_from_one_to_the_other(rule: Rule) -> None:
    """At 15 degrees, lanes 1.5 m inside of the lines are 8.3 m apart 43 m from the node."""
    nodes = {"w": (-180.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0)}
    nodes["x"] = (-180.0 * math.cos(math.radians(15.0)), 180.0 * math.sin(math.radians(15.0)))
    tags = "highway=residential lanes=2 width=6"
    roads = built(Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)}), rule)
    left = left_of(roads)
    across = 8.33 / math.cos(math.radians(7.5)) + 3.0
    expected = 180.0 - across / (2 * math.tan(math.radians(7.5)))
    assert (left[1], left[3]) == pytest.approx((expected, expected), abs=1.5)
    assert min(turn(roads, 1, 3), turn(roads, 3, 1)) >= 4.0 - 1e-6


@pytest.mark.parametrize(("length", "apart"), [(70.0, False), (180.0, True)])
def test_one_arm_of_an_acute_fork_is_not_set_back_alone(length: float, apart: bool) -> None:
    """Where the other street is too short, cars would drive along it to and fro to turn."""
    angle = math.radians(18.0)
    nodes = {"w": (-180.0, 0.0), "o": (0.0, 0.0), "e": (90.0, 0.0)}
    nodes["x"] = (-length * math.cos(angle), length * math.sin(angle))
    tags = "highway=residential lanes=2 width=6"
    left = left_of(built(Case(nodes, {1: ("w o", tags), 2: ("o e", tags), 3: ("o x", tags)}), Rule.RIGHT_HAND))
    assert 180.0 - left[1] == pytest.approx(length - left[3], abs=0.1)
    assert (180.0 - left[1] > 36.0) == apart


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


def built_flat(case: Case, rule: Rule = Rule.RIGHT_HAND) -> RoadMap:
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
    roads = built_flat(split(merge=merge), rule)
    assert sharpest(roads) >= 0.8 * wanted(100)
    assert 400.0 - defaults.MERGE_SETBACK_MAX - 30.0 < length_of(roads, 1) < 370.0


def test_no_stem_gives_more_than_is_wanted_at_a_lower_limit() -> None:
    fast, slow, town = (built_flat(split(speed)) for speed in (100, 70, 50))
    assert length_of(fast, 1) < length_of(slow, 1) - 5.0 < length_of(town, 1) - 10.0
    assert sharpest(town) < 0.5 * wanted(50)
    assert sharpest(slow) >= 0.95 * wanted(70)


def test_two_way_stems_stay() -> None:
    assert length_of(built_flat(split(stem="highway=trunk oneway=no lanes=4 maxspeed=100")), 1) > 370.0


def test_no_way_is_swallowed() -> None:
    """The last 45 m of the stem are a way of their own."""
    case = split()
    nodes, ways = (
        {**case.nodes, "v": (-45.0, 0.0)},
        {**case.ways, 1: ("w v", _FAST), 4: ("v o", _FAST + " bridge=no")},
    )
    roads = built_flat(Case(nodes, ways))
    (stem,) = (road for road in roads.roads if 4 in road.osm_way_ids)
    assert stem.osm_way_ids == (1, 4)
    assert length_of(roads, 1) == pytest.approx(400.0 - 45.0 * defaults.MERGE_SHARE_MAX, abs=0.1)


def test_a_short_street_gives_what_it_has() -> None:
    roads = built_flat(split(length=35.0))
    assert 0.6 * 35.0 < length_of(roads, 1) < 30.0
    assert sharpest(built_flat(split(50))) < sharpest(roads) < 0.8 * wanted(100)


def test_a_crossing_with_a_street_stays() -> None:
    """One way turns by more than 30 degrees: the junction is no split."""
    case = split()
    nodes, ways = {**case.nodes, "n": (0.0, 60.0)}, {**case.ways, 4: ("o n", "highway=residential oneway=yes")}
    assert length_of(built_flat(Case(nodes, ways)), 1) > 370.0
