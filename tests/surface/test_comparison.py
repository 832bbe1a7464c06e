from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.model import FloatArray
from osm2xodr.surface.comparison import GridComparison, MethodResult, Patch, compare_grid


def paraboloid(rows: int, cols: int, first_row: int = 0, first_col: int = 0) -> FloatArray:
    row, col = np.mgrid[first_row : first_row + rows, first_col : first_col + cols].astype(np.float64)
    z: FloatArray = 200 + 0.02 * (col - 30) ** 2 + 0.03 * (row - 20) ** 2
    return z


def named(results: tuple[MethodResult, ...], name: str) -> MethodResult:
    return next(result for result in results if result.name == name)


def compare(z: FloatArray, steps: tuple[float, float] = (10.0, 10.0)) -> GridComparison:
    return compare_grid([Patch(0, 0, z)], steps)


def test_a_smooth_paraboloid() -> None:
    result = compare(paraboloid(41, 61))
    assert [item.name for item in result.interpolations] == ["nearest", "bilinear", "bicubic"]
    nearest, bilinear, bicubic = result.interpolations
    # Half-way between heights two cells apart a parabola a x² is a below the chord: 0.02, 0.03 or both of them.
    errors = bilinear.errors[0]
    assert errors[0::2, 1::2] == pytest.approx(0.02)
    assert errors[1::2, 0::2] == pytest.approx(0.03)
    assert errors[1::2, 1::2] == pytest.approx(0.05)
    assert np.isnan(errors[::2, ::2]).all()
    counts = 21 * 30, 20 * 31, 20 * 30
    assert bilinear.count == sum(counts) == 41 * 61 - 21 * 31
    squares = counts[0] * 0.02**2 + counts[1] * 0.03**2 + counts[2] * 0.05**2
    assert bilinear.rms == pytest.approx(np.sqrt(squares / sum(counts)))
    assert bilinear.maximum == pytest.approx(0.05)
    assert bilinear.bias == pytest.approx((counts[0] * 0.02 + counts[1] * 0.03 + counts[2] * 0.05) / sum(counts))
    assert bicubic.maximum < 1e-9
    assert bicubic.rms < bilinear.rms < nearest.rms
    assert nearest.rms == max(item.rms for item in result.interpolations)
    assert all(item.seconds >= 0.0 for item in (*result.interpolations, *result.polynomials))


def test_grades() -> None:
    # A ridge at an odd column: bilinear cuts 1 m off it, over one cell of 10 m on either side.
    z = np.zeros((11, 13))
    z[:, 5] = 1.0
    bilinear = compare(z, (10.0, 20.0)).interpolations[1]
    assert bilinear.maximum == 1.0
    assert bilinear.bias == pytest.approx(-11.0 / bilinear.count)
    # Pairs in a row: 12 by 11, of which two in each row are off by 0.1; in a column all are as they are.
    assert bilinear.grade_rms == pytest.approx(np.sqrt(2 * 11 * 0.01 / (12 * 11 + 13 * 10)))


def test_polynomials_are_exact_up_to_their_degree() -> None:
    row, col = np.mgrid[:50, :70].astype(np.float64)
    u, v = col / 35 - 1, row / 25 - 1
    quartic = 300 + 50 * u**4 - 30 * u**2 * v**2 + 20 * v**3 - 10 * u * v**3
    result = compare(quartic)
    orders = {item.name: item for item in result.polynomials}
    assert list(orders) == ["2", "3", "4", "5"]
    assert orders["4"].maximum < 1e-9
    assert orders["5"].maximum < 1e-9
    assert orders["2"].rms > orders["3"].rms > 0.5
    assert orders["3"].count == quartic.size
    residual = orders["3"].errors[0]
    assert orders["3"].rms == pytest.approx(np.sqrt(np.mean(residual**2)))
    assert abs(orders["3"].bias) < 1e-9


def test_noise_is_amplified_by_bicubic() -> None:
    result = compare(np.random.default_rng(1).normal(0, 1, (101, 101)))
    assert named(result.interpolations, "bilinear").rms < named(result.interpolations, "bicubic").rms
    # Mean of two: 1 + 1/2; of four: 1 + 1/4.
    assert named(result.interpolations, "bilinear").rms == pytest.approx(np.sqrt(1 + (2 / 2 + 1 / 4) / 3), rel=0.03)


def test_patches_are_one_model() -> None:
    whole = paraboloid(60, 80)
    patches = [Patch(0, 0, whole[:21, :31]), Patch(49, 39, whole[39:, 49:])]
    result = compare_grid(patches, (10.0, 10.0))
    assert result.polynomials[0].maximum < 1e-9
    assert result.interpolations[1].count == 2 * (21 * 31 - 11 * 16)
    assert result.interpolations[1].maximum == pytest.approx(0.05)
    assert [error.shape for error in result.interpolations[1].errors] == [(21, 31), (21, 31)]


def test_voids_are_neither_told_nor_asked() -> None:
    z = paraboloid(41, 61)
    z[10:20, 20:35] = np.nan
    result = compare(z)
    for item in (*result.interpolations, *result.polynomials):
        assert np.isnan(item.errors[0][10:20, 20:35]).all()
        assert np.isfinite([item.rms, item.p95, item.maximum, item.grade_rms]).all()
    # What lies beside the void has a void among its corners.
    assert np.isnan(result.interpolations[1].errors[0][9, 20:35]).all()
    assert result.interpolations[1].maximum == pytest.approx(0.05)
    assert result.polynomials[0].count == 41 * 61 - 150


def test_few_cells_have_few_polynomials() -> None:
    assert [item.name for item in compare(paraboloid(5, 5)).polynomials] == ["2", "3"]
