"""Signs of networks made by hand, drawn for right-hand traffic; left-hand traffic must mirror them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sign_cases import Signed, signed
from street_cases import Case

from osm2xodr.furniture.signs.speed_signs import shown_speed
from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
# The main road from west to east (ways 1 and 2), a side street from the south (way 3).
T = Case(
    {
        "w": (-150.0, 0.0),
        "o": (0.0, 0.0),
        "e": (150.0, 0.0),
        "s": (0.0, -150.0),
        "sm": (0.0, -80.0),
        "si": (0.0, -12.0),
    },
    {1: ("w o", "highway=secondary"), 2: ("o e", "highway=secondary"), 3: ("s sm si o", "highway=residential")},
)
STREET = Case(
    {"w": (-150.0, 0.0), "m": (0.0, 0.0), "n": (60.0, 0.0), "e": (150.0, 0.0)},
    {1: ("w m", "highway=tertiary maxspeed=50"), 2: ("m n e", "highway=tertiary maxspeed=30")},
)


def tagged(case: Case, **tags: str) -> Case:
    return replace(case, node_tags={**case.node_tags, **tags})


def ways(case: Case, **tags: str) -> Case:
    return replace(
        case, ways={number: (nodes, tags.get(f"w{number}", old)) for number, (nodes, old) in case.ways.items()}
    )


def the(found: Signed, name: str) -> complex:
    (sign,) = found.named(name)
    return found.at(sign)


@EITHER
@pytest.mark.parametrize("kind", ["stop", "give_way"])
def test_a_sign_before_a_junction_stands_at_its_stop_line_beside_the_road(kind: str, rule: Rule) -> None:
    found = signed(tagged(T, si=f"highway={kind}"), rule)
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
    found = signed(tagged(T, si="highway=stop"), rule, signalled=frozenset({3}))
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
    found = signed(tagged(T, o=tags), rule)
    assert sorted(found.way(sign) for sign in found.signs.signals) == at
    assert len(found.signs.stops) == len(at)
    assert {sign.osm_id for sign in found.signs.signals} == {"node/1002"}


@EITHER
def test_equal_roads_need_a_word(rule: Rule) -> None:
    equal = ways(T, w1="highway=residential", w2="highway=residential")
    found = signed(tagged(equal, o="highway=stop"), rule)
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
    found = signed(tagged(case, si=f"highway=stop direction={direction}"), rule)
    (sign,) = found.signs.signals
    assert found.at(sign).real == pytest.approx(3.5 if towards_junction else -3.5, abs=0.01)
    assert found.at(sign).imag == pytest.approx(-12.0, abs=0.2)


@EITHER
def test_both_directions_in_mid_street(rule: Rule) -> None:
    found = signed(tagged(T, sm="highway=give_way direction=both"), rule)
    places = sorted((found.at(sign) for sign in found.signs.signals), key=lambda z: z.real)
    assert [round(z.real, 2) for z in places] == [-3.5, 3.5]
    assert all(z.imag == pytest.approx(-80.0, abs=0.01) for z in places)
    assert [stop.kind for stop in found.signs.stops] == ["give_way", "give_way"]


@EITHER
def test_one_sign_for_each_approach(rule: Rule) -> None:
    found = signed(tagged(T, si="highway=give_way", o="highway=stop"), rule)
    assert [sign.name for sign in found.signs.signals] == ["stop"]
    assert list(found.left_out) == ["node/1006"]
    assert len(found.signs.stops) == 1


@EITHER
def test_a_sign_beside_the_street(rule: Rule) -> None:
    beside = replace(T, nodes={**T.nodes, "p": (5.0, -20.0)})
    found = signed(tagged(beside, p="traffic_sign=DE:206"), rule)
    (sign,) = found.signs.signals
    assert (sign.name, sign.osm_id) == ("stop", "node/1007")
    assert found.at(sign).real == pytest.approx(3.5, abs=0.01)
    assert [stop.osm_id for stop in found.signs.stops] == ["node/1007"]


@EITHER
def test_signs_beside_the_street_stay_where_they_are(rule: Rule) -> None:
    beside = replace(STREET, nodes={**STREET.nodes, "p": (-60.0, -6.0), "q": (-90.0, 6.0), "far": (-90.0, 40.0)})
    found = signed(
        tagged(beside, p="traffic_sign=hazard", q="traffic_sign=no_overtaking", far="traffic_sign=hazard"), rule
    )
    assert the(found, "hazard") == pytest.approx(-60 - 6j, abs=0.01)
    assert the(found, "no_overtaking") == pytest.approx(-90 + 6j, abs=0.01)
    assert [sign.orientation for sign in (*found.named("hazard"), *found.named("no_overtaking"))] == ["+", "-"]


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
def test_a_mapped_sign_goes_before_one_that_follows(rule: Rule) -> None:
    found = signed(tagged(STREET, n="traffic_sign=maxspeed maxspeed=30 direction=forward"), rule)
    said = [(30.0, "node/1003"), (30.0, "way/2"), (50.0, "way/1")]
    assert sorted((sign.value, sign.osm_id) for sign in found.signs.signals) == said
    near = replace(STREET, nodes={**STREET.nodes, "n": (30.0, 0.0)})
    found = signed(tagged(near, n="traffic_sign=maxspeed maxspeed=30 direction=forward"), rule)
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
    found = signed(tagged(STREET, m=f"traffic_sign=city_limit name=Ort {tags}"), rule)
    towns = [sign for sign in found.signs.signals if sign.type in ("310", "311")]
    assert {(sign.name, sign.orientation) for sign in towns} == seen
    assert {sign.text for sign in towns} == {"Ort"}


@EITHER
def test_signs_on_one_pole_stand_above_each_other(rule: Rule) -> None:
    found = signed(tagged(STREET, n="traffic_sign:forward=DE:274[30],DE:1042-33,DE:276"), rule)
    pole = sorted(
        (sign for sign in found.signs.signals if sign.osm_id == "node/1003"), key=lambda sign: sign.z_offset
    )
    assert [sign.type for sign in pole] == ["276", "1042-33", "274"]
    assert [sign.z_offset for sign in pole] == pytest.approx([2.2, 2.8, 3.13])
    assert len({(sign.s, sign.t) for sign in pole}) == 1


@EITHER
def test_signs_that_are_not_for_cars_or_not_known(rule: Rule) -> None:
    found = signed(tagged(STREET, n="traffic_sign=DE:239", m="traffic_sign=yes"), rule)
    assert set(found.left_out) == {"node/1002", "node/1003"}


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
    found = signed(tagged(divided, m="highway=stop direction=forward"), rule)
    assert found.signs.signals == ()
    assert "inside a junction" in found.left_out["node/1008"]
    # On the crossing itself: the minor street from the south meets the first carriageway there.
    found = signed(tagged(divided, a="highway=stop"), rule)
    assert [found.at(sign).real for sign in found.signs.signals] == pytest.approx([3.5], abs=0.01)
    assert found.at(found.signs.signals[0]).imag < -10.0


def test_codes_without_a_common_number_are_written_and_reported_once() -> None:
    found = signed(tagged(STREET, n="traffic_sign:forward=DE:434-52", m="traffic_sign:forward=DE:434-52"))
    assert [(sign.type, sign.country) for sign in found.named("DE:434-52")] == [("434-52", "DE")] * 2
    assert len([item for item in found.world.diagnostics if item.code == "sign-code"]) == 1


def test_foreign_codes() -> None:
    case = tagged(T, si="traffic_sign:forward=FR:AB4")
    (sign,) = signed(case).signs.signals
    assert (sign.type, sign.country, sign.name) == ("206", "DE", "stop")
    assert len(signed(case).signs.stops) == 1


def test_esmini_looks_for_the_type_alone() -> None:
    assert {(sign.type, sign.subtype) for sign in signed(STREET, target="esmini").signs.signals} == {("274", "-1")}


def test_own_codes_where_they_are_wanted() -> None:
    foreign = tagged(STREET, n="traffic_sign:forward=FR:B3")
    (sign,) = signed(foreign, target="roadrunner").named("no_overtaking")
    assert (sign.type, sign.subtype, sign.country) == ("B3", "-1", "FR")
    (sign,) = signed(foreign).named("no_overtaking")
    assert (sign.type, sign.subtype, sign.country) == ("276", "-1", "DE")
    assert {sign.country for sign in signed(STREET, target="roadrunner").signs.signals} == {"DE"}


def test_ways_that_name_signs_are_counted() -> None:
    found = signed(ways(STREET, w2="highway=tertiary maxspeed=30 traffic_sign=DE:274.1"))
    (note,) = [item for item in found.world.diagnostics if item.code == "signs-of-ways"]
    assert note.message.startswith("1 way with")
    # The way says that its limit is that of a zone.
    assert [(sign.type, sign.subtype) for sign in found.signs.signals if sign.orientation == "+"] == [("274.1", "30")]


@pytest.mark.parametrize(
    "case",
    [
        STREET,
        tagged(T, si="highway=stop", o="highway=give_way"),
        tagged(T, o="highway=stop stop=all", sm="traffic_sign=DE:274[30]"),
        tagged(STREET, m="traffic_sign=city_limit name=Ort", n="traffic_sign:backward=DE:310"),
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
