"""Cosines as a basis for the heights of windows, and the smooth surface's spectrum."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from osm2xodr.curves import cosine, exp, log
from osm2xodr.model import FloatArray, IntArray

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
_LOG_A: Final = (-14.0, 14.0, 0.35)
_LOG_N: Final = (-4.0, 16.0, 0.25)
# Standard deviation of the prior of ln N about the surface's own statement.
_NOISE_SPREAD: Final = 1.0
# Cosines are multiples of this, windows of a power of 2 that leaves them so many binary digits; in the sum of one by
# the other they grow by so many at most.
_UNIT: Final = 2.0**-23
_DIGITS: Final = 26
_GROWTH: Final = 4
# Keeps logarithms of wave numbers finite, rad/m.
_LEAST_WAVE: Final = 1e-30


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
        self._log_a = np.arange(*_LOG_A)
        self._log_n = np.arange(*_LOG_N)
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
