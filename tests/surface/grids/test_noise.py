from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.surface.grids.noise import estimate_sigma, quantum_of, usual_sigma


@pytest.mark.parametrize(
    ("cell", "sigma"),
    [
        (0.5, 0.12),
        (1.0, 0.12),
        (2.0, 0.15),
        (5.0, 0.5),
        (10.0, 1.0),
        (17.32, 1.414),
        (30.0, 2.0),
        (90.0, 5.0),
        (900.0, 5.0),
    ],
)
def test_usual_sigma(cell: float, sigma: float) -> None:
    assert usual_sigma(cell) == pytest.approx(sigma, rel=1e-3)


def test_noise_is_found_under_hills() -> None:
    rng = np.random.default_rng(1)
    row, col = np.mgrid[0:300, 0:400]
    noise = rng.normal(0, 1.0, row.shape)
    # The residual against a mean of nine that holds the cell itself has sqrt(8/9) of white noise.
    expected = 1.2 * np.sqrt(8 / 9)
    hills = 40 * np.sin(row / 60) * np.cos(col / 80)
    assert estimate_sigma(hills + 8 * noise, (300.0, 300.0), 0.0) == pytest.approx(8 * expected, rel=0.02)
    # What is less than usual for the cell size is not believed.
    assert estimate_sigma(hills + 0.5 * noise, (300.0, 300.0), 0.0) == pytest.approx(5.0)
    assert estimate_sigma(hills + 0.5 * noise, (30.0, 30.0), 0.0) == pytest.approx(2.0)
    # Nothing is flat on this grid, so that nothing can be told.
    assert estimate_sigma(1000 * hills + noise, (1.0, 1.0), 0.0) == pytest.approx(0.12)


def test_relief_of_a_few_cells_is_no_noise() -> None:
    rng = np.random.default_rng(1)
    k = 2 * np.pi * np.hypot(np.fft.fftfreq(400)[:, None], np.fft.rfftfreq(400))
    k[0, 0] = np.inf
    relief = np.fft.irfft2(np.fft.rfft2(rng.normal(0, 1.0, (400, 400))) * k**-1.75, (400, 400))
    # 12 m between neighbours, on cells so large that all of it is flat.
    relief *= 12.0 / np.diff(relief).std()
    noise = rng.normal(0, 1.0, relief.shape)
    assert estimate_sigma(relief, (1200.0, 1200.0), 0.0) == pytest.approx(5.0)
    # What is noise is found beneath it, to 5 %.
    expected = 1.2 * np.sqrt(8 / 9)
    assert estimate_sigma(relief + 16 * noise, (1200.0, 1200.0), 0.0) == pytest.approx(16 * expected, rel=0.05)


def test_outliers_and_voids_do_not_count() -> None:
    rng = np.random.default_rng(1)
    z = rng.normal(0, 5.0, (300, 300))
    clean = estimate_sigma(z, (400.0, 400.0), 0.0)
    z[::10, ::10] += 500.0
    z[5::20, 5::20] = np.nan
    assert estimate_sigma(z, (400.0, 400.0), 0.0) == pytest.approx(clean, rel=0.25)


def test_rounding_counts() -> None:
    flat = np.full((50, 50), 3.0)
    assert estimate_sigma(flat, (1.0, 1.0), 1.0) == pytest.approx(np.hypot(0.12, 1 / np.sqrt(12)))


@pytest.mark.parametrize("shape", [(1, 1), (2, 50), (3, 3), (4, 9), (5, 5)])
def test_small_grids_have_the_usual_noise(shape: tuple[int, int]) -> None:
    assert estimate_sigma(np.random.default_rng(1).normal(0, 50, shape), (10.0, 10.0), 0.0) == pytest.approx(1.0)


def test_quantum() -> None:
    whole = np.array([[1.0, 5.0], [np.nan, -3.0]])
    assert quantum_of(whole, 1.0) == 1.0
    assert quantum_of(whole * 0.3048, 0.3048) == 0.3048
    assert quantum_of(whole * 0.3048, 1.0) == 0.0
    assert quantum_of(whole + 0.5, 1.0) == 0.0
    assert quantum_of(np.full((3, 3), 7.0), 1.0) == 0.0
    assert quantum_of(np.full((3, 3), np.nan), 1.0) == 0.0
