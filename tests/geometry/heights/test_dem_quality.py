"""Heights from models of different quality: fine beside coarse, and surfaces that stand on canopy and roofs."""

from __future__ import annotations

import numpy as np
import pytest
from elevation_helpers import Ground, RoadSpec, cross, make_problem, solve, straight

from osm2xodr.geometry.heights.elements import build_elements, build_samples
from osm2xodr.geometry.heights.readings import road_spacing, typical_density
from osm2xodr.geometry.heights.solver import Observations, Robust, Stage, see_through
from osm2xodr.model import FloatArray


def rolling(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(100.0 + 12.0 * np.sin(x / 120.0) + 0.03 * x)


def in_cells(x: FloatArray, cell: float, seed: int, sigma: float) -> FloatArray:
    """Return noise of independent cells along x, interpolated between their centres."""
    nodes = sigma * np.random.default_rng(seed).standard_normal(4000)
    return np.interp(x / cell, np.arange(-2000.0, 2000.0), nodes)


def mosaic(seed: int = 1) -> Ground:
    """A laser model of 1 m west of 0, a global one of 30 m east of it; both of one plane."""

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        fine, coarse = in_cells(x, 1.0, seed, 0.1), in_cells(x, 30.0, seed + 1, 3.0)
        return np.asarray(0.02 * x + np.where(x < 0, fine, coarse * np.clip(x / 60.0, 0.0, 1.0)))

    return Ground(
        height,
        cell_size=30.0,
        sigma=3.0,
        cells=lambda x, y: np.where(x < 0, 1.0, 30.0),
        sigmas=lambda x, y: np.where(x < 0, 0.1, 3.0),
    )


def test_roads_are_cut_as_finely_as_the_finest_model_along_them() -> None:
    roads = [
        straight((-600.0, 0.0), (-100.0, 0.0)),
        straight((100.0, 0.0), (600.0, 0.0)),
        straight((-200.0, 9.0), (600.0, 9.0)),
    ]
    problem = make_problem(roads)
    spacing = road_spacing(problem, mosaic())
    assert spacing.cell.tolist() == [1.0, 30.0, 1.0]
    assert spacing.knots.tolist() == [12.0, 60.0, 12.0]
    assert spacing.samples.tolist() == [3.0, 20.0, 3.0]
    elements = build_elements(problem, spacing.knots)
    assert np.bincount(elements.road).tolist() == [42, 9, 67]
    samples = build_samples(problem, elements, spacing.samples)
    assert samples.ds[elements.road[samples.element] == 1].max() <= 20.0
    assert samples.ds[elements.road[samples.element] == 0].max() <= 3.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_fine_heights_are_followed_and_coarse_ones_smoothed(seed: int) -> None:
    found = solve([straight((-600.0, 0.0), (600.0, 0.0))], mosaic(seed))
    s, x, _, z = found.along(0)
    error = z - 0.02 * x
    assert np.abs(error[x < -30.0]).max() < 0.15
    assert float(np.sqrt(np.mean(error[x > 0.0] ** 2))) < 2.0
    grade = found.grade(0, s) - 0.02
    assert np.abs(grade[x < -60.0]).max() < 0.03
    assert np.abs(grade).max() < 0.05


def test_what_is_usual_is_told_apart_by_cell_size() -> None:
    from osm2xodr.geometry.heights.readings import Reading

    n = np.ones(4)
    cell = np.array([1.0, 1.0, 30.0, 30.0])
    reading = Reading(n, n, np.array([0.1, 0.1, 2.0, 2.0]), 10 * n, cell, n > 0, n < 0)
    assert typical_density(reading, np.array([1.02, 29.5])) == pytest.approx([10.0, 0.025])


def test_step_between_two_models_becomes_a_ramp() -> None:
    # Two models that differ by 3 m meet under a road, without the blend that the surface itself has.
    ground = Ground(
        lambda x, y: np.where(x < 0.0, 50.0, 53.0),
        cells=lambda x, y: np.where(x < 0.0, 10.0, 5.0),
        sigmas=lambda x, y: np.where(x < 0.0, 1.0, 0.5),
    )
    found = solve([straight((-400.0, 0.0), (400.0, 0.0))], ground)
    s, x, _, z = found.along(0)
    assert z[x < -80.0] == pytest.approx(50.0, abs=0.3)
    assert z[x > 80.0] == pytest.approx(53.0, abs=0.3)
    assert np.abs(found.grade(0, s)).max() < 0.15


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


def test_blobs_lose_their_weight_on_a_stiff_road_only() -> None:
    import scipy.sparse as sp

    # Heights of 9 places, three of them on a roof; a stiff road has one height, a soft one a height for each place.
    z = np.array([0.0, 0.0, 0.0, 10.0, 10.0, 10.0, 0.0, 0.0, 0.0])
    n = len(z)
    obs = Observations(sp.csr_matrix(np.eye(n)), z, np.ones(n), np.ones(n))
    difference = np.diff(np.eye(n), axis=0)
    stiff, soft = (sp.csr_matrix(k * difference.T @ difference) for k in (1e6, 1e-6))
    robust = Robust(1.5, 8.0)
    assert see_through([Stage(stiff, 0.5)], obs, robust)[3:6].max() < 0.05
    assert see_through([Stage(stiff, 0.5)], obs, robust)[[0, 8]].min() > 0.9
    assert see_through([Stage(soft, 0.5)], obs, robust).min() > 0.99


def test_ring_in_a_wood() -> None:
    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        z: FloatArray = np.where(np.hypot(x - 50.0, y) < 30.0, 15.0, 0.0) + 0.01 * y
        return z

    ring = RoadSpec(0.0, -50.0, 0.0, 2 * np.pi * 50.0, curvature=0.02, start_link=1, end_link=0)
    found = solve([ring], Ground(height, 5.0, 0.5, covered=True))
    _, _, y, z = found.along(0)
    assert np.abs(z - 0.01 * y).max() < 0.5
