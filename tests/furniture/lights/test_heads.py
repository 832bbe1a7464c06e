"""Where the heads of lights stand, and which lanes they govern.

Lights on roads apart from junctions.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import pytest
from junction_cases import CASES
from light_cases import ONE_WAY, ROAD, SIGNALS, X, crossing_at, lit, point, sides, with_tags
from street_cases import Case

from osm2xodr.model import Rule, Signal

EITHER = pytest.mark.parametrize("rule", list(Rule))


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


def test_ids_are_unique_and_heads_stand_on_their_roads() -> None:
    found = lit(with_tags(X, o=SIGNALS), crossings=crossing_at(2, 5.0, at_start=True))
    ids = [item.id for item in found.lights.signals]
    assert len(set(ids)) == len(ids) == 6
    switched = [number for item in found.lights.controllers for number in item.signals]
    assert sorted(switched) == sorted(ids)

    def inside(item: Signal) -> bool:
        return 0.0 <= item.s <= found.world.lanes.length(item.road)

    assert all(map(inside, found.lights.signals))


def test_esmini_gets_no_references_which_it_does_not_support() -> None:
    found = lit(with_tags(X, o=SIGNALS), crossings=crossing_at(2, 5.0, at_start=True), target="esmini")
    assert (len(found.heads("1000002")), found.lights.references) == (2, [])


def test_sumo_gets_no_lights_that_it_misreads() -> None:
    case = with_tags(X, o=SIGNALS)
    crossings = crossing_at(2, 5.0, at_start=True)
    usual, found = (lit(case, crossings=crossings, target=name) for name in ("generic", "sumo"))
    assert (len(usual.heads("1000002")), len(usual.lights.references)) == (2, 12)
    assert (len(found.heads("1000002")), len(found.lights.references)) == (0, 0)
    assert [replace(item, id=0) for item in found.heads()] == [replace(item, id=0) for item in usual.heads()]
    assert {item.kind for item in found.lights.controllers} == {"traffic"}


@EITHER
def test_a_crossing_with_lights_apart_from_junctions(rule: Rule) -> None:
    case = with_tags(ROAD, b="highway=crossing crossing=traffic_signals")
    found = lit(case, rule, crossings=crossing_at(1, 100.0), target="roadrunner")
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
    found = lit(with_tags(ROAD, **tags), crossings=crossing_at(1, 100.0), target="roadrunner")
    # The nodes say where the lines are: 20 m before the crossing, and 10 m.
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == [("+", 80.0), ("-", 110.0)]
    assert [len(item.signals) for item in found.lights.controllers] == [2, 2]


@pytest.mark.parametrize("target", ["generic", "carla"])
def test_carla_switches_lights_apart_from_junctions_by_themselves(target: str) -> None:
    found = lit(with_tags(ROAD, b=SIGNALS), target=target)
    assert len(found.heads()) == 2
    assert found.lights.controllers == []


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
def test_lights_apart_from_junctions(case: Case, tags: str, heads: list[tuple[str, float]]) -> None:
    found = lit(with_tags(case, b=tags))
    assert [(item.orientation, round(item.s, 2)) for item in found.heads()] == heads
    assert not found.left_out
