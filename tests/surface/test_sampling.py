""" """

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
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
from pyproj import CRS

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import LocalFrame
from osm2xodr.projection import transformer_to
from osm2xodr.surface import METHODS
from osm2xodr.surface.grids.grid import GridFrame
from osm2xodr.surface.grids.voids import fit_polynomial
from osm2xodr.surface.mosaic import fit_trend
from osm2xodr.surface.sampling import Layer, LayeredSurface, Trend

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

# The local frame itself as a raster's CRS: positions are what they seem.
LOCAL = CRS.from_user_input(BAVARIA.proj)


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
        # Half a metre of way at a slope of 30 % at most, and half a metre of rounding over 20 m.
        assert np.abs(np.diff(z)).max() < 0.5 * 0.3
        at_x, at_y = in_crs(BAVARIA, "EPSG:32632", x, y)
        u, v = (at_x - px.mean()) / 1000, (at_y - py.mean()) / 1000
        error = z - (400 + 60 * u - 80 * v + 30 * u * v + 25 * np.sin(4 * u) * np.cos(3 * v))
        assert np.abs(error[measured]).max() < 0.8
        assert np.abs(error[~measured]).max() < 15.0
        assert list(diagnostics) == []


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
    assert 400 < z.min() < z.max() < 600
    # Half a metre of way at a slope of 20 % at most, and the steps of the surface of steps itself.
    assert np.abs(np.diff(z)).max() < (3.0 if method == "nearest" else 0.16)
    assert kinds(diagnostics) == []


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


def layer(z: np.ndarray, west: float, north: float, cell: float, ramp: float = 100.0) -> Layer:  # type: ignore[type-arg]
    frame = GridFrame(LOCAL, transformer_to(BAVARIA, LOCAL), (cell, 0.0, west, 0.0, -cell, north), *z.shape)
    return Layer(frame, z, 1.0, ramp)


def trend(height: float = 0.0) -> Trend:
    x, y = np.random.default_rng(1).uniform(-500, 500, (2, 50))
    polynomial = fit_polynomial(x, y, np.full(50, height), 1)
    return Trend(polynomial, (-500.0, -500.0, 500.0, 500.0), height - 1000.0, height + 1000.0)


def test_a_layer_holds_in_its_cells_and_fades_beyond() -> None:
    surface = LayeredSurface([layer(np.full((20, 20), 8.0), -100.0, 100.0, 10.0)], trend(), "bilinear")
    x = np.array([0.0, 95.0, 99.9, 105.0, 150.0, 200.0, 1000.0])
    z, source = surface.sample(x, np.zeros(7))
    assert source.tolist() == [0, 0, 0, -1, -1, -1, -1]
    # From half a cell beyond the last centre on the height fades over 100 m, half of it gone after 50 m.
    assert z == pytest.approx([8.0, 8.0, 8.0, 8.0 * (1 - 0.05**2 * (3 - 0.1)), 4.0, 0.0, 0.0])


def test_layers_in_order() -> None:
    upper = layer(np.full((20, 20), 5.0), -100.0, 100.0, 10.0)
    lower = layer(np.full((40, 40), 2.0), -200.0, 200.0, 10.0, ramp=1000.0)
    surface = LayeredSurface([upper, lower], trend(), "bilinear")
    z, source = surface.sample(np.array([0.0, 150.0, 195.0, 205.0]), np.zeros(4))
    assert source.tolist() == [0, 1, 1, -1]
    assert z[:2] == pytest.approx([5.0, 3.5])


def test_voids_are_filled_from_below_and_measured_there() -> None:
    cells = np.full((20, 20), 5.0)
    cells[8:12, 8:12] = np.nan
    upper = layer(cells, -100.0, 100.0, 10.0)
    lower = layer(2.0 + 0.1 * np.tile(np.arange(40.0), (40, 1)), -200.0, 200.0, 10.0)
    both = LayeredSurface([upper, lower], trend(), "bilinear").sample(np.array([0.0, 55.0]), np.zeros(2))
    alone = LayeredSurface([upper], trend(5.0), "bilinear").sample(np.array([0.0, 55.0]), np.zeros(2))
    assert both[1].tolist() == [1, 0]
    assert alone[1].tolist() == [-1, 0]
    assert alone[0] == pytest.approx([5.0, 5.0])
    # The void keeps some of the step of about a metre at its rim.
    assert 3.95 < both[0][0] < 5.0


def test_positions_that_are_not_finite_stay_so() -> None:
    surface = LayeredSurface([layer(np.full((20, 20), 8.0), -100.0, 100.0, 10.0)], trend(), "bilinear")
    z, source = surface.sample(np.array([np.nan, 0.0]), np.zeros(2))
    assert np.isnan(z[0])
    assert source.tolist() == [-1, 0]


def test_no_positions() -> None:
    surface = LayeredSurface([layer(np.full((20, 20), 8.0), -100.0, 100.0, 10.0)], trend(), "bicubic")
    z, source = surface.sample(np.zeros(0), np.zeros(0))
    assert (len(z), len(source)) == (0, 0)


def test_the_trend_keeps_within_its_box_and_heights() -> None:
    x, y = np.random.default_rng(1).uniform(-100, 100, (2, 500))
    polynomial = fit_polynomial(x, y, x**4 / 1e6, 4)
    kept = Trend(polynomial, (-110.0, -110.0, 110.0, 110.0), -10.0, 120.0)
    at = np.array([0.0, 100.0, 105.0, 110.0, 5000.0])
    assert kept.heights(at, np.zeros(5)) == pytest.approx([0.0, 100.0, 120.0, 120.0, 120.0], abs=1e-6)
    assert polynomial.heights(np.array([5000.0]), np.zeros(1))[0] == pytest.approx(6.25e8)


def test_beyond_its_box_the_slope_of_the_trend_fades_and_does_not_break_off() -> None:
    x, y = np.random.default_rng(1).uniform(-500, 500, (2, 500))
    plane = fit_polynomial(x, y, 50.0 + 0.02 * x - 0.01 * y, 2)
    kept = Trend(plane, (-500.0, -500.0, 500.0, 500.0), 0.0, 200.0, (0.02, -0.01), 1000.0)
    away = np.array([0.0, 1.0, 100.0, 1000.0, 5000.0, 1e6])
    east = kept.heights(500.0 + away, 0.0 * away)
    assert east == pytest.approx(60.0 + 20.0 * (1 - np.exp(-away / 1000.0)))
    # Level with the box at its rim, with the same slope, and never a constant near by.
    assert (east[1] - east[0]) / 1.0 == pytest.approx(0.02, rel=1e-3)
    assert east[4] - east[3] > 5.0
    # Beyond a corner it goes on along the line to the corner.
    corner = kept.heights(500.0 + 0.6 * away, 500.0 + 0.8 * away)
    assert corner == pytest.approx(55.0 + (0.6 * 20.0 - 0.8 * 10.0) * (1 - np.exp(-away / 1000.0)))
    # As far as the heights that are plausible.
    assert Trend(plane, kept.box, 0.0, 70.0, kept.slope, 1000.0).heights(np.array([5000.0]), np.zeros(1)) == [70.0]


def test_an_island_beside_the_model_takes_the_slope_of_the_land() -> None:
    # A plane on 2 km by 2 km, and heights up to 6 km east of it.
    cells = 300.0 + 0.01 * np.tile(-1000.0 + 20.0 * np.arange(101.0), (101, 1))
    land = layer(cells, -1010.0, 1010.0, 20.0, ramp=1000.0)
    surface = LayeredSurface([land], fit_trend([land], 4), "bicubic")
    x = np.array([900.0, 1500.0, 2500.0, 4500.0, 7000.0])
    z, source = surface.sample(x, np.zeros(5))
    assert source.tolist() == [0, -1, -1, -1, -1]
    d = np.maximum(x - 1020.0, 0.0)
    rise = np.minimum(x, 1020.0) + 500.0 * -np.expm1(-d / 500.0)
    # At most as far above the highest cell as half of what cells differ by.
    assert z == pytest.approx(np.minimum(300.0 + 0.01 * rise, 320.0), abs=0.05)
    assert (np.diff(z) > 0).all()
