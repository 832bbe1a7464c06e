"""Stop and give-way signs of networks drawn by hand for right-hand traffic; left-hand traffic must mirror them.

Signs that say who yields where the map has none, for SUMO alone.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from light_cases import with_tags
from sign_cases import Signed, T, signed, ways
from street_cases import Case

from osm2xodr.model import Rule, Signal

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)

# A primary road from west to east, a tertiary one to the north, a service road to the south.
THREE_RANKS = Case(
    {"w": (-150.0, 0.0), "o": (0.0, 0.0), "e": (150.0, 0.0), "n": (0.0, 150.0), "s": (0.0, -150.0)},
    {
        1: ("w o", "highway=primary"),
        2: ("o e", "highway=primary"),
        3: ("n o", "highway=tertiary"),
        4: ("s o", "highway=service"),
    },
)


@EITHER
@pytest.mark.parametrize("kind", ["stop", "give_way"])
def test_a_sign_before_a_junction_stands_at_its_stop_line_beside_the_road(kind: str, rule: Rule) -> None:
    found = signed(with_tags(T, si=f"highway={kind}"), rule)
    (sign,) = found.signs.signals
    place = found.at(sign)
    # Lanes of 2.75 m, and 0.75 m beyond them; the node is 12 m before the junction.
    assert place.real == pytest.approx(3.5, abs=0.01)
    assert place.imag == pytest.approx(-12.0, abs=0.2)
    assert (sign.type, sign.subtype, sign.country) == ({"stop": "206", "give_way": "205"}[kind], "-1", "DE")
    assert (sign.osm_id, sign.dynamic, sign.h_offset) == ("node/1006", False, 0.0)
    assert sign.orientation == "+"
    assert sign.validity == (((-1, -1),) if rule is Rule.RIGHT_HAND else ((1, 1),))
    (stop,) = found.signs.stops
    assert (stop.kind, stop.road, stop.orientation, stop.osm_id) == (kind, sign.road, "+", "node/1006")
    assert stop.s == sign.s
    assert stop.lanes == ((-1,) if rule is Rule.RIGHT_HAND else (1,))
    assert found.left_out == {}


@EITHER
def test_where_there_are_lights_the_sign_stays_and_stops_nobody(rule: Rule) -> None:
    found = signed(with_tags(T, si="highway=stop"), rule, signalled=frozenset({3}))
    assert len(found.named("stop")) == 1
    assert found.signs.stops == ()


@EITHER
@pytest.mark.parametrize(
    ("tags", "at"),
    [
        ("highway=stop", [3]),
        ("highway=give_way", [3]),
        ("highway=stop stop=minor", [3]),
        ("highway=stop stop=all", [1, 2, 3]),
    ],
)
def test_signs_on_the_junction_itself(tags: str, at: list[int], rule: Rule) -> None:
    found = signed(with_tags(T, o=tags), rule)
    assert sorted(found.way(sign) for sign in found.signs.signals) == at
    assert len(found.signs.stops) == len(at)
    assert {sign.osm_id for sign in found.signs.signals} == {"node/1002"}


@EITHER
def test_signs_on_junctions_of_equal_roads_need_a_direction(rule: Rule) -> None:
    equal = ways(T, w1="highway=residential", w2="highway=residential")
    found = signed(with_tags(equal, o="highway=stop"), rule)
    assert found.signs.signals == ()
    assert "equal roads" in found.left_out["node/1002"]


@EITHER
@pytest.mark.parametrize(
    ("nodes", "direction", "towards_junction"),
    [
        ("s sm si o", "forward", True),
        ("s sm si o", "backward", False),
        ("o si sm s", "backward", True),
        ("o si sm s", "forward", False),
        # It faces south, so that traffic to the north sees it.
        ("s sm si o", "180", True),
        ("s sm si o", "10", False),
        # It faces the side of the street, which says nothing.
        ("o si sm s", "95", True),
    ],
)
def test_directions(nodes: str, direction: str, towards_junction: bool, rule: Rule) -> None:
    case = replace(T, ways={**T.ways, 3: (nodes, "highway=residential")})
    found = signed(with_tags(case, si=f"highway=stop direction={direction}"), rule)
    (sign,) = found.signs.signals
    assert found.at(sign).real == pytest.approx(3.5 if towards_junction else -3.5, abs=0.01)
    assert found.at(sign).imag == pytest.approx(-12.0, abs=0.2)


@EITHER
def test_both_directions_in_mid_street(rule: Rule) -> None:
    found = signed(with_tags(T, sm="highway=give_way direction=both"), rule)
    places = sorted((found.at(sign) for sign in found.signs.signals), key=lambda z: z.real)
    assert [round(z.real, 2) for z in places] == [-3.5, 3.5]
    assert all(z.imag == pytest.approx(-80.0, abs=0.01) for z in places)
    assert [stop.kind for stop in found.signs.stops] == ["give_way", "give_way"]


@EITHER
def test_one_sign_for_each_approach(rule: Rule) -> None:
    found = signed(with_tags(T, si="highway=give_way", o="highway=stop"), rule)
    assert [sign.name for sign in found.signs.signals] == ["stop"]
    assert list(found.left_out) == ["node/1006"]
    assert len(found.signs.stops) == 1


@EITHER
def test_signs_inside_wide_junctions(rule: Rule) -> None:
    divided = Case(
        {
            "aw": (-150.0, -6.0),
            "a": (0.0, -6.0),
            "ae": (150.0, -6.0),
            "be": (150.0, 6.0),
            "b": (0.0, 6.0),
            "bw": (-150.0, 6.0),
            "s": (0.0, -150.0),
            "m": (0.0, 0.0),
            "n": (0.0, 150.0),
        },
        {
            1: ("aw a ae", "highway=primary oneway=yes"),
            2: ("be b bw", "highway=primary oneway=yes"),
            3: ("s a m b n", "highway=residential"),
        },
    )
    # In the median: who comes there may have come from several roads.
    found = signed(with_tags(divided, m="highway=stop direction=forward"), rule)
    assert found.signs.signals == ()
    assert "inside a junction" in found.left_out["node/1008"]
    # On the crossing itself: the minor street from the south meets the first carriageway there.
    found = signed(with_tags(divided, a="highway=stop"), rule)
    assert [found.at(sign).real for sign in found.signs.signals] == pytest.approx([3.5], abs=0.01)
    assert found.at(found.signs.signals[0]).imag < -10.0


def derived(found: Signed) -> dict[int, tuple[str, str]]:
    """Return name and type of the signs that follow from priorities, by the way from which they are seen."""
    return {found.way(item): (item.name, item.type) for item in found.signs.signals if item.derived}


@EITHER
def test_the_main_road_goes_first_and_the_side_street_yields(rule: Rule) -> None:
    found = signed(T, rule, target="sumo")
    assert derived(found) == {1: ("priority_next", "301"), 2: ("priority_next", "301"), 3: ("give_way", "205")}
    (side,) = found.named("give_way")
    # Beside the road, 1 m before the junction.
    assert found.at(side).real == pytest.approx(3.5, abs=0.01)
    assert -15.0 < found.at(side).imag < -5.0
    assert (side.orientation, side.dynamic, side.osm_id) == ("+", False, "")
    assert side.validity == (((-1, -1),) if rule is Rule.RIGHT_HAND else ((1, 1),))
    assert [item.message for item in found.world.diagnostics if item.code == "priority-signs"] == [
        "3 signs added that sumo takes the right of way from"
    ]


@pytest.mark.parametrize("target", ["generic", "carla", "esmini", "roadrunner"])
def test_other_readers_get_only_signs_of_the_map(target: str) -> None:
    found = signed(T, target=target)
    assert found.signs.signals == ()
    assert "priority-signs" not in {item.code for item in found.world.diagnostics}


def test_who_yields_to_some_and_goes_before_others_has_no_sign() -> None:
    found = derived(signed(THREE_RANKS, target="sumo"))
    assert found == {1: ("priority_next", "301"), 2: ("priority_next", "301"), 4: ("give_way", "205")}


def test_equal_roads_have_no_signs() -> None:
    equal = ways(T, w1="highway=residential", w2="highway=residential")
    assert signed(equal, target="sumo").signs.signals == ()


def test_lights_need_no_signs() -> None:
    assert signed(with_tags(T, o="highway=traffic_signals"), target="sumo").signs.signals == ()


@EITHER
def test_a_sign_of_the_map_is_enough(rule: Rule) -> None:
    found = signed(with_tags(T, si="highway=give_way"), rule, target="sumo")
    assert derived(found) == {1: ("priority_next", "301"), 2: ("priority_next", "301")}
    assert [item.osm_id for item in found.named("give_way")] == ["node/1006"]


def test_a_stop_sign_is_not_as_sumo_does_not_read_it() -> None:
    found = signed(with_tags(T, si="highway=stop"), target="sumo")
    assert derived(found)[3] == ("give_way", "205")
    assert len(found.named("stop")) == 1


def test_a_sign_that_says_the_opposite_farther_back_is_overruled() -> None:
    # The side street is a priority road from its last junction on, but yields to the secondary road here.
    case = replace(T, ways={**T.ways, 3: ("s sm si o", "highway=residential priority_road=designated")})
    signs = with_tags(case, si="highway=give_way", sm="traffic_sign=DE:306 direction=forward")
    found = signed(signs, target="sumo")
    (road,) = {item.road for item in found.named("give_way")}
    names = [
        item.name
        for item in sorted(found.signs.signals, key=Signal.place_for_traffic)
        if (item.road, item.orientation) == (road, "+")
    ]
    assert names[-1] == "give_way"


def test_signs_are_in_the_order_in_which_traffic_meets_them() -> None:
    def at(number: int, s: float, orientation: str, road: int = 1) -> Signal:
        return Signal(number, road, s, 0.0, "", "", "", "", False, orientation, z_offset=0.0, height=0.0, width=0.0)

    mixed = [at(1, 5.0, "-"), at(2, 5.0, "+"), at(3, 9.0, "-"), at(4, 9.0, "+"), at(5, 0.0, "+", road=0)]
    assert [item.id for item in sorted(mixed, key=Signal.place_for_traffic)] == [5, 2, 4, 3, 1]
