"""Some roads of a network as a problem of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from elevation_helpers import RoadSpec, connector_between, make_problem, straight

from osm2xodr.geometry.heights import ProfileProblem, chosen_roads


def four_roads() -> tuple[list[RoadSpec], ProfileProblem]:
    roads = [
        straight((0.0, 0.0), (100.0, 0.0), end=0, highway="primary", grade=0.01, name=3),
        straight((500.0, 0.0), (600.0, 0.0)),
        straight((110.0, 0.0), (200.0, 0.0), start=0, end_link=6, spans=((0.0, 0, 0), (20.0, 1, 1))),
        straight((200.0, 0.0), (300.0, 0.0), start_link=5, end=1),
    ]
    return roads, make_problem(roads, [(105.0, 0.0), (310.0, 0.0)])


def test_some_roads_make_the_problem_that_they_would_make_alone() -> None:
    roads, problem = four_roads()
    part = chosen_roads(problem, np.array([0, 2], np.int64))
    alone = make_problem([roads[0], replace(roads[2], end_link=-1)], [(105.0, 0.0)])
    for name in ("end_junction", "end_link", "junction_xy", "span_start", "span_s", "span_structure", "span_layer"):
        np.testing.assert_array_equal(getattr(part, name), getattr(alone, name))
    assert part.span_highway == alone.span_highway
    assert part.span_way.tolist() == [100, 102, 103]
    for name in ("start", "s", "x", "y", "hdg", "length", "curvature"):
        np.testing.assert_array_equal(getattr(part.plan_view, name), getattr(alone.plan_view, name))


def test_connecting_roads_between_them_come_along() -> None:
    connector = connector_between((100.0, 0.0), (110.0, 0.0), (1, 4))
    problem = replace(
        four_roads()[1], connectors=connector, carried=np.array([True, False]), warped=np.array([False, True])
    )
    part = chosen_roads(problem, np.array([0, 2], np.int64))
    assert part.connectors is not None
    assert part.carried is not None
    assert part.connectors.start_end.tolist() == [1]
    assert part.connectors.end_end.tolist() == [2]
    assert part.connectors.junction.tolist() == [0]
    assert part.carried.tolist() == [True]
    assert part.warped is not None
    assert part.warped.tolist() == [False]
    other = chosen_roads(problem, np.array([2, 3], np.int64))
    assert other.connectors is not None
    assert len(other.connectors.junction) == 0
    assert other.end_link.tolist() == [[-1, 2], [1, -1]]
