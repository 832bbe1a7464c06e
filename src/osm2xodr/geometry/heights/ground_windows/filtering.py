"""The ground of windows by Wiener's filter, with a roughness of its own at each place."""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np

from osm2xodr.curves import exp, log
from osm2xodr.geometry.heights.ground_windows.basis import SIZE, Basis, Single
from osm2xodr.geometry.heights.ground_windows.spectra import Spectrum
from osm2xodr.model import BoolArray, FloatArray

# Edges of the bands, as shares of the highest wave number that cells show: octaves.
_EDGES: Final = (0.0442, 0.0884, 0.1768, 0.3536, 0.7071)
# Standard deviation of the averages of a band's power: so many cells at least, and so many times 1 / k of the band.
_AROUND_CELLS: Final = 6.0
_AROUND: Final = 3.0
# Coefficients in each direction that averages are made of: the next one counts 2e-5.
_LONG: Final = 13
# Levels of the logarithm of the relief at a place, about the window's: from, to, step; and their prior's standard
# deviation. In windows with canopy or roofs places are at most as rough as the window is.
_LEVELS: Final = (-3.5, 7.01, 0.5)
_LEVEL_SPREAD: Final = 1.2
# Share of the coefficients under an average that count as independent: bands overlap.
_INDEPENDENT: Final = 0.5
# The logarithm of 2 in two parts, the first of which has 9 binary digits, and that of the least probability.
_LN_2_HIGH: Final = np.float32(0.693359375)
_LN_2_LOW: Final = np.float32(-2.12194440e-4)
_LEAST_EXPONENT: Final = np.float32(-87.0)


class PlaceFilter:
    """Wiener's filter, place by place, for windows of a cell size."""

    def __init__(self, basis: Basis) -> None:
        self._basis = basis
        k, highest = basis.k, np.pi / basis.cell
        edges = [share * highest for share in _EDGES]
        passes = [1.0 / (1.0 + np.square(np.square(np.square(k / edge)))) for edge in edges]
        self._longest = passes[0].astype(np.float32)
        edges_of = itertools.pairwise([*passes, np.ones_like(k)])
        self._bands = [(high - low).astype(np.float32) for low, high in edges_of]
        middles = [np.sqrt(2.0) * edge for edge in edges]
        around = [max(_AROUND / middle, _AROUND_CELLS * basis.cell) for middle in middles]
        long = k[:_LONG, :_LONG]
        self._blurs = [exp(-0.5 * np.square(long * length)).astype(np.float32) for length in around]
        self._waves = np.maximum(k, k[0, 1])
        powers = [np.square(band) for band in self._bands]
        width = [float(np.square(power.sum()) / np.square(power).sum()) / SIZE**2 for power in powers]
        cells = [4.0 * np.pi * (length / basis.cell) ** 2 for length in around]
        self._count = [_INDEPENDENT * share * number for share, number in zip(width, cells, strict=True)]
        self._levels = np.arange(*_LEVELS)

    def apply(
        self, heights: Single, spectrum: Spectrum, one_sided: BoolArray, smoothing: float
    ) -> tuple[Single, Single]:
        """Return the ground's coefficients, and ln A at each place, (W, SIZE, SIZE).

        `heights`, (W, SIZE, SIZE), m, are known everywhere; `one_sided`, (W,), says where canopy or roofs stand out,
        and `smoothing` is a factor on the noise.
        """
        basis, levels = self._basis, self._levels
        cosines, sided = basis.to_cosines(heights), np.flatnonzero(one_sided)
        noise_at = smoothing * spectrum.of_noise(basis.k) / basis.cell**2
        ground_at = spectrum.of_ground(self._waves) / basis.cell**2
        cost = np.empty((len(levels), *heights.shape), np.float32)
        cost[:] = np.square(levels / _LEVEL_SPREAD)[:, None, None, None]
        parts, gains = [], []
        for band, blur, count in zip(self._bands, self._blurs, self._count, strict=True):
            part = basis.from_cosines(band * cosines)
            power = basis.averages(np.square(part), blur)
            if len(sided):
                # Canopy and roofs stand out above alone.
                above = basis.averages(np.square(np.maximum(part[sided], np.float32(0.0))), blur)
                below = np.maximum(power[sided] - above, np.float32(0.0))
                power[sided] = np.maximum(above + np.minimum(below, 2.0 * below - above), np.float32(0.0))
            noise = (np.square(band) * noise_at).mean(axis=(1, 2))
            relief = exp(levels)[:, None] * (np.square(band) * ground_at).mean(axis=(1, 2))
            total = relief + noise
            weight, offset = count / total, count * log(total)
            for level in range(len(levels)):
                cost[level] += weight[level].astype(np.float32)[:, None, None] * power
                cost[level] += offset[level].astype(np.float32)[:, None, None]
            parts.append(part)
            gains.append((relief / total).astype(np.float32))
        share = _shares(cost, levels, one_sided)
        out = self._longest * cosines
        for part, gain in zip(parts, gains, strict=True):
            out += basis.to_cosines(part * np.einsum("lwij,lw->wij", share, gain))
        log_relief = log(spectrum.relief).astype(np.float32)[:, None, None]
        return out, log_relief + np.einsum("lwij,l->wij", share, levels.astype(np.float32))


def _shares(cost: Single, levels: FloatArray, one_sided: BoolArray) -> Single:
    """Return the probability of each level at each place, from twice its negative logarithm (used up)."""
    cost[np.ix_(levels > 0.0, one_sided)] = np.inf
    cost -= cost.min(axis=0)
    cost *= np.float32(-0.5)
    _exponentials(cost)
    cost /= cost.sum(axis=0)
    return cost


def _exponentials(x: Single) -> None:
    """Turn numbers that are not positive into e to their power, in place: the same on every machine, to 3e-6.

    With the polynomial of Taylor's series to the fifth order over ln 2 / 2 either side of 0: it leaves out 2e-6.
    """
    np.maximum(x, _LEAST_EXPONENT, out=x)
    halvings = np.rint(x * np.float32(1.4426950408889634))
    x -= halvings * _LN_2_HIGH
    x -= halvings * _LN_2_LOW
    series = x * np.float32(1.0 / 120.0)
    for coefficient in (1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0):
        series += np.float32(coefficient)
        series *= x
    series += np.float32(1.0)
    # The exponent of a single stands above its 23 digits, 127 more than it is.
    scale = (halvings.astype(np.int32) + 127 << 23).view(np.float32)
    np.multiply(series, scale, out=x)
