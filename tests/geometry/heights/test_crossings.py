"""Crossings of layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import RoadSpec, make_problem, straight

from osm2xodr.geometry.heights.crossings import Crossings, find_crossings
from osm2xodr.geometry.heights.elements import build_elements, number_unknowns


def crossings(roads: list[RoadSpec], junctions: list[tuple[float, float]] = []) -> Crossings:  # noqa: B006
    problem = make_problem(roads, junctions)
    return find_crossings(problem, number_unknowns(problem, build_elements(problem, 60.0)).end_node)


def test_bridge_over_a_road_is_found_once() -> None:
    found = crossings(
        [
            straight((-100.0, 3.0), (100.0, 3.0), spans=[(0.0, 0, 0), (60.0, 1, 1), (140.0, 0, 0)]),
            straight((7.0, 100.0), (7.0, -100.0)),
        ]
    )
    assert (found.upper.tolist(), found.lower.tolist()) == ([0], [1])
    assert found.upper_s == pytest.approx([107.0])
    assert found.lower_s == pytest.approx([97.0])


def test_tunnel_under_a_bridge_is_found_once() -> None:
    found = crossings(
        [
            straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 2, -1)]),
            straight((0.0, 100.0), (0.0, -100.0), spans=[(0.0, 1, 1)]),
        ]
    )
    assert (found.upper.tolist(), found.lower.tolist()) == ([1], [0])


@pytest.mark.parametrize("layers", [(0, 0), (1, 1)])
def test_same_layer_is_no_crossing(layers: tuple[int, int]) -> None:
    found = crossings(
        [
            straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, layers[0])]),
            straight((0.0, 100.0), (0.0, -100.0), spans=[(0.0, 0, layers[1])]),
        ]
    )
    assert len(found.upper) == 0


def test_layer_without_structure_is_no_crossing() -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 0, 2)]),
        straight((0.0, 100.0), (0.0, -100.0), spans=[(0.0, 1, 1)]),
    ]
    assert len(crossings(roads).upper) == 0


def test_roads_that_meet_nearby_do_not_cross() -> None:
    roads = [
        straight((-1.0, 0.5), (100.0, 0.5), start=0, spans=[(0.0, 1, 1)]),
        straight((0.0, -1.0), (0.0, 100.0), start=0),
        straight((0.0, -5.0), (5.0, -100.0), start=0),
    ]
    assert len(crossings(roads, [(0.0, 0.0)]).upper) == 0


def decks(aside: float, end: int = -1, bridge: float = 0.0) -> Crossings:
    """Return where a bridge beside a road of its own length passes over it; both 8 m wide.

    The bridge begins and ends `bridge` m from its road's ends.
    """
    spans = [(0.0, 1, 1)] if not bridge else [(0.0, 0, 0), (bridge, 1, 1), (240.0 - bridge, 0, 0)]
    roads = [
        straight((0.0, 0.0), (240.0, 0.0), start=end, spans=[(0.0, 0, 0)]),
        straight((240.0, aside), (0.0, aside), end=end, spans=spans),
    ]
    problem = replace(make_problem(roads, [(0.0, 0.0)] if end >= 0 else []), span_width=np.full(1 + len(spans), 8.0))
    return find_crossings(problem, number_unknowns(problem, build_elements(problem, 60.0)).end_node)


def test_decks_one_above_the_other_are_apart_all_along() -> None:
    found = decks(1.5)
    assert set(found.upper.tolist()) == {1}
    assert set(found.lower.tolist()) == {0}
    assert found.upper_s + found.lower_s == pytest.approx(240.0)
    assert np.diff(np.sort(found.lower_s)).max() <= 12.0 + 1e-9
    assert (found.lower_s.min() < 12.0, found.lower_s.max() > 228.0) == (True, True)


def test_roads_beside_each_other_and_ramps_are_not_decks() -> None:
    assert len(decks(7.0).upper) == 0
    assert len(decks(1.5, end=0).upper) == 0


@pytest.mark.parametrize("bridge", [0.0, 60.0])
def test_deck_over_the_edge_of_a_road_is_above_it_but_at_its_ends(bridge: float) -> None:
    # Of 8 m each 3 m lie above each other; near its ends a bridge may as well lie beside the road.
    found = decks(5.0, bridge=bridge)
    assert set(found.upper.tolist()) == {1}
    assert found.upper_s + found.lower_s == pytest.approx(240.0)
    assert found.upper_s.min() == pytest.approx(bridge + 42.0, abs=12.0)
    assert found.upper_s.max() == pytest.approx(198.0 - bridge, abs=12.0)
    assert np.diff(np.sort(found.lower_s)).max() <= 12.0 + 1e-9


def test_clearance_by_class() -> None:
    roads = [
        straight((-100.0, 0.0), (100.0, 0.0), spans=[(0.0, 1, 1)]),
        straight((-50.0, -100.0), (-50.0, 100.0), highway="motorway_link"),
        straight((0.0, -100.0), (0.0, 100.0), highway="tertiary"),
        straight((50.0, -100.0), (50.0, 100.0), highway="track"),
    ]
    found = crossings(roads)
    assert dict(zip(found.lower.tolist(), found.clearance.tolist(), strict=True)) == {1: 5.4, 2: 5.2, 3: 4.2}
