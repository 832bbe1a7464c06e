from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from affine import Affine
from dem_factory import BAVARIA, around, centres, in_crs, write_raster

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError
from osm2xodr.surface.survey import compare_surfaces

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
