"""The ground told apart from the noise of a coarse elevation model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, map_coordinates

from osm2xodr.geometry.ground_trend import GroundReading, read_ground
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
    return read_ground(model, x, y, model.cell_size, model.sigma, smoothing)


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
    # What it says about its own error is of the right size, and that error is correlated over a long way.
    assert 0.3 * rms(found.z - truth) < found.sigma.mean() < 3.0 * rms(found.z - truth)
    assert found.correlation.min() > 150.0


def hills(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(40.0 * np.sin(x / 150.0) * np.cos(y / 180.0) + 60.0 * np.sin((x + y) / 500.0))


def test_hills_keep_their_shape() -> None:
    x, y = grid()
    model = Model(np.round(hills(x, y) + noise(2, 1.5)))
    found = read(model, ROAD_X, ROAD_Y)
    drape = model.heights(ROAD_X, ROAD_Y)[0]
    truth = hills(ROAD_X, ROAD_Y)
    assert rms(found.z - truth) < 0.95 * rms(drape - truth)
    assert rms(np.diff(found.z - truth)) < 0.65 * rms(np.diff(drape - truth))
    assert found.correlation.max() < 150.0


def test_buildings_and_trees_are_seen_through() -> None:
    x, _ = grid()
    field = noise(3, 1.0, 1.5)
    blobs = np.where(field > np.quantile(field, 0.92), 9.0, 0.0)
    model = Model(np.round(20.0 + 0.002 * x + noise(4, 1.0) + blobs))
    found = read(model, ROAD_X, ROAD_Y)
    assert abs(float(np.mean(found.z - 20.0 - 0.002 * ROAD_X))) < 0.35
    assert float(np.abs(found.z - 20.0 - 0.002 * ROAD_X).max()) < 1.2


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
