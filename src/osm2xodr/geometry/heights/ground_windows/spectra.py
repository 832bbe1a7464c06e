"""The spectra of a window's ground and of its noise, whose errors are correlated over cells."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from osm2xodr.curves import exp, log, power
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.ground_windows.basis import Rings, Single, wave_numbers
from osm2xodr.model import FloatArray

# Bands that spectra are averaged in, up to the highest wave number that cells show in every direction.
_BANDS: Final = 28
# Coefficients that a band counts for at most: no spectrum is quite of this form, and the many short waves must not
# settle what the few long ones are. On coarsened models of real and of made-up places 40 to 70 do equally well.
_MOST_COUNTED: Final = 60.0
# Powers of the wave number by which the spectrum of relief may fall: banks and cuts have 3, hills 4. With neither of
# them alone the spectrum of hills with banks would look as if some of it were correlated noise.
_FALLS: Final = (3.0, 3.5, 4.0)
# Lengths over which errors may be correlated, in cells, and shares of the noise at long waves that are white. With
# finer steps, or lengths from 0.5 to 2, nothing is gained on coarsened models.
_LENGTHS: Final = (1.0, 1.5)
_WHITE_SHARES: Final = (0.01, 0.03, 0.1, 0.3, 1.0)
# Levels of ln A c² and ln N / c² that are tried with cells of c, from, to, step: plains to high mountains, noise of
# centimetres to 10 m.
_LOG_A: Final = (-7.0, 21.0, 0.5)
_LOG_N: Final = (-10.0, 8.0, 0.33)
# Standard deviation of the prior of the logarithm of the noise's variance about the surface's own statement.
_VARIANCE_SPREAD: Final = 0.8
# Power of the white share that its prior goes with, twice: where hills and correlated noise look alike, noise is
# white. On coarsened models 0.5 and 1 do equally well; 0 is worse on rough ground with white noise, 2 on real places.
_WHITENESS: Final = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """The spectra of W windows: ground A kᵣ^(p - 4) / k^p and noise N ((1 - e) exp(-(L k)²) + e)."""

    relief: FloatArray  # (W,) A, of no unit
    fall: FloatArray  # (W,) p
    noise: FloatArray  # (W,) N, m⁴
    length: FloatArray  # (W,) L, m
    white: FloatArray  # (W,) e

    @property
    def ground_error(self) -> FloatArray:
        """The standard error of the ground that follows, (W,), m: that of a thin-plate smoother."""
        out: FloatArray = np.sqrt(np.sqrt(self.noise * self.relief) / 8.0)
        return out

    def of_ground(self, k: FloatArray) -> FloatArray:
        """Return the ground's spectrum at wave numbers (n, n), rad/m, but 0: (W, n, n), m⁴."""
        relief, fall = self.relief[:, None, None], self.fall[:, None, None]
        out: FloatArray = relief / defaults.RELIEF_WAVE**4 * power(k / defaults.RELIEF_WAVE, -fall)
        return out

    def of_noise(self, k: FloatArray) -> FloatArray:
        """Return the noise's spectrum at wave numbers of any shape, rad/m: (W, ...), m⁴."""
        shape = (-1,) + (1,) * k.ndim
        noise, length, white = (item.reshape(shape) for item in (self.noise, self.length, self.white))
        out: FloatArray = noise * ((1.0 - white) * exp(-np.square(length * k)) + white)
        return out


class Spectra:
    """Spectra to choose from, for all windows: lengths are in cells, 1 / k likewise."""

    def __init__(self) -> None:
        self._rings = rings = Rings(wave_numbers(), np.pi, _BANDS)
        count = np.minimum(rings.count, _MOST_COUNTED)
        a, n = np.arange(*_LOG_A), np.arange(*_LOG_N)
        choices = itertools.product(_FALLS, _LENGTHS, _WHITE_SHARES)
        # White noise has no length.
        each_once = [choice for choice in choices if choice[2] < 1.0 or choice[1] == _LENGTHS[0]]
        fall, length, white = np.array(each_once).T
        shape = (1.0 - white)[:, None] * exp(-np.square(length[:, None] * rings.wave)) + white[:, None]
        noise = exp(n)[:, None, None] * shape
        shapes = (len(a), *noise.shape[:2])
        weighted_log, inverse = np.empty(shapes), np.empty((len(rings.wave), *shapes))
        # One level of relief after the other: the arrays of all do not fit into the processor's cache.
        for k, relief in enumerate(exp(a)[:, None, None] * power(rings.wave, -fall[:, None])):
            spectrum = relief + noise
            weighted_log[k] = (count * log(spectrum)).sum(axis=-1)
            inverse[:, k] = np.moveaxis(count / spectrum, -1, 0)
        self._weighted_log, self._inverse = weighted_log.ravel(), inverse.reshape(len(rings.wave), -1)
        each = (a[:, None, None], n[:, None], fall, length, white)
        self._choices = [item.ravel() for item in np.broadcast_arrays(*each)]
        # The integrals of both parts of the spectrum: correlated errors, and those of single cells.
        variance = (1.0 - white) / (4.0 * np.pi * length**2) + white
        self._log_white = log(self._choices[-1])
        self._log_variance = np.broadcast_to(n[:, None] + log(variance), shapes).ravel()

    def fit(self, cosines: Single, cell: float, sigma: float) -> Spectrum:
        """Return the spectra of windows' coefficients (W, SIZE, SIZE), m, by Whittle's likelihood.

        The prior of the noise's variance is about the square of `sigma`, m.
        """
        prior = ((self._log_variance - 2.0 * log(sigma)) / _VARIANCE_SPREAD) ** 2 - _WHITENESS * self._log_white
        cost = self._rings.mean_power(cosines) @ self._inverse
        best = np.argmin(cost + (self._weighted_log + prior), axis=1)
        a, n, fall, length, white = (choice[best] for choice in self._choices)
        # The same at the wave kᵣ, whatever the fall.
        k = defaults.RELIEF_WAVE * cell
        relief = exp(a) / cell**2 * power(k, 4.0 - fall)
        return Spectrum(relief, fall, exp(n) * cell**2, length * cell, white)


@cache
def all_spectra() -> Spectra:
    """Return the spectra to choose from."""
    return Spectra()
