"""

Ways whose direction changes with time, where they meet head-on.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from osm_builder import ROAD, ROW, Area, about, ends_of, nodes_of, ways_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import InputError
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.network import with_one_flow


@pytest.mark.parametrize(
    ("way", "node", "streets", "ends"),
    [
        # A ring by itself has no intersection.
        ([1, 2, 12, 11, 1], ROAD, [[1, 2, 12, 11, 1]], [(-1, -1)]),
        ([1, 2, 12, 11, 1], "highway=residential oneway=-1", [[1, 11, 12, 2, 1]], [(-1, -1)]),
        # A loop at the end of a street, an eight, and a way that crosses itself.
        ([5, 1, 2, 12, 11, 1], ROAD, [[5, 1], [1, 2, 12, 11, 1]], [(5, 1), (1, 1)]),
        ([1, 2, 12, 1, 3, 13, 1], ROAD, [[1, 2, 12, 1], [1, 3, 13, 1]], [(1, 1), (1, 1)]),
        ([1, 2, 3, 13, 12, 2, 4], ROAD, [[1, 2], [2, 3, 13, 12, 2], [2, 4]], [(1, 2), (2, 2), (2, 4)]),
        # Out and back over the same nodes.
        ([1, 2, 1], ROAD, [[1, 2]], [(1, 2)]),
        ([1, 2, 3, 2], ROAD, [[1, 2, 3]], [(1, 3)]),
        ([1, 2, 3, 2, 1], ROAD, [[1, 2, 3]], [(1, 3)]),
        # Nodes that follow themselves.
        ([1, 1, 2, 2, 2, 3], ROAD, [[1, 2, 3]], [(1, 3)]),
    ],
)
def test_ways_that_visit_nodes_twice(
    tmp_path: Path, way: list[int], node: str, streets: list[list[int]], ends: list[tuple[int, int]]
) -> None:
    network, _ = Area(ROW, {20: (way, node)}).parse(tmp_path)
    assert nodes_of(network) == streets
    assert ends_of(network) == ends


def test_a_roundabout_is_cut_at_its_arms(tmp_path: Path) -> None:
    ring = ([2, 3, 13, 12, 2], "highway=tertiary junction=roundabout lanes=1")
    network, _ = Area(ROW, {20: ring, 21: ([1, 2], ROAD), 22: ([13, 14], ROAD)}).parse(tmp_path)
    assert nodes_of(network) == [[2, 3, 13], [13, 12, 2], [1, 2], [13, 14]]
    assert [street.pieces[0][1].roundabout for street in network.streets] == [True, True, False, False]


def test_ways_on_top_of_others_are_left_out(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2, 3, 4], ROAD), 21: ([3, 2], ROAD), 22: ([4, 5], ROAD)})
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3, 4, 5]]
    assert ways_of(network) == [[(20, False), (22, False)]]
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [
        (Kind.DROPPED, "duplicate-way", "way/21")
    ]


def test_nodes_at_one_place_are_one_node(tmp_path: Path) -> None:
    nodes = ROW | {30: (200.0004, 0.0), 31: (200.0004, 0.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 31, 30], ROAD), 21: ([30, 3], ROAD), 22: ([31, 12], ROAD)},
        node_tags={30: "highway=stop a=b"},
    )
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [2, 3], [2, 12]]
    assert [(item.osm_id, item.kind) for item in about(diagnostics, "same-place")] == [
        ("node/30", Kind.REPAIRED),
        ("node/31", Kind.REPAIRED),
    ]
    assert network.node_tags == {2: {"highway": "stop"}}


def test_absent_nodes(tmp_path: Path) -> None:
    # 99 and 98 are absent: 100 m are bridged, 300 m are not.
    area = Area(
        ROW,
        {
            20: ([1, 99, 2], ROAD),
            21: ([3, 4, 98, 99, 7, 8], ROAD),
            22: ([13, 98, 16], ROAD),
            23: ([97, 98], ROAD),
            24: ([99, 11, 98], ROAD),
            25: ([], ROAD),
        },
    )
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [3, 4], [7, 8]]
    said = [(item.osm_id, item.kind.value) for item in about(diagnostics, "absent-node")]
    assert said == [(f"way/{k}", "dropped") for k in (20, 21, 22, 23, 24)] + [
        ("way/21", "repaired"),
        ("way/22", "repaired"),
    ]
    assert [item.osm_id for item in about(diagnostics, "short-way")] == ["way/23", "way/24", "way/25"]


def test_nodes_far_from_their_neighbours_are_left_out(tmp_path: Path) -> None:
    # Node 90 lies 60 km or more away: within a way, at its end, alone with another one.
    area = Area(
        {**ROW, 90: (60_000.0, 0.0)},
        {
            20: ([1, 2, 90, 3, 4], ROAD),
            21: ([5, 6, 90], ROAD),
            22: ([8, 90], ROAD),
        },
    )
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3, 4], [5, 6]]
    said = [(item.osm_id, item.kind, item.message) for item in about(diagnostics, "far-node")]
    assert [(osm_id, kind) for osm_id, kind, _ in said] == [
        ("node/90", Kind.DROPPED),
        ("node/90", Kind.DROPPED),
        ("way/22", Kind.DROPPED),
    ]
    assert "km from its neighbours on way/20" in said[0][2]
    assert "km from node/8 to node/90 are left out" in said[2][2]


def test_ways_that_lie_on_each_other_by_the_kilometre_are_left_out(tmp_path: Path) -> None:
    # 300 streets of 100 m within 30 m, and one 1 km away.
    nodes = {1000 + 2 * k + end: (100.0 * end, 0.1 * k) for k in range(300) for end in (0, 1)}
    nodes |= {1: (1000.0, 0.0), 2: (1100.0, 0.0)}
    ways = {k: ([1000 + 2 * k, 1001 + 2 * k], ROAD) for k in range(300)}
    network, diagnostics = Area(nodes, {**ways, 999: ([1, 2], ROAD)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2]]
    assert {item.osm_id for item in about(diagnostics, "crowd")} == {f"way/{k}" for k in range(300)}


def test_more_streets_at_a_node_than_have_room_are_refused(tmp_path: Path) -> None:
    spokes = {k: (100.0 * math.cos(k), 100.0 * math.sin(k)) for k in range(1, 34)}
    area = Area({**spokes, 99: (0.0, 0.0)}, {k: ([99, k], ROAD) for k in spokes})
    with pytest.raises(InputError, match=r"33 streets meet at node/99"):
        area.parse(tmp_path)


@pytest.mark.parametrize("crossed", [False, True])
def test_thousands_of_kilometres_with_few_nodes_are_refused_but_where_streets_cross(
    tmp_path: Path, crossed: bool
) -> None:
    # 41 rows of 80 km, or a grid of streets every 1.6 km.
    rows, columns, step = (34, 60, 1600.0) if crossed else (41, 3, 40_000.0)
    nodes = {r * 100 + c + 1: (step * c, 1600.0 * r) for r in range(rows) for c in range(columns)}
    ways = {r + 1: ([r * 100 + c + 1 for c in range(columns)], ROAD) for r in range(rows)}
    if crossed:
        ways |= {100 + c: ([r * 100 + c + 1 for r in range(rows)], ROAD) for c in range(columns)}
        # At the corners two are one.
        assert len(Area(nodes, ways).parse(tmp_path)[0].streets) == 34 * 59 + 33 * 60 - 4
    else:
        with pytest.raises(InputError, match=r"3,2\d\d km of streets have far fewer nodes .* as on way/\d+; correct"):
            Area(nodes, ways).parse(tmp_path)


def way(number: int, nodes: str, tags: str = "") -> RawWay:
    """A reversible carriageway of a motorway from node to node, one letter each."""
    pairs = dict(item.split("=") for item in f"highway=motorway oneway=reversible {tags}".split())
    return RawWay(number, [ord(letter) for letter in nodes], pairs)


@pytest.mark.parametrize(
    ("ways", "turned"),
    [
        # They run on.
        ([way(1, "ab"), way(2, "bc")], []),
        # Head-on, and away from each other: the one with more nodes stays.
        ([way(1, "abc"), way(2, "dc")], [2]),
        ([way(1, "ba"), way(2, "bcd")], [1]),
        # Tags of a direction count more than nodes.
        ([way(1, "abcde"), way(2, "ge"), way(3, "hg", "turn:lanes:forward=through|right")], [1]),
        # A chain turns as a whole.
        ([way(1, "ab"), way(2, "bc"), way(3, "fedc")], [3]),
        # Ramps between them say nothing, and nor do ways with a known direction.
        ([way(1, "abc"), way(2, "dc"), way(3, "ce", "highway=motorway_link")], [2]),
        ([way(1, "abc"), way(2, "dc", "oneway=yes")], []),
        # Three of a class are no chain.
        ([way(1, "ab"), way(2, "cb"), way(3, "bd")], []),
    ],
)
def test_a_chain_has_one_direction(ways: list[RawWay], turned: list[int]) -> None:
    diagnostics = Diagnostics()
    found = with_one_flow(ways, diagnostics)
    assert [item.id for item in found if item.tags["oneway"] == "-1"] == turned
    assert [item.osm_id for item in diagnostics if item.kind is Kind.GUESSED] == [f"way/{k}" for k in turned]
