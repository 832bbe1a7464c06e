from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dem_factory import BAVARIA, around, centres, in_crs, read, scatter, write_raster
from scipy import ndimage

from osm2xodr import defaults
from osm2xodr.diagnostics import Kind
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray
from osm2xodr.surface import METHODS, FlatSurface, SurfaceOptions


def lidar(path: Path, half: float = 300.0) -> Path:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 1.0, half)
    return write_raster(path, np.full((rows, cols), 400.0, np.float32), transform, "EPSG:32632")


def srtm(path: Path, rise: float = 0.0) -> Path:
    transform, rows, cols = around(BAVARIA, "EPSG:4326", 1 / 3600)
    noise = np.random.default_rng(1).normal(0.0, 1.0, (rows, cols))
    return write_raster(path, np.round(400.0 + rise + noise).astype(np.int16), transform, "EPSG:4326")


def test_a_mosaic_tells_its_models_apart(tmp_path: Path) -> None:
    surface, _ = read([srtm(tmp_path / "coarse.tif"), lidar(tmp_path / "fine.tif")], BAVARIA, *scatter())
    x = np.array([0.0, 250.0, -299.0, 400.0, -800.0, 30000.0])
    quality = surface.quality(x, 0.0 * x)
    coarse = np.sqrt(20.11 * 30.89)
    assert quality.cell_size == pytest.approx([1.0, 1.0, 1.0, coarse, coarse, surface.cell_size], rel=2e-3)
    assert quality.sigma[:3] == pytest.approx(0.12)
    usual = np.exp(np.interp(np.log(coarse), np.log([10.0, 30.0]), np.log([1.0, 2.0])))
    assert quality.sigma[3:5] == pytest.approx(np.hypot(usual, 1 / np.sqrt(12)), rel=0.01)
    assert quality.sigma[5] == defaults.GUESS_SIGMA
    assert not quality.covered.any()
    # Most of these roads lie beyond the laser model.
    assert (surface.cell_size, surface.sigma) == (quality.cell_size[3], quality.sigma[3])
    assert surface.heights(x, 0.0 * x)[1].tolist() == [True, True, True, True, True, False]


def test_voids_of_the_fine_are_as_good_as_the_coarse(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 2.0, 300.0)
    px, py = centres(transform, rows, cols)
    x0, y0 = in_crs(BAVARIA, "EPSG:32632", 0.0, 0.0)
    cells = np.where(np.hypot(px - x0, py - y0) < 100.0, np.nan, 400.0).astype(np.float32)
    fine = write_raster(tmp_path / "fine.tif", cells, transform, "EPSG:32632")
    surface, _ = read([fine, srtm(tmp_path / "coarse.tif")], BAVARIA, *scatter(half=250.0))
    quality = surface.quality(np.array([0.0, 80.0, 150.0]), np.zeros(3))
    assert quality.cell_size == pytest.approx([24.92, 24.92, 2.0], rel=2e-3)
    assert quality.sigma[2] == pytest.approx(0.15)


@pytest.mark.parametrize("method", METHODS)
def test_the_layer_that_measures_is_the_one_that_gives_the_height(tmp_path: Path, method: str) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 2.0, 300.0)
    cells = np.full((rows, cols), 400.0, np.float32)
    cells[100:140, 60:220] = np.nan
    fine = write_raster(tmp_path / "fine.tif", cells, transform, "EPSG:32632")
    surface, _ = read([fine, srtm(tmp_path / "coarse.tif")], BAVARIA, *scatter(half=900.0), method=method)
    x, y = scatter(half=4000.0, count=4000, seed=9)
    x, y = np.concatenate([x, x / 10.0]), np.concatenate([y, y / 10.0])
    found = surface.layers.sources(x, y)
    assert sorted(set(found.tolist())) == [-1, 0, 1]
    assert np.array_equal(found, surface.layers.sample(x, y)[1])
    assert np.array_equal(surface.measured(x, y), surface.heights(x, y)[1])


def test_one_sigma_for_all(tmp_path: Path) -> None:
    paths = [srtm(tmp_path / "coarse.tif"), lidar(tmp_path / "fine.tif")]
    surface, _ = read(paths, BAVARIA, *scatter(), sigma=0.7)
    x = np.array([0.0, 800.0, 30000.0])
    assert surface.quality(x, 0.0 * x).sigma.tolist() == [0.7, 0.7, defaults.GUESS_SIGMA]
    trend, _ = read(paths, BAVARIA, *scatter(), sigma=0.1, method="polynomial")
    assert trend.quality(x, 0.0 * x).sigma[:2] == pytest.approx(trend.polynomial.rms)
    assert trend.polynomial.rms > 0.3


def canopy(shape: tuple[int, int]) -> FloatArray:
    field = ndimage.gaussian_filter(np.random.default_rng(2).normal(size=shape), 5.0)
    z: FloatArray = np.where(field > np.quantile(field, 0.7), 8.0 + np.clip(field / field.std(), 0, 3), 0.0)
    return z


def test_surface_models_are_told_by_their_heights(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 1.0, 300.0)
    path = write_raster(tmp_path / "a.tif", (400 + canopy((rows, cols))).astype(np.float32), transform, "EPSG:32632")
    paths = [path, srtm(tmp_path / "coarse.tif")]
    x = np.array([0.0, 250.0, 800.0, 9000.0])
    surface, diagnostics = read(paths, BAVARIA, *scatter())
    assert surface.quality(x, 0.0 * x).covered.tolist() == [True, True, False, False]
    said = [item for item in diagnostics if item.code == "dem-type"]
    assert [item.kind for item in said] == [Kind.GUESSED]
    assert said[0].message == (
        f"{path}: by its heights the elevation model shows canopy and roofs, and was taken for a surface model; if "
        "it shows the ground, give --dem-type dtm."
    )
    for dem_type, covered in (("dtm", False), ("dsm", True)):
        surface, diagnostics = read(paths, BAVARIA, *scatter(), dem_type=dem_type)
        assert surface.quality(x, 0.0 * x).covered.tolist() == [covered, covered, covered, False]
        assert "dem-type" not in [item.code for item in diagnostics]


def test_surface_models_are_told_by_their_names(tmp_path: Path) -> None:
    x = np.zeros(1)
    surface, diagnostics = read(srtm(tmp_path / "Copernicus_DSM_COG_10_N49_00_E011.tif"), BAVARIA, *scatter())
    assert surface.quality(x, x).covered.tolist() == [True]
    assert "by its name the elevation model shows canopy" in next(iter(diagnostics)).message
    # A name that says terrain outweighs what the heights look like.
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 1.0, 300.0)
    cells = (400 + canopy((rows, cols))).astype(np.float32)
    bare = write_raster(tmp_path / "dgm1.tif", cells, transform, "EPSG:32632")
    surface, diagnostics = read(bare, BAVARIA, *scatter(half=250.0))
    assert surface.quality(x, x).covered.tolist() == [False]
    assert [item.code for item in diagnostics] == []
    described = write_raster(
        tmp_path / "b.tif",
        np.full((rows, cols), 400.0, np.float32),
        transform,
        "EPSG:32632",
        tags={"TIFFTAG_IMAGEDESCRIPTION": "Digital Surface Model of Bavaria"},
    )
    surface, _ = read(described, BAVARIA, *scatter(half=250.0))
    assert surface.quality(x, x).covered.tolist() == [True]


def test_terrain_and_surface_models_on_one_grid_stay_apart(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 10.0)
    level = np.full((rows, cols), 400.0, np.float32)
    level[:, cols // 2 :] = np.nan
    ground = write_raster(tmp_path / "dtm.tif", level, transform, "EPSG:32632")
    roofs = write_raster(tmp_path / "dsm.tif", np.full((rows, cols), 400.0, np.float32), transform, "EPSG:32632")
    surface, _ = read([ground, roofs], BAVARIA, *scatter())
    x = np.array([-500.0, 500.0])
    assert surface.quality(x, 0.0 * x).covered.tolist() == [False, True]


def test_outliers_are_not_used(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    px, _ = centres(transform, rows, cols)
    cells = 400.0 + 0.1 * (px - px.mean())
    cells[50, 50] += 5000.0
    cells[20:22, 70:72] -= 400.0
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    x, y = scatter()
    surface, diagnostics = read(path, BAVARIA, x, y, method="bicubic")
    expected = 400.0 + 0.1 * (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - px.mean())
    assert np.abs(surface.heights(x, y)[0] - expected).max() < 0.2
    assert (surface.dems[0].outliers, surface.dems[0].voids) == (5, 5)
    first = next(iter(diagnostics))
    assert (first.kind, first.code) == (Kind.REPAIRED, "dem-outlier")
    lon, lat = in_crs_degrees(px[20, 70], transform.f - 20.5 * 20.0)
    assert first.message == (
        f"{path}: 5 cells of {cells[20:22, 70:72].min():.0f} to {cells[50, 50]:.0f} m, the first at {lon:.5f} E, "
        f"{lat:.5f} N, differ from all ground around them by more than 50 m, as no ground does; they were taken for "
        "voids."
    )


def in_crs_degrees(px: float, py: float) -> tuple[float, float]:
    from pyproj import Transformer

    lon, lat = Transformer.from_crs("EPSG:32632", 4326, always_xy=True).transform(px, py)
    return float(lon), float(lat)


def test_outliers_of_averaged_models_leave_no_fringe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("osm2xodr.surface.reading._CELLS_MAX", 5000)
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 10.0)
    cells = np.full((rows, cols), 600.0, np.float32) + np.random.default_rng(1).normal(0, 0.5, (rows, cols))
    row, col = np.mgrid[:rows, :cols]
    cells[row + col < 130] = 0.0
    path = write_raster(tmp_path / "a.tif", cells.astype(np.float32), transform, "EPSG:32632")
    surface, diagnostics = read(path, BAVARIA, *scatter(half=800.0), allow_partial=True)
    assert np.abs(surface.heights(*scatter(half=800.0))[0] - 600.0).max() < 2.0
    assert [item.code for item in diagnostics] == ["dem-outlier", "dem-averaged"]


def test_flat_surfaces_are_exact() -> None:
    quality = FlatSurface().quality(np.zeros(2), np.zeros(2))
    assert (quality.cell_size.tolist(), quality.sigma.tolist()) == ([0.0, 0.0], [0.0, 0.0])
    assert quality.covered.tolist() == [False, False]


def test_types_of_models() -> None:
    with pytest.raises(InputError, match="choose one of auto, dtm, dsm"):
        SurfaceOptions(dem_type="dem")
