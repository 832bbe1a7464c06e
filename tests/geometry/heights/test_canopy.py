"""Ground and canopy in surface models."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from elevation_helpers import Ground, Height, RoadSpec, cross, in_cells, solve, straight

from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.canopy import Stage, bare_runs, canopy_stages, downweight_canopy, restore_ground
from osm2xodr.geometry.heights.observations import FLOOR, Kind, Observations
from osm2xodr.geometry.heights.sparse import join_blocks
from osm2xodr.geometry.heights.stiffness import Beams
from osm2xodr.model import BoolArray, FloatArray

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


@pytest.mark.parametrize(("step", "rise", "bare"), [(2.5, 1.6, True), (2.5, 2.4, False), (7.0, 2.4, True)])
def test_walls_are_two_metres_high_and_steeper_than_half(step: float, rise: float, bare: bool) -> None:
    out = np.array([0, 1, 1, 0], bool)
    z = np.array([0.0, rise, rise, 0.0])
    assert bare_runs(ONE_ROAD[:4], step * np.arange(4), z, out).tolist() == (out & bare).tolist()


def test_no_heights() -> None:
    none = np.zeros(0)
    assert bare_runs(np.zeros(0, np.int64), none, none, np.zeros(0, bool)).tolist() == []


def observed(z: FloatArray, canopy: BoolArray, kind: Kind = Kind.ROAD_HEIGHT) -> Observations:
    """Return heights that each have an unknown of their own."""
    n = len(z)
    return Observations(
        sp.csr_matrix(np.eye(n)),
        z,
        weight=np.ones(n),
        sigma=np.ones(n),
        kind=np.full(n, kind, np.int64),
        above=np.full(n, 1.5),
        below=np.full(n, 8.0),
        canopy=canopy,
        floor=np.full(n, FLOOR),
    )


def test_ground_keeps_weight_and_gets_it_back() -> None:
    z = np.array([0.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 20.0])
    factors = np.array([1.0, 0.6, 0.1, 0.01, 0.01, 0.1, 0.9, 0.01, 0.5, 0.01])
    canopy = np.array([1, 1, 1, 1, 1, 1, 1, 1, 1, 0], bool)
    blocks = [observed(z, canopy[:8]), observed(np.zeros(2), canopy[8:], Kind.JUNCTION_HEIGHT)]
    found, factors = restore_ground(join_blocks(blocks, 8), factors, ONE_ROAD, S, z)
    # The rise in the middle is the ground's; the tree at the end is not, nor is the last one a surface model's.
    assert factors.tolist() == [1.0, 0.6, 1.0, 1.0, 1.0, 1.0, 0.9, 0.01, 0.5, 0.01]
    kept, lost = defaults.CANOPY_GROUND_FLOOR, FLOOR
    assert found.floor.tolist() == [kept] * 7 + [lost, kept, lost]
    far = found.robust_factors(np.full(10, 1e3), np.ones(10), geman_mcclure=True)
    # Huber's loss of bare ground: 1.5 standard errors of 1000.
    assert far == pytest.approx([kept] * 7 + [lost, kept, 1.5e-3])


def test_stages_give_way_over_shorter_and_shorter_lengths() -> None:
    beams = Beams(np.array([5e-5, 1e-12]), np.array([0.05, 0.05]))
    seen: list[FloatArray] = []

    def stiffness(flexibility: FloatArray) -> sp.csr_matrix:
        seen.append(flexibility)
        return sp.csr_matrix((1, 1))

    stages = list(canopy_stages(beams, stiffness))
    assert [stage.tolerance for stage in stages] == [3.0, 1.0, 0.5]
    lengths = [(0.05 * flexibility[0]) ** -0.25 for flexibility in seen]
    assert lengths == pytest.approx([150.0, 80.0, 40.0])
    # A road that is stiffer by itself stays as stiff.
    assert [flexibility[1] for flexibility in seen] == [1e-12] * 3


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
    assert np.abs(z - known).max() < 4.0


def rolling(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(100.0 + 12.0 * np.sin(x / 120.0) + 0.03 * x)


def canopy(x: FloatArray, seed: int, cell: float = 5.0) -> FloatArray:
    """Return crowns 15 m high in patches of 20 to 100 m with gaps as long, as cells show them."""
    rng = np.random.default_rng(seed)
    out, s = np.zeros(len(x)), 60.0
    while s < 1100.0:
        end = s + rng.uniform(20.0, 100.0)
        out = np.maximum(out, 15.0 * np.clip(np.minimum(x - s, end - x) / cell + 0.5, 0.0, 1.0))
        s = end + rng.uniform(20.0, 100.0)
    return out


@pytest.mark.parametrize("seed", range(6))
def test_road_through_a_wood_lies_on_the_ground(seed: int) -> None:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return rolling(x, y) + canopy(x, seed) + in_cells(x, 5.0, seed, 0.1)

    road = straight((0.0, 0.0), (1200.0, 0.0))
    found = solve([road], Ground(height, 5.0, 0.5, covered=True))
    _, x, y, z = found.along(0)
    assert np.abs(z - rolling(x, y)).max() < 0.5
    # Heights that are taken for the ground's own lead into the crowns.
    trusted = solve([road], Ground(height, 5.0, 0.5))
    assert np.abs(trusted.along(0)[3] - rolling(x, y)).max() > 3.0


def test_streets_between_houses_lie_on_the_ground() -> None:
    # Blocks of 18 m: roofs lie over the street where the houses stand forward, on 30 m of each 90 m.
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        along, across = np.where(np.abs(y) < np.abs(x), x, y), np.where(np.abs(y) < np.abs(x), y, x)
        forward = (np.mod(along, 90.0) > 30.0) & (np.mod(along, 90.0) < 60.0) & (np.abs(along) > 25.0)
        roof = (np.abs(across) > 8.0) & (np.abs(along) > 8.0)
        return np.asarray(0.02 * x + np.where(forward | roof, 18.0, 0.0))

    found = solve(cross(angle=0.0), Ground(height, 2.0, 0.3, covered=True), [(0.0, 0.0)])
    for road in range(4):
        _, x, _, z = found.along(road)
        assert np.abs(z - 0.02 * x).max() < 0.5


def test_bare_ground_that_is_taken_for_a_surface_model_is_still_followed() -> None:
    found = solve([straight((0.0, 0.0), (1200.0, 0.0))], Ground(rolling, 5.0, 0.5, covered=True))
    _, x, y, z = found.along(0)
    assert np.abs(z - rolling(x, y)).max() < 0.4


def test_heights_on_a_roof_lose_their_weight_on_a_stiff_road_only() -> None:
    # Heights of 9 places, three of them on a roof; a stiff road has one height, a soft one a height for each place.
    z = np.array([0.0, 0.0, 0.0, 10.0, 10.0, 10.0, 0.0, 0.0, 0.0])
    n = len(z)
    observations = observed(z, np.ones(n, bool))
    difference = np.diff(np.eye(n), axis=0)
    stiff, soft = (sp.csr_matrix(k * difference.T @ difference) for k in (1e6, 1e-6))
    assert downweight_canopy([Stage(stiff, 0.5)], observations)[3:6].max() < 0.05
    assert downweight_canopy([Stage(stiff, 0.5)], observations)[[0, 8]].min() > 0.9
    assert downweight_canopy([Stage(soft, 0.5)], observations).min() > 0.99


def test_only_heights_of_surface_models_lose_weight_to_canopy() -> None:
    z = np.array([0.0, 0.0, 10.0, 0.0, 10.0, 0.0])
    canopy = np.array([1, 1, 1, 1, 0, 1], bool)
    difference = np.diff(np.eye(6), axis=0)
    stage = Stage(sp.csr_matrix(1e6 * difference.T @ difference), 0.5)
    factors = downweight_canopy([stage], observed(z, canopy))
    assert factors[2] < 0.05
    assert factors[4] == 1.0


def test_ring_in_a_wood() -> None:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        z: FloatArray = np.where(np.hypot(x - 50.0, y) < 30.0, 15.0, 0.0) + 0.01 * y
        return z

    ring = RoadSpec(0.0, -50.0, 0.0, 2 * np.pi * 50.0, curvature=0.02, start_link=1, end_link=0)
    found = solve([ring], Ground(height, 5.0, 0.5, covered=True))
    _, _, y, z = found.along(0)
    assert np.abs(z - 0.01 * y).max() < 0.5
