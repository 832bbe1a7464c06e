import pytest
from osm_builder import tags_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import TurnRestriction
from osm2xodr.osmParsing.file.reader import RawMember, RawRelation, RawWay
from osm2xodr.osmParsing.network.restrictions import read_restrictions

WAYS = [RawWay(1, [10, 11], {}), RawWay(2, [11, 12], {}), RawWay(3, [11, 13], {}), RawWay(4, [12, 14], {})]


def read(
    members: str, tags: str = "type=restriction restriction=no_left_turn", same_node: dict[int, int] | None = None
) -> tuple[TurnRestriction | None, list[tuple[Kind, str]]]:
    """Read one relation; members as ``role:w1`` or ``role:n11``."""
    parts = [member.split(":") for member in members.split()]
    kinds = {"w": "way", "n": "node", "r": "relation"}
    relation = RawRelation(
        7, tuple(RawMember(kinds[ref[0]], int(ref[1:]), role) for role, ref in parts), tags_of(tags)
    )
    diagnostics = Diagnostics()
    found = read_restrictions([relation], WAYS, same_node or {}, diagnostics)
    assert all(item.osm_id == "relation/7" and item.code == "restriction" for item in diagnostics)
    return (found[0] if found else None), [(item.kind, item.message) for item in diagnostics]


def test_via_a_node() -> None:
    found, said = read("from:w1 via:n11 to:w2")
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


def test_via_ways_in_their_order() -> None:
    found, said = read("to:w1 via:w4 via:w2 from:w3", "type=restriction restriction=only_straight_on")
    assert found is not None
    assert (found.only, found.via_node, found.via_ways, found.from_ways, found.to_ways) == (
        True,
        None,
        (4, 2),
        (3,),
        (1,),
    )
    assert said == []


def test_several_ways() -> None:
    found, _ = read("from:w1 from:w2 via:n11 to:w3", "type=restriction restriction=no_entry")
    assert found is not None
    assert found.from_ways == (1, 2)
    found, _ = read("from:w1 via:n11 to:w2 to:w3", "type=restriction restriction=no_exit")
    assert found is not None
    assert found.to_ways == (2, 3)


def test_the_same_way_twice() -> None:
    found, _ = read("from:w1 via:n11 to:w1", "type=restriction restriction=no_u_turn")
    assert found is not None
    assert found.from_ways == found.to_ways == (1,)


def test_via_a_node_that_another_stands_for() -> None:
    found, _ = read("from:w1 via:n11 to:w2", same_node={11: 5})
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
def test_those_that_hold_for_cars(tags: str, value: str) -> None:
    found, said = read("from:w1 via:n11 to:w2", tags)
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
def test_those_that_do_not_concern_cars(tags: str) -> None:
    assert read("from:w1 via:n11 to:w2", tags) == (None, [])


@pytest.mark.parametrize(
    "tags",
    [
        "type=restriction restriction:conditional=no_left_turn@(Mo-Fr)",
        "type=restriction restriction:motorcar:conditional=no_left_turn@(Mo-Fr)",
        "type=restriction restriction=no_left_turn hour_on=07:00 hour_off=09:00",
    ],
)
def test_those_that_hold_at_times(tags: str) -> None:
    assert read("from:w1 via:n11 to:w2", tags) == (None, [(Kind.NOTE, "holds at times only and is not applied")])


@pytest.mark.parametrize(
    ("members", "tags", "words"),
    [
        ("from:w1 via:n11", "", "no_left_turn lacks a from or to member and is not applied"),
        ("from:w9 via:n11 to:w2", "", "no_left_turn needs ways that are absent or left out and is not applied"),
        ("from:w1 via:w9 to:w2", "", "no_left_turn needs ways that are absent or left out and is not applied"),
        ("from:w1 to:w2", "", "no_left_turn has no via nodes and is not applied"),
        ("from:w1 via:n11 via:n12 to:w2", "", "no_left_turn has 2 via nodes and is not applied"),
        ("from:w1 via:n11 to:w4", "", "no_left_turn is via a node that is not on way 4 and is not applied"),
        ("from:w1 via:n11 to:w2", "type=restriction restriction=left", "'left' is no restriction that is known"),
    ],
)
def test_what_is_incomplete_is_said(members: str, tags: str, words: str) -> None:
    found, said = read(members, tags or "type=restriction restriction=no_left_turn")
    assert found is None
    assert said == [(Kind.DROPPED, words)]


def test_ways_that_are_left_out_do_not_matter_beside_others() -> None:
    found, said = read("from:w1 from:w9 via:n11 to:w3", "type=restriction restriction=no_entry")
    assert found is not None
    assert (found.from_ways, said) == ((1,), [])
