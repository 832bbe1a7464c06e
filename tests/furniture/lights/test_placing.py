"""Which nodes give lights, where the heads stand, and what they are for."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from junction_cases import CASES
from light_cases import Lit, lit, point, with_tags
from street_cases import Case

from osm2xodr.furniture.world.world import Crossing, World
from osm2xodr.model import Footway, RoadsideKind, RoadsideThing, Rule, Signal, StreetNetwork, ThingFacts

EITHER = pytest.mark.parametrize("rule", list(Rule))
SIGNALS = "highway=traffic_signals"
X = CASES["x"].case
# Streets of the crossing with a node each 12 m before it.
NODES = {**X.nodes, "wi": (-12.0, 0.0), "ei": (12.0, 0.0), "si": (0.0, -12.0), "ni": (0.0, 12.0)}
ARMS = Case(NODES, {1: ("w wi o", ""), 2: ("o ei e", ""), 3: ("s si o", ""), 4: ("o ni n", "")})
YIELDING = {"si": "highway=give_way", "ni": "highway=give_way"}
STREET = {"w": (-100.0, 0.0), "a": (-20.0, 0.0), "b": (0.0, 0.0), "c": (10.0, 0.0), "e": (100.0, 0.0)}
ROAD = Case(STREET, {1: ("w a b c e", "")})
ONE_WAY = Case(STREET, {1: ("w a b c e", "oneway=yes")})


def sides(found: Lit) -> float:
    """Return 1 where traffic drives on the right, -1 on the left."""
    return 1.0 if found.world.road_map.rule is Rule.RIGHT_HAND else -1.0


def crossing_at(way: int, s: float, **changes: object) -> Callable[[World], tuple[Crossing, ...]]:
    """Return what makes a crossing with lights of 4 m by 7 m on the road of a way."""

    def make(world: World) -> tuple[Crossing, ...]:
        road = next(road.id for road in world.road_map.roads if road.osm_way_ids == (way,) and road.junction is None)
        found = Crossing(road, s, 4.0, 3.0, -3.0, "node/1003", signals=True)
        return (replace(found, **changes),)  # type: ignore[arg-type]

    return make


@EITHER
def test_a_signal_on_the_junction_is_for_all_approaches(rule: Rule) -> None:
    found = lit(with_tags(X, o=SIGNALS), rule)
    heads = {found.way(item): item for item in found.heads()}
    assert sorted(heads) == [1, 2, 3, 4]
    assert not found.left_out
    # Each beside the carriageway of two lanes of 3 m, on the side where one drives, 1 m before the junction's edge.
    mirror = sides(found)
    expected = {1: (-9.8, -3.5), 2: (9.8, 3.5), 3: (3.5, -9.8), 4: (-3.5, 9.8)}
    for way, (x, y) in expected.items():
        assert found.at(heads[way]) == pytest.approx(complex(x, mirror * y), abs=0.01)
        assert heads[way].orientation == ("+" if way in (1, 3) else "-")
        assert heads[way].validity == (((-1, -1),) if (way in (1, 3)) == (mirror > 0) else ((1, 1),))
        assert (heads[way].z_offset, heads[way].height, heads[way].width) == (2.1, 0.9, 0.3)
    assert {(item.type, item.subtype, item.country, item.dynamic, item.osm_id) for item in heads.values()} == {
        ("1000001", "-1", "OpenDRIVE", True, "node/1002")
    }


@EITHER
def test_connecting_roads_refer_to_the_head_that_governs_them(rule: Rule) -> None:
    found = lit(with_tags(X, o=SIGNALS), rule)
    way_of = {item.id: found.way(item) for item in found.heads()}
    roads = {road.id: road for road in found.world.road_map.roads}
    seen: Counter[int] = Counter()
    for item in found.lights.references:
        path = roads[item.road]
        assert path.junction == found.world.road_map.junctions[0].id
        assert path.predecessor is not None
        assert roads[path.predecessor.id].osm_way_ids == (way_of[item.signal],)
        assert (item.s, item.orientation) == (0.0, "+")
        own = next(lane for lane in path.lane_sections[0].lanes if lane.id and lane.type.value == "driving")
        assert item.validity == ((own.id, own.id),)
        # The connecting road begins at the junction's edge, 1 m beyond the head, which stands as far aside.
        head = next(head for head in found.heads() if head.id == item.signal)
        place = point(found.world.road_map, item.road, item.s, item.t)
        assert abs(place - found.at(head)) == pytest.approx(1.0, abs=0.05)
        seen[item.signal] += 1
    assert seen == dict.fromkeys(way_of, 3)


@EITHER
def test_a_head_for_each_group_of_lanes(rule: Rule) -> None:
    found = lit(with_tags(CASES["pockets"].case, o=SIGNALS), rule)
    mirror = sides(found)
    heads = [item for item in found.heads() if found.way(item) == 1]
    by_turn = {item.name.removeprefix("traffic light, "): item for item in heads}
    inner, kerb = ("left", "right") if mirror > 0 else ("right", "left")
    # Four lanes of 3 m, three of them to the junction: two heads above the middles of their lanes, one at the kerb.
    places = {inner: (1.5, 4.5, 1), "through": (-1.5, 4.5, 2), kerb: (-6.5, 2.1, 3)}
    assert by_turn.keys() == places.keys()
    for turn, (t, z, lane) in places.items():
        item = by_turn[turn]
        assert item.t == pytest.approx(mirror * t, abs=1e-6)
        assert item.z_offset == z
        assert item.validity == ((-mirror * lane, -mirror * lane),)
    references = Counter(item.signal for item in found.lights.references)
    assert [references[item.id] for item in heads] == [1, 1, 1]


def test_lanes_that_lead_to_the_same_sides_share_a_head() -> None:
    tags = "oneway=yes lanes=3 turn:lanes=through|through|right"
    case = Case({**X.nodes}, {1: ("w o", tags), 2: ("o e", "oneway=yes lanes=2"), 3: ("o s", "oneway=yes")})
    found = lit(with_tags(case, o=SIGNALS))
    assert [(item.name, item.validity) for item in found.heads()] == [
        ("traffic light, through", ((-2, -1),)),
        ("traffic light, right", ((-3, -3),)),
    ]


@EITHER
@pytest.mark.parametrize(
    ("tagged", "ways"),
    [
        ({"wi": SIGNALS, "ei": SIGNALS, "si": SIGNALS, "ni": SIGNALS}, [1, 2, 3, 4]),
        ({"wi": SIGNALS, "ei": SIGNALS, **YIELDING}, [1, 2]),
        (
            {
                "wi": f"{SIGNALS} traffic_signals:direction=forward",
                "ei": f"{SIGNALS} traffic_signals:direction=backward",
                **YIELDING,
            },
            [1, 2],
        ),
    ],
)
def test_a_signal_on_an_approach_is_for_it(rule: Rule, tagged: dict[str, str], ways: list[int]) -> None:
    found = lit(with_tags(ARMS, **tagged), rule)
    assert sorted(found.way(item) for item in found.heads()) == ways
    assert not found.left_out
    number = {name: 1001 + k for k, name in enumerate(NODES)}
    assert {item.osm_id for item in found.heads()} == {
        f"node/{number[name]}" for name in tagged if SIGNALS in tagged[name]
    }
    # The node shows where traffic stops, as far as it is off the junction's edge.
    assert [abs(abs(found.at(item)) - abs(12.0 - 3.5j)) for item in found.heads()] == pytest.approx(
        [0.0] * len(ways), abs=0.02
    )
    assert {(item.orientation, item.kind) for item in found.lights.stops} <= {
        ("+", "traffic_signals"),
        ("-", "traffic_signals"),
    }
    assert len(found.lights.stops) == len(ways)
    assert all(item.junction == found.world.road_map.junctions[0].id for item in found.lights.controllers)
    assert found.lights.signalled == {(item.road, item.orientation == "+") for item in found.heads()}


@EITHER
def test_one_signal_of_four_arms_is_a_light_on_its_road(rule: Rule) -> None:
    """So few make no junction with lights; right of way stays as it is without."""
    found = lit(with_tags(ARMS, wi=f"{SIGNALS} traffic_signals:direction=forward"), rule)
    (head,) = found.heads()
    assert found.at(head) == pytest.approx(complex(-12.0, -3.5 * sides(found)), abs=0.02)
    assert found.lights.references == ()
    assert [(item.junction, item.signals) for item in found.lights.controllers] == [(None, (head.id,))]
    assert found.lights.signalled == frozenset()


def test_an_approach_with_a_sign_of_its_own_has_no_lights() -> None:
    found = lit(with_tags(ARMS, o=SIGNALS, si="highway=give_way direction=forward"))
    assert sorted(found.way(item) for item in found.heads()) == [1, 2, 4]


@EITHER
def test_who_crosses_a_sign_for_when_the_lights_are_off_has_them_too(rule: Rule) -> None:
    """The lights are those of the crossing that one comes to before the junction."""
    nodes = {**NODES, "sp": (0.0, -16.0)}
    case = Case(nodes, {**ARMS.ways, 3: ("s sp si o", "")})
    people = "highway=crossing crossing=traffic_signals"
    found = lit(with_tags(case, o=SIGNALS, si="highway=give_way", sp=people), rule)
    assert {found.way(item): item.osm_id for item in found.heads()} == {
        **dict.fromkeys((1, 2, 4), "node/1002"),
        3: f"node/{1001 + list(nodes).index('sp')}",
    }
    assert {item.junction for item in found.lights.controllers} == {found.world.road_map.junctions[0].id}
    assert "signal-added" not in {item.code for item in found.world.diagnostics}


@EITHER
@pytest.mark.parametrize("tagged", [("wi", "ei"), ("wi", "ei", "ni"), ("wi", "si")])
def test_who_crosses_traffic_with_lights_and_has_no_sign_has_lights_too(tagged: tuple[str, ...], rule: Rule) -> None:
    found = lit(with_tags(ARMS, **dict.fromkeys(tagged, SIGNALS)), rule)
    heads = {found.way(item): item for item in found.heads()}
    assert sorted(heads) == [1, 2, 3, 4]
    added = {"wi": 1, "ei": 2, "si": 3, "ni": 4}.keys() - set(tagged)
    ways = sorted({"wi": 1, "ei": 2, "si": 3, "ni": 4}[name] for name in added)
    guessed = [item for item in found.world.diagnostics if item.code == "signal-added"]
    assert sorted(item.osm_id for item in guessed) == [f"way/{way}" for way in ways]
    assert [way for way in sorted(heads) if not heads[way].osm_id] == ways
    assert found.lights.signalled == {(item.road, item.orientation == "+") for item in heads.values()}
    # Who turns across oncoming traffic shares a head with who does not: each arm has a phase of its own.
    assert [item.signals for item in found.lights.controllers] == [(heads[way].id,) for way in (1, 2, 3, 4)]


def test_who_only_merges_yields_on() -> None:
    case = CASES["slip_lane"].case
    found = lit(with_tags(case, o=SIGNALS))
    assert "signal-added" not in {item.code for item in found.world.diagnostics}
    merge = Case(
        {"w": (-100.0, 0.0), "wi": (-12.0, 0.0), "o": (0.0, 0.0), "e": (100.0, 0.0), "r": (-80.0, -30.0)},
        {
            1: ("w wi o", "highway=primary oneway=yes lanes=2"),
            2: ("o e", "highway=primary oneway=yes lanes=3"),
            3: ("r o", "highway=primary_link oneway=yes"),
        },
    )
    found = lit(with_tags(merge, wi=SIGNALS))
    assert {found.way(item) for item in found.heads()} == {1}
    assert "signal-added" not in {item.code for item in found.world.diagnostics}


@EITHER
def test_lights_between_carriageways_are_those_of_the_arms(rule: Rule) -> None:
    found = lit(with_tags(CASES["dual_cross"].case, a=SIGNALS, b=SIGNALS, c=SIGNALS, d=SIGNALS), rule)
    assert Counter(found.way(item) for item in found.heads()) == {1: 2, 4: 2, 7: 2, 10: 2}
    assert len(found.lights.references) == 16
    assert len(found.lights.stops) == 4
    assert {abs(found.at(item)) > 15.0 for item in found.heads()} == {True}
    assert not found.left_out


@EITHER
def test_lights_between_carriageways_that_are_junctions_of_their_own(rule: Rule) -> None:
    """OSM has them at the four arms alone; who waits between the carriageways has some too."""
    case = CASES["dual_cross_far_apart"].case
    nodes = {**case.nodes, "wi": (-25.0, -15.0), "ei": (25.0, 15.0), "si": (15.0, -25.0), "ni": (-15.0, 25.0)}
    ways = {**case.ways}
    for way, text in ((1, "w wi a"), (4, "e2 ei c"), (7, "s si b"), (10, "n2 ni d")):
        ways[way] = (text, case.ways[way][1])
    found = lit(with_tags(Case(nodes, ways, case.restrictions), wi=SIGNALS, ei=SIGNALS, si=SIGNALS, ni=SIGNALS), rule)
    assert {found.way(item) for item in found.heads()} == {1, 2, 4, 5, 7, 8, 10, 11}
    assert {bool(item.osm_id) for item in found.heads() if found.way(item) in (2, 5, 8, 11)} == {False}
    guessed = [item.osm_id for item in found.world.diagnostics if item.code == "signal-between"]
    assert sorted(guessed) == ["way/11", "way/2", "way/5", "way/8"]
    assert Counter(item.junction for item in found.lights.controllers) == {
        junction.id: 2 for junction in found.world.road_map.junctions
    }


def test_a_slip_lane_is_no_part_of_the_signalled_junction() -> None:
    found = lit(with_tags(CASES["slip_lane"].case, o=SIGNALS))
    assert sorted(found.way(item) for item in found.heads()) == [2, 5, 6]
    roads = {road.id: road for road in found.world.road_map.roads}
    assert not {item.road for item in found.heads()} & {
        key for key, road in roads.items() if road.osm_way_ids == (4,)
    }


@EITHER
def test_crossing_with_lights_amid_a_street(rule: Rule) -> None:
    found = lit(with_tags(ROAD, b="highway=crossing crossing=traffic_signals"), rule, crossings=crossing_at(1, 100.0))
    mirror = sides(found)
    # Stop lines 1 m before the crossing of 4 m.
    assert [(item.orientation, item.s) for item in found.heads()] == [("+", 97.0), ("-", 103.0)]
    assert [found.at(item) for item in found.heads()] == pytest.approx(
        [complex(-3.0, -3.5 * mirror), complex(3.0, 3.5 * mirror)], abs=0.02
    )
    people = found.heads("1000002")
    assert [(item.s, item.t) for item in people] == [(100.0, 3.5), (100.0, -3.5)]
    # Who walks to the left sees the head at the left, as who drives along s sees one without a turn.
    assert [item.h_offset for item in people] == pytest.approx([math.pi / 2, -math.pi / 2])
    # Without a sidewalk they are for no lane: cars need not heed them.
    assert {item.validity for item in people} == {((0, 0),)}
    assert [(item.kind, item.junction, item.sequence, item.signals) for item in found.lights.controllers] == [
        ("traffic", None, 0, tuple(item.id for item in found.heads())),
        ("pedestrian", None, 1, tuple(item.id for item in people)),
    ]
    assert [(item.s, item.orientation, item.kind) for item in found.lights.stops] == [
        (97.0, "+", "traffic_signals"),
        (103.0, "-", "traffic_signals"),
    ]
    assert found.lights.section_breaks == ((found.heads()[0].road, 100.0),)


def test_nodes_about_one_crossing_are_one_installation() -> None:
    tags = {"a": f"{SIGNALS} traffic_signals:direction=forward", "b": "highway=crossing crossing=traffic_signals"}
    tags["c"] = f"{SIGNALS} traffic_signals:direction=backward"
    found = lit(with_tags(ROAD, **tags), crossings=crossing_at(1, 100.0))
    # The nodes say where the lines are: 20 m before the crossing, and 10 m.
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == [("+", 80.0), ("-", 110.0)]
    assert [len(item.signals) for item in found.lights.controllers] == [2, 2]


@pytest.mark.parametrize(
    ("case", "tags", "heads"),
    [
        (ROAD, SIGNALS, [("+", 99.0), ("-", 101.0)]),
        (ROAD, f"{SIGNALS} traffic_signals:direction=forward", [("+", 100.0)]),
        (ROAD, f"{SIGNALS} traffic_signals:direction=backward", [("-", 100.0)]),
        (ONE_WAY, SIGNALS, [("+", 99.0)]),
        (ONE_WAY, f"{SIGNALS} traffic_signals=ramp_meter direction=forward", [("+", 100.0)]),
        (ROAD, f"{SIGNALS} traffic_signals=emergency", [("+", 99.0), ("-", 101.0)]),
        (ROAD, "highway=crossing crossing:signals=yes", [("+", 97.0), ("-", 103.0)]),
        (ROAD, f"{SIGNALS} traffic_signals=pedestrian_crossing", [("+", 97.0), ("-", 103.0)]),
        (ROAD, "highway=crossing crossing=marked", []),
    ],
)
def test_lights_amid_a_street(case: Case, tags: str, heads: list[tuple[str, float]]) -> None:
    found = lit(with_tags(case, b=tags))
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == heads
    assert not found.left_out


@pytest.mark.parametrize(
    ("tagged", "node", "why"),
    [
        ({"b": f"{SIGNALS} traffic_signals=blinker"}, "node/1003", "traffic_signals=blinker never shows green"),
        ({"b": f"{SIGNALS} traffic_signals=level_crossing"}, "node/1003", "level_crossing never shows green"),
        ({"e": SIGNALS}, "node/1005", "its street ends there"),
    ],
)
def test_what_gives_no_lights_is_said(tagged: dict[str, str], node: str, why: str) -> None:
    found = lit(with_tags(ROAD, **tagged))
    assert found.lights.signals == ()
    assert list(found.left_out) == [node]
    assert why in found.left_out[node]


@EITHER
def test_people_at_a_signalled_junction_have_lights(rule: Rule) -> None:
    found = lit(with_tags(X, o=SIGNALS), rule, crossings=crossing_at(2, 5.0, at_start=True, osm_id="node/7"))
    people = found.heads("1000002")
    assert [(found.way(item), item.s, item.t, item.orientation) for item in people] == [
        (2, 5.0, 3.5, "-"),
        (2, 5.0, -3.5, "-"),
    ]
    # Cars from that arm stop before the crossing, and people have a phase of their own, the last.
    (head,) = (item for item in found.heads() if found.way(item) == 2)
    assert head.s == 8.0
    last = found.lights.controllers[-1]
    assert (last.kind, last.sequence, last.signals) == ("pedestrian", 4, tuple(item.id for item in people))
    assert last.junction == found.world.road_map.junctions[0].id


def test_crossings_with_lights_on_enough_arms_make_a_signalled_junction() -> None:
    crossing = "highway=crossing crossing=traffic_signals"
    found = lit(with_tags(ARMS, wi=crossing, ei=crossing, **YIELDING))
    assert sorted(found.way(item) for item in found.heads()) == [1, 2]
    assert {item.junction for item in found.lights.controllers} == {found.world.road_map.junctions[0].id}
    alone = lit(with_tags(ARMS, wi=crossing))
    assert {item.junction for item in alone.lights.controllers} == {None}


def beside(x: float, y: float, on_footway: bool) -> Callable[[StreetNetwork], StreetNetwork]:
    """Return what puts lights beside the street, on a footway or not."""
    ids = np.array([77], np.int64)
    thing = RoadsideThing(RoadsideKind.TRAFFIC_SIGNALS, "node/77", np.array([[x, y]]), ids, ThingFacts())
    way = Footway(9, True, np.array([[x, y], [x, -y]]), np.array([77, 78], np.int64), {})
    return lambda network: replace(network, roadside=(thing,), footways=(way,) if on_footway else ())


def test_lights_on_a_footway_are_those_of_its_crossing() -> None:
    found = lit(ROAD, crossings=crossing_at(1, 100.0, signals=False), network=beside(0.0, 6.0, on_footway=True))
    assert [len(found.heads()), len(found.heads("1000002"))] == [2, 2]
    assert not found.left_out
    far = lit(ROAD, crossings=crossing_at(1, 60.0, signals=False), network=beside(0.0, 6.0, on_footway=True))
    assert far.lights.signals == ()
    assert list(far.left_out) == ["node/77"]
    tram = lit(ROAD, crossings=crossing_at(1, 100.0, signals=False), network=beside(0.0, 6.0, on_footway=False))
    assert tram.lights.signals == ()
    assert "no street of the map" in tram.left_out["node/77"]


def test_ids_are_unique_and_heads_stand_on_their_roads() -> None:
    found = lit(with_tags(X, o=SIGNALS), crossings=crossing_at(2, 5.0, at_start=True))
    ids = [item.id for item in found.lights.signals]
    assert len(set(ids)) == len(ids) == 6
    switched = [number for item in found.lights.controllers for number in item.signals]
    assert sorted(switched) == sorted(ids)

    def inside(item: Signal) -> bool:
        return 0.0 <= item.s <= found.world.lanes.length(item.road)

    assert all(map(inside, found.lights.signals))


def test_sumo_gets_no_lights_that_it_takes_for_others() -> None:
    case = with_tags(X, o=SIGNALS)
    crossings = crossing_at(2, 5.0, at_start=True)
    usual, found = (lit(case, crossings=crossings, target=name) for name in ("generic", "sumo"))
    assert (len(usual.heads("1000002")), len(usual.lights.references)) == (2, 12)
    assert (len(found.heads("1000002")), len(found.lights.references)) == (0, 0)
    assert [replace(item, id=0) for item in found.heads()] == [replace(item, id=0) for item in usual.heads()]
    assert {item.kind for item in found.lights.controllers} == {"traffic"}
