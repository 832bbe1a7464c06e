"""The spectra of ground and noise, from heights whose spectra are known."""

from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.geometry.heights.ground_windows.spectra import SIZE, Basis, Single, Spectrum, all_spectra
from osm2xodr.model import FloatArray

CELL, WINDOWS = 30.0, 12


def known(relief: float, fall: float, noise: float, length: float, white: float) -> Spectrum:
    return Spectrum(*(np.full(WINDOWS, value) for value in (relief, fall, noise, length, white)))


def drawn(spectrum: Spectrum) -> Single:
    """Return coefficients of windows with a spectrum."""
    basis = Basis(CELL)
    power = spectrum.of_ground(np.maximum(basis.k, basis.k[0, 1])) + spectrum.of_noise(basis.k)
    random: FloatArray = np.random.default_rng(1).standard_normal((WINDOWS, SIZE, SIZE))
    out: Single = (random * np.sqrt(power) / CELL).astype(np.float32)
    return out


def test_ground_and_noise_have_these_powers() -> None:
    spectrum = known(0.01, 3.0, 5000.0, 45.0, 0.1)
    k = np.array([[0.025, 0.05]])
    assert spectrum.of_ground(k)[0] == pytest.approx(0.01 / 0.025**4 * np.array([[1.0, 0.125]]))
    assert spectrum.of_noise(k)[0] == pytest.approx(5000.0 * (0.9 * np.exp(-((45.0 * k) ** 2)) + 0.1))


@pytest.mark.parametrize(("length", "white"), [(30.0, 0.03), (45.0, 0.01), (45.0, 0.03)])
@pytest.mark.parametrize("fall", [3.0, 4.0])
def test_correlated_noise_of_a_plain_is_told_from_its_relief(fall: float, length: float, white: float) -> None:
    noise = 4.0 / ((1.0 - white) / (4.0 * np.pi * length**2) + white / CELL**2)
    found = all_spectra().fit(drawn(known(1e-3, fall, noise, length, white)), CELL, 2.0)
    assert np.median(found.noise) == pytest.approx(noise, rel=0.35)
    assert np.median(found.length) == length
    assert np.median(found.white) == pytest.approx(white, rel=0.75)
    # Hardly any of the noise counts as relief.
    assert np.median(found.relief) < 4e-3


def test_white_noise_is_white() -> None:
    found = all_spectra().fit(drawn(known(1e-3, 4.0, 4.0 * CELL**2, CELL, 1.0)), CELL, 2.0)
    assert np.median(found.white) == 1.0
    assert np.median(found.noise) == pytest.approx(4.0 * CELL**2, rel=0.25)


@pytest.mark.parametrize("fall", [3.0, 3.5, 4.0])
def test_hills_with_little_noise_are_relief(fall: float) -> None:
    spectrum = known(0.1, fall, 0.25 * CELL**2, CELL, 1.0)
    found = all_spectra().fit(drawn(spectrum), CELL, 2.0)
    assert np.median(found.relief) == pytest.approx(0.1, rel=0.5)
    # At waves of five cells most is relief.
    k = np.array([[2.0 * np.pi / (5.0 * CELL)]])
    assert np.median(found.of_ground(k) / found.of_noise(k)) > 2.0


def test_the_error_of_the_ground_is_that_of_a_smoother() -> None:
    # The integral over all waves of N S / (N + S) with S = A / k^4, by rings.
    spectrum, k = known(0.02, 4.0, 4000.0, CELL, 1.0), np.linspace(1e-5, 2.0, 400_000)
    ground, noise = spectrum.of_ground(k[None, None])[0, 0], 4000.0
    variance = float(np.sum(k / (2.0 * np.pi) * ground * noise / (ground + noise)) * (k[1] - k[0]))
    assert spectrum.ground_error[0] == pytest.approx(np.sqrt(variance), rel=0.01)
