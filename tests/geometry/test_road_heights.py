"""Heights from tags."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from elevation_helpers import plan_view, straight

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.heights import ProfileSolution
from osm2xodr.geometry.road_heights import _tagged_heights, too_steep_corners
from osm2xodr.model import LocalFrame, Rule, Street, StreetNetwork


def network(heights: dict[int, float]) -> StreetNetwork:
    street = Street(0, -1, -1, np.array([[0.0, 0.0], [100.0, 0.0], [200.0, 0.0]]), np.array([1, 2, 3], np.int64), ())
    frame = LocalFrame("+proj=tmerc", 0.0, 0.0)
    return StreetNetwork(
        frame, Rule.RIGHT_HAND, "DE", (street,), (), (), {}, (0.0, 0.0, 1.0, 1.0), node_heights=heights
    )


def test_heights_lie_where_their_nodes_are() -> None:
    # The street became two roads with a junction from 140 to 160 between them; the last one is cut at 190.
    curves = plan_view([straight((0.0, 0.0), (140.0, 0.0)), straight((160.0, 0.0), (190.0, 0.0))])
    road, s, z = _tagged_heights(network({2: 20.0, 3: 31.0, 77: 5.0}), curves, np.array([0, 0]))
    assert (road.tolist(), z.tolist()) == ([0, 1], [20.0, 31.0])
    assert s == pytest.approx([100.0, 30.0], abs=1.0)


def test_corners_are_too_steep_beyond_what_connecting_roads_may_be() -> None:
    # Steepest half-way: 1.5 times 2 m over 8 m, and over 12 m, and against arms that are as steep themselves.
    # The last one is as the second, but for 0.15 rad across that make it 1 m higher: its sidewalk lies 6.7 m aside.
    corners = SimpleNamespace(
        entry=np.array([1, 1, 5, 9]),
        exit=np.array([2, 2, 6, 10]),
        entry_t=np.zeros(4),
        exit_t=np.array([0.0, 0.0, 0.0, 6.7]),
        length=np.array([8.0, 12.0, 6.5, 12.0]),
    )
    level, steep, across = np.zeros((2, 2)), np.array([[0.4, 0.4], [0.0, 0.0]]), np.zeros((6, 2))
    across[5, 0] = 0.15
    solution = SimpleNamespace(
        end_z=np.array([[0.0, 10.0], [12.0, 0.0]] * 3),
        end_grade=np.vstack([level, steep, level]),
        end_superelevation=across,
    )
    found = too_steep_corners(cast(ConnectingRoads, corners), cast(ProfileSolution, solution))
    assert found.tolist() == [True, False, False, True]
