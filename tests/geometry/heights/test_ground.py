"""The ground, separated from the noise of a coarse elevation model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, map_coordinates

from osm2xodr.geometry.heights.ground import GroundReading, complete_ground, estimate_ground, read_ground
from osm2xodr.model import BoolArray, FloatArray, SurfaceQuality

CELL = 30.0


@dataclass
class Model:
    """A grid of heights with its first cell at (-2000, -2000), bilinear, NaN where unknown."""

    z: FloatArray
    cell_size: float = CELL
    sigma: float = 2.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        place = [(np.asarray(y) + 2000.0) / CELL, (np.asarray(x) + 2000.0) / CELL]
        z = map_coordinates(self.z, place, order=1, mode="constant", cval=np.nan)
        return np.where(np.isfinite(z), z, 0.0), np.isfinite(z)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        return self.heights(x, y)[1]

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        n = len(x)
        return SurfaceQuality(np.full(n, self.cell_size), np.full(n, self.sigma), np.zeros(n, np.bool_))


def grid() -> tuple[FloatArray, FloatArray]:
    axis = -2000.0 + CELL * np.arange(134)
    x, y = np.meshgrid(axis, axis)
    return x, y


def noise(seed: int, sigma: float, length: float = 1.0) -> FloatArray:
    field = gaussian_filter(np.random.default_rng(seed).standard_normal((134, 134)), length)
    out: FloatArray = sigma * field / field.std()
    return out


def read(model: Model, x: FloatArray, y: FloatArray, smoothing: float = 1.0) -> GroundReading:
    ground = estimate_ground(model, x, y, smoothing)
    return read_ground(ground, np.full(len(x), model.cell_size), x, y)


ROAD_X, ROAD_Y = np.linspace(-900.0, 900.0, 181), np.linspace(-300.0, 400.0, 181)


def rms(v: FloatArray) -> float:
    return float(np.sqrt(np.mean(v**2)))


def test_plane_without_noise_is_met() -> None:
    x, y = grid()
    found = read(Model(100.0 + 0.1 * x - 0.05 * y), ROAD_X, ROAD_Y)
    assert found.z == pytest.approx(100.0 + 0.1 * ROAD_X - 0.05 * ROAD_Y, abs=0.01)


def test_noise_of_a_plain_is_smoothed_away() -> None:
    x, _ = grid()
    model = Model(np.round(50.0 + 0.004 * x + noise(1, 1.5)))
    found = read(model, ROAD_X, ROAD_Y)
    truth = 50.0 + 0.004 * ROAD_X
    drape = model.heights(ROAD_X, ROAD_Y)[0]
    assert rms(found.z - truth) < 0.3 * rms(drape - truth)
    assert rms(np.diff(found.z - truth)) < 0.04 * rms(np.diff(drape - truth))
    # What it says about its own error is of the right size.
    assert 0.3 * rms(found.z - truth) < found.sigma.mean() < 3.0 * rms(found.z - truth)


def hills(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(40.0 * np.sin(x / 150.0) * np.cos(y / 180.0) + 60.0 * np.sin((x + y) / 500.0))


def test_hills_keep_their_shape() -> None:
    x, y = grid()
    model = Model(np.round(hills(x, y) + noise(2, 1.5)))
    found = read(model, ROAD_X, ROAD_Y)
    drape = model.heights(ROAD_X, ROAD_Y)[0]
    truth = hills(ROAD_X, ROAD_Y)
    assert rms(found.z - truth) < 0.98 * rms(drape - truth)
    assert rms(np.diff(found.z - truth)) < 0.8 * rms(np.diff(drape - truth))


def test_buildings_and_trees_are_seen_through() -> None:
    x, _ = grid()
    field = noise(3, 1.0, 1.5)
    blobs = np.where(field > np.quantile(field, 0.92), 9.0, 0.0)
    model = Model(np.round(20.0 + 0.002 * x + noise(4, 1.0) + blobs))
    found = read(model, ROAD_X, ROAD_Y)
    assert abs(float(np.mean(found.z - 20.0 - 0.002 * ROAD_X))) < 0.35
    assert float(np.abs(found.z - 20.0 - 0.002 * ROAD_X).max()) < 1.2


def bank(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a plain with a bank of 30 m across it."""
    return np.asarray(15.0 * np.tanh((x + 0.3 * y) / 50.0))


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_bank_across_a_plain_keeps_its_shape_and_the_plain_stays_smooth(seed: int) -> None:
    x, y = grid()
    model = Model(bank(x, y) + noise(seed, 1.0))
    found, truth, drape = read(model, ROAD_X, ROAD_Y), bank(ROAD_X, ROAD_Y), model.heights(ROAD_X, ROAD_Y)[0]
    near = np.abs(ROAD_X + 0.3 * ROAD_Y) < 150.0
    assert rms((found.z - truth)[near]) < 1.2 * rms((drape - truth)[near])
    assert rms((found.z - truth)[~near]) < 0.85 * rms((drape - truth)[~near])


def test_hill_and_plain_of_one_model_have_reliefs_of_their_own() -> None:
    x, y = grid()
    side = np.clip((x + 300.0) / 600.0, 0.0, 1.0)
    model = Model(side * hills(x, y) + noise(14, 1.0))
    found = read(model, np.array([-1400.0, 1400.0]), np.zeros(2))
    # The amplitude of relief goes with the root of A.
    assert found.log_relief[1] - found.log_relief[0] > 2.0 * np.log(10.0)


def test_pits_count_as_much_as_peaks() -> None:
    x, _ = grid()
    model = Model(20.0 + 0.002 * x + noise(5, 1.0))
    upright, mirrored = (read(Model(sign * model.z), ROAD_X, ROAD_Y).z for sign in (1.0, -1.0))
    assert upright == pytest.approx(-mirrored, abs=0.02)


def test_voids_are_filled_and_the_far_outside_is_not() -> None:
    x, y = grid()
    z = 100.0 + 0.1 * x
    z[(np.abs(x) < 70.0) & (np.abs(y) < 70.0)] = np.nan
    z[x > 1000.0] = np.nan
    places = np.array([-500.0, 0.0, 900.0, 1500.0])
    found = read(Model(z), places, np.zeros(4))
    assert found.z[:3] == pytest.approx(100.0 + 0.1 * places[:3], abs=0.1)
    assert np.isnan(found.z[3])
    assert np.isnan(found.sigma[3])


def test_windows_join_smoothly() -> None:
    x, y = grid()
    model = Model(hills(x, y) + noise(6, 1.5))
    # The first place decides where windows begin; the line passes from one to the next.
    along = np.linspace(-1900.0, 1900.0, 3801)
    z = read(model, along, np.full(len(along), 35.0)).z
    assert np.abs(np.diff(z)).max() < 0.6
    assert np.abs(np.diff(z, 2)).max() < 0.02


def test_more_smoothing_is_smoother() -> None:
    x, _ = grid()
    model = Model(50.0 + 0.004 * x + noise(7, 1.5))
    rough, smooth = (rms(np.diff(read(model, ROAD_X, ROAD_Y, k).z, 2)) for k in (0.05, 20.0))
    assert smooth < 0.5 * rough


def test_too_few_heights_give_nothing() -> None:
    x, _ = grid()
    z = np.full_like(x, np.nan)
    z[60:64, 60:64] = 5.0
    assert np.isnan(read(Model(z), ROAD_X, ROAD_Y).z).all()


def test_no_places_give_no_heights() -> None:
    x, _ = grid()
    assert len(read(Model(x), np.zeros(0), np.zeros(0)).z) == 0


def cells(x: FloatArray) -> FloatArray:
    return np.full(len(x), CELL)


def test_what_was_estimated_early_serves_places_nearby() -> None:
    x, y = grid()
    model = Model(hills(x, y) + noise(8, 1.5))
    early = estimate_ground(model, ROAD_X, ROAD_Y, reach=40.0)
    near_x, near_y = ROAD_X + 25.0, ROAD_Y - 30.0
    assert complete_ground(early, model, model.quality(near_x, near_y), near_x, near_y).layers == early.layers
    aside = read_ground(early, cells(near_x), near_x, near_y).z
    assert rms(aside - hills(near_x, near_y)) < 1.5


def test_what_lacks_is_estimated_as_if_it_had_been_there() -> None:
    x, y = grid()
    model = Model(hills(x, y) + noise(9, 1.5))
    first = estimate_ground(model, ROAD_X[:40], ROAD_Y[:40])
    later = complete_ground(first, model, model.quality(ROAD_X, ROAD_Y), ROAD_X, ROAD_Y)
    at_once = estimate_ground(model, ROAD_X, ROAD_Y)
    assert len(first.layers[0].number) < len(later.layers[0].number)
    assert later.layers[0].number.tolist() == at_once.layers[0].number.tolist()
    found = [read_ground(ground, cells(ROAD_X), ROAD_X, ROAD_Y).z for ground in (later, at_once)]
    assert found[0] == pytest.approx(found[1], abs=1e-3)


def test_slope_is_the_heights_slope() -> None:
    x, y = grid()
    ground = estimate_ground(Model(hills(x, y) + noise(10, 1.5)), ROAD_X, ROAD_Y, reach=40.0)
    found = read_ground(ground, cells(ROAD_X), ROAD_X, ROAD_Y)
    east, west = (read_ground(ground, cells(ROAD_X), ROAD_X + dx, ROAD_Y).z for dx in (0.5, -0.5))
    north, south = (read_ground(ground, cells(ROAD_X), ROAD_X, ROAD_Y + dy).z for dy in (0.5, -0.5))
    assert found.slope_x == pytest.approx(east - west, abs=2e-3)
    assert found.slope_y == pytest.approx(north - south, abs=2e-3)


def test_fine_cells_are_left_alone() -> None:
    x, _ = grid()
    model = Model(x, cell_size=5.0)
    ground = estimate_ground(model, ROAD_X, ROAD_Y)
    assert ground.layers == ()
    assert np.isnan(read_ground(ground, np.full(len(ROAD_X), 5.0), ROAD_X, ROAD_Y).z).all()
