"""Signs that follow from attributes of ways, in networks made by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest
from light_cases import with_tags
from sign_cases import STREET, T, signed, ways

from osm2xodr.furniture.signs.speed_signs import shown_speed
from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)


@EITHER
def test_limits_where_they_change(rule: Rule) -> None:
    found = signed(STREET, rule)
    east, west = sorted(found.signs.signals, key=lambda sign: found.at(sign).imag)
    assert (east.type, east.subtype, east.value, east.unit, east.orientation) == ("274", "30", 30.0, "km/h", "+")
    assert (west.type, west.subtype, west.value, west.unit, west.orientation) == ("274", "50", 50.0, "km/h", "-")
    # Lanes of 3 m, and 0.75 m beyond them.
    assert found.at(east) == pytest.approx(-3.75j, abs=0.01)
    assert found.at(west) == pytest.approx(3.75j, abs=0.01)


@EITHER
@pytest.mark.parametrize(
    "tags",
    [
        "highway=tertiary maxspeed:type=DE:zone30",
        "highway=tertiary source:maxspeed=DE:urban",
        "highway=tertiary",
        "highway=tertiary maxspeed=50",
    ],
)
def test_limits_of_the_law_have_no_signs(tags: str, rule: Rule) -> None:
    found = signed(ways(STREET, w2=tags), rule)
    assert not [sign for sign in found.signs.signals if sign.orientation == "+"]


@EITHER
def test_a_mapped_sign_replaces_that_of_the_way(rule: Rule) -> None:
    found = signed(with_tags(STREET, n="traffic_sign=maxspeed maxspeed=30 direction=forward"), rule)
    said = [(30.0, "node/1003"), (30.0, "way/2"), (50.0, "way/1")]
    assert sorted((sign.value, sign.osm_id) for sign in found.signs.signals) == said
    near = replace(STREET, nodes={**STREET.nodes, "n": (30.0, 0.0)})
    found = signed(with_tags(near, n="traffic_sign=maxspeed maxspeed=30 direction=forward"), rule)
    assert sorted((sign.value, sign.osm_id) for sign in found.signs.signals) == [(30.0, "node/1003"), (50.0, "way/1")]


@EITHER
def test_limits_behind_junctions(rule: Rule) -> None:
    limits = {
        number: (nodes, f"{tags} maxspeed={50 if number < 3 else 30}") for number, (nodes, tags) in T.ways.items()
    }
    found = signed(replace(T, ways=limits), rule)
    assert sorted((sign.value, found.way(sign)) for sign in found.signs.signals if sign.value == 30.0) == [(30.0, 3)]
    assert len(found.named("maxspeed")) == 3
    (side,) = [sign for sign in found.signs.signals if sign.value == 30.0]
    # It is for those who come from the main road, on their right.
    assert found.at(side).real == pytest.approx(-3.5, abs=0.01)
    assert -20.0 < found.at(side).imag < -5.0


@EITHER
def test_priority_roads(rule: Rule) -> None:
    main = "highway=secondary priority_road=designated"
    found = signed(ways(T, w1=main, w2=main), rule)
    assert {(sign.type, found.way(sign)) for sign in found.signs.signals} == {("306", 1), ("306", 2)}
    assert len(found.signs.signals) == 2


@pytest.mark.parametrize(
    ("speed", "country", "shown"),
    [
        (50 / 3.6, "DE", (50.0, "km/h")),
        (30 * 0.44704, "US", (30.0, "mph")),
        (30 * 0.44704, "DE", (30.0, "mph")),
        (50 / 3.6, "GB", (50.0, "km/h")),
    ],
)
def test_numbers_on_signs(speed: float, country: str, shown: tuple[float, str]) -> None:
    assert shown_speed(speed, country) == shown
