"""Ground that a surface model shows, told from what stands on it."""

from __future__ import annotations

import numpy as np
import pytest
from elevation_helpers import Ground, Height, solve, straight

from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.canopy import bare_runs, keep_ground
from osm2xodr.geometry.heights.solver import LEAST_FACTOR, Robust

ONE_ROAD = np.zeros(8, np.int64)
S = 5.0 * np.arange(8)


@pytest.mark.parametrize(
    ("z", "bare"),
    [
        ([0, 0, 12, 12, 12, 12, 0, 0], False),  # a wood
        ([0, 0, 1, 3, 3, 1, 0, 0], True),  # a hill
        ([0, 0, 2, 4, 4, 9, 8, 7], False),  # a wall at one end
        ([0, 0, 1, 2, 8, 2, 1, 0], False),  # a tree on a hill
        ([9, 9, 3, 3, 4, 3, 3, 3], False),  # a wall to what does not stand out
    ],
)
def test_what_stands_on_the_ground_has_walls(z: list[float], bare: bool) -> None:
    out = np.array([0, 0, 1, 1, 1, 1, 0, 0], bool)
    assert bare_runs(ONE_ROAD, S, np.array(z, np.float64), out).tolist() == (out & bare).tolist()


def test_walls_far_from_a_run_and_on_other_roads_are_not_its_own() -> None:
    road = np.array([0, 0, 0, 0, 1, 1, 1, 1])
    s = np.tile(5.0 * np.arange(4), 2)
    z = np.array([20.0, 0.0, 1.0, 2.0, 30.0, 31.0, 50.0, 50.0])
    out = np.array([0, 0, 1, 1, 1, 0, 1, 1], bool)
    assert bare_runs(road, s, z, out).tolist() == [False, False, True, True, True, False, False, False]


def test_no_heights() -> None:
    none = np.zeros(0)
    assert bare_runs(np.zeros(0, np.int64), none, none, np.zeros(0, bool)).tolist() == []


def test_ground_keeps_weight_and_gets_it_back() -> None:
    z = np.array([0.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 20.0])
    factors = np.array([1.0, 0.6, 0.1, 0.01, 0.01, 0.1, 0.9, 0.01, 0.5, 0.01])
    covered = np.array([1, 1, 1, 1, 1, 1, 1, 1, 1, 0], bool)
    robust = keep_ground(Robust(1.5, 8.0), factors, covered, ONE_ROAD, S, z)
    # The rise in the middle is the ground's; the tree at the end is not, nor is the last one a surface model's.
    assert factors.tolist() == [1.0, 0.6, 1.0, 1.0, 1.0, 1.0, 0.9, 0.01, 0.5, 0.01]
    kept, lost = defaults.COVERED_LEAST, LEAST_FACTOR
    assert np.asarray(robust.least).tolist() == [kept] * 7 + [lost, kept, lost]
    far = robust.factors(np.full(10, 1e3), np.ones(10), late=True)
    assert far.tolist() == [kept] * 7 + [lost, kept, lost]


@pytest.mark.parametrize(
    ("height", "length", "allowed"),
    [
        (lambda x, y: 0.12 * np.abs(x - 60.0), 400.0, 3.5),  # 10.6 m if ground may lose all its weight
        (lambda x, y: 16.0 * np.exp(-(((x - 200.0) / 45.0) ** 2)), 400.0, 7.2),  # 13.1 m
    ],
)
def test_bare_hills_and_dips_that_are_taken_for_a_surface_model(
    height: Height, length: float, allowed: float
) -> None:
    road = straight((0.0, 0.0), (length, 0.0))
    found = solve([road], Ground(height, cell_size=9.0, sigma=0.9, covered=True))
    _, x, y, z = found.along(0)
    assert np.abs(z - height(x, y)).max() < allowed
    # Not much farther off than where the model is known to show the ground.
    _, _, _, known = solve([road], Ground(height, cell_size=9.0, sigma=0.9)).along(0)
    assert np.abs(z - known).max() < 2.0
