"""Cosines as a basis for the heights of windows, and the spectra of their ground and of its noise."""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import cosine, exp, log, power
from osm2xodr.geometry.heights import defaults
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.system import record

Single = npt.NDArray[np.float32]
AnyArray = npt.NDArray[np.floating[Any]]

# Windows overlap by twice the margin, both in cells. Within a window the smooth surface is of one kind: on coarsened
# models of a valley town and a city on a river, and on ten known terrains, windows of 36 to 60 cells do equally well,
# ones of 96 cells are worse by a tenth in grade.
CORE: Final = 24
MARGIN: Final = 12
SIZE: Final = CORE + 2 * MARGIN
# Shortest wavelength at which the noise counts as flat, in cells, and number of bands that spectra are averaged in.
_SHORTEST_WAVE: Final = 5.0
_BANDS: Final = 28
# Levels of ln A and ln N that are tried, from, to, step: plains to high mountains, noise of centimetres to 10 m.
_LOG_SURFACE_A: Final = (-14.0, 14.0, 0.35)
_LOG_SURFACE_N: Final = (-4.0, 16.0, 0.25)
# Standard deviation of the prior of ln N about the surface's own statement.
_NOISE_SPREAD: Final = 1.0
# Cosines are multiples of this, windows of a power of 2 that leaves them so many binary digits; in the sum of one by
# the other they grow by so many at most.
_UNIT: Final = 2.0**-23
_DIGITS: Final = 26
_GROWTH: Final = 4
# Keeps logarithms of wave numbers finite, rad/m.
_LEAST_WAVE: Final = 1e-30

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


def _cosines() -> FloatArray:
    """Return the orthonormal discrete cosine transform (DCT-II) of a window's values, (SIZE, SIZE)."""
    wave, place = np.arange(SIZE)[:, None], np.arange(SIZE) + 0.5
    scale = np.where(wave == 0, np.sqrt(1.0 / SIZE), np.sqrt(2.0 / SIZE))
    return np.asarray(scale * cosine(np.pi / SIZE * (wave * place)))


def wave_numbers() -> FloatArray:
    """Return the wave numbers of a window's coefficients, (SIZE, SIZE), rad/cell."""
    wave = np.pi * np.arange(SIZE) / SIZE
    return np.asarray(np.sqrt(wave[:, None] ** 2 + wave[None, :] ** 2))


def _as_wholes(values: AnyArray, largest: IntArray) -> FloatArray:
    """Return windows, (W, ., .), below 2**largest in size, (W, 1, 1), rounded to `_DIGITS` binary digits of that.

    Cosines are multiples of `_UNIT`. Sums of so few products of the two are exact in doubles, in whatever order a
    linear algebra library adds them up.
    """
    # Added and taken away again this leaves multiples of the last digit.
    rounder = np.ldexp(1.5, largest + (52 - _DIGITS))
    out = values.astype(np.float64)
    out += rounder
    out -= rounder
    return out


def _between(left: FloatArray, values: Single, right: FloatArray) -> Single:
    """Return left · values · right of windows, (W, ., .), `left` and `right` being cosines."""
    largest = np.frexp(np.abs(values).max(axis=(1, 2), keepdims=True))[1]
    # No row of cosines sums up to more than 2**`_GROWTH` in size.
    across = _as_wholes(values, largest) @ right
    return np.asarray(left @ _as_wholes(across, largest + _GROWTH), np.float32)


class Rings:
    """Bands of wave numbers, equally wide in their logarithm, over which the power of windows is averaged."""

    def __init__(self, k: FloatArray, highest: float, bands: int) -> None:
        flat = k.ravel()
        used = (flat > 0) & (flat < highest)
        edges = np.linspace(log(flat[used].min()), log(flat[used].max()), bands)
        number = np.where(used, np.digitize(log(np.maximum(flat, _LEAST_WAVE)), edges), 0)
        self._order: IntArray = np.argsort(number, kind="stable")[int((number == 0).sum()) :]
        _, first, count = np.unique(number[self._order], return_index=True, return_counts=True)
        self._first, self.count = first, count.astype(np.float64)
        self.wave: FloatArray = exp(np.add.reduceat(log(flat[self._order]), first) / count)

    def mean_power(self, cosines: Single) -> FloatArray:
        """Return the mean square of windows' coefficients (W, SIZE, SIZE), m², in each band, (W, bands)."""
        power = cosines.reshape(len(cosines), -1)[:, self._order].astype(np.float64)
        mean: FloatArray = np.add.reduceat(power**2, self._first, axis=1) / self.count
        return mean


class Basis:
    """Cosines as a basis for all windows of a cell size, m, with spectra to choose from."""

    def __init__(self, cell: float) -> None:
        self.cell = cell
        self.k = wave_numbers() / cell  # (SIZE, SIZE) Wave numbers, rad/m
        self.k4 = np.square(np.square(self.k)).astype(np.float32)
        # Matrices this small are transformed by multiplication in a third of the time that the fast transform takes.
        self._cosines = np.rint(_cosines() / _UNIT) * _UNIT
        self._sines = np.ascontiguousarray(self._cosines.T)
        # From values to the coefficients of the cubic B-spline through them: a filter (1/6, 4/6, 1/6) undone.
        spline = 6.0 / (4.0 + 2.0 * cosine(np.pi * np.arange(SIZE) / SIZE))
        self.to_spline = (spline[:, None] * spline[None, :]).astype(np.float32)
        self._rings = Rings(self.k, 2 * np.pi / (_SHORTEST_WAVE * cell), _BANDS)
        self._log_a = np.arange(*_LOG_SURFACE_A)
        self._log_n = np.arange(*_LOG_SURFACE_N)
        relief = exp(self._log_a)[:, None, None] / np.square(np.square(self._rings.wave))
        spectrum = relief + exp(self._log_n)[None, :, None]
        self._weighted_log = (self._rings.count * log(spectrum)).sum(-1).ravel()
        # Cosines are real: each adds half as much as a complex amplitude would.
        self._inverse = np.ascontiguousarray((self._rings.count / spectrum).reshape(-1, len(self._rings.wave)).T)

    def to_cosines(self, values: Single) -> Single:
        """Return the coefficients of windows (W, SIZE, SIZE) in the orthonormal basis of cosines."""
        return _between(self._cosines, values, self._sines)

    def from_cosines(self, coefficients: Single) -> Single:
        """Return the values of coefficients (W, SIZE, SIZE)."""
        return _between(self._sines, coefficients, self._cosines)

    def averages(self, values: Single, weighting: Single) -> Single:
        """Return averages around each place of values that are not negative, (W, SIZE, SIZE).

        The spectrum of the weighting, (n, n), is that of its n longest waves in each direction.
        """
        n = len(weighting)
        cosines, sines = self._cosines[:n], self._sines[:, :n]
        weighted = weighting * _between(cosines, values, sines)
        return np.maximum(_between(sines, weighted, cosines), np.float32(0.0))

    def fit(self, residual: Single, prior_log_n: float) -> tuple[FloatArray, FloatArray]:
        """Return ln A and ln N of windows' heights (W, SIZE, SIZE), by Whittle's likelihood with a prior on N."""
        mean = self.cell**2 * self._rings.mean_power(self.to_cosines(residual))
        prior = np.tile(((self._log_n - prior_log_n) / _NOISE_SPREAD) ** 2, len(self._log_a))
        best = np.argmin(mean @ self._inverse + (self._weighted_log + prior), axis=1)
        return self._log_a[best // len(self._log_n)], self._log_n[best % len(self._log_n)]


@record(eq=False)
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
