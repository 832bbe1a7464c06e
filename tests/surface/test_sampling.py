from __future__ import annotations

import numpy as np
import pytest
from dem_factory import BAVARIA
from pyproj import CRS

from osm2xodr.projection import transformer_to
from osm2xodr.surface.grids.grid import GridFrame
from osm2xodr.surface.grids.trend import fit_polynomial
from osm2xodr.surface.mosaic import fit_trend
from osm2xodr.surface.sampling import Layer, LayeredSurface, Trend

# The local frame itself as a raster's CRS: positions are what they seem.
LOCAL = CRS.from_user_input(BAVARIA.proj)


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
