"""Crossings of layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import RoadSpec, connector_between, make_problem, straight

from osm2xodr.geometry.heights import ProfileProblem
from osm2xodr.geometry.heights.crossings import Crossings, find_crossings
from osm2xodr.geometry.heights.elements import build_elements, number_unknowns
from osm2xodr.geometry.heights.problem import connector_spans


def crossings(roads: list[RoadSpec], junctions: list[tuple[float, float]] = []) -> Crossings:  # noqa: B006
    problem = make_problem(roads, junctions)
    return find(problem)


def find(problem: ProfileProblem) -> Crossings:
    return find_crossings(problem, number_unknowns(problem, build_elements(problem, 60.0)).end_node)[0]


def test_bridge_over_a_road_is_one_place_with_its_corners() -> None:
    found = crossings(
        [
            straight((-100.0, 3.0), (100.0, 3.0), spans=[(0.0, 0, 0), (60.0, 1, 1), (140.0, 0, 0)]),
            straight((7.0, 100.0), (7.0, -100.0)),
        ]
    )
    assert (set(found.upper.tolist()), set(found.lower.tolist())) == ({0}, {1})
    assert set(found.place.tolist()) == {0}
    # Both are 6 m wide, and cut into pieces of 4 m.
    assert (found.upper_s.min(), found.upper_s.max()) == pytest.approx((107.0, 107.0), abs=5.0)
    assert (found.lower_s.min(), found.lower_s.max()) == pytest.approx((97.0, 97.0), abs=5.0)
    assert np.ptp(found.upper_s) >= 4.0
    assert np.ptp(found.lower_s) >= 4.0
    assert 4 <= len(found.upper) <= 5
    assert found.xy == pytest.approx(np.tile([7.0, 3.0], (len(found.xy), 1)), abs=4.0)


def test_tunnel_under_a_bridge_is_found_once() -> None:
    found = crossings(
        [
            straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 2, -1)]),
            straight((0.0, 100.0), (0.0, -100.0), spans=[(0.0, 1, 1)]),
        ]
    )
    assert (set(found.upper.tolist()), set(found.lower.tolist())) == ({1}, {0})
    assert set(found.place.tolist()) == {0}


@pytest.mark.parametrize("layer", [-1, 0, 1])
def test_in_one_layer_bridges_are_above_the_ground_and_tunnels_below(layer: int) -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, layer)]),
        straight((-50.0, 100.0), (-50.0, -100.0), spans=[(0.0, 0, layer)]),
        straight((50.0, 100.0), (50.0, -100.0), spans=[(0.0, 2, layer)]),
    ]
    found = crossings(roads)
    assert set(zip(found.upper.tolist(), found.lower.tolist(), strict=True)) == {(0, 1), (0, 2)}


@pytest.mark.parametrize("structure", [0, 1, 2])
def test_structures_of_one_layer_cross_and_the_ground_does_not(structure: int) -> None:
    spans = [(0.0, structure, 1)]
    roads = [straight((-100.0, 0.0), (100.0, 0.0), spans=spans), straight((0.0, 100.0), (0.0, -100.0), spans=spans)]
    found = crossings(roads)
    assert (len(found.upper) > 0) == (structure != 0)
    # Side by side none of them passes over the other.
    roads[1] = straight((-100.0, 4.0), (100.0, 4.0), spans=spans)
    assert len(crossings(roads).upper) == 0


def test_layers_that_overlap_beside_their_node_are_level_there() -> None:
    roads = [
        straight((-1.0, 0.5), (100.0, 0.5), start=0, spans=[(0.0, 2, 0)]),
        straight((0.0, 0.0), (100.0, 30.0), start=0),
    ]
    problem = make_problem(roads, [(0.0, 0.0)])
    passing, meets = find_crossings(problem, number_unknowns(problem, build_elements(problem, 60.0)).end_node)
    assert len(passing.upper) == 0
    assert (set(meets.upper.tolist()), set(meets.lower.tolist())) == ({1}, {0})
    assert meets.upper_s.max() < 25.0
    # What only touches it by its side is left alone.
    roads[1] = straight((0.0, 6.0), (100.0, 36.0), start=0)
    problem = make_problem(roads, [(0.0, 0.0)])
    assert (
        len(find_crossings(problem, number_unknowns(problem, build_elements(problem, 60.0)).end_node)[1].upper) == 0
    )


def test_layer_goes_before_structure() -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 0, 2)]),
        straight((0.0, 100.0), (0.0, -100.0), spans=[(0.0, 1, 1)]),
        straight((50.0, 100.0), (50.0, -100.0)),
    ]
    found = crossings(roads)
    # Way 0 has neither bridge nor tunnel: what crosses in another layer passes below all the same.
    assert set(zip(found.upper.tolist(), found.lower.tolist(), strict=True)) == {(0, 1), (0, 2)}


def test_roads_that_meet_nearby_do_not_cross() -> None:
    roads = [
        straight((-1.0, 0.5), (100.0, 0.5), start=0, spans=[(0.0, 1, 1)]),
        straight((0.0, -1.0), (0.0, 100.0), start=0),
        straight((0.0, -5.0), (5.0, -100.0), start=0),
    ]
    assert len(crossings(roads, [(0.0, 0.0)]).upper) == 0


def arms_below(bridge: int, layer: int = 1) -> ProfileProblem:
    """Return a bridge, or what else it is, over the connecting road 3 of a junction whose arms end short of it."""
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, bridge, layer)]),
        straight((0.0, -100.0), (0.0, -12.0), end=0, highway="motorway"),
        straight((0.0, 12.0), (0.0, 100.0), start=0, highway="motorway"),
    ]
    connectors = connector_between((0.0, -12.0), (0.0, 12.0), (3, 4))
    return replace(make_problem(roads, [(0.0, 0.0)]), connectors=connectors)


def test_connecting_road_is_crossed_as_its_arms_are() -> None:
    found = find(arms_below(bridge=1))
    assert (set(found.upper.tolist()), set(found.lower.tolist())) == ({0}, {3})
    assert set(found.clearance.tolist()) == {5.4}
    # 3.5 m of it lie below 6 m of the bridge.
    assert found.upper_s == pytest.approx(np.full(len(found.upper_s), 100.0), abs=4.0)
    assert found.lower_s == pytest.approx(np.full(len(found.lower_s), 12.0), abs=5.0)
    assert len(find(arms_below(bridge=0, layer=0)).upper) == 0


@pytest.mark.parametrize(("structure", "layer", "above"), [(1, 1, True), (2, -1, False)])
def test_connecting_road_passes_what_has_no_node_with_it_as_its_other_arm_does(
    structure: int, layer: int, above: bool
) -> None:
    # Both roads are on the ground where they cross, and one arm of the junction is a bridge or a tunnel.
    problem = arms_below(bridge=0, layer=0)
    spans = (np.array([0, 0, value], np.int64) for value in (structure, layer))
    problem = replace(problem, span_structure=next(spans), span_layer=next(spans))
    found = find(problem)
    assert set(found.upper.tolist()) == ({3} if above else {0})
    assert set(found.lower.tolist()) == ({0} if above else {3})


def test_road_does_not_cross_the_connecting_roads_of_its_own_end() -> None:
    problem = arms_below(bridge=1)
    end = problem.end_junction.copy()
    end[0, 1] = 0
    # The bridge ends 10 m beyond the connecting road, at the same junction.
    plan = replace(problem.plan_view, length=np.array([110.0, 88.0, 88.0]))
    assert len(find(replace(problem, end_junction=end, plan_view=plan)).upper) == 0


@pytest.mark.parametrize("ends", [(3, 0), (0, 3)])
def test_connecting_road_from_a_bridge_to_the_ground_is_on_the_ground(ends: tuple[int, int]) -> None:
    roads = [
        straight((0.0, 5.0), (0.0, 50.0), start=0, spans=[(0.0, 1, 2)]),
        straight((0.0, -50.0), (0.0, -5.0), end=0),
    ]
    problem = make_problem(roads, [(0.0, 0.0)])
    problem = replace(problem, connectors=connector_between((0.0, 5.0), (0.0, -5.0), ends))
    assert problem.span_layer[connector_spans(problem)].tolist() == [0]


def decks(aside: float, end: int = -1, bridge: float = 0.0) -> Crossings:
    """Return where a bridge beside a road of its own length passes over it; both 8 m wide.

    The bridge begins and ends `bridge` m from its road's ends.
    """
    spans = [(0.0, 1, 1)] if not bridge else [(0.0, 0, 0), (bridge, 1, 1), (240.0 - bridge, 0, 0)]
    roads = [
        straight((0.0, 0.0), (240.0, 0.0), start=end, spans=[(0.0, 0, 0)]),
        straight((240.0, aside), (0.0, aside), end=end, spans=spans),
    ]
    problem = make_problem(roads, [(0.0, 0.0)] if end >= 0 else [])
    return find(replace(problem, span_width=np.full(1 + len(spans), 8.0)))


def test_decks_one_above_the_other_are_apart_all_along() -> None:
    found = decks(1.5)
    assert (set(found.upper.tolist()), set(found.lower.tolist())) == ({1}, {0})
    assert found.upper_s + found.lower_s == pytest.approx(240.0, abs=4.1)
    assert np.diff(np.sort(found.lower_s)).max() <= 12.0 + 1e-9
    assert (found.lower_s.min() < 12.0, found.lower_s.max() > 228.0) == (True, True)
    assert set(found.place.tolist()) == {0}


def test_roads_beside_each_other_and_ramps_are_not_decks() -> None:
    assert len(decks(7.9).upper) == 0
    assert len(decks(1.5, end=0).upper) == 0


@pytest.mark.parametrize("aside", [5.0, 7.5])
@pytest.mark.parametrize("bridge", [0.0, 60.0])
def test_deck_over_the_edge_of_a_road_is_above_it_but_at_its_ends(bridge: float, aside: float) -> None:
    # Both are 8 m wide; near its ends a bridge may as well lie beside the road.
    found = decks(aside, bridge=bridge)
    assert (set(found.upper.tolist()), set(found.lower.tolist())) == ({1}, {0})
    assert found.upper_s + found.lower_s == pytest.approx(240.0, abs=4.1)
    assert found.upper_s.min() == pytest.approx(bridge + 27.0, abs=4.0)
    assert found.upper_s.max() == pytest.approx(213.0 - bridge, abs=4.0)
    assert np.diff(np.sort(found.lower_s)).max() <= 12.0 + 1e-9


def test_clearance_by_the_sign_on_the_road_below() -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, 1)]),
        straight((-50.0, -100.0), (-50.0, 100.0), highway="motorway"),
        straight((0.0, -100.0), (0.0, 100.0), highway="motorway"),
        straight((50.0, -100.0), (50.0, 100.0), highway="motorway"),
    ]
    found = find(replace(make_problem(roads), span_max_height=np.array([2.0, 3.2, 5.5, np.nan])))
    wanted = dict(zip(found.lower.tolist(), found.clearance.tolist(), strict=True))
    assert wanted == pytest.approx({1: 3.9, 2: 6.2, 3: 5.4})


def test_clearance_by_class() -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, 1)]),
        straight((-50.0, -100.0), (-50.0, 100.0), highway="motorway_link"),
        straight((0.0, -100.0), (0.0, 100.0), highway="tertiary"),
        straight((50.0, -100.0), (50.0, 100.0), highway="track"),
    ]
    found = crossings(roads)
    assert dict(zip(found.lower.tolist(), found.clearance.tolist(), strict=True)) == {1: 5.4, 2: 5.2, 3: 4.2}
