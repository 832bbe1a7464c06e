"""Corrections of junctions: nodes joined and kept apart, and U-turns that are left out."""

from __future__ import annotations

import pytest
from corrected_cases import build_corrected, node_of, said
from dual_carriageways import dual
from street_cases import Case

from osm2xodr.model import NodeCorrection, RoadMap, WayCorrection


def two_crossings(apart: float) -> Case:
    """Make a street with two others that cross it, so far apart, m."""
    nodes = {"w": (-90.0, 0.0), "a": (0.0, 0.0), "b": (apart, 0.0), "e": (apart + 90.0, 0.0)}
    nodes |= {"s": (0.0, -90.0), "n": (0.0, 90.0), "t": (apart, -90.0), "m": (apart, 90.0)}
    ways = {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("s a", ""), 5: ("a n", "")}
    return Case(nodes, ways | {6: ("t b", ""), 7: ("b m", "")})


def junctions(case: Case, road_map: RoadMap) -> set[frozenset[str]]:
    """Return the nodes of each junction by name."""
    names = {node_of(case, name): name for name in case.nodes}
    return {frozenset(names[node] for node in item.osm_node_ids) for item in road_map.junctions}


def test_nodes_are_joined() -> None:
    case = two_crossings(60.0)
    road_map, _ = build_corrected(case)
    assert junctions(case, road_map) == {frozenset("a"), frozenset("b")}
    road_map, found = build_corrected(case, nodes={"a": NodeCorrection(join=(node_of(case, "b"),))})
    assert junctions(case, road_map) == {frozenset("ab")}
    assert said(found) == {("node/1002", "join"): (True, "one junction with node/1003")}
    # The street between them is no road any longer; ways over it are.
    assert all(2 not in road.osm_way_ids for road in road_map.roads if road.junction is None)


@pytest.mark.parametrize(
    ("others", "why"),
    [((9,), "no streets meet at node/9"), (("e",), "no streets meet at node/1004"), (("c",), "no street leads from")],
)
def test_nodes_that_no_street_connects_are_not_joined(others: tuple[str | int, ...], why: str) -> None:
    case = two_crossings(60.0)
    nodes = dict(case.nodes) | {"c": (300.0, 0.0), "d": (300.0, 90.0), "f": (390.0, 0.0), "g": (300.0, -90.0)}
    case = Case(nodes, dict(case.ways) | {8: ("c d", ""), 9: ("c f", ""), 10: ("g c", "")})
    ids = tuple(node_of(case, item) if isinstance(item, str) else item for item in others)
    road_map, found = build_corrected(case, nodes={"a": NodeCorrection(join=ids)})
    assert len(road_map.junctions) == 3
    applied, text = said(found)["node/1002", "join"]
    assert not applied
    assert text.startswith(why)


@pytest.mark.parametrize("both", [False, True])
def test_nodes_are_kept_apart(both: bool) -> None:
    case = two_crossings(9.0)
    road_map, _ = build_corrected(case)
    assert junctions(case, road_map) == {frozenset("ab")}
    known = NodeCorrection(split_all=True) if both else NodeCorrection(split=(node_of(case, "b"),))
    road_map, found = build_corrected(case, nodes={"a": known})
    assert junctions(case, road_map) == {frozenset("a"), frozenset("b")}
    others = "all others" if both else "node/1003"
    assert said(found) == {("node/1002", "split"): (True, f"kept apart from {others}")}
    assert any(road.osm_way_ids == (2,) for road in road_map.roads if road.junction is None)


@pytest.mark.parametrize(("apart", "node", "why"), [(60.0, "a", "nothing would join it"), (60.0, "e", "no junction")])
def test_a_split_of_what_is_apart_changes_nothing(apart: float, node: str, why: str) -> None:
    case = two_crossings(apart)
    _, found = build_corrected(case, nodes={node: NodeCorrection(split_all=True)})
    ((applied, text),) = said(found).values()
    assert not applied
    assert text.startswith(why)


def u_turns(road_map: RoadMap) -> set[tuple[int, int]]:
    """Return from which way onto which carriageways' U-turns lead."""
    ways = {road.id: road.osm_way_ids for road in road_map.roads}
    found = set()
    for junction in road_map.junctions:
        for item in junction.connections:
            through = next(road for road in road_map.roads if road.id == item.connecting_road)
            assert through.successor is not None
            found.add((ways[item.incoming_road][0], ways[through.successor.id][0]))
    return found & {(2, 1), (3, 4)}


def test_u_turns_are_left_out_at_a_node_or_from_a_way() -> None:
    case = dual(12.0, "lanes=1 width=3")
    assert u_turns(build_corrected(case)[0]) == {(2, 1), (3, 4)}
    road_map, found = build_corrected(case, nodes={"o1": NodeCorrection(no_u_turn=True)})
    assert said(found)[f"node/{node_of(case, 'o1')}", "no-u-turn"][0]
    assert u_turns(road_map) == set()
    road_map, found = build_corrected(case, {3: WayCorrection(no_u_turn=True), 5: WayCorrection(no_u_turn=True)})
    assert u_turns(road_map) == {(2, 1)}
    assert {element: applied for (element, _), (applied, _) in said(found).items()} == {"way/3": True, "way/5": False}


def test_what_the_option_leaves_out_needs_no_correction() -> None:
    case = dual(12.0, "lanes=1 width=3")
    _, found = build_corrected(case, nodes={"o1": NodeCorrection(no_u_turn=True)}, u_turns="none")
    assert said(found) == {
        (f"node/{node_of(case, 'o1')}", "no-u-turn"): (False, "no U-turn is kept there that could be left out")
    }
