"""Signs that follow from the map: at level crossings, at the entries of roundabouts, at mini roundabouts."""

from __future__ import annotations

from math import cos, pi, sin

import pytest
from light_cases import with_tags
from sign_cases import Signed, T, signed, ways
from street_cases import Case

from osm2xodr.furniture.objects.crossings import rail_crossing_objects
from osm2xodr.furniture.objects.road_marks import mini_roundabouts
from osm2xodr.furniture.world import find_rail_stops
from osm2xodr.model import Rule, Sign

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
RAIL = "railway=level_crossing"
TRACKS = Case(
    {"w": (-150.0, 0.0), "a": (0.0, 0.0), "b": (4.0, 0.0), "e": (150.0, 0.0)},
    {1: ("w a b e", "highway=tertiary")},
)


def roundabout(radius: float) -> Case:
    """Return a roundabout of three streets, which come from the east (way 2), the north and the west."""
    ring = {f"r{k}": (radius * cos(k * pi / 6), radius * sin(k * pi / 6)) for k in range(12)}
    return Case(
        {**ring, "e": (120.0, 0.0), "n": (0.0, 120.0), "w": (-120.0, 0.0)},
        {
            1: (" ".join([*ring, "r0"]), "highway=tertiary junction=roundabout"),
            2: ("e r0", "highway=tertiary"),
            3: ("n r3", "highway=tertiary"),
            4: ("w r6", "highway=tertiary"),
        },
    )


ROUND = roundabout(15.0)


def rail_signs(found: Signed) -> list[complex]:
    """Return where St. Andrew's crosses stand."""
    return sorted((found.at(item) for item in found.named("level_crossing")), key=lambda place: place.real)


@EITHER
@pytest.mark.parametrize("second", ["", RAIL])
def test_crosses_stand_before_the_first_track_of_each_direction(second: str, rule: Rule) -> None:
    found = signed(with_tags(TRACKS, a=RAIL, b=second), rule)
    west, east = rail_signs(found)
    last = 4.0 if second else 0.0
    assert (west.real, east.real) == pytest.approx((-4.4, last + 4.4), abs=0.05)
    assert west.imag < -3.0
    assert east.imag > 3.0
    assert {(item.type, item.country) for item in found.signs.signals} == {("201", "DE")}


@pytest.mark.parametrize("tags", [f"{RAIL} crossing:saltire=no", "railway=tram_level_crossing"])
def test_where_there_are_no_crosses_none_stand(tags: str) -> None:
    assert rail_signs(signed(with_tags(TRACKS, a=tags))) == []


def test_a_cross_that_is_mapped_is_not_doubled() -> None:
    case = Case({**TRACKS.nodes, "m": (-10.0, 0.0)}, {1: ("w m a b e", "highway=tertiary oneway=yes")})
    found = signed(with_tags(case, a=RAIL, m="traffic_sign=DE:201-50"))
    assert [item.osm_id for item in found.named("level_crossing")] == ["node/1005"]


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("", []),
        ("crossing:barrier=no crossing:light=no", []),
        ("crossing:light=yes", ["pole"] * 2),
        ("crossing:barrier=half", ["barrier"] * 2),
        ("crossing:barrier=full crossing:light=yes", ["barrier"] * 4 + ["pole"] * 2),
    ],
)
@EITHER
def test_lights_and_barriers_stand_beside_the_road(tags: str, expected: list[str], rule: Rule) -> None:
    world = signed(with_tags(TRACKS, a=f"{RAIL} {tags}"), rule).world
    objects = rail_crossing_objects(world, find_rail_stops(world))
    assert sorted(item.type for item in objects) == expected
    assert all(abs(item.t) > 3.0 for item in objects)
    assert all(abs(item.s - 150.0) < 4.0 for item in objects)


@EITHER
@pytest.mark.parametrize(("radius", "junctions"), [(15.0, 3), (3.0, 1)])
def test_entries_of_a_roundabout_have_give_way_signs(radius: float, junctions: int, rule: Rule) -> None:
    """A small one lies inside of one junction; there, too, who goes round goes first."""
    found = signed(roundabout(radius), rule)
    assert len(found.world.road_map.junctions) == junctions
    assert all(item.priorities for item in found.world.road_map.junctions)
    assert sorted(found.way(item) for item in found.named("give_way")) == [2, 3, 4]
    assert [stop.kind for stop in found.signs.stops] == [Sign.GIVE_WAY.value] * 3
    (said,) = [item for item in found.world.diagnostics if item.code == "yield-sign"]
    assert said.message.startswith("3 roads into a roundabout")


def test_entries_with_a_sign_or_lights_keep_these() -> None:
    case = Case({**ROUND.nodes, "s": (30.0, 0.0)}, {**ROUND.ways, 2: ("e s r0", "highway=tertiary")})
    found = signed(with_tags(case, s="highway=stop direction=forward"), signalled=frozenset({3}))
    assert [(item.name, found.way(item)) for item in found.signs.signals] == [("stop", 2), ("give_way", 4)]


@EITHER
def test_all_arms_of_a_mini_roundabout_yield_to_those_who_go_round(rule: Rule) -> None:
    case = ways(T, w3="highway=secondary")
    found = signed(with_tags(case, o="highway=mini_roundabout"), rule)
    assert sorted(found.way(item) for item in found.named("give_way")) == [1, 2, 3]
    (junction,) = found.world.road_map.junctions
    ends = {item.id: item for item in found.world.road_map.roads}
    ways_of = {item.id: item.osm_way_ids[0] for item in found.world.road_map.roads if item.osm_way_ids}

    def movement(road: int) -> tuple[int, int]:
        before, after = ends[road].predecessor, ends[road].successor
        assert before is not None
        assert after is not None
        return ways_of[before.id], ways_of[after.id]

    # Counter-clockwise as drawn: those from the west pass the south, from the south the east ...
    assert {tuple(map(movement, pair)) for pair in junction.priorities} == {
        ((1, 2), (3, 2)),
        ((1, 2), (3, 1)),
        ((2, 3), (1, 2)),
        ((2, 3), (1, 3)),
        ((3, 1), (2, 1)),
        ((3, 1), (2, 3)),
    }
    (disc,) = mini_roundabouts(found.world)
    assert (disc.type, disc.radius, disc.osm_id) == ("roadMark", 2.0, "node/1002")
