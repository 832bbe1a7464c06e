"""Wiener's filter, place by place."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from osm2xodr.geometry.heights.ground_windows.estimate import PlaceFilter
from osm2xodr.geometry.heights.ground_windows.spectra import SIZE, Basis, Single, Spectrum
from osm2xodr.model import FloatArray

CELL, WINDOWS = 30.0, 8
BASIS = Basis(CELL)
NOISE = 4.0 * 4.0 * np.pi * 45.0**2


def rms(v: FloatArray | Single) -> float:
    return float(np.sqrt(np.mean(v**2)))


def noise() -> FloatArray:
    """Return noise of 2 m that is correlated over 1.5 cells."""
    white = np.random.default_rng(2).standard_normal((WINDOWS, 2 * SIZE, 2 * SIZE))
    field = gaussian_filter(white, (0.0, 1.5, 1.5))[:, :SIZE, :SIZE]
    return np.asarray(2.0 * field / field.std())


def filtered(
    heights: FloatArray, relief: float, smoothing: float = 1.0, canopy: bool = False
) -> tuple[Single, Single]:
    each = (np.full(WINDOWS, value) for value in (relief, 4.0, NOISE, 45.0, 0.01))
    found = PlaceFilter(BASIS).apply(heights.astype(np.float32), Spectrum(*each), np.full(WINDOWS, canopy), smoothing)
    return BASIS.from_cosines(found[0]), found[1]


def test_correlated_noise_of_a_plain_goes() -> None:
    z, log_relief = filtered(noise(), 1e-3)
    assert rms(z) < 0.75
    assert np.median(log_relief) < np.log(1e-3)


def half_hilly() -> FloatArray:
    """Return hills with the spectrum 0.3 / k⁴, at waves up to 24 cells, beside a plain."""
    k = np.maximum(BASIS.k, np.pi / (12.0 * CELL))
    random = np.random.default_rng(4).standard_normal((WINDOWS, SIZE, SIZE))
    hills = BASIS.from_cosines((random * np.sqrt(0.3) / k**2 / CELL).astype(np.float32))
    return np.asarray(np.where(np.arange(SIZE) < SIZE / 2, hills, 0.0), np.float64)


def test_hill_beside_a_plain_stays_and_the_plain_is_smooth() -> None:
    truth, y = half_hilly(), half_hilly() + noise()
    z, log_relief = filtered(y, 1e-2)
    hills, plain = (slice(None), slice(6, -6), slice(6, 16)), (slice(None), slice(6, -6), slice(34, -4))
    assert rms((z - truth)[hills]) < 1.2 * rms((y - truth)[hills])
    assert rms((z - truth)[plain]) < 0.75 * rms((y - truth)[plain])
    # The amplitude of relief goes with the root of A.
    assert np.median(log_relief[hills]) - np.median(log_relief[plain]) > 2.0


def test_with_canopy_no_place_is_rougher_than_its_window() -> None:
    assert filtered(half_hilly() + noise(), 1e-2, canopy=True)[1].max() <= np.log(1e-2) + 1e-3


def test_more_smoothing_is_smoother() -> None:
    rough, smooth = (rms(np.diff(filtered(noise(), 1e-3, factor)[0])) for factor in (0.05, 20.0))
    assert smooth < 0.5 * rough


def test_averages_are_those_of_all_waves() -> None:
    values = np.random.default_rng(3).random((1, SIZE, SIZE)).astype(np.float32)
    full = np.exp(-0.5 * (BASIS.k * 6.0 * CELL) ** 2).astype(np.float32)
    wanted = BASIS.from_cosines(full * BASIS.to_cosines(values))
    assert BASIS.averages(values, full[:13, :13]) == pytest.approx(wanted, abs=1e-4)
