""" """

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from affine import Affine
from dem_factory import BAVARIA, around, centres, in_crs, write_raster

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.model import FloatArray
from osm2xodr.surface.survey import GridComparison, MethodResult, Patch, compare_grid, compare_surfaces

WHOLE = None


def parabolic(path: Path, cell: float = 20.0, half: float = 1000.0) -> Path:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", cell, half)
    px, py = centres(transform, rows, cols)
    z = 400 + 5e-5 * (px - px.mean()) ** 2 - 3e-5 * (py - py.mean()) ** 2
    return write_raster(path, z, transform, "EPSG:32632")


def test_a_whole_model(tmp_path: Path) -> None:
    path = parabolic(tmp_path / "a.tif")
    comparison = compare_surfaces([path], WHOLE, Diagnostics())
    model = comparison.models[0]
    assert comparison.box_deg is None
    assert (model.path, model.driver, model.crs, model.dtype) == (path, "GTiff", "WGS 84 / UTM zone 32N", "float64")
    assert model.size[0] * model.size[1] == model.cells
    assert (model.voids, model.outliers, model.covered) == (0, 0, False)
    assert model.cell_size == pytest.approx(20.0, rel=1e-3)
    nearest, bilinear, bicubic = model.grid.interpolations
    assert bilinear.maximum == pytest.approx(5e-5 * 400, rel=1e-3)
    assert bicubic.maximum < 1e-8
    assert nearest.rms > bilinear.rms
    assert max(item.maximum for item in model.grid.polynomials) < 1e-8


def test_a_box(tmp_path: Path) -> None:
    path = parabolic(tmp_path / "a.tif")
    lon, lat = in_crs(BAVARIA, 4326, np.array([-300.0, 300.0]), np.array([-500.0, 100.0]))
    box = float(lon[0]), float(lat[0]), float(lon[1]), float(lat[1])
    model = compare_surfaces([path], box, Diagnostics()).models[0]
    # 600 m are 30 cells and their neighbours; the grid is turned against the meridian by 2 degrees.
    assert 31 <= model.size[0] <= 34
    assert 31 <= model.size[1] <= 34
    assert model.cells == model.size[0] * model.size[1]


def test_patches_of_a_large_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("osm2xodr.surface.survey._CELLS_MAX", 9 * 20 * 20)
    model = compare_surfaces([parabolic(tmp_path / "a.tif", 10.0)], WHOLE, Diagnostics()).models[0]
    assert [patch.z.shape for patch in model.grid.patches] == [(20, 20)] * 9
    assert model.cells == 3600
    first = [patch.first_col for patch in model.grid.patches[:3]]
    gaps = [first[0], first[1] - first[0] - 20, first[2] - first[1] - 20, model.size[0] - first[2] - 20]
    assert max(gaps) - 2 * min(gaps) <= 2
    # All patches together lie on one polynomial.
    assert model.grid.polynomials[0].maximum < 1e-8
    assert model.grid.interpolations[1].maximum == pytest.approx(5e-5 * 100, rel=1e-3)


@pytest.mark.parametrize(("a", "e"), [(20.0, 20.0), (-20.0, -20.0), (-20.0, 20.0)])
def test_pictures_are_upright(tmp_path: Path, a: float, e: float) -> None:
    x0, y0 = (float(value) for value in in_crs(BAVARIA, "EPSG:32632", 0.0, 0.0))
    transform = Affine(a, 0.0, x0 - 20 * a, 0.0, e, y0 - 15 * e)
    px, py = centres(transform, 30, 40)
    path = write_raster(tmp_path / "a.tif", 0.01 * (px - x0) + 0.1 * (py - y0), transform, "EPSG:32632")
    z = compare_surfaces([path], WHOLE, Diagnostics()).models[0].grid.patches[0].z
    assert (np.diff(z, axis=0) < 0.0).all()
    assert (np.diff(z, axis=1) > 0.0).all()


def test_several_models_and_what_is_wrong_with_them(tmp_path: Path) -> None:
    good = parabolic(tmp_path / "good.tif")
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 50.0, np.float32)
    cells[:5] = np.nan
    cells[40, 40] = 2000.0
    odd = write_raster(tmp_path / "dsm.tif", cells, transform, "EPSG:32632")
    diagnostics = Diagnostics()
    one, two = compare_surfaces([good, odd], WHOLE, diagnostics).models
    assert (one.voids, two.voids, two.outliers) == (0, 5 * cols + 1, 1)
    assert two.covered
    assert [item.code for item in diagnostics] == ["dem-outlier"]
    assert two.grid.interpolations[2].maximum < 1e-9


def test_what_cannot_be_compared(tmp_path: Path) -> None:
    path = parabolic(tmp_path / "a.tif")
    with pytest.raises(InputError, match="name at least one file"):
        compare_surfaces([], WHOLE, Diagnostics())
    for box in ((12.0, 49.0, 11.0, 50.0), (11.0, 50.0, 12.0, 49.0), (11.0, 49.0, float("nan"), 50.0)):
        with pytest.raises(InputError, match="give west, south, east, north in degrees"):
            compare_surfaces([path], box, Diagnostics())
    with pytest.raises(CoverageError, match=r"does not reach into the box 5,40,6,41; give another --bbox"):
        compare_surfaces([path], (5.0, 40.0, 6.0, 41.0), Diagnostics())
    with pytest.raises(InputError, match="cells are too few to compare anything"):
        compare_surfaces([path], (11.5, 49.5, 11.5005, 49.5005), Diagnostics())
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    void = write_raster(tmp_path / "void.tif", np.full((rows, cols), np.nan), transform, "EPSG:32632")
    with pytest.raises(CoverageError, match="all is nodata"):
        compare_surfaces([void], WHOLE, Diagnostics())


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
