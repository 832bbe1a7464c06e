""" """

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from dem_factory import BAVARIA
from pyproj import CRS
from scipy.interpolate import RectBivariateSpline

from osm2xodr.projection import make_frame, transformer_to
from osm2xodr.surface.grids.grid import Affine, GridFrame, all_corners, make_interpolator, nearest_known

Z = np.array([[0.0, 10.0, 20.0, 30.0], [100.0, 110.0, 120.0, 130.0], [200.0, 210.0, 220.0, 990.0]])


def utm(affine: Affine, rows: int = 40, cols: int = 60) -> GridFrame:
    crs = CRS.from_epsg(32632)
    return GridFrame(crs, transformer_to(BAVARIA, crs), affine, rows, cols)


TURNED = (8.0, -6.0, 680000.0, 3.0, 4.0, 5480000.0)


def test_cells_count_from_the_centre_of_the_first() -> None:
    frame = utm((10.0, 0.0, 680000.0, 0.0, -10.0, 5480000.0))
    col, row = frame.cells_at(np.array([680005.0, 680000.0, 680595.0]), np.array([5479995.0, 5480000.0, 5479605.0]))
    assert col.tolist() == [0.0, -0.5, 59.0]
    assert row.tolist() == [0.0, -0.5, 39.0]


@pytest.mark.parametrize("affine", [TURNED, (10.0, 0.0, 680000.0, 0.0, -10.0, 5480000.0)])
def test_there_and_back(affine: Affine) -> None:
    frame = utm(affine)
    rng = np.random.default_rng(1)
    for count in (1, 2, 200):
        col, row = rng.uniform(-50, 100, (2, count))
        back = frame.cells(*frame.positions(col, row))
        assert np.abs(back[0] - col).max() < 1e-6
        assert np.abs(back[1] - row).max() < 1e-6


def test_steps_are_lengths_on_the_ground() -> None:
    assert utm(TURNED).steps() == pytest.approx((np.hypot(8, 3), np.hypot(6, 4)), rel=5e-4)


def test_window() -> None:
    frame = utm(TURNED)
    part = frame.window(7, 5, 12, 10)
    assert (part.rows, part.cols) == (10, 12)
    x, y = part.positions(np.array([0.0, 11.0]), np.array([0.0, 9.0]))
    col, row = frame.cells(x, y)
    assert col == pytest.approx([7.0, 18.0], abs=1e-6)
    assert row == pytest.approx([5.0, 14.0], abs=1e-6)
    coarse = frame.window(7, 5, 12, 10, 2)
    assert (coarse.rows, coarse.cols) == (5, 6)
    x, y = coarse.positions(np.array([0.0, 5.0]), np.array([0.0, 4.0]))
    col, row = frame.cells(x, y)
    # The centre of a block of four is between their centres.
    assert col == pytest.approx([7.5, 17.5], abs=1e-6)
    assert row == pytest.approx([5.5, 13.5], abs=1e-6)


def test_offset_between_frames() -> None:
    frame = utm((10.0, 0.0, 680000.0, 0.0, -10.0, 5480000.0))
    assert frame.window(3, 4, 10, 10).offset_in(frame) == (3, 4)
    assert frame.offset_in(frame.window(3, 4, 10, 10)) == (-3, -4)
    assert frame.window(3, 4, 10, 10, 2).offset_in(frame) is None
    assert utm((10.0, 0.0, 680003.0, 0.0, -10.0, 5480000.0)).offset_in(frame) is None
    assert utm((10.001, 0.0, 680000.0, 0.0, -10.0, 5480000.0)).offset_in(frame) is None
    crs = CRS.from_epsg(25832)
    other = GridFrame(crs, transformer_to(BAVARIA, crs), frame.affine, 40, 60)
    assert other.offset_in(frame) is None


def test_rim_goes_all_around() -> None:
    col, row = utm(TURNED).rim(5)
    assert (col.min(), col.max(), row.min(), row.max()) == (-0.5, 59.5, -0.5, 39.5)
    assert all(np.isin([-0.5, 59.5], col[np.abs(row - edge) < 1e-9]).all() for edge in (-0.5, 39.5))


def test_longitudes_are_taken_to_the_turn_of_the_raster() -> None:
    frame = make_frame(-17.0, 179.999)
    crs = CRS.from_epsg(4326)
    # Columns of a tenth of a degree from 170 to 190 degrees east.
    across = GridFrame(crs, transformer_to(frame, crs), (0.1, 0.0, 170.0, 0.0, -0.1, -10.0), 100, 200)
    x = np.array([-5000.0, 0.0, 5000.0])
    col, _ = across.cells(x, np.zeros(3))
    assert np.diff(col) == pytest.approx([0.4696, 0.4696], abs=1e-3)
    assert col[1] == pytest.approx(99.49, abs=1e-6)


def test_positions_that_have_no_place_are_not_finite() -> None:
    col, row = utm(TURNED).cells_at(np.array([np.inf, np.nan]), np.array([np.inf, 0.0]))
    assert not np.isfinite(col).any()
    assert not np.isfinite(row).any()


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
