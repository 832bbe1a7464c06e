from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.surface.grids import outliers
from osm2xodr.surface.grids.grid import Cells
from osm2xodr.surface.grids.outliers import find_outliers


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
    monkeypatch.setattr(outliers, "_STRIP_CELLS", 150 * 7)
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
