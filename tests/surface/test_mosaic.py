from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from affine import Affine
from dem_factory import BAVARIA, around, centres, in_crs, moved, read, scatter, write_raster
from pyproj import Transformer

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import FloatArray


def hills(px: FloatArray, py: FloatArray) -> FloatArray:
    """Heights over UTM 32, with slopes of up to 14 %."""
    x0, y0 = in_crs(BAVARIA, "EPSG:32632", 0.0, 0.0)
    u, v = (px - x0) / 1000, (py - y0) / 1000
    z: FloatArray = 400 + 50 * u - 30 * v + 20 * np.sin(2 * u) * np.cos(2 * v)
    return z


def tile(
    path: Path, cell: float, crs: str, cols: tuple[float, float], rise: float = 0.0, half: float = 1000.0
) -> Path:
    """Write the columns of the hills between two shares of the area's width, raised by some metres."""
    transform, rows, count = around(BAVARIA, crs, cell, half)
    first, last = int(cols[0] * count), int(cols[1] * count)
    part = moved(transform, first * cell, 0.0)
    px, py = centres(part, rows, last - first)
    if crs != "EPSG:32632":
        px, py = Transformer.from_crs(crs, 32632, always_xy=True).transform(px, py)
    return write_raster(path, (hills(px, py) + rise).astype(np.float32), part, crs)


def truth(x: FloatArray, y: FloatArray) -> FloatArray:
    return hills(*in_crs(BAVARIA, "EPSG:32632", x, y))


ALONG = np.linspace(-900.0, 900.0, 36001)


@pytest.mark.parametrize(
    ("second", "cols"),
    [
        pytest.param((20.0, "EPSG:32632"), (0.5, 1.0), id="abutting-on-one-grid"),
        pytest.param((20.0, "EPSG:32632"), (0.3, 1.0), id="overlapping-on-one-grid"),
        pytest.param((20.0, "EPSG:32632"), (0.48, 1.0), id="hardly-overlapping-on-one-grid"),
        pytest.param((30.0, "EPSG:32632"), (0.4, 1.0), id="coarser"),
        pytest.param((1 / 2400, "EPSG:4326"), (0.4, 1.0), id="geographic"),
        pytest.param((45.0, "EPSG:3857"), (0.46, 1.0), id="hardly-overlapping-in-another-crs"),
    ],
)
@pytest.mark.parametrize("method", ["bilinear", "bicubic"])
def test_a_step_of_three_metres_becomes_a_ramp(
    tmp_path: Path, second: tuple[float, str], cols: tuple[float, float], method: str
) -> None:
    left = tile(tmp_path / "left.tif", 20.0, "EPSG:32632", (0.0, 0.5))
    right = tile(tmp_path / "right.tif", *second, cols, rise=3.0)
    for y in (333.3, -700.0):
        across = ALONG, np.full(len(ALONG), y)
        surface, diagnostics = read([left, right], BAVARIA, *across, method=method)
        z, measured = surface.heights(*across)
        assert measured.all()
        rise = z - truth(*across)
        # The first is as it is, the second is reached within its ramp, and between them it goes up evenly.
        assert np.abs(rise[ALONG < -60.0]).max() < 0.25
        assert np.abs(rise[ALONG > 250.0] - 3.0).max() < 0.5
        assert -0.3 < rise.min() < rise.max() < 3.5
        # 5 cm of way: at 17 % of slope and 3 m over a ramp of 100 m or more that is half a centimetre more.
        assert np.abs(np.diff(z)).max() < 0.05 * (0.17 + 1.5 * 3.0 / 100.0)
        assert ("dem-step" in [item.code for item in diagnostics]) == (second == (20.0, "EPSG:32632"))


def test_tiles_of_one_model_are_one_grid(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = hills(*centres(transform, rows, cols))
    whole = write_raster(tmp_path / "whole.tif", cells, transform, "EPSG:32632")
    tiles = []
    for i, top in enumerate(range(0, rows, 40)):
        for j, left in enumerate(range(0, cols, 30)):
            part = cells[top : top + 40, left : left + 30]
            name = tmp_path / f"{i}_{j}.tif"
            tiles.append(write_raster(name, part, moved(transform, 20.0 * left, -20.0 * top), "EPSG:32632"))
    x, y = scatter(half=1000.0, count=3000)
    alone, _ = read(whole, BAVARIA, x, y, method="bicubic")
    together, diagnostics = read(tiles[::-1], BAVARIA, x, y, method="bicubic")
    assert len(tiles) == 12
    assert list(diagnostics) == []
    z, measured = together.heights(x, y)
    assert measured.all()
    assert np.abs(z - alone.heights(x, y)[0]).max() < 1e-9
    assert [dem.path for dem in together.dems] == tiles[::-1]
    assert sum(dem.share for dem in together.dems) == pytest.approx(1.0)


def test_overlapping_tiles_of_one_model(tmp_path: Path) -> None:
    left = tile(tmp_path / "left.tif", 20.0, "EPSG:32632", (0.0, 0.5))
    right = tile(tmp_path / "right.tif", 20.0, "EPSG:32632", (0.45, 1.0))
    x, y = scatter(half=950.0)
    surface, diagnostics = read([left, right], BAVARIA, x, y)
    assert list(diagnostics) == []
    assert np.abs(surface.heights(x, y)[0] - truth(x, y)).max() < 0.03


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_finer_comes_first_whatever_the_order(tmp_path: Path, order: tuple[int, int]) -> None:
    fine = tile(tmp_path / "fine.tif", 5.0, "EPSG:32632", (0.3, 0.7), rise=2.0)
    coarse = tile(tmp_path / "coarse.tif", 40.0, "EPSG:32632", (0.0, 1.0))
    x, y = scatter(half=950.0, count=4000)
    surface, diagnostics = read([(fine, coarse)[k] for k in order], BAVARIA, x, y)
    z, measured = surface.heights(x, y)
    rise = z - truth(x, y)
    inside, outside = np.abs(x) < 350.0, np.abs(x) > 650.0
    assert measured.all()
    assert list(diagnostics) == []
    assert np.abs(rise[inside] - 2.0).max() < 0.01
    assert np.abs(rise[outside]).max() < 0.1
    # Most roads lie on the coarse one.
    assert surface.cell_size == pytest.approx(40.0, rel=1e-3)
    few, _ = read([fine, coarse], BAVARIA, x[inside], y[inside])
    assert few.cell_size == pytest.approx(5.0, rel=1e-3)


def test_the_first_given_comes_first_among_equals(tmp_path: Path) -> None:
    files = [tile(tmp_path / f"{k}.tif", 20.0 + 0.5 * k, "EPSG:32632", (0.0, 1.0), rise=float(k)) for k in range(3)]
    x, y = scatter()
    for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
        surface, _ = read([files[k] for k in order], BAVARIA, x, y)
        assert np.abs(surface.heights(x, y)[0] - truth(x, y) - order[0]).max() < 0.05


def test_voids_of_the_first_are_filled_from_the_second(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 5.0)
    px, py = centres(transform, rows, cols)
    cells = hills(px, py) + 3.0
    u, v = px - px.mean(), py - py.mean()
    cells[np.hypot(u, v) < 30.0] = np.nan
    cells[np.hypot(u - 500.0, v) < 300.0] = np.nan
    fine = write_raster(tmp_path / "fine.tif", cells, transform, "EPSG:32632")
    coarse = tile(tmp_path / "coarse.tif", 30.0, "EPSG:32632", (0.0, 1.0))
    across = ALONG, 0.0 * ALONG
    alone, _ = read(fine, BAVARIA, *across)
    assert alone.heights(*across)[1].mean() < 0.7
    surface, diagnostics = read([fine, coarse], BAVARIA, *across)
    z, measured = surface.heights(*across)
    rise = z - truth(*across)
    assert measured.all()
    assert list(diagnostics) == []
    # A small void keeps the level of what is around it, in the middle of a large one the second model holds.
    assert np.abs(rise[np.abs(ALONG) < 40.0] - 3.0).max() < 0.6
    assert np.abs(rise[np.abs(ALONG - 500.0) < 20.0]).max() < 0.7
    assert np.abs(np.diff(z)).max() < 0.05 * (0.17 + 0.1)


def test_units_and_crs_mixed(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 10.0)
    px, py = centres(transform, rows, cols // 2)
    feet = write_raster(tmp_path / "feet.tif", hills(px, py) / 0.3048, transform, "EPSG:32632", units="ft")
    metres = tile(tmp_path / "metres.tif", 1 / 3600, "EPSG:4326", (0.0, 1.0))
    x, y = scatter(half=950.0, count=2000)
    surface, _ = read([feet, metres], BAVARIA, x, y)
    z, measured = surface.heights(x, y)
    assert measured.all()
    assert np.abs(z - truth(x, y)).max() < 0.1
    assert [dem.unit for dem in surface.dems] == ["ft", "metre"]


def test_a_gap_between_two_models_is_bridged(tmp_path: Path) -> None:
    left = tile(tmp_path / "left.tif", 20.0, "EPSG:32632", (0.0, 0.4))
    right = tile(tmp_path / "right.tif", 20.0, "EPSG:32632", (0.7, 1.0))
    across = ALONG, 0.0 * ALONG
    surface, diagnostics = read([left, right], BAVARIA, *across)
    z, measured = surface.heights(*across)
    assert 0.27 < np.mean(~measured) < 0.37
    assert np.abs((z - truth(*across))[measured]).max() < 0.05
    assert np.abs((z - truth(*across))[~measured]).max() < 10.0
    assert np.abs(np.diff(z)).max() < 0.05 * 0.3
    assert list(diagnostics) == []


def test_few_heights_lower_the_degree_of_the_trend(tmp_path: Path) -> None:
    transform = Affine(500.0, 0.0, float(in_crs(BAVARIA, "EPSG:32632", 0, 0)[0]) - 1000, 0.0, -500.0,
                       float(in_crs(BAVARIA, "EPSG:32632", 0, 0)[1]) + 1000)  # fmt: skip
    path = write_raster(tmp_path / "a.tif", hills(*centres(transform, 4, 4)), transform, "EPSG:32632")
    x, y = scatter(half=400.0)
    surface, diagnostics = read(path, BAVARIA, x, y)
    assert surface.polynomial.order == 2
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.NOTE, "trend-order")]


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_the_polynomial_surface(tmp_path: Path, order: int) -> None:
    path = tile(tmp_path / "a.tif", 20.0, "EPSG:32632", (0.0, 1.0))
    x, y = scatter()
    options: dict[str, Any] = {"method": "polynomial", "polynomial_order": order}
    surface, _ = read(path, BAVARIA, x, y, **options)
    z, measured = surface.heights(x, y)
    assert measured.all()
    assert surface.polynomial.order == order
    assert np.array_equal(z, surface.polynomial.heights(x, y))
    # The hills are even in one direction and odd in the other: every second order takes more of them.
    assert np.sqrt(np.mean((z - truth(x, y)) ** 2)) < {2: 6.5, 3: 6.5, 4: 1.7, 5: 1.7}[order]


def kinds(diagnostics: Diagnostics) -> list[str]:
    return [item.code for item in diagnostics]


def test_only_the_window_is_read(tmp_path: Path) -> None:
    path = tmp_path / "huge.tif"
    size, cell = 20000, 5.0
    centre = in_crs(BAVARIA, "EPSG:32632", 0.0, 0.0)
    transform = Affine(cell, 0, float(centre[0]) - 40000, 0, -cell, float(centre[1]) + 60000)
    with rasterio.open(
        path, "w", driver="GTiff", width=size, height=size, count=1, dtype="float32", crs="EPSG:32632", nodata=-1.0,
        transform=transform, tiled=True, blockxsize=256, blockysize=256, sparse_ok=True,
    ) as dataset:  # fmt: skip
        dataset.write(np.full((1, 512, 512), 55.0, np.float32), window=rasterio.windows.Window(7744, 11744, 512, 512))
    x, y = scatter()
    read(path, BAVARIA, x, y)
    tracemalloc.start()
    surface, _ = read(path, BAVARIA, x, y)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert surface.heights(x, y)[0] == pytest.approx(55.0)
    # 1800 m of roads at 5 m, and 50 m on every side.
    assert 360**2 < surface.dems[0].cells < 390**2
    # The whole raster takes 1.6 GB.
    assert peak < 20e6


def test_large_windows_are_averaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("osm2xodr.surface.reading._CELLS_MAX", 5000)
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 10.0)
    px, py = centres(transform, rows, cols)
    heights = 0.1 * (px - px.mean()) - 0.2 * (py - py.mean())
    heights[::7, ::5] = np.nan
    path = write_raster(tmp_path / "a.tif", heights, transform, "EPSG:32632")
    x, y = scatter(half=800.0)
    surface, diagnostics = read(path, BAVARIA, x, y)
    assert surface.dems[0].cells <= 5000
    assert surface.cell_size == pytest.approx(30.0, rel=1e-3)
    at_x, at_y = in_crs(BAVARIA, "EPSG:32632", x, y)
    # Voids shift a block's mean by less than a cell.
    assert np.abs(surface.heights(x, y)[0] - 0.1 * (at_x - px.mean()) + 0.2 * (at_y - py.mean())).max() < 0.5
    assert kinds(diagnostics) == ["dem-averaged"]


def test_the_ways_from_a_crs_are_looked_for_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # In PROJ's database this takes .02 to .2 s each time.
    halves = [(k / 4, (k + 1) / 4) for k in range(4)]
    tiles = [tile(tmp_path / f"{k}.tif", 20.0, "EPSG:25833", cols) for k, cols in enumerate(halves)]
    looked_for: list[tuple[object, object]] = []
    from_crs = Transformer.from_crs

    def counted(source: object, target: object, **options: Any) -> Transformer:
        looked_for.append((source, target))
        return from_crs(source, target, **options)

    monkeypatch.setattr(Transformer, "from_crs", counted)
    read(tiles, BAVARIA, *scatter(), method="bilinear")
    ways = {(str(source), str(target)) for source, target in looked_for}
    assert len(looked_for) == len(ways) <= 2
