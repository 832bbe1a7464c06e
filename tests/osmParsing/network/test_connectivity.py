from pathlib import Path

import pytest
from osm_builder import Area, about, tags_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import LaneConnectivity
from osm2xodr.osmParsing.file.reader import RawMember, RawRelation, RawWay
from osm2xodr.osmParsing.network.connectivity import parse_connectivity, read_connectivities

WAYS = [RawWay(1, [10, 11], {}), RawWay(2, [11, 12], {}), RawWay(3, [12, 13], {})]


def read(
    members: str, value: str = "connectivity=1:1|2:2", same_node: dict[int, int] | None = None
) -> tuple[LaneConnectivity | None, list[tuple[Kind, str]]]:
    """Read one relation; members as ``role:w1`` or ``role:n11``."""
    parts = [member.split(":") for member in members.split()]
    kinds = {"w": "way", "n": "node"}
    relation = RawRelation(
        7,
        tuple(RawMember(kinds[ref[0]], int(ref[1:]), role) for role, ref in parts),
        tags_of(f"type=connectivity {value}"),
    )
    diagnostics = Diagnostics()
    found = read_connectivities([relation], WAYS, same_node or {}, diagnostics)
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
def test_values(text: str, lanes: tuple[tuple[int, int, bool], ...]) -> None:
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
def test_values_that_cannot_be_used(text: str, words: str) -> None:
    assert parse_connectivity(text) == words


def test_via_a_node_that_another_stands_for() -> None:
    found, said = read("from:w1 via:n11 to:w2", same_node={11: 5})
    assert found == LaneConnectivity(
        osm_relation_id=7,
        from_way=1,
        via_node=5,
        via_ways=(),
        to_way=2,
        lanes=((1, 1, False), (2, 2, False)),
    )
    assert said == []


def test_via_ways() -> None:
    found, _ = read("from:w1 via:w2 to:w3")
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
def test_what_is_broken_is_said(members: str, value: str, words: str) -> None:
    found, said = read(members, value)
    assert found is None
    assert said == [(Kind.DROPPED, f"the connectivity {words} and is not applied")]


def test_other_relations_are_passed_over() -> None:
    relation = RawRelation(7, (), {"type": "restriction", "connectivity": "1:1"})
    diagnostics = Diagnostics()
    assert read_connectivities([relation], WAYS, {}, diagnostics) == ()
    assert len(diagnostics) == 0


def test_from_a_file(tmp_path: Path) -> None:
    members = [("way", 1, "from"), ("node", 2, "via"), ("way", 2, "to")]
    area = Area(
        nodes={1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)},
        ways={1: ([1, 2], "highway=primary oneway=yes lanes=2"), 2: ([2, 3], "highway=primary oneway=yes lanes=3")},
        relations={5: (members, "type=connectivity connectivity=1:1|2:2,(3)")},
    )
    network, diagnostics = area.parse(tmp_path)
    assert network.connectivities == (LaneConnectivity(5, 1, 2, (), 2, ((1, 1, False), (2, 2, False), (2, 3, True))),)
    assert about(diagnostics, "connectivity") == []
