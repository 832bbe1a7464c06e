""" """

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.surface.grids import quality
from osm2xodr.surface.grids.grid import Cells
from osm2xodr.surface.grids.quality import (
    estimate_sigma,
    find_outliers,
    looks_covered,
    named_cover,
    quantum_of,
    usual_sigma,
)


def hills(rows: int = 120, cols: int = 150, cell: float = 30.0) -> FloatArray:
    row, col = np.mgrid[:rows, :cols] * cell
    z: FloatArray = 600 + 150 * np.sin(col / 900) * np.cos(row / 700) + 0.1 * col
    return z + np.random.default_rng(1).normal(0, 1.5, z.shape)


def cells(mask: BoolArray) -> list[tuple[int, int]]:
    return [(int(row), int(col)) for row, col in np.argwhere(mask)]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("cell", [1.0, 10.0, 30.0])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_spikes_and_pits(sign: float, cell: float, dtype: type) -> None:
    z: Cells = (600 + (hills() - 600) * cell / 30.0).astype(dtype)
    step = find_outliers(z, cell)[1]
    assert step == pytest.approx({1.0: 30.0, 10.0: 30.0, 30.0: 75.0}[cell])
    off = sign * (2.0 * step + 150.0)
    z[40, 50] += off
    z[0, 7] += off
    z[80:83, 100:103] += off
    found = find_outliers(z, cell)[0]
    assert cells(found) == [(0, 7), (40, 50), *((row, col) for row in (80, 81, 82) for col in (100, 101, 102))]


def test_what_is_near_the_noise_stays() -> None:
    z = hills()
    z[40, 50] += 60.0
    assert not find_outliers(z, 30.0)[0].any()


def test_a_spike_beside_voids() -> None:
    z = hills()
    z[30:60, 40:60] = np.nan
    z[29, 45] += 300.0
    z[60, 60] += 300.0
    # In the corner there are three neighbours out of eight, which is too little to tell.
    z[119, 149] += 300.0
    assert cells(find_outliers(z, 30.0)[0]) == [(29, 45), (60, 60)]


def test_strips_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    z = hills()
    rng = np.random.default_rng(5)
    for row, col in zip(rng.integers(0, 118, 25), rng.integers(0, 148, 25), strict=True):
        z[row : row + 2, col : col + 2] += 900.0
    whole = find_outliers(z, 30.0)[0]
    assert np.count_nonzero(whole) > 60
    monkeypatch.setattr(quality, "_STRIP_CELLS", 150 * 7)
    assert np.array_equal(find_outliers(z, 30.0)[0], whole)


@pytest.mark.parametrize("value", [0.0, -1.0, 3000.0])
def test_undeclared_filling(value: float) -> None:
    z = hills()
    row, col = np.mgrid[:120, :150]
    # Corners, as a raster has that was turned into another CRS, and a block inside.
    filling = (row + col < 40) | (row - col > 90) | ((np.abs(row - 60) < 6) & (np.abs(col - 100) < 8))
    z[filling] = value
    found = find_outliers(z, 30.0)[0]
    assert np.array_equal(found, filling)


def test_a_cloud() -> None:
    z = hills()
    row, col = np.mgrid[:120, :150]
    cloud = np.hypot(row - 70, col - 40) < 9
    z[cloud] += 900.0 + np.random.default_rng(2).normal(0, 20, np.count_nonzero(cloud))
    assert np.array_equal(find_outliers(z, 30.0)[0], cloud)


def test_ground_is_ground() -> None:
    row, col = np.mgrid[:200, :200].astype(np.float64)
    x, y = 30.0 * col, 30.0 * row
    cliff = np.where(col > 90, 900.0, 300.0) + 0.05 * y
    ridge = 500 + 0.02 * y + 2.0 * np.maximum(0.0, 300.0 - np.abs(x - 3000.0))
    canyon = 1500.0 + 0.02 * y - 1200.0 * (np.abs(x - 3000.0 - 500.0 * np.sin(y / 600)) < 60.0)
    cone = 300 + 2.0 * np.maximum(0.0, 900.0 - np.hypot(x - 3000, y - 3000))
    island = np.maximum(0.0, 400 - 0.6 * np.hypot(x - 3000, y - 3000))
    mesa = 300 + np.clip(1.2 * (1000 - np.hypot(x - 3000, y - 3000)), 0, 400)
    for z in (cliff, ridge, canyon, cone, island, mesa, 300 + 0 * x):
        for ground in (z, -z, z + 0.05 * y):
            assert not find_outliers(ground, 30.0)[0].any()


def test_grids_of_next_to_nothing() -> None:
    for shape in ((1, 1), (1, 40), (2, 3), (5, 5)):
        assert not find_outliers(np.full(shape, 12.0), 30.0)[0].any()
        assert not find_outliers(np.full(shape, np.nan), 30.0)[0].any()


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


@pytest.mark.parametrize(
    ("name", "covered"),
    [
        ("Copernicus_DSM_COG_10_N49_00_E011_00_DEM.tif", True),
        ("ALPSMLC30_N049E011_DSM.tif", True),
        ("ASTGTMV003_N49E011_dem.tif", True),
        ("dom1_32_678_5403.tif", True),
        ("LITTO3D_MNS_1M.asc", True),
        ("dgm1_32_678_5403.tif", False),
        ("RGEALTI_MNT_5M.asc", False),
        ("USGS_13_n46w123.tif", False),
        ("swissalti3d_2019_2.tif", False),
        ("N49E011_FABDEM_V1-2.tif", False),
        ("N49E011.hgt", None),
        ("dem.tif", None),
        ("random.tif", None),
        ("dsm_minus_dtm.tif", None),
    ],
)
def test_names_of_products(name: str, covered: bool | None) -> None:
    assert named_cover(name) is covered


def test_descriptions() -> None:
    assert named_cover("a.tif", ["", "Digital Surface Model 2020"]) is True
    assert named_cover("a.tif", ["bare-earth heights from laser"]) is False
    assert named_cover("a_dtm.tif", ["made from a digital surface model"]) is None


def ground(cells: int, cell: float) -> FloatArray:
    row, col = np.mgrid[:cells, :cells] * cell
    z: FloatArray = 300 + 0.03 * col + 15 * np.sin(col / 300) * np.cos(row / 200) + 4 * np.sin(row / 60)
    return z


def objects(cells: int, cell: float, share: float, seed: int = 2) -> FloatArray:
    """Houses and trees of 3 to 12 m over a share of the ground, some 15 m wide."""
    field = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(cells, cells)), max(7.0 / cell, 0.5))
    least = np.quantile(field, 1.0 - share)
    z: FloatArray = np.where(field > least, 3 + np.clip(9 * (field - least) / field.std(), 0, 9), 0.0)
    return z


@pytest.mark.parametrize(("cell", "noise"), [(1.0, 0.1), (2.0, 0.15), (5.0, 0.4)])
@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_fine_models_show_walls(cell: float, noise: float, share: float) -> None:
    z = ground(400, cell) + np.random.default_rng(1).normal(0, noise, (400, 400))
    assert not looks_covered(z, (cell, cell))
    assert looks_covered(z + objects(400, cell, share), (cell, cell))


@pytest.mark.parametrize("cell", [20.0, 30.0])
def test_coarse_models_show_blobs(cell: float) -> None:
    rng = np.random.default_rng(4)
    noise = ndimage.gaussian_filter(rng.normal(0, 1, (200, 200)), 1.0)
    z = ground(200, cell) + 1.5 * noise / noise.std()
    assert not looks_covered(z, (cell, cell))
    assert not looks_covered(np.round(z), (cell, cell))
    blobs = z + objects(200, 7.0, 0.1)
    assert looks_covered(blobs, (cell, cell))
    # Turned upside down the same blobs are pits, which are on no surface model.
    assert not looks_covered(-blobs, (cell, cell))


def test_mountains_are_no_canopy() -> None:
    row, col = np.mgrid[:600, :600]
    # Slopes of 45 degrees with ledges of rock 3 m high.
    steep = np.floor((row + 0.3 * col) / 3.0) * 3.0
    assert not looks_covered(steep.astype(np.float64), (1.0, 1.0))
    # A wall of 20 m through gentle ground.
    assert not looks_covered(ground(600, 1.0) + 20.0 * (col > 310), (1.0, 1.0))


def test_too_little_to_tell() -> None:
    z = np.zeros((12, 12))
    z[::2, ::2] = 10.0
    assert not looks_covered(z, (1.0, 1.0))
    assert not looks_covered(z, (30.0, 30.0))
    assert not looks_covered(np.full((100, 100), np.nan), (1.0, 1.0))
    assert not looks_covered(np.zeros((2, 3)), (30.0, 30.0))
