"""How far along a polyline its points are."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves import running_lengths


def test_running_lengths_adds_up_what_lies_between_points() -> None:
    points = np.array([[1.0, 1.0], [4.0, 5.0], [4.0, 5.0], [16.0, 0.0]])
    np.testing.assert_array_equal(running_lengths(points), [0.0, 5.0, 5.0, 18.0])


def test_one_point_is_at_the_start() -> None:
    np.testing.assert_array_equal(running_lengths(np.array([[7.0, 8.0]])), [0.0])
