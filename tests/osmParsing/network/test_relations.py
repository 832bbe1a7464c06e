"""Relations between ways: turn restrictions and lane connectivity."""

from pathlib import Path

import pytest
from osm_builder import ROAD, ROW, Area, about, tags_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import LaneConnectivity, TurnRestriction
from osm2xodr.osmParsing.file.access import RawMember, RawRelation, RawWay
from osm2xodr.osmParsing.network.relations import forbids, parse_connectivity, read_connectivities, read_restrictions


def relation_of(members: str, tags: str) -> RawRelation:
    """Make a relation of members such as ``role:w1`` or ``role:n11``."""
    parts = [member.split(":") for member in members.split()]
    kinds = {"w": "way", "n": "node", "r": "relation"}
    return RawRelation(7, tuple(RawMember(kinds[ref[0]], int(ref[1:]), role) for role, ref in parts), tags_of(tags))


# ---------------------------------------------------------------- turn restrictions

RESTRICTED_WAYS = [RawWay(1, [10, 11], {}), RawWay(2, [11, 12], {}), RawWay(3, [11, 13], {}), RawWay(4, [12, 14], {})]


def read_restriction(
    members: str, tags: str = "type=restriction restriction=no_left_turn", same_node: dict[int, int] | None = None
) -> tuple[TurnRestriction | None, list[tuple[Kind, str]]]:
    diagnostics = Diagnostics()
    found = read_restrictions([relation_of(members, tags)], RESTRICTED_WAYS, same_node or {}, diagnostics)
    assert all(item.osm_id == "relation/7" and item.code == "restriction" for item in diagnostics)
    return (found[0] if found else None), [(item.kind, item.message) for item in diagnostics]


def test_a_restriction_via_a_node() -> None:
    found, said = read_restriction("from:w1 via:n11 to:w2")
    assert found == TurnRestriction(
        osm_relation_id=7,
        only=False,
        value="no_left_turn",
        from_ways=(1,),
        via_node=11,
        via_ways=(),
        to_ways=(2,),
    )
    assert said == []


def test_a_restriction_via_ways_keeps_their_order() -> None:
    found, said = read_restriction("to:w1 via:w4 via:w2 from:w3", "type=restriction restriction=only_straight_on")
    assert found is not None
    assert (found.only, found.via_node, found.via_ways, found.from_ways, found.to_ways) == (
        True,
        None,
        (4, 2),
        (3,),
        (1,),
    )
    assert said == []


def test_restrictions_of_several_ways() -> None:
    found, _ = read_restriction("from:w1 from:w2 via:n11 to:w3", "type=restriction restriction=no_entry")
    assert found is not None
    assert found.from_ways == (1, 2)
    found, _ = read_restriction("from:w1 via:n11 to:w2 to:w3", "type=restriction restriction=no_exit")
    assert found is not None
    assert found.to_ways == (2, 3)


def test_a_u_turn_restriction_has_one_way_twice() -> None:
    found, _ = read_restriction("from:w1 via:n11 to:w1", "type=restriction restriction=no_u_turn")
    assert found is not None
    assert found.from_ways == found.to_ways == (1,)


def test_a_restriction_via_a_joined_node() -> None:
    found, _ = read_restriction("from:w1 via:n11 to:w2", same_node={11: 5})
    assert found is not None
    assert found.via_node == 5


@pytest.mark.parametrize(
    ("tags", "value"),
    [
        ("type=restriction restriction=no_right_turn", "no_right_turn"),
        ("type=restriction restriction:motorcar=no_u_turn", "no_u_turn"),
        ("type=restriction restriction:vehicle=no_u_turn restriction:hgv=no_left_turn", "no_u_turn"),
        ("type=restriction:motorcar restriction=no_left_turn", "no_left_turn"),
        # The most specific one decides.
        ("type=restriction restriction=no_left_turn restriction:motorcar=only_straight_on", "only_straight_on"),
        ("type=restriction restriction=no_left_turn except=psv;bicycle", "no_left_turn"),
        ("type=restriction restriction=no_left_turn except=no", "no_left_turn"),
    ],
)
def test_restrictions_that_hold_for_cars(tags: str, value: str) -> None:
    found, said = read_restriction("from:w1 via:n11 to:w2", tags)
    assert found is not None
    assert (found.value, said) == (value, [])


@pytest.mark.parametrize(
    "tags",
    [
        "type=restriction restriction:hgv=no_left_turn",
        "type=restriction restriction:bicycle=no_left_turn",
        "type=restriction restriction=no_left_turn except=motorcar",
        "type=restriction restriction=no_left_turn except=bicycle;motor_vehicle",
        "type=restriction restriction:conditional_note=x",
        "type=route restriction=no_left_turn",
    ],
)
def test_restrictions_that_do_not_concern_cars(tags: str) -> None:
    assert read_restriction("from:w1 via:n11 to:w2", tags) == (None, [])


@pytest.mark.parametrize(
    "tags",
    [
        "type=restriction restriction:conditional=no_left_turn@(Mo-Fr)",
        "type=restriction restriction:motorcar:conditional=no_left_turn@(Mo-Fr)",
        "type=restriction restriction=no_left_turn hour_on=07:00 hour_off=09:00",
    ],
)
def test_restrictions_that_hold_at_certain_times(tags: str) -> None:
    assert read_restriction("from:w1 via:n11 to:w2", tags) == (
        None,
        [(Kind.NOTE, "holds at certain times only and is not applied")],
    )


@pytest.mark.parametrize(
    ("members", "tags", "words"),
    [
        ("from:w1 via:n11", "", "no_left_turn lacks a from or to member and is not applied"),
        ("from:w9 via:n11 to:w2", "", "no_left_turn needs ways that are absent or left out and is not applied"),
        ("from:w1 via:w9 to:w2", "", "no_left_turn needs ways that are absent or left out and is not applied"),
        ("from:w1 to:w2", "", "no_left_turn has no via nodes and is not applied"),
        ("from:w1 via:n11 via:n12 to:w2", "", "no_left_turn has 2 via nodes and is not applied"),
        ("from:w1 via:n11 to:w4", "", "no_left_turn is via a node that is not on way 4 and is not applied"),
        ("from:w1 via:n11 to:w2", "type=restriction restriction=left", "'left' is not a known restriction"),
    ],
)
def test_incomplete_restrictions_are_reported(members: str, tags: str, words: str) -> None:
    found, said = read_restriction(members, tags or "type=restriction restriction=no_left_turn")
    assert found is None
    assert said == [(Kind.DROPPED, words)]


def test_absent_ways_do_not_matter_if_others_remain() -> None:
    found, said = read_restriction("from:w1 from:w9 via:n11 to:w3", "type=restriction restriction=no_entry")
    assert found is not None
    assert (found.from_ways, said) == ((1,), [])


ONLY = "type=restriction restriction=only_straight_on"


def test_the_only_way_on_may_be_absent() -> None:
    found, said = read_restriction("from:w1 via:n11 to:w9", ONLY)
    assert found is not None
    assert (found.only, found.from_ways, found.to_ways, said) == (True, (1,), (), [])


@pytest.mark.parametrize(
    "members",
    [
        "from:w1 via:n11 to:w9",  # way 1 runs on beyond node 11: nobody knows from which side it is meant
        "from:w3 via:w2 to:w9",
    ],
)
def test_an_absent_only_way_on_that_leaves_doubts(members: str) -> None:
    diagnostics = Diagnostics()
    ways = [RawWay(1, [10, 11, 15], {}), *RESTRICTED_WAYS[1:]]
    assert read_restrictions([relation_of(members, ONLY)], ways, {}, diagnostics) == ()
    said = "only_straight_on needs ways that are absent or left out and is not applied"
    assert [item.message for item in diagnostics] == [said]


def restriction(value: str, from_way: int, *to_ways: int) -> TurnRestriction:
    return TurnRestriction(7, value.startswith("only_"), value, (from_way,), 11, (), to_ways)


@pytest.mark.parametrize(
    ("rules", "closed"),
    [
        ((), set()),
        ((restriction("no_left_turn", 1, 2),), {2}),
        ((restriction("no_left_turn", 2, 3),), set()),
        ((restriction("only_straight_on", 1, 2),), {3, 4}),
        ((restriction("only_straight_on", 1),), {2, 3, 4}),
        ((restriction("only_straight_on", 1, 2), restriction("only_right_turn", 1, 3)), {4}),
        ((restriction("only_straight_on", 1, 2), restriction("no_exit", 1, 2, 3)), {2, 3, 4}),
    ],
)
def test_what_restrictions_forbid_at_a_node(rules: tuple[TurnRestriction, ...], closed: set[int]) -> None:
    assert {way for way in (2, 3, 4) if forbids(rules, 1, way)} == closed


# ---------------------------------------------------------------- lane connectivity

CONNECTED_WAYS = [RawWay(1, [10, 11], {}), RawWay(2, [11, 12], {}), RawWay(3, [12, 13], {})]


def read_connectivity(
    members: str, value: str = "connectivity=1:1|2:2", same_node: dict[int, int] | None = None
) -> tuple[LaneConnectivity | None, list[tuple[Kind, str]]]:
    diagnostics = Diagnostics()
    relation = relation_of(members, f"type=connectivity {value}")
    found = read_connectivities([relation], CONNECTED_WAYS, same_node or {}, diagnostics)
    assert all(item.osm_id == "relation/7" and item.code == "connectivity" for item in diagnostics)
    return (found[0] if found else None), [(item.kind, item.message) for item in diagnostics]


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("1:1", ((1, 1, False),)),
        ("1:1|2:2", ((1, 1, False), (2, 2, False))),
        ("1:1|2:2,3", ((1, 1, False), (2, 2, False), (2, 3, False))),
        ("1:1|2:2,(3)", ((1, 1, False), (2, 2, False), (2, 3, True))),
        ("1:(1)|2:1,(2,3)", ((1, 1, True), (2, 1, False), (2, 2, True), (2, 3, True))),
        (" 2 : 1 , ( 2 ) | 1 : 1 ", ((1, 1, False), (2, 1, False), (2, 2, True))),
        # What is certain once is not optional.
        ("1:(1),1", ((1, 1, False),)),
        ("1:1|1:2", ((1, 1, False), (1, 2, False))),
    ],
)
def test_values_of_connectivity(text: str, lanes: tuple[tuple[int, int, bool], ...]) -> None:
    assert parse_connectivity(text) == lanes


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "names no lanes"),
        ("1", "'1' is not understood"),
        ("1:", "'1:' is not understood"),
        ("1:a", "'1:a' is not understood"),
        ("0:1", "'0:1' is not understood"),
        ("1:1|2:99", "'1:1|2:99' is not understood"),
        ("1:1|2:(3", "'1:1|2:(3' is not understood"),
        ("1:1|bw:1", "'1:1|bw:1' names lanes against the direction of travel"),
        ("1:1|bw1:1", "'1:1|bw1:1' names lanes against the direction of travel"),
    ],
)
def test_values_of_connectivity_that_cannot_be_used(text: str, words: str) -> None:
    assert parse_connectivity(text) == words


def test_connectivity_via_a_joined_node() -> None:
    found, said = read_connectivity("from:w1 via:n11 to:w2", same_node={11: 5})
    assert found == LaneConnectivity(
        osm_relation_id=7,
        from_way=1,
        via_node=5,
        via_ways=(),
        to_way=2,
        lanes=((1, 1, False), (2, 2, False)),
    )
    assert said == []


def test_connectivity_via_ways() -> None:
    found, _ = read_connectivity("from:w1 via:w2 to:w3")
    assert found is not None
    assert (found.from_way, found.via_node, found.via_ways, found.to_way) == (1, None, (2,), 3)


@pytest.mark.parametrize(
    ("members", "value", "words"),
    [
        ("from:w1 via:n11", "connectivity=1:1", "lacks a from or to member"),
        ("from:w9 via:n11 to:w2", "connectivity=1:1", "needs ways that are absent or left out"),
        ("from:w1 from:w2 via:n11 to:w2", "connectivity=1:1", "has several from or to members"),
        ("from:w1 via:n12 to:w2", "connectivity=1:1", "is via a node that is not on way 1"),
        ("from:w1 via:n11 to:w2", "note=x", "names no lanes"),
        ("from:w1 via:n11 to:w2", "connectivity=1-1", "'1-1' is not understood"),
    ],
)
def test_broken_connectivity_is_reported(members: str, value: str, words: str) -> None:
    found, said = read_connectivity(members, value)
    assert found is None
    assert said == [(Kind.DROPPED, f"the connectivity {words} and is not applied")]


def test_other_relations_are_ignored() -> None:
    relation = RawRelation(7, (), {"type": "restriction", "connectivity": "1:1"})
    diagnostics = Diagnostics()
    assert read_connectivities([relation], CONNECTED_WAYS, {}, diagnostics) == ()
    assert len(diagnostics) == 0


def test_connectivity_from_a_file(tmp_path: Path) -> None:
    members = [("way", 1, "from"), ("node", 2, "via"), ("way", 2, "to")]
    area = Area(
        nodes={1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)},
        ways={1: ([1, 2], "highway=primary oneway=yes lanes=2"), 2: ([2, 3], "highway=primary oneway=yes lanes=3")},
        relations={5: (members, "type=connectivity connectivity=1:1|2:2,(3)")},
    )
    network, diagnostics = area.parse(tmp_path)
    assert network.connectivities == (LaneConnectivity(5, 1, 2, (), 2, ((1, 1, False), (2, 2, False), (2, 3, True))),)
    assert about(diagnostics, "connectivity") == []


def test_restrictions_of_carried_ways(tmp_path: Path) -> None:
    members = [("way", 20, "from"), ("node", 2, "via"), ("way", 21, "to")]
    area = Area(
        ROW,
        {20: ([1, 2], ROAD), 21: ([2, 3], ROAD), 22: ([2, 12], ROAD), 23: ([2, 11], "highway=footway")},
        {
            9: (members, "type=restriction restriction=no_left_turn"),
            8: ([*members[:2], ("way", 22, "to")], "type=restriction restriction=only_right_turn"),
            7: ([*members[:2], ("way", 23, "to")], "type=restriction restriction=no_right_turn"),
        },
    )
    network, diagnostics = area.parse(tmp_path)
    assert [(item.osm_relation_id, item.only, item.to_ways) for item in network.restrictions] == [
        (8, True, (22,)),
        (9, False, (21,)),
    ]
    assert [item.osm_id for item in about(diagnostics, "restriction")] == ["relation/7"]
