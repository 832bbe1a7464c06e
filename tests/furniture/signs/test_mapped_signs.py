"""Signs of traffic_sign=* on streets and beside them, in networks made by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest
from light_cases import with_tags
from sign_cases import STREET, T, signed, the, ways

from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)


@EITHER
def test_a_sign_beside_the_street(rule: Rule) -> None:
    beside = replace(T, nodes={**T.nodes, "p": (5.0, -20.0)})
    found = signed(with_tags(beside, p="traffic_sign=DE:206"), rule)
    (sign,) = found.signs.signals
    assert (sign.name, sign.osm_id) == ("stop", "node/1007")
    assert found.at(sign).real == pytest.approx(3.5, abs=0.01)
    assert [stop.osm_id for stop in found.signs.stops] == ["node/1007"]


@EITHER
def test_signs_beside_the_street_stay_where_they_are(rule: Rule) -> None:
    beside = replace(STREET, nodes={**STREET.nodes, "p": (-60.0, -6.0), "q": (-90.0, 6.0), "far": (-90.0, 40.0)})
    found = signed(
        with_tags(beside, p="traffic_sign=hazard", q="traffic_sign=no_overtaking", far="traffic_sign=hazard"), rule
    )
    assert the(found, "hazard") == pytest.approx(-60 - 6j, abs=0.01)
    assert the(found, "no_overtaking") == pytest.approx(-90 + 6j, abs=0.01)
    assert [sign.orientation for sign in (*found.named("hazard"), *found.named("no_overtaking"))] == ["+", "-"]


@EITHER
@pytest.mark.parametrize(
    ("tags", "seen"),
    [
        # Lower limits lie to the east: there is the town.
        ("", {("city_limit", "+"), ("city_limit_end", "-")}),
        ("city_limit=both", {("city_limit", "+"), ("city_limit_end", "-")}),
        ("city_limit=begin", {("city_limit", "+")}),
        ("city_limit=end", {("city_limit_end", "-")}),
        ("city_limit=begin direction=backward", {("city_limit", "-")}),
        ("city_limit=end direction=forward", {("city_limit_end", "+")}),
    ],
)
def test_towns(tags: str, seen: set[tuple[str, str]], rule: Rule) -> None:
    found = signed(with_tags(STREET, m=f"traffic_sign=city_limit name=Ort {tags}"), rule)
    towns = [sign for sign in found.signs.signals if sign.type in ("310", "311")]
    assert {(sign.name, sign.orientation) for sign in towns} == seen
    assert {sign.text for sign in towns} == {"Ort"}


@EITHER
def test_signs_that_are_not_for_cars_or_not_known(rule: Rule) -> None:
    found = signed(with_tags(STREET, n="traffic_sign=DE:239", m="traffic_sign=yes"), rule)
    assert set(found.left_out) == {"node/1002", "node/1003"}


def test_ways_that_name_signs_are_counted() -> None:
    found = signed(ways(STREET, w2="highway=tertiary maxspeed=30 traffic_sign=DE:274.1"))
    (note,) = [item for item in found.world.diagnostics if item.code == "signs-of-ways"]
    assert note.message.startswith("1 way with")
    # The way says that its limit is that of a zone.
    assert [(sign.type, sign.subtype) for sign in found.signs.signals if sign.orientation == "+"] == [("274.1", "30")]
