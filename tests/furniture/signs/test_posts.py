"""Posts and the codes of their signs, in networks made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from light_cases import with_tags
from sign_cases import STREET, T, signed
from street_cases import Case

from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)


@EITHER
def test_signs_on_one_post_stand_above_each_other(rule: Rule) -> None:
    found = signed(with_tags(STREET, n="traffic_sign:forward=DE:274[30],DE:1042-33,DE:276"), rule)
    pole = sorted(
        (sign for sign in found.signs.signals if sign.osm_id == "node/1003"), key=lambda sign: sign.z_offset
    )
    assert [sign.type for sign in pole] == ["276", "1042-33", "274"]
    assert [sign.z_offset for sign in pole] == pytest.approx([2.2, 2.8, 3.13])
    assert len({(sign.s, sign.t) for sign in pole}) == 1


def test_codes_without_a_common_number_are_written_and_reported_once() -> None:
    found = signed(with_tags(STREET, n="traffic_sign:forward=DE:434-52", m="traffic_sign:forward=DE:434-52"))
    assert [(sign.type, sign.country) for sign in found.named("DE:434-52")] == [("434-52", "DE")] * 2
    assert len([item for item in found.world.diagnostics if item.code == "sign-code"]) == 1


def test_foreign_codes() -> None:
    case = with_tags(T, si="traffic_sign:forward=FR:AB4")
    (sign,) = signed(case).signs.signals
    assert (sign.type, sign.country, sign.name) == ("206", "DE", "stop")
    assert len(signed(case).signs.stops) == 1


def test_esmini_looks_for_the_type_alone() -> None:
    assert {(sign.type, sign.subtype) for sign in signed(STREET, target="esmini").signs.signals} == {("274", "")}


def test_own_codes_where_they_are_wanted() -> None:
    foreign = with_tags(STREET, n="traffic_sign:forward=FR:B3")
    (sign,) = signed(foreign, target="roadrunner").named("no_overtaking")
    assert (sign.type, sign.subtype, sign.country) == ("B3", "-1", "FR")
    (sign,) = signed(foreign).named("no_overtaking")
    assert (sign.type, sign.subtype, sign.country) == ("276", "-1", "DE")
    assert {sign.country for sign in signed(STREET, target="roadrunner").signs.signals} == {"DE"}


@pytest.mark.parametrize(
    "case",
    [
        STREET,
        with_tags(T, si="highway=stop", o="highway=give_way"),
        with_tags(T, o="highway=stop stop=all", sm="traffic_sign=DE:274[30]"),
        with_tags(STREET, m="traffic_sign=city_limit name=Ort", n="traffic_sign:backward=DE:310"),
    ],
)
def test_left_hand_traffic_is_the_mirror_image(case: Case) -> None:
    left, right = signed(case, Rule.LEFT_HAND), signed(case)
    assert left.summary() == right.summary() != []
    places = [
        sorted((sign.name, found.at(sign).real, found.at(sign).imag) for sign in found.signs.signals)
        for found in (left, right)
    ]
    # Nodes are written to 1 cm.
    assert [name for name, *_ in places[0]] == [name for name, *_ in places[1]]
    assert np.abs(np.array([p[1:] for p in places[0]]) - np.array([p[1:] for p in places[1]])).max() < 0.02
