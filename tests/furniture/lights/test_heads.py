"""Where the heads of lights stand, and which lanes they govern."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest
from junction_cases import CASES
from light_cases import (
    SIGNALS,
    X,
    crossing_at,
    lit,
    point,
    sides,
    with_tags,
)
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
