from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from affine import Affine
from dem_factory import (
    BAVARIA,
    MALTA,
    OREGON,
    around,
    centres,
    in_crs,
    moved,
    place,
    read,
    scatter,
    to_local,
    write_raster,
)
from hypothesis import HealthCheck, given, settings, strategies as st
from pyproj import Transformer

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import InputError
from osm2xodr.model import FloatArray, LocalFrame, Surface
from osm2xodr.surface import METHODS, FlatSurface, SurfaceOptions, read_surface

DEGREES_30_M = 1 / 3600


PLACES = pytest.mark.parametrize(
    ("frame", "crs", "cell"),
    [
        pytest.param(BAVARIA, "EPSG:4326", DEGREES_30_M, id="geographic"),
        pytest.param(BAVARIA, "EPSG:32632", 20.0, id="utm"),
        pytest.param(BAVARIA, "EPSG:3857", 30.0, id="web-mercator"),
        pytest.param(MALTA, "EPSG:23033", 40.0, id="ed50"),
        pytest.param(OREGON, "EPSG:4269", DEGREES_30_M / 3, id="nad83"),
        pytest.param(OREGON, "EPSG:2269", 50.0, id="state-plane-feet"),
    ],
)


def kinds(diagnostics: Diagnostics) -> list[str]:
    return [item.code for item in diagnostics]


@PLACES
@pytest.mark.parametrize("axis", [0, 1])
def test_one_sided_ramp_is_neither_mirrored_nor_shifted(
    tmp_path: Path, frame: LocalFrame, crs: str, cell: float, axis: int
) -> None:
    transform, rows, cols = around(frame, crs, cell)
    position = centres(transform, rows, cols)
    # The ramp begins at the centre of a cell, so that the bilinear surface is the ramp itself: 20 % or so of slope.
    begin = np.unique(position[axis])[len(np.unique(position[axis])) // 3]
    per_cell = 0.2 * 30.0
    heights = 100.0 + per_cell * np.maximum(0.0, position[axis] - begin) / cell
    path = write_raster(tmp_path / "ramp.tif", heights, transform, crs)
    x, y = scatter()
    surface, _ = read(path, frame, x, y)
    z, measured = surface.heights(x, y)
    expected = 100.0 + per_cell * np.maximum(0.0, in_crs(frame, crs, x, y)[axis] - begin) / cell
    assert np.ptp(expected) > 50.0
    assert np.abs(z - expected).max() < 1e-4
    assert measured.all()
    assert surface.coverage == 1.0


@PLACES
@pytest.mark.parametrize("method", ["bilinear", "bicubic", "polynomial"])
def test_plane_is_reproduced(tmp_path: Path, frame: LocalFrame, crs: str, cell: float, method: str) -> None:
    transform, rows, cols = around(frame, crs, cell)
    px, py = centres(transform, rows, cols)
    heights = 500.0 + 2.0 * (px - px.mean()) / cell - 3.0 * (py - py.mean()) / cell
    path = write_raster(tmp_path / "plane.tif", heights, transform, crs)
    x, y = scatter()
    surface, _ = read(path, frame, x, y, method=method)
    z, _ = surface.heights(x, y)
    at_x, at_y = in_crs(frame, crs, x, y)
    expected = 500.0 + 2.0 * (at_x - px.mean()) / cell - 3.0 * (at_y - py.mean()) / cell
    # A plane in the raster's CRS is bent by the projection a little for the polynomial in the local frame.
    assert np.abs(z - expected).max() < 1e-4


def test_cell_size_is_metric(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:4326", DEGREES_30_M)
    path = write_raster(tmp_path / "a.tif", np.ones((rows, cols), np.float32), transform, "EPSG:4326")
    surface, _ = read(path, BAVARIA, *scatter())
    # At 49.5 degrees north one arc second is 20.11 m of parallel and 30.89 m of meridian.
    assert surface.cell_size == pytest.approx(np.sqrt(20.11 * 30.89), rel=1e-3)
    transform, rows, cols = around(BAVARIA, "EPSG:3857", 30.0)
    path = write_raster(tmp_path / "b.tif", np.ones((rows, cols), np.float32), transform, "EPSG:3857")
    surface, _ = read(path, BAVARIA, *scatter())
    assert surface.cell_size == pytest.approx(30.0 * np.cos(np.radians(49.5)), rel=5e-3)


@pytest.mark.parametrize(
    "turn",
    [
        pytest.param((0.8, 0.6, -0.6, 0.8), id="rotated"),
        pytest.param((0.28, 0.48, 0.96, -0.14), id="rotated-oblong"),
        pytest.param((1.0, 0.3, 0.0, -1.0), id="sheared"),
        pytest.param((1.0, 0.0, 0.0, 1.0), id="south-up"),
        pytest.param((-1.0, 0.0, 0.0, -1.0), id="east-left"),
        pytest.param((0.0, 1.0, 1.0, 0.0), id="transposed"),
    ],
)
def test_any_affine_transform(tmp_path: Path, turn: tuple[float, float, float, float]) -> None:
    x0, y0 = (float(value) for value in in_crs(BAVARIA, "EPSG:32632", 0.0, 0.0))
    a, b, d, e = 20.0 * np.array(turn)
    transform = Affine(a, b, x0 - 150 * a - 160 * b, d, e, y0 - 150 * d - 160 * e)
    px, py = centres(transform, 320, 300)
    path = write_raster(tmp_path / "turned.tif", 300.0 + 0.1 * (px - x0) - 0.2 * (py - y0), transform, "EPSG:32632")
    x, y = scatter()
    surface, _ = read(path, BAVARIA, x, y)
    z, measured = surface.heights(x, y)
    at_x, at_y = in_crs(BAVARIA, "EPSG:32632", x, y)
    assert measured.all()
    assert np.abs(z - (300.0 + 0.1 * (at_x - x0) - 0.2 * (at_y - y0))).max() < 1e-5
    lengths = np.hypot(a, d) * np.hypot(b, e)
    assert surface.cell_size == pytest.approx(np.sqrt(lengths), rel=1e-3)


def test_pixel_is_point(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    px, _ = centres(transform, rows, cols)
    heights = 0.1 * (px - px.mean())
    area = write_raster(tmp_path / "area.tif", heights, transform, "EPSG:32632")
    point = write_raster(tmp_path / "point.tif", heights, transform, "EPSG:32632", tags={"AREA_OR_POINT": "Point"})
    with rasterio.open(area) as a, rasterio.open(point) as b:
        assert a.tags()["AREA_OR_POINT"] != b.tags()["AREA_OR_POINT"]
    # The two files state other tie points for the same cells; the heights are where they are.
    assert area.read_bytes() != point.read_bytes()
    x, y = scatter()
    z_area, z_point = (read(path, BAVARIA, x, y)[0].heights(x, y)[0] for path in (area, point))
    assert np.array_equal(z_area, z_point)
    expected = 0.1 * (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - px.mean())
    assert np.abs(z_point - expected).max() < 1e-5


@pytest.mark.parametrize(
    ("units", "crs", "factor"),
    [
        ("ft", "EPSG:32632", 0.3048),
        ("US survey foot", "EPSG:32632", 1200 / 3937),
        ("m", "EPSG:32632", 1.0),
        ("cm", "EPSG:32632", 0.01),
        (None, "EPSG:25832+5783", 1.0),
        (None, "EPSG:26910+6360", 1200 / 3937),
        (None, "EPSG:26910+8228", 0.3048),
        ("m", "EPSG:26910+8228", 1.0),
    ],
)
def test_units(tmp_path: Path, units: str | None, crs: str, factor: float) -> None:
    frame = OREGON if "26910" in crs else BAVARIA
    transform, rows, cols = around(frame, crs.split("+")[0], 20.0)
    path = write_raster(tmp_path / "a.tif", np.full((rows, cols), 1234.5), transform, crs, units=units)
    surface, diagnostics = read(path, frame, *scatter())
    z, _ = surface.heights(*scatter())
    assert np.abs(z - 1234.5 * factor).max() < 1e-6
    assert kinds(diagnostics) == []


def test_units_that_are_guessed(tmp_path: Path) -> None:
    transform, rows, cols = around(OREGON, "EPSG:2269", 50.0)
    cells = np.full((rows, cols), 100.0)
    feet = write_raster(tmp_path / "feet.tif", cells, transform, "EPSG:2269")
    surface, diagnostics = read(feet, OREGON, *scatter())
    assert surface.heights(*scatter())[0] == pytest.approx(100.0)
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.GUESSED, "dem-unit")]
    cubits = write_raster(tmp_path / "cubits.tif", cells, transform, "EPSG:2269", units="cubit")
    _, diagnostics = read(cubits, OREGON, *scatter())
    assert [item.message for item in diagnostics] == [
        f"{cubits}: the unit of heights 'cubit' is not known; they were taken as metres."
    ]


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "int32", "float32", "float64"])
def test_scale_offset_and_every_type_of_cells(tmp_path: Path, dtype: str) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.broadcast_to(np.arange(cols) % 200, (rows, cols)).astype(dtype)
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", scale=0.5, offset=-100.0)
    x, y = scatter()
    surface, diagnostics = read(path, BAVARIA, x, y, method="nearest")
    col = (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - transform.c) / 20.0
    assert np.array_equal(surface.heights(x, y)[0], np.floor(col) % 200 * 0.5 - 100.0)
    assert surface.dems[0].dtype == dtype
    assert kinds(diagnostics) == []


def test_voids_are_flagged_and_filled_without_a_step(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    px, py = centres(transform, rows, cols)
    u, v = (px - px.mean()) / 1000, (py - py.mean()) / 1000
    truth = 400 + 60 * u - 80 * v + 30 * u * v + 25 * np.sin(4 * u) * np.cos(3 * v)
    cells = np.round(truth).astype(np.int16)
    hole = np.hypot(u - 0.2, v + 0.1) < 0.35
    cells[hole] = -32768
    path = write_raster(tmp_path / "holes.tif", cells, transform, "EPSG:32632", nodata=-32768)
    t = np.linspace(-900, 900, 3601)
    for x, y in ((t, 0 * t - 100.0), (0 * t + 200.0, t), (t, t)):
        surface, diagnostics = read(path, BAVARIA, x, y)
        z, measured = surface.heights(x, y)
        assert 0.2 < np.mean(~measured) < 0.45
        assert surface.coverage == np.mean(measured)
        # Half a metre of way at a slope of 30 % at most, and half a metre of rounding over 20 m.
        assert np.abs(np.diff(z)).max() < 0.5 * 0.3
        at_x, at_y = in_crs(BAVARIA, "EPSG:32632", x, y)
        u, v = (at_x - px.mean()) / 1000, (at_y - py.mean()) / 1000
        error = z - (400 + 60 * u - 80 * v + 30 * u * v + 25 * np.sin(4 * u) * np.cos(3 * v))
        assert np.abs(error[measured]).max() < 0.8
        assert np.abs(error[~measured]).max() < 14.0
        assert [(item.kind, item.code) for item in diagnostics] == [(Kind.GUESSED, "dem-gap")]


def test_a_point_is_measured_only_if_all_its_cells_are(tmp_path: Path) -> None:
    transform = Affine(10, 0, 600000, 0, -10, 5500000)
    cells = np.full((200, 200), 7.0, np.float32)
    cells[100, 100] = np.nan
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    col = np.array([101.0, 101.5, 100.9, 100.4, 99.4, 99.0])
    x, y = to_local(BAVARIA, "EPSG:32632", *place(transform, col, np.full(6, 100.0)))
    surface, _ = read(path, BAVARIA, x, y, allow_partial=True)
    # The centre next to the void is measured itself, what lies between it and the void is not.
    assert surface.heights(x, y)[1].tolist() == [True, True, False, False, False, True]
    nearest, _ = read(path, BAVARIA, x, y, allow_partial=True, method="nearest")
    assert nearest.heights(x, y)[1].tolist() == [True, True, True, False, True, True]


@pytest.mark.parametrize("value", [-32768, -9999])
def test_undeclared_sentinels_are_voids(tmp_path: Path, value: int) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 321, np.int16)
    cells[:, 40:44] = value
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    surface, diagnostics = read(path, BAVARIA, *scatter())
    z, measured = surface.heights(*scatter())
    assert z == pytest.approx(321.0)
    assert 0.01 < np.mean(~measured) < 0.1
    assert [(item.kind, item.code) for item in diagnostics] == [
        (Kind.REPAIRED, "dem-sentinel"),
        (Kind.GUESSED, "dem-gap"),
    ]
    assert next(iter(diagnostics)).message == (
        f"{path}: {4 * rows} cells hold values that are not heights ({value}) and that the file does not declare as "
        "nodata; they were taken for voids."
    )


@pytest.mark.parametrize("value", [3.4028235e38, -3.4028235e38, 1e20, 12345.0, np.inf, np.nan])
def test_impossible_heights_are_voids(tmp_path: Path, value: float) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 321, np.float32)
    cells[40:44] = value
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", nodata=-32768)
    surface, diagnostics = read(path, BAVARIA, *scatter())
    z, measured = surface.heights(*scatter())
    assert z == pytest.approx(321.0)
    assert 0.01 < np.mean(~measured) < 0.1
    assert ("dem-sentinel" in kinds(diagnostics)) == np.isfinite(value)


def test_real_heights_are_no_sentinels(tmp_path: Path) -> None:
    # 9999 ft are a pass in Colorado, -410 m the shore of the Dead Sea, -9999 mm the ground of a polder.
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    for value, profile, expected in (
        (9999, {"units": "ft"}, 9999 * 0.3048),
        (-410, {}, -410.0),
        (-9999, {"scale": 0.001}, -9.999),
    ):
        path = write_raster(
            tmp_path / "a.tif", np.full((rows, cols), value, np.int32), transform, "EPSG:32632", **profile
        )
        surface, diagnostics = read(path, BAVARIA, *scatter())
        assert surface.heights(*scatter())[0] == pytest.approx(expected)
        assert kinds(diagnostics) == []


def test_mask_band_and_alpha(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((2, rows, cols), 100, np.uint16)
    cells[1] = 65535
    cells[1, :, :30] = 0
    path = tmp_path / "alpha.tif"
    write_raster(path, cells, transform, "EPSG:32632", photometric="MINISBLACK", alpha="YES")
    x, y = scatter()
    surface, diagnostics = read(path, BAVARIA, x, y)
    col = (in_crs(BAVARIA, "EPSG:32632", x, y)[0] - transform.c) / 20.0
    assert np.array_equal(surface.heights(x, y)[1], col >= 30.5)
    assert kinds(diagnostics) == ["dem-gap"]


def test_first_of_several_bands(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.stack([np.full((rows, cols), 11.0), np.full((rows, cols), 99.0)]).astype(np.float32)
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    surface, diagnostics = read(path, BAVARIA, *scatter())
    assert surface.heights(*scatter())[0] == pytest.approx(11.0)
    assert kinds(diagnostics) == ["dem-bands"]


def test_hgt_and_virtual_raster(tmp_path: Path) -> None:
    row, col = np.mgrid[0:1201, 0:1201]
    cells = (200 + col // 4 + row // 8).astype(np.int16)
    cells[600, 600] = -32768
    hgt = tmp_path / "N49E011.hgt"
    hgt.write_bytes(cells.astype(">i2").tobytes())
    x, y = scatter(half=5000.0)
    lon, lat = in_crs(BAVARIA, 4326, x, y)
    # Tiles hold the heights at the whole three arc seconds from corner to corner.
    at_row, at_col = np.floor((50 - lat) * 1200 + 0.5), np.floor((lon - 11) * 1200 + 0.5)
    expected = 200 + at_col // 4 + at_row // 8
    hole = (at_row == 600) & (at_col == 600)
    surface, _ = read(hgt, BAVARIA, x, y, method="nearest")
    z, measured = surface.heights(x, y)
    assert surface.dems[0].driver == "SRTMHGT"
    assert np.array_equal(measured, ~hole)
    assert np.array_equal(z[measured], expected[measured])
    vrt = tmp_path / "all.vrt"
    vrt.write_text(
        '<VRTDataset rasterXSize="1201" rasterYSize="1201"><SRS>EPSG:4326</SRS>'
        f"<GeoTransform>{11 - 1 / 2400!r}, {1 / 1200!r}, 0, {50 + 1 / 2400!r}, 0, {-1 / 1200!r}</GeoTransform>"
        '<VRTRasterBand dataType="Int16" band="1"><NoDataValue>-32768</NoDataValue><SimpleSource>'
        '<SourceFilename relativeToVRT="1">N49E011.hgt</SourceFilename><SourceBand>1</SourceBand>'
        "</SimpleSource></VRTRasterBand></VRTDataset>"
    )
    virtual, _ = read(vrt, BAVARIA, x, y, method="nearest")
    assert virtual.dems[0].driver == "VRT"
    assert np.array_equal(virtual.heights(x, y)[0], z)


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


def test_longitudes_beyond_half_a_turn(tmp_path: Path) -> None:
    transform, rows, cols = around(OREGON, "EPSG:4326", DEGREES_30_M)
    px, py = centres(transform, rows, cols)
    heights = 1e4 * (px - px.mean()) + 2e4 * (py - py.mean())
    turned = moved(transform, 360.0, 0.0)
    x, y = scatter()
    z = [
        read(write_raster(tmp_path / f"{k}.tif", heights, t, "EPSG:4326"), OREGON, x, y)[0].heights(x, y)[0]
        for k, t in enumerate((transform, turned))
    ]
    assert np.abs(z[1] - z[0]).max() < 1e-3


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    a=st.floats(-2000, 4000),
    b=st.floats(-30, 30),
    c=st.floats(-30, 30),
    method=st.sampled_from(["bilinear", "bicubic"]),
    seed=st.integers(0, 1000),
)
def test_affine_heights_are_reproduced_anywhere(
    tmp_path: Path, a: float, b: float, c: float, method: str, seed: int
) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 25.0)
    row, col = np.mgrid[0:rows, 0:cols]
    a += 450.0 + 50.0 * (abs(b) + abs(c))
    heights = a + b * (col - cols / 2 + 0.5) + c * (row - rows / 2 + 0.5)
    path = write_raster(tmp_path / "plane.tif", heights / 10, transform, "EPSG:32632")
    rng = np.random.default_rng(seed)
    # As far as the outermost cells reach, half a cell beyond their centres.
    at_col, at_row = rng.uniform(-0.5, cols - 0.5, 200), rng.uniform(-0.5, rows - 0.5, 200)
    x, y = to_local(BAVARIA, "EPSG:32632", *place(transform, at_col, at_row))
    surface, _ = read(path, BAVARIA, x, y, method=method)
    z, measured = surface.heights(x, y)
    expected = (a + b * (at_col - cols / 2 + 0.5) + c * (at_row - rows / 2 + 0.5)) / 10
    assert measured.all()
    assert np.abs(z - expected).max() <= 1e-6 * max(1.0, np.abs(heights).max() / 10)


@pytest.mark.parametrize("method", METHODS)
def test_beyond_the_edge_heights_go_on_without_a_step_and_are_not_measured(tmp_path: Path, method: str) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    px, py = centres(transform, rows, cols)
    heights = 500 + 40 * np.sin((px - px.mean()) / 300) + 20 * np.cos((py - py.mean()) / 200)
    path = write_raster(tmp_path / "a.tif", heights, transform, "EPSG:32632")
    x = np.linspace(-900.0, 8000.0, 17801)
    surface, diagnostics = read(path, BAVARIA, x, 0 * x, method=method, allow_partial=True)
    z, measured = surface.heights(x, 0 * x)
    east = transform.c + cols * 20.0
    assert np.array_equal(measured, in_crs(BAVARIA, "EPSG:32632", x, 0 * x)[0] <= east)
    assert surface.coverage == np.mean(measured)
    assert 400 < z.min() < z.max() < 600
    # Half a metre of way at a slope of 20 % at most, and the steps of the surface of steps itself.
    assert np.abs(np.diff(z)).max() < (3.0 if method == "nearest" else 0.15)
    assert kinds(diagnostics) == ["dem-gap"]


def test_summary(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.full((rows, cols), 300, np.int16)
    cells[0, :3] = -1
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632", nodata=-1, units="ft")
    away = write_raster(tmp_path / "b.tif", cells, moved(transform, 0.0, 50000.0), "EPSG:32632")
    surface, diagnostics = read([path, away], BAVARIA, *scatter(half=990.0))
    used, unused = surface.dems
    assert (used.path, used.driver, used.crs, used.dtype, used.unit, used.nodata) == (
        path, "GTiff", "EPSG:32632", "int16", "ft", -1.0,
    )  # fmt: skip
    assert used.cell_size == pytest.approx(20.0, rel=1e-3)
    assert (used.cells, used.voids, used.share) == (rows * cols, 3, 1.0)
    lon, lat = Transformer.from_crs("EPSG:32632", 4326, always_xy=True).transform(
        *place(transform, np.array([0, cols, 0, cols]) - 0.5, np.array([0, 0, rows, rows]) - 0.5)
    )
    assert used.bounds_deg == pytest.approx((lon.min(), lat.min(), lon.max(), lat.max()), abs=1e-6)
    assert (unused.cells, unused.share) == (0, 0.0)
    assert [(item.kind, item.code) for item in diagnostics] == [(Kind.NOTE, "dem-unused")]


def test_sigma(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 30.0)
    rng = np.random.default_rng(1)
    quiet = write_raster(tmp_path / "a.tif", rng.normal(100, 0.01, (rows, cols)), transform, "EPSG:32632")
    loud = write_raster(tmp_path / "b.tif", rng.normal(100, 0.5, (rows, cols)), transform, "EPSG:32632")
    whole = write_raster(tmp_path / "c.tif", rng.integers(99, 102, (rows, cols), np.int16), transform, "EPSG:32632")
    x, y = scatter()
    assert read(quiet, BAVARIA, x, y)[0].sigma == pytest.approx(2.0, rel=1e-3)
    assert read(loud, BAVARIA, x, y)[0].sigma == pytest.approx(2.0, rel=1e-3)
    assert read(whole, BAVARIA, x, y)[0].sigma == pytest.approx(np.hypot(2.0, 1 / np.sqrt(12)), rel=1e-3)
    assert read(loud, BAVARIA, x, y, sigma=0.7)[0].sigma == 0.7
    rough = read(loud, BAVARIA, x, y, sigma=0.1, method="polynomial")[0]
    assert rough.sigma == rough.polynomial.rms == pytest.approx(0.5, rel=0.05)


def test_flat_surface() -> None:
    surface: Surface = FlatSurface()
    z, measured = surface.heights(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    assert (z.tolist(), measured.tolist()) == ([0.0, 0.0], [True, True])
    assert (surface.cell_size, surface.sigma) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "kriging"}, "choose one of nearest, bilinear"),
        ({"polynomial_order": 6}, "choose 2 to 5"),
        ({"sigma": 0.0}, "not above 0"),
        ({"sigma": float("nan")}, "not above 0"),
    ],
)
def test_options_out_of_range(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        SurfaceOptions(**options)


def test_nothing_to_read() -> None:
    nowhere: FloatArray = np.zeros(0)
    with pytest.raises(InputError, match="name at least one file"):
        read_surface([], BAVARIA, np.zeros(1), np.zeros(1), SurfaceOptions(), Diagnostics())
    with pytest.raises(InputError, match="no roads"):
        read_surface([Path("a.tif")], BAVARIA, nowhere, nowhere, SurfaceOptions(), Diagnostics())


def test_same_input_same_surface(tmp_path: Path) -> None:
    transform, rows, cols = around(BAVARIA, "EPSG:32632", 20.0)
    cells = np.random.default_rng(5).normal(100, 3, (rows, cols)).astype(np.float32)
    cells[20:40, 30:50] = np.nan
    path = write_raster(tmp_path / "a.tif", cells, transform, "EPSG:32632")
    x, y = scatter()
    first, second = (read(path, BAVARIA, x, y)[0].heights(x, y)[0] for _ in range(2))
    assert first.tobytes() == second.tobytes()
