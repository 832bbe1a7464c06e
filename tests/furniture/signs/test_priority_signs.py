"""Signs that say who yields where the map has none, for SUMO alone."""

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
