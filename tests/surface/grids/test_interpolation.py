from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

from osm2xodr.surface.grids.interpolation import all_corners, make_interpolator, nearest_known

Z = np.array([[0.0, 10.0, 20.0, 30.0], [100.0, 110.0, 120.0, 130.0], [200.0, 210.0, 220.0, 990.0]])


def test_bilinear_values() -> None:
    interpolate = make_interpolator(Z, "bilinear")
    col, row = np.array([0.0, 3.0, 1.25, 2.5, 3.0]), np.array([0.0, 2.0, 0.5, 1.5, 1.5])
    expected = [0.0, 990.0, 62.5, (120 + 130 + 220 + 990) / 4, (130 + 990) / 2]
    assert interpolate(col, row) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_bilinear_is_the_spline_of_degree_one(dtype: Any) -> None:
    rng = np.random.default_rng(1)
    z = rng.normal(500, 100, (37, 53)).astype(dtype)
    col, row = rng.uniform(0, 52, 2000), rng.uniform(0, 36, 2000)
    spline = RectBivariateSpline(np.arange(37), np.arange(53), z.astype(np.float64), kx=1, ky=1)
    assert np.abs(make_interpolator(z, "bilinear")(col, row) - spline.ev(row, col)).max() < 1e-9


def test_bicubic_is_exact_on_cubic_polynomials() -> None:
    row, col = np.mgrid[0:30, 0:40] / 10.0

    def cubic(r: np.ndarray, c: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        out: np.ndarray = 5 + r - 2 * c + r * c**2 - 0.5 * r**3 * c + 0.1 * (r * c) ** 3  # type: ignore[type-arg]
        return out

    interpolate = make_interpolator(cubic(row, col), "bicubic")
    rng = np.random.default_rng(1)
    at_col, at_row = rng.uniform(0, 39, 1000), rng.uniform(0, 29, 1000)
    assert np.abs(interpolate(at_col, at_row) - cubic(at_row / 10, at_col / 10)).max() < 1e-8


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (6, 1), (2, 2), (3, 7)])
@pytest.mark.parametrize("method", ["nearest", "bilinear", "bicubic"])
def test_small_grids(shape: tuple[int, int], method: str) -> None:
    row, col = np.mgrid[0 : shape[0], 0 : shape[1]].astype(np.float64)
    interpolate = make_interpolator(7.0 + 2.0 * col - 3.0 * row, method)
    at_col, at_row = col.reshape(-1), row.reshape(-1)
    assert interpolate(at_col, at_row) == pytest.approx(7.0 + 2.0 * at_col - 3.0 * at_row, abs=1e-9)


def test_nearest_values() -> None:
    interpolate = make_interpolator(Z, "nearest")
    col, row = np.array([-0.5, 0.49, 0.5, 3.49, 3.5]), np.array([-0.5, 0.0, 1.49, 1.5, 2.5])
    assert interpolate(col, row).tolist() == [0.0, 0.0, 110.0, 990.0, 990.0]


def test_which_cells_take_part() -> None:
    known = np.ones((3, 4), bool)
    known[1, 2] = False
    col = np.array([0.5, 1.0, 1.1, 2.0, 2.5, 3.0, 2.0, 2.0, 1.0 + 1e-9])
    row = np.array([0.5, 1.0, 1.0, 0.0, 0.5, 1.5, 0.1, 1.0, 1.0])
    assert all_corners(known, col, row).tolist() == [True, True, False, True, False, True, False, False, True]
    assert nearest_known(known, col, row).tolist() == [True, True, True, True, True, True, True, False, True]
