"""Which nodes give lights, and for which approaches."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from junction_cases import CASES, dual_cross
from light_cases import ARMS, NODES, ROAD, SIGNALS, YIELDING, Lit, X, crossing_at, lit, sides, with_tags
from street_cases import Case

from osm2xodr.model import (
    Footway,
    RoadsideKind,
    RoadsideThing,
    Rule,
    StreetNetwork,
    ThingFacts,
)

EITHER = pytest.mark.parametrize("rule", list(Rule))


@EITHER
def test_a_signal_on_the_junction_is_for_all_approaches(rule: Rule) -> None:
    found = lit(with_tags(X, o=SIGNALS), rule)
    heads = {found.way(item): item for item in found.heads()}
    assert sorted(heads) == [1, 2, 3, 4]
    assert not found.left_out
    # Each beside the carriageway of two lanes of 3 m, on the side where one drives, 1 m before the junction's edge.
    mirror = sides(found)
    expected = {1: (-10.8, -3.5), 2: (10.8, 3.5), 3: (3.5, -10.8), 4: (-3.5, 10.8)}
    for way, (x, y) in expected.items():
        assert found.at(heads[way]) == pytest.approx(complex(x, mirror * y), abs=0.01)
        assert heads[way].orientation == ("+" if way in (1, 3) else "-")
        assert heads[way].validity == (((-1, -1),) if (way in (1, 3)) == (mirror > 0) else ((1, 1),))
        assert (heads[way].z_offset, heads[way].height, heads[way].width) == (2.1, 0.9, 0.3)
    assert {(item.type, item.subtype, item.country, item.dynamic, item.osm_id) for item in heads.values()} == {
        ("1000001", "-1", "OpenDRIVE", True, "node/1002")
    }


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
    found = lit(with_tags(ARMS, wi=f"{SIGNALS} traffic_signals:direction=forward"), rule, target="esmini")
    (head,) = found.heads()
    assert found.at(head) == pytest.approx(complex(-12.0, -3.5 * sides(found)), abs=0.02)
    assert found.lights.references == []
    assert [(item.junction, item.signals) for item in found.lights.controllers] == [(None, (head.id,))]
    assert found.lights.signalled == frozenset()


def test_an_approach_with_a_sign_of_its_own_has_no_lights() -> None:
    found = lit(with_tags(ARMS, o=SIGNALS, si="highway=give_way direction=forward"))
    assert sorted(found.way(item) for item in found.heads()) == [1, 2, 4]


@EITHER
def test_traffic_with_lights_of_a_crossing_and_a_sign_has_lights(rule: Rule) -> None:
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
def test_traffic_without_a_sign_that_crosses_traffic_with_lights_has_lights(
    tagged: tuple[str, ...], rule: Rule
) -> None:
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


def test_traffic_that_only_merges_yields() -> None:
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


def far_apart(half: float, rule: Rule) -> Lit:
    """Return two dual carriageways of twice `half` m that cross, with lights on the four arms alone."""
    case = dual_cross(half)
    nodes = {**case.nodes, "wi": (-half - 10.0, -half), "ei": (half + 10.0, half)}
    nodes |= {"si": (half, -half - 10.0), "ni": (-half, half + 10.0)}
    ways = {**case.ways}
    for way, text in ((1, "w wi a"), (4, "e2 ei c"), (7, "s si b"), (10, "n2 ni d")):
        ways[way] = (text, case.ways[way][1])
    return lit(with_tags(Case(nodes, ways, case.restrictions), wi=SIGNALS, ei=SIGNALS, si=SIGNALS, ni=SIGNALS), rule)


@EITHER
def test_where_a_queue_fits_between_carriageways_it_has_lights(rule: Rule) -> None:
    found = far_apart(30.0, rule)
    assert {found.way(item) for item in found.heads()} == {1, 2, 4, 5, 7, 8, 10, 11}
    assert {bool(item.osm_id) for item in found.heads() if found.way(item) in (2, 5, 8, 11)} == {False}
    guessed = [item.osm_id for item in found.world.diagnostics if item.code == "signal-between"]
    assert sorted(guessed) == ["way/11", "way/2", "way/5", "way/8"]


@EITHER
def test_nobody_is_held_twice_where_no_queue_fits_between_carriageways(rule: Rule) -> None:
    found = far_apart(22.0, rule)
    assert Counter(found.way(item) for item in found.heads()) == {1: 2, 4: 2, 7: 2, 10: 2}
    assert len(found.lights.stops) == 4
    # No sign holds anybody on the roads between, either.
    assert len(found.lights.signalled) == 8
    # They are one installation, whose phases keep apart who meets beyond the first junction.
    junctions = sorted(item.id for item in found.world.road_map.junctions)
    assert len(junctions) == 4
    assert {(item.junction, *item.further_junctions) for item in found.lights.controllers} == {tuple(junctions)}
    way_of = {item.id: found.way(item) for item in found.heads()}
    green = [{way_of[k] for k in item.signals} for item in found.lights.controllers]
    assert sorted(green, key=min) == [{1}, {4}, {7}, {10}]


def test_a_slip_lane_is_no_part_of_the_signalled_junction() -> None:
    found = lit(with_tags(CASES["slip_lane"].case, o=SIGNALS))
    assert sorted(found.way(item) for item in found.heads()) == [2, 5, 6]
    roads = {road.id: road for road in found.world.road_map.roads}
    assert not {item.road for item in found.heads()} & {
        key for key, road in roads.items() if road.osm_way_ids == (4,)
    }


@pytest.mark.parametrize(
    ("tagged", "node", "why"),
    [
        ({"b": f"{SIGNALS} traffic_signals=blinker"}, "node/1003", "traffic_signals=blinker never shows green"),
        ({"b": f"{SIGNALS} traffic_signals=level_crossing"}, "node/1003", "level_crossing never shows green"),
        ({"e": SIGNALS}, "node/1005", "its street ends there"),
    ],
)
def test_nodes_that_give_no_lights_are_reported(tagged: dict[str, str], node: str, why: str) -> None:
    found = lit(with_tags(ROAD, **tagged))
    assert found.lights.signals == []
    assert list(found.left_out) == [node]
    assert why in found.left_out[node]


def test_crossings_with_lights_on_enough_arms_make_a_signalled_junction() -> None:
    crossing = "highway=crossing crossing=traffic_signals"
    found = lit(with_tags(ARMS, wi=crossing, ei=crossing, **YIELDING))
    assert sorted(found.way(item) for item in found.heads()) == [1, 2]
    assert {item.junction for item in found.lights.controllers} == {found.world.road_map.junctions[0].id}
    alone = lit(with_tags(ARMS, wi=crossing), target="esmini")
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
    assert far.lights.signals == []
    assert list(far.left_out) == ["node/77"]
    tram = lit(ROAD, crossings=crossing_at(1, 100.0, signals=False), network=beside(0.0, 6.0, on_footway=False))
    assert tram.lights.signals == []
    assert "no street of the map" in tram.left_out["node/77"]


@EITHER
@pytest.mark.parametrize(("back", "kinds"), [(6.0, {"junction"}), (20.0, {"junction", "road"})])
def test_lights_with_no_room_for_a_car_before_the_junctions_are_those(
    rule: Rule, back: float, kinds: set[str]
) -> None:
    """A crossing that counts as none of the junction's: its people wait for the lights of the junction, too."""
    case = with_tags(Case(X.nodes, {**X.ways, 1: (X.ways[1][0], "oneway=yes")}), o=SIGNALS)
    without = lit(case, rule)
    length = next(without.world.lanes.length(item.road) for item in without.heads() if without.way(item) == 1)
    found = lit(case, rule, crossings=crossing_at(1, length - back), target="esmini")
    of_road = [item for item in found.lights.controllers if item.junction is None]
    assert {"junction" if item.junction is not None else "road" for item in found.lights.controllers} == kinds
    assert len([item for item in found.heads() if found.way(item) == 1]) == len(kinds)
    assert len(found.heads("1000002")) == 2
    assert len(of_road) == (2 if "road" in kinds else 0)
    assert not found.left_out
