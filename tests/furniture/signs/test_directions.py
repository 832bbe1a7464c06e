"""Which road a sign is for that is mapped beside streets; drawn for right-hand traffic, which left-hand mirrors."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sign_cases import Signed, signed
from street_cases import Case

from osm2xodr.model import Rule

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
# A main road from west to east (ways 1 and 2), a side street from the south (way 3).
T = Case(
    {"w": (-150.0, 0.0), "o": (0.0, 0.0), "e": (150.0, 0.0), "s": (0.0, -150.0)},
    {1: ("w o", "highway=secondary"), 2: ("o e", "highway=secondary"), 3: ("s o", "highway=residential")},
)
STREET = Case({"w": (-150.0, 0.0), "m": (0.0, 0.0), "e": (150.0, 0.0)}, {1: ("w m e", "highway=tertiary")})


def standing(case: Case, x: float, y: float, tags: str) -> Case:
    """Return a case with a sign beside its streets."""
    return replace(case, nodes={**case.nodes, "sign": (x, y)}, node_tags={**case.node_tags, "sign": tags})


def only_reason(found: Signed) -> str:
    """Return why the only sign is left out; signs that stand at level crossings and roundabouts are not mapped."""
    assert [item for item in found.signs.signals if item.osm_id[:4] == "node" and item.name != "level_crossing"] == []
    assert [stop for stop in found.signs.stops if stop.osm_id[:4] == "node"] == []
    (why,) = found.left_out.values()
    return why.removeprefix("the sign is left out: ")


@EITHER
@pytest.mark.parametrize(
    ("tags", "kind", "why"),
    [
        ("highway=motorway oneway=yes", "stop", "the road where it stands is a motorway"),
        ("highway=motorway oneway=yes", "give_way", "the road where it stands is a motorway"),
        ("highway=trunk", "stop", "the road where it stands is a trunk"),
        ("highway=trunk", "give_way", ""),
        ("highway=motorway_link oneway=yes", "stop", ""),
        (
            "highway=primary oneway=yes junction=circular",
            "stop",
            "the road where it stands is the ring of a roundabout",
        ),
        ("highway=tertiary oneway=-1", "stop", "it stands on the far side of the nearest road"),
    ],
)
def test_where_stop_and_give_way_signs_can_be(tags: str, kind: str, why: str, rule: Rule) -> None:
    case = replace(T, ways={**T.ways, 3: ("s o", tags)})
    found = signed(standing(case, 6.0, -20.0, f"traffic_sign={kind}"), rule)
    if why:
        assert only_reason(found).startswith(why)
    else:
        (sign,) = found.named(kind)
        assert found.way(sign) == 3
        assert found.left_out == {}


@EITHER
@pytest.mark.parametrize(
    ("x", "y", "why"),
    [
        # On the lane of those who come, and where those who leave the junction drive: nobody's side.
        (0.5, -20.0, "it lies on the carriageway but on no street"),
        (-5.0, -20.0, "no junction or crossing is ahead of it"),
        (5.0, -80.0, "no junction or crossing is ahead of it"),
        (40.0, -16.5, "no road for cars that it faces is near"),
    ],
)
def test_a_stop_sign_is_beside_those_who_come_to_a_junction(x: float, y: float, why: str, rule: Rule) -> None:
    assert only_reason(signed(standing(T, x, y, "traffic_sign=stop"), rule)).startswith(why)


@EITHER
@pytest.mark.parametrize("x", [5.0, 2.5])
def test_carriageways_may_be_drawn_a_little_too_wide(x: float, rule: Rule) -> None:
    found = signed(standing(T, x, -20.0, "traffic_sign=stop"), rule)
    (sign,) = found.named("stop")
    # 0.75 m beyond a lane of 2.75 m.
    assert found.at(sign).real == pytest.approx(3.5, abs=0.01)
    assert [stop.osm_id for stop in found.signs.stops] == [sign.osm_id]


@EITHER
@pytest.mark.parametrize("tags", ["railway=level_crossing", "highway=crossing crossing=uncontrolled"])
def test_what_is_crossed_amid_a_street_can_be_meant(tags: str, rule: Rule) -> None:
    case = standing(replace(STREET, node_tags={"m": tags}), -8.0, -5.0, "traffic_sign=stop")
    found = signed(case, rule, with_crossings=True)
    (sign,) = found.named("stop")
    assert found.at(sign).real == pytest.approx(-8.0, abs=0.1)
    assert sign.orientation == "+"
    behind = standing(replace(STREET, node_tags={"m": tags}), 8.0, -5.0, "traffic_sign=stop")
    assert only_reason(signed(behind, rule, with_crossings=True)).startswith("no junction or crossing is ahead")


@EITHER
def test_below_a_motorway_the_street_is_meant(rule: Rule) -> None:
    """As below the Ship Canal Bridge in Seattle: on the ground two streets meet."""
    over = {**T.ways, 4: ("mw me", "highway=motorway oneway=yes lanes=4 bridge=yes layer=3")}
    case = Case({**T.nodes, "mw": (-150.0, -20.0), "me": (150.0, -20.0)}, over)
    found = signed(standing(case, 5.0, -20.3, "traffic_sign=stop"), rule)
    assert [found.way(item) for item in found.named("stop")] == [3]


@EITHER
@pytest.mark.parametrize(("bridge", "aside"), [("bridge=yes layer=1", 3.5), ("", 2.94)])
def test_a_bridge_above_leaves_signs_their_place_on_a_level_world(bridge: str, aside: float, rule: Rule) -> None:
    nodes = {**T.nodes, "g": (0.0, -20.0), "mw": (6.5, -150.0), "me": (6.5, -4.0)}
    ways = {**T.ways, 3: ("s g o", "highway=residential"), 4: ("mw me", f"highway=motorway oneway=yes {bridge}")}
    found = signed(Case(nodes, ways, node_tags={"g": "highway=give_way"}), rule)
    (sign,) = found.named("give_way")
    place = found.at(sign)
    assert place == pytest.approx(complex(aside, -20.0), abs=0.01)
    # At one level there is no room between the two roads.
    said = [item.osm_id for item in found.world.diagnostics if item.code == "sign-on-road"]
    assert said == ([] if bridge else [sign.osm_id])


@EITHER
def test_between_roads_of_several_levels_it_is_not_clear_which_is_meant(rule: Rule) -> None:
    beside = {**STREET.nodes, "a": (-150.0, -12.0), "b": (150.0, -12.0)}
    street = "highway=tertiary"
    level = Case(beside, {1: STREET.ways[1], 2: ("a b", street)})
    found = signed(standing(level, 20.0, -6.0, "traffic_sign=hazard"), rule)
    assert [found.way(item) for item in found.named("hazard")] == [1]
    raised = Case(beside, {1: STREET.ways[1], 2: ("a b", f"{street} bridge=yes layer=1")})
    why = only_reason(signed(standing(raised, 20.0, -6.0, "traffic_sign=hazard"), rule))
    assert why.startswith("roads on several levels are near")


@EITHER
@pytest.mark.parametrize(("y", "said"), [(-6.0, ""), (-12.0, "the nearest road runs in a tunnel")])
def test_above_a_tunnel_signs_stand_beside_the_street(y: float, said: str, rule: Rule) -> None:
    """The tunnel leads along the street, 14 m south of it."""
    nodes = {**STREET.nodes, "a": (-150.0, -14.0), "b": (150.0, -14.0)}
    case = Case(nodes, {1: STREET.ways[1], 2: ("a b", "highway=tertiary tunnel=yes layer=-1")})
    found = signed(standing(case, 20.0, y, "traffic_sign=hazard"), rule)
    if said:
        assert only_reason(found).startswith(said)
    else:
        assert [found.way(item) for item in found.named("hazard")] == [1]


@EITHER
def test_in_a_tunnel_signs_say_so(rule: Rule) -> None:
    tunnel = replace(STREET, ways={1: ("w m e", "highway=tertiary tunnel=yes layer=-1")})
    why = only_reason(signed(standing(tunnel, 20.0, -5.0, "traffic_sign=hazard"), rule))
    assert why.startswith("the nearest road runs in a tunnel")


@EITHER
@pytest.mark.parametrize(("oneway", "way"), [("-1", 1), ("yes", 2)])
def test_the_road_is_meant_whose_traffic_has_it_on_its_own_side(oneway: str, way: int, rule: Rule) -> None:
    """The second road is nearer; traffic to the west has the sign to the left of it."""
    roads = {1: STREET.ways[1], 2: ("a b", f"highway=tertiary oneway={oneway}")}
    case = Case({**STREET.nodes, "a": (-150.0, 12.0), "b": (150.0, 12.0)}, roads)
    found = signed(standing(case, 20.0, 7.0, "traffic_sign=hazard"), rule)
    assert [found.way(item) for item in found.named("hazard")] == [way]


@EITHER
def test_of_two_carriageways_that_is_meant_whose_traffic_it_faces(rule: Rule) -> None:
    roads = {1: ("w m e", "highway=primary oneway=yes"), 2: ("b a", "highway=primary oneway=yes")}
    case = Case({**STREET.nodes, "a": (-150.0, 14.0), "b": (150.0, 14.0)}, roads)
    # Between them, nearer to the first, facing east.
    found = signed(standing(case, 20.0, 6.0, "traffic_sign=hazard direction=90"), rule)
    assert [found.way(item) for item in found.named("hazard")] == [2]
    facing_west = signed(standing(case, 20.0, 6.0, "traffic_sign=hazard direction=270"), rule)
    assert [facing_west.way(item) for item in facing_west.named("hazard")] == [1]


@EITHER
def test_signs_on_footways_stop_no_cars(rule: Rule) -> None:
    case = standing(T, 5.0, -20.0, "highway=give_way")
    case = replace(case, nodes={**case.nodes, "p": (40.0, -20.0)}, ways={**T.ways, 4: ("p sign", "highway=cycleway")})
    assert only_reason(signed(case, rule)) == "it stands on a way for people on foot or bicycles"


@EITHER
def test_what_hangs_below_a_stop_sign_that_is_left_out_is_left_out_too(rule: Rule) -> None:
    tags = "traffic_sign=DE:206,DE:1040-30,DE:274-30"
    found = signed(standing(STREET, 20.0, -5.0, tags), rule)
    assert [(item.name, item.value) for item in found.signs.signals] == [("maxspeed", 30.0)]
    assert list(found.left_out) == ["node/1004"]


@EITHER
@pytest.mark.parametrize(
    ("ways", "tags", "signs", "guessed"),
    [
        ("highway=tertiary", "traffic_sign=hazard", 2, True),
        ("highway=tertiary", "traffic_sign=hazard direction=forward", 1, False),
        ("highway=tertiary", "traffic_sign=hazard direction=both", 2, False),
        ("highway=tertiary oneway=yes", "traffic_sign=hazard", 1, False),
        ("highway=tertiary maxspeed=30", "traffic_sign=maxspeed maxspeed=30", 2, True),
        ("highway=tertiary", "traffic_sign:forward=hazard traffic_sign:backward=hazard", 2, False),
    ],
)
def test_signs_for_both_directions_are_guessed_where_no_tag_says_so(
    ways: str, tags: str, signs: int, guessed: bool, rule: Rule
) -> None:
    found = signed(Case(STREET.nodes, {1: ("w m e", ways)}, node_tags={"m": tags}), rule)
    assert len([item for item in found.signs.signals if item.osm_id == "node/1002"]) == signs
    said = [item.osm_id for item in found.world.diagnostics if item.code == "sign-direction"]
    assert said == (["node/1002"] if guessed else [])


@EITHER
def test_limits_that_change_at_their_sign_say_its_direction(rule: Rule) -> None:
    ways = {1: ("w m", "highway=tertiary maxspeed=50"), 2: ("m e", "highway=tertiary maxspeed=30")}
    found = signed(Case(STREET.nodes, ways, node_tags={"m": "traffic_sign=maxspeed"}), rule)
    assert sorted(item.value for item in found.signs.signals if item.osm_id == "node/1002" and item.value) == [
        30.0,
        50.0,
    ]
    assert "sign-direction" not in {item.code for item in found.world.diagnostics}
