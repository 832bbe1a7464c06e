"""The elevation model read along roads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elevation_helpers import Ground, in_cells, make_problem, solve, straight

from osm2xodr.geometry.heights.elements import build_elements, build_samples
from osm2xodr.geometry.heights.ground import Ground as GroundEstimate
from osm2xodr.geometry.heights.readings import Reading, noise_length, read_heights, road_spacing, typical_ground
from osm2xodr.model import FloatArray


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


def typical(reading: Reading, cell: list[float]) -> list[object]:
    """Return the typical weight per metre of road, 1/m³, and standard error, m, on cells of these sizes."""
    density, sigma = typical_ground(reading, np.array(cell))
    return [density.tolist(), sigma.tolist()]


def test_typical_ground_is_that_of_cells_of_the_same_size() -> None:
    n = np.ones(4)
    cell = np.array([1.0, 1.0, 30.0, 30.0])
    reading = Reading(n, n, np.array([0.1, 0.1, 2.0, 2.0]), 10 * n, cell, n > 0, n < 0, np.nan * n, 0 * n, 0 * n)
    density, sigma = typical(reading, [1.02, 29.5])
    assert density == pytest.approx([10.0, 0.025])
    assert sigma == pytest.approx([0.1, 2.0])


def test_what_is_not_measured_weighs_nothing_unless_nothing_is() -> None:
    """1 / (correlation sigma²) of guesses, and the median of three."""
    n = np.ones(3)
    reading = Reading(n, n, np.array([1.0, 2.0, 4.0]), 10 * n, 30 * n, n > 0, n < 0, n, 0 * n, 0 * n)
    assert typical(reading, [30.0]) == [pytest.approx([0.1 / 4.0]), [2.0]]
    first = replace(reading, measured=np.array([True, False, False]))
    assert typical(first, [30.0, 30.0]) == [pytest.approx([0.1, 0.1]), [1.0, 1.0]]
    nowhere = replace(reading, measured=n < 0)
    assert typical(nowhere, [30.0, 1.0]) == [pytest.approx([0.1 / 4.0] * 2), [2.0, 2.0]]
    assert typical(reading.part(slice(0)), [30.0]) == [[1.0], [1.0]]


def test_cells_of_a_size_that_was_not_measured_weigh_as_all() -> None:
    n, cell = np.ones(3), np.array([1.0, 1.0, 30.0])
    reading = Reading(n, n, np.array([1.0, 1.0, 2.0]), 10 * n, cell, n > 0, n < 0, n, 0 * n, 0 * n)
    assert typical(reading, [1.0, 30.0, 9.0]) == [pytest.approx([0.1, 0.025, 0.1]), [1.0, 2.0, 1.0]]


@pytest.mark.parametrize(("cell", "knots"), [(0.0, 12.0), (4.9, 12.0), (5.0, 25.0), (19.9, 25.0), (20.0, 60.0)])
def test_length_of_elements_goes_with_cells(cell: float, knots: float) -> None:
    problem = make_problem([straight((0.0, 0.0), (200.0, 0.0))])
    assert road_spacing(problem, Ground(lambda x, y: 0.0 * x, cell_size=cell)).knots.tolist() == [knots]


def test_cells_are_looked_up_every_fifty_metres() -> None:
    """At 22.5, 67.5, 112.5 and 157.5 m of 180 m, at 25 m of 50 m, in the middle of shorter roads."""
    seen: list[float] = []

    def cells(x: FloatArray, y: FloatArray) -> FloatArray:
        seen.extend(x.tolist())
        return np.full(len(x), 10.0)

    roads = [straight((0.0, 9.0 * k), (length, 9.0 * k)) for k, length in enumerate((180.0, 50.0, 4.0))]
    road_spacing(make_problem(roads), Ground(lambda x, y: 0.0 * x, cells=cells))
    assert seen == pytest.approx([22.5, 67.5, 112.5, 157.5, 25.0, 2.0])


@pytest.mark.parametrize("hdg", [0.0, 0.7, 2.0, -2.5])
@pytest.mark.parametrize(("cell", "wide"), [(1.0, 0.05), (5.9, 0.05), (6.1, 0.3), (14.0, 0.3)])
def test_slope_across_is_read_to_both_sides(hdg: float, cell: float, wide: float) -> None:
    """2 m to either side, or half a cell: a bank of 5 % near the road, beyond 3 m of 40 %."""
    along = np.array([np.cos(hdg), np.sin(hdg)])
    problem = make_problem([straight((0.0, 0.0), tuple(200.0 * along))])
    samples = build_samples(problem, build_elements(problem, 50.0), np.array([10.0]))

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        t = y * along[0] - x * along[1]
        return np.asarray(np.where(np.abs(t) < 3.0, 0.05 * t, 0.3 * t) + 0.1 * (x * along[0] + y * along[1]))

    surface = Ground(height, cell_size=cell, sigma=0.5)
    found, _ = read_heights(surface, samples, np.zeros((0, 2)), GroundEstimate(1.0))
    assert found.sigma == pytest.approx(np.full(20, np.hypot(0.5, wide * 0.17 * cell)), rel=1e-6)
    assert found.across == pytest.approx(np.full(20, wide))
    # Known on one side only: nothing is known of the slope.
    surface.known = lambda x, y: np.asarray(y * along[0] - x * along[1] < 1.0)
    found, _ = read_heights(surface, samples, np.zeros((0, 2)), GroundEstimate(1.0))
    assert found.sigma == pytest.approx(np.full(20, 0.5))
    assert found.measured.all()


def test_what_is_not_measured_is_a_guess_and_nothing_covers_it() -> None:
    problem = make_problem([straight((0.0, 0.0), (200.0, 0.0))], [(0.0, 50.0), (150.0, 50.0)])
    samples = build_samples(problem, build_elements(problem, 50.0), np.array([10.0]))
    surface = Ground(
        lambda x, y: 40.0 + y, cell_size=10.0, sigma=1.0, known=lambda x, y: np.asarray(x < 100.0), covered=True
    )
    roads, junctions = read_heights(surface, samples, problem.junction_xy, GroundEstimate(1.0))
    measured = samples.x < 100.0
    assert roads.measured.tolist() == roads.covered.tolist() == measured.tolist()
    assert roads.correlation == pytest.approx(np.where(measured, 17.0, 200.0))
    # They are the less certain the farther what is measured is: twice as much in a kilometre.
    assert roads.sigma[~measured] == pytest.approx(30.0 * (1.0 + roads.away[~measured] / 1000.0))
    assert roads.away[~measured].max() > 50.0
    assert roads.z.tolist() == roads.surface_z.tolist() == [40.0] * 20
    # Junctions have no part for the position of a road.
    assert junctions.z.tolist() == [90.0, 90.0]
    # The second is 74 m from the nearest sample that is measured, at (95, 0).
    assert junctions.sigma == pytest.approx([1.0, 30.0 * (1.0 + np.hypot(55.0, 50.0) / 1000.0)])
    assert junctions.measured.tolist() == junctions.covered.tolist() == [True, False]
    assert junctions.cell.tolist() == [10.0, 10.0]


@pytest.mark.parametrize(("cell", "samples"), [(0.0, 3.0), (3.0, 3.0), (9.0, 6.0), (90.0, 20.0)])
def test_distance_of_samples_goes_with_cells_and_is_bounded(cell: float, samples: float) -> None:
    problem = make_problem([straight((0.0, 0.0), (200.0, 0.0))])
    spacing = road_spacing(problem, Ground(lambda x, y: 0.0 * x, cell_size=cell))
    assert spacing.samples.tolist() == [samples]


def test_noise_is_correlated_over_cells_and_a_least_length() -> None:
    assert noise_length(np.array([0.5, 10.0])) == pytest.approx([2.0, 17.0])


@pytest.mark.parametrize(
    ("sigma", "slope", "expected"), [(0.0, 0.0, 0.05), (1.0, 0.0, 1.0), (0.0, 0.3, 0.5124), (0.0, -0.3, 0.5124)]
)
def test_standard_error_has_a_least_and_a_part_for_the_position(sigma: float, slope: float, expected: float) -> None:
    problem = make_problem([straight((0.0, 0.0), (200.0, 0.0))])
    samples = build_samples(problem, build_elements(problem, 50.0), np.array([10.0]))
    surface = Ground(lambda x, y: slope * y, cell_size=10.0, sigma=sigma)
    found, _ = read_heights(surface, samples, np.zeros((0, 2)), GroundEstimate(1.0))
    # Cells do not show by how much roads of 0.17 of their size are cut into the slope.
    assert found.sigma == pytest.approx(np.full(20, expected), abs=2e-4)
    assert found.across == pytest.approx(np.full(20, slope))
    assert found.correlation.tolist() == [17.0] * 20


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_fine_heights_are_followed_and_coarse_ones_smoothed(seed: int) -> None:
    found = solve([straight((-600.0, 0.0), (600.0, 0.0))], mosaic(seed))
    s, x, _, z = found.along(0)
    error = z - 0.02 * x
    assert np.abs(error[x < -30.0]).max() < 0.15
    assert float(np.sqrt(np.mean(error[x > 0.0] ** 2))) < 2.0
    grade = found.grade(0, s) - 0.02
    assert np.abs(grade[x < -60.0]).max() < 0.03
    assert np.abs(grade).max() < 0.06


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
