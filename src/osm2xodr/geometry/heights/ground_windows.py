"""Separation of the ground from the noise of coarse elevation models, in windows around the roads.

A global elevation model of 30 m cells has errors of metres that are correlated over a few cells, and takes canopy
and roofs for ground. Sampled along a road they look like grades of many per cent. The terrain beside a road says more
about it than the few cells beneath it, so the ground is estimated in two dimensions first.

The model: ground with a power spectrum A / k⁴ (a thin-plate spline; relief at road scale is close to it), plus noise
of level N that is flat at wavelengths the model resolves well. A and N are estimated window by window from the
elevation model itself by Whittle's likelihood, so that a plain is smoothed over a kilometre and the Alps over a
cell or two. The estimate is the penalised weighted least-squares surface with penalty N / A, with Cauchy's and then
Geman-McClure's weights (one-sided where errors are), solved by conjugate gradients in the basis of cosines; detail
that is clearly no noise, such as a bank across a plain, is then brought back where it is. Windows
are treated in stacks that stay in the processor's cache, in single precision: its rounding is 1e-4 m.
docs/method/heights.md has the formulas.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from osm2xodr.geometry.heights import defaults
from osm2xodr.model import BoolArray, FloatArray

Single = npt.NDArray[np.float32]

# Windows overlap by twice the margin, both in cells. Within a window the terrain counts as of one kind: on coarsened
# models of a valley town and a city on a river, and on ten known terrains, windows of 36 to 60 cells do equally well,
# ones of 96 cells are worse by a tenth in grade.
CORE: Final = 24
MARGIN: Final = 12
SIZE: Final = CORE + 2 * MARGIN
# The outermost cells of a window steady it and are not used.
RIM: Final = 4
INNER: Final = SIZE - 2 * RIM
# Windows in a stack: they fit the cache.
_STACK: Final = 16
# Shortest wavelength at which the noise counts as flat, in cells, and number of bands that spectra are averaged in.
_SHORTEST_WAVE: Final = 5.0
_BANDS: Final = 28
# Levels of ln A and ln N that are tried, from, to, step: plains to high mountains, noise of centimetres to 10 m.
_LOG_A: Final = (-14.0, 14.0, 0.35)
_LOG_N: Final = (-4.0, 16.0, 0.25)
# Standard deviation of the prior of ln N about the surface's own statement.
_NOISE_SPREAD: Final = 1.0
# Standard deviations above and below the ground at which heights lose half of their weight: where errors are mostly
# above it (canopy, roofs), and elsewhere. They are mostly above if the share of heights more than _TAIL standard
# deviations above exceeds _TAIL_RATIO times the share as far below, plus _TAIL_SHARE.
_ONE_SIDED: Final = (1.8, 4.5)
_TWO_SIDED: Final = (4.0, 4.0)
_TAIL: Final = 2.5
_TAIL_SHARE: Final = 0.005
_TAIL_RATIO: Final = 1.5
# Residuals are clipped to these, in standard deviations, before A and N are estimated for the second time.
_CLIP: Final = (-3.0, 2.0)
# Median of the size of normal deviates, and the least standard deviation, m.
_MEDIAN_SIZE: Final = 0.6745
_SPREAD_MIN: Final = 1e-3
# Fewest heights that make an estimate, and the share of a window's cells from which the trend is of second order.
_FEWEST: Final = 30
_SECOND_ORDER: Final = 0.3
# A place is supported if this share of the square with this many cells per side around it is known.
_SUPPORT: Final = 0.15
_SUPPORT_CELLS: Final = 7
# Share of known cells that the standard error counts at least with.
_KNOWN_MIN: Final = 0.05
# Times that the weights are set, steps of conjugate gradients before and after the first time, and the error of
# heights at which they stop, m.
_PASSES: Final = 3
_FIRST_STEPS: Final = 12
_CG_STEPS: Final = 6
_CG_ERROR: Final = 0.002
# Upper edges of the bands of detail, as shares of the highest wave number that cells show, and the factor on them at
# which a low pass has fallen to half; the distance over which a band's power is averaged, times its edge.
_DETAIL_BANDS: Final = (0.125, 0.25, 0.5, 1.0)
_BAND_EDGE: Final = 0.7
_AROUND: Final = 3.0
# Relief is what a band's power has beyond the first times the noise's, and at most the second times what the window
# usually has: in windows with canopy or roofs, and in others. On coarsened models of real places and on known terrain
# with canopy, more for the former loses on the latter, and less for the others loses on the places.
_CLEARLY: Final = 1.5
_ROUGHER: Final = (0.25, 10.0)
# Where the noise's spectrum leaves its level, and from where it is measured, as shares of the highest wave number;
# and the least that it can be, m⁴.
_NOISE_FALLS: Final = (0.3, 0.75)
_LEAST_POWER: Final = 1e-6
# Keeps the trend of heights in one row determinate, as a share of their weight.
_RIDGE: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class WindowEstimates:
    """The ground within W windows, without their rims."""

    # (W, INNER, INNER) Coefficients of the cubic B-spline that is the height, m, in rows from the south and columns
    # from the west; NaN where too little is known.
    spline: Single
    supported: BoolArray  # (W, INNER, INNER) Where heights are known around
    # (W,) Standard error, m, and the length over which it is correlated, m; NaN where too little is known
    sigma: Single
    correlation: Single
    # (W,) ln A of the relief, whose spectrum is A / k⁴; NaN where too little is known
    log_relief: Single


def _cosines() -> FloatArray:
    """Return the orthonormal discrete cosine transform (DCT-II) of a window's values, (SIZE, SIZE)."""
    wave, place = np.arange(SIZE)[:, None], np.arange(SIZE) + 0.5
    scale = np.where(wave == 0, np.sqrt(1.0 / SIZE), np.sqrt(2.0 / SIZE))
    return np.asarray(scale * np.cos(np.pi / SIZE * (wave * place)))


class Basis:
    """Cosines as a basis for all windows of a cell size, m, with spectra to choose from."""

    def __init__(self, cell: float) -> None:
        k = np.pi * np.arange(SIZE) / (SIZE * cell)
        k2 = k[:, None] ** 2 + k[None, :] ** 2
        self.cell = cell
        self.k4 = (k2 * k2).astype(np.float32)
        # The mean has no place in a spectrum of relief; it counts like the longest wave.
        self.inverse_k4 = 1.0 / np.maximum(self.k4, self.k4[0, 1])
        self._set_up_bands(np.sqrt(k2), np.pi / cell)
        # Matrices this small are transformed by multiplication in a third of the time that the fast transform takes.
        self._cosines = _cosines().astype(np.float32)
        self._sines = np.ascontiguousarray(self._cosines.T)
        # From values to the coefficients of the cubic B-spline through them: a filter (1/6, 4/6, 1/6) undone.
        spline = 6.0 / (4.0 + 2.0 * np.cos(np.pi * np.arange(SIZE) / SIZE))
        self.to_spline = (spline[:, None] * spline[None, :]).astype(np.float32)
        flat = np.sqrt(k2).ravel()
        used = (flat > 0) & (flat < 2 * np.pi / (_SHORTEST_WAVE * cell))
        edges = np.linspace(np.log(flat[used].min()), np.log(flat[used].max()), _BANDS)
        number = np.where(used, np.digitize(np.log(np.maximum(flat, 1e-30)), edges), 0)
        self._order = np.argsort(number, kind="stable")[int((number == 0).sum()) :]
        _, first, count = np.unique(number[self._order], return_index=True, return_counts=True)
        self._first, self._count = first, count.astype(np.float64)
        wave = np.exp(np.add.reduceat(np.log(flat[self._order]), first) / count)
        self.log_a = np.arange(*_LOG_A)
        self.log_n = np.arange(*_LOG_N)
        spectrum = np.exp(self.log_a)[:, None, None] / wave**4 + np.exp(self.log_n)[None, :, None]
        self._weighted_log = (self._count * np.log(spectrum)).sum(-1).ravel()
        # Cosines are real: each adds half as much as a complex amplitude would.
        self._inverse = np.ascontiguousarray((self._count / spectrum).reshape(-1, len(first)).T)

    def _set_up_bands(self, k: FloatArray, highest: float) -> None:
        """Set up the bands of the detail; k are wave numbers up to the highest that cells show, rad/m."""
        # Low passes, each an octave above the last one, and what is between them.
        edges = [1.0 / (1.0 + (k / (_BAND_EDGE * share * highest)) ** 4) for share in _DETAIL_BANDS[:-1]]
        passes = [np.zeros_like(k), *edges, np.ones_like(k)]
        self.bands = [(high - low).astype(np.float32) for low, high in itertools.pairwise(passes)]
        around = [_AROUND / (share * highest) for share in _DETAIL_BANDS]
        self.blurs = [np.exp(-0.5 * (k * length) ** 2).astype(np.float32) for length in around]
        # From the flat part of the noise's spectrum, 0, to the part that is measured, 1.
        low, high = (share * highest for share in _NOISE_FALLS)
        self._fallen = np.clip(np.log(np.maximum(k, low) / low) / np.log(high / low), 0.0, 1.0).astype(np.float32)
        self._shortest = (k > high) & (k < highest)

    def noise_spectrum(self, cosines: Single, noise: FloatArray) -> Single:
        """Return the spectrum of windows' noise, (W, SIZE, SIZE), m⁴, with the level N, (W,), at long waves.

        Errors are correlated over cells: the spectrum falls to what the shortest waves of residuals have at most.
        """
        shortest = np.square(cosines[:, self._shortest] * np.float32(self.cell)).mean(axis=1)
        level = np.log(noise)
        fall = np.minimum(np.log(np.maximum(shortest, _LEAST_POWER)) - level, 0.0)
        out: Single = np.exp(level[:, None, None] + self._fallen * fall[:, None, None]).astype(np.float32)
        return out

    def to_cosines(self, values: Single) -> Single:
        """Return the coefficients of windows (W, SIZE, SIZE) in the orthonormal basis of cosines."""
        out: Single = self._cosines @ (values @ self._sines)
        return out

    def from_cosines(self, coefficients: Single) -> Single:
        """Return the values of coefficients (W, SIZE, SIZE)."""
        out: Single = self._sines @ (coefficients @ self._cosines)
        return out

    def fit(self, residual: Single, prior_log_n: float) -> tuple[FloatArray, FloatArray]:
        """Return ln A and ln N of windows' heights (W, SIZE, SIZE), by Whittle's likelihood with a prior on N."""
        power = self.to_cosines(residual).reshape(len(residual), -1)[:, self._order].astype(np.float64)
        mean = np.add.reduceat((power * self.cell) ** 2, self._first, axis=1) / self._count
        prior = np.tile(((self.log_n - prior_log_n) / _NOISE_SPREAD) ** 2, len(self.log_a))
        best = np.argmin(mean @ self._inverse + (self._weighted_log + prior), axis=1)
        return self.log_a[best // len(self.log_n)], self.log_n[best % len(self.log_n)]


def _monomials() -> tuple[FloatArray, FloatArray]:
    """Return the six monomials of order 2 over a window and their B-spline coefficients, (SIZE², 6)."""
    t = np.linspace(-1.0, 1.0, SIZE)
    # The B-spline with coefficients t² is t² + a third of the square of the distance of its knots.
    third = (2.0 / (SIZE - 1)) ** 2 / 3.0
    y, x = (axis.ravel() for axis in np.meshgrid(t, t, indexing="ij"))
    value = [np.ones_like(x), x, y, x * x, x * y, y * y]
    spline = [np.ones_like(x), x, y, x * x - third, x * y, y * y - third]
    return np.column_stack(value), np.column_stack(spline)


_MONOMIALS, _MONOMIAL_SPLINES = _monomials()
_PAIRS = np.triu_indices(6)
_PRODUCTS = np.ascontiguousarray(_MONOMIALS[:, _PAIRS[0]] * _MONOMIALS[:, _PAIRS[1]])


def _trends(z: FloatArray, known: BoolArray) -> FloatArray:
    """Return the factors (W, 6) of the monomials in the trends of windows (W, SIZE²), 0 where not known."""
    weight = known.astype(np.float64)
    count = weight.sum(axis=1)
    mean = z.sum(axis=1) / count
    # Sums as einsum does them depend neither on threads nor on the kernel that a linear algebra library picks.
    products = np.einsum("wn,nk->wk", weight, _PRODUCTS)
    gram = np.zeros((len(z), 6, 6))
    gram[:, _PAIRS[0], _PAIRS[1]] = gram[:, _PAIRS[1], _PAIRS[0]] = products
    right = np.einsum("wn,nk->wk", np.where(known, z - mean[:, None], 0.0), _MONOMIALS)
    few = count <= _SECOND_ORDER * z.shape[1]
    gram[few, 3:, :] = gram[few, :, 3:] = right[few, 3:] = 0.0
    gram += (_RIDGE * count)[:, None, None] * np.eye(6)
    factors: FloatArray = np.linalg.solve(gram, right[:, :, None])[:, :, 0]
    factors[:, 0] += mean
    return factors


class _Stack:
    """Penalised least squares of some windows at once: heights less the trend, weights, and the smooth surface."""

    def __init__(self, basis: Basis, target: Single, known: BoolArray) -> None:
        self.basis = basis
        self.target = target
        self.weight: Single = known.astype(np.float32)
        self.coefficients = np.zeros_like(target)
        self.smooth = np.zeros_like(target)

    def solve(self, ratio: FloatArray, steps: int) -> None:
        """Minimise weight (target - f)² + ratio k⁴ c² by preconditioned conjugate gradients, from where it is.

        Windows stop whose error, by their residual, is small.
        """
        basis, weight = self.basis, self.weight
        penalty = ratio.astype(np.float32)[:, None, None] * basis.k4
        mean = weight.mean(axis=(1, 2))
        diagonal = 1.0 / (mean[:, None, None] + penalty)
        enough = mean * np.float32(_CG_ERROR**2 * SIZE * SIZE)
        r = basis.to_cosines(weight * (self.target - self.smooth)) - penalty * self.coefficients
        p = diagonal * r
        rz = _dot(r, p)
        index = np.arange(len(rz))
        for _ in range(steps):
            left = rz > enough
            if not left.all():
                index, weight, penalty, diagonal, enough, r, p, rz = (
                    item[left] for item in (index, weight, penalty, diagonal, enough, r, p, rz)
                )
                if not len(index):
                    break
            g = basis.from_cosines(p)
            q = basis.to_cosines(weight * g) + penalty * p
            alpha = (rz / _dot(p, q))[:, None, None]
            self.coefficients[index] += alpha * p
            self.smooth[index] += alpha * g
            r = r - alpha * q
            z = diagonal * r
            new = _dot(r, z)
            p = z + (new / rz)[:, None, None] * p
            rz = new


def _dot(a: Single, b: Single) -> Single:
    """Return the inner products of windows."""
    out: Single = np.einsum("wij,wij->w", a, b)
    return out


def unknown_windows(count: int) -> WindowEstimates:
    """Return windows of which nothing is known."""
    spline, nothing = np.full((count, INNER, INNER), np.nan, np.float32), np.full(count, np.nan, np.float32)
    return WindowEstimates(spline, np.zeros(spline.shape, np.bool_), nothing, nothing.copy(), nothing.copy())


def estimate_windows(z: FloatArray, basis: Basis, prior_log_n: float, smoothing: float) -> WindowEstimates:
    """Estimate the ground in windows of heights (W, SIZE, SIZE), m, NaN where unknown.

    `prior_log_n` is ln N as expected, N in m⁴; `smoothing` is a factor on the penalty.
    """
    out = unknown_windows(len(z))
    enough = np.flatnonzero(np.isfinite(z).sum(axis=(1, 2)) >= _FEWEST)
    for first in range(0, len(enough), _STACK):
        part = enough[first : first + _STACK]
        found = _estimate(z[part], basis, prior_log_n, smoothing)
        for item in fields(out):
            getattr(out, item.name)[part] = getattr(found, item.name)
    return out


def _estimate(z: FloatArray, basis: Basis, prior_log_n: float, smoothing: float) -> WindowEstimates:
    """Estimate the ground in a stack of windows that have enough heights."""
    known = np.isfinite(z)
    share = known.mean(axis=(1, 2))
    z = np.where(known, z, 0.0).reshape(len(z), -1)
    factors = _trends(z, known.reshape(z.shape))
    target = np.where(known, (z - np.einsum("wk,nk->wn", factors, _MONOMIALS)).reshape(known.shape), 0.0)
    stack = _Stack(basis, target.astype(np.float32), known)
    log_a, log_n = basis.fit(stack.target, prior_log_n)
    for step in range(_PASSES + 1):
        ratio = smoothing * defaults.ROAD_SMOOTHNESS * np.exp(log_n - log_a)
        stack.solve(ratio, _CG_STEPS if step else _FIRST_STEPS)
        if step == _PASSES:
            break
        residual = stack.target - stack.smooth
        scale = _spread(residual, known)
        one_sided = _one_sided(residual, scale, known)
        sides = np.where(one_sided[:, None], _ONE_SIDED, _TWO_SIDED).astype(np.float32)
        above, below = sides[:, 0, None, None], sides[:, 1, None, None]
        base = 1.0 / (1.0 + (residual / np.where(residual > 0, above * scale, below * scale)) ** 2)
        stack.weight = np.where(known, base * base if step else base, np.float32(0.0))
        if step == 1:
            clipped = np.where(known, np.clip(residual, _CLIP[0] * scale, _CLIP[1] * scale), np.float32(0.0))
            log_a, log_n = basis.fit(stack.smooth + clipped, prior_log_n)
    cosines = stack.coefficients + _detail(stack, known, np.exp(log_a), np.exp(log_n), smoothing)
    inner = slice(RIM, SIZE - RIM)
    spline = np.einsum("wk,nk->wn", factors, _MONOMIAL_SPLINES).reshape(known.shape)
    spline += basis.from_cosines(cosines * basis.to_spline)
    supported = np.ones(known.shape, np.bool_)
    partly = np.flatnonzero(share < 1.0)
    if len(partly):
        # How many are known in the square around each; beyond its edges a window goes on as it is there.
        around = np.pad(known[partly], ((0, 0), *[(_SUPPORT_CELLS // 2,) * 2] * 2), mode="edge")
        for axis in (1, 2):
            around = sliding_window_view(around, _SUPPORT_CELLS, axis=axis).sum(axis=-1)
        supported[partly] = around > _SUPPORT * _SUPPORT_CELLS**2
    sigma = np.sqrt(np.exp(log_n) / np.maximum(share, _KNOWN_MIN) / (8.0 * np.sqrt(ratio)))
    return WindowEstimates(
        spline[:, inner, inner].astype(np.float32),
        supported[:, inner, inner],
        sigma.astype(np.float32),
        (2.0 * ratio**0.25).astype(np.float32),
        log_a.astype(np.float32),
    )


def _detail(stack: _Stack, known: BoolArray, relief: FloatArray, noise: FloatArray, smoothing: float) -> Single:
    """Return the cosines of what the smooth surface lacks of relief, band by band and place by place.

    The smooth surface has one roughness for a whole window. Where a slope or a bank crosses a plain, the residuals
    around it are far larger than noise makes them: there each band counts by the share of relief in its power, as in
    Wiener's filter. `relief` and `noise` are A and N, (W,); `smoothing` is a factor on the noise.
    """
    basis = stack.basis
    residual = np.where(known, stack.target - stack.smooth, np.float32(0.0))
    cosines = basis.to_cosines(residual)
    one_sided = _one_sided(residual, _spread(residual, known), known)[:, None, None]
    rougher = np.where(one_sided, *_ROUGHER).astype(np.float32)
    ratio = (smoothing * defaults.ROAD_SMOOTHNESS * noise / relief).astype(np.float32)[:, None, None]
    # What share of the power of ground and noise the residuals have.
    left = (ratio * basis.k4 / (1.0 + ratio * basis.k4)) ** 2
    noise_left = left * basis.noise_spectrum(cosines, noise) / basis.cell**2
    relief_left = left * basis.inverse_k4 * (relief / basis.cell**2).astype(np.float32)[:, None, None]
    out = np.zeros_like(cosines)
    for band, blur in zip(basis.bands, basis.blurs, strict=True):
        part = basis.from_cosines(band * cosines)
        above, below = (_blurred(basis, np.square(np.maximum(side, 0.0)), blur) for side in (part, -part))
        # Canopy and roofs stand out above alone.
        power = above + np.where(one_sided, np.minimum(below, 2.0 * below - above), below)
        expected = np.float32(smoothing) * (band * band * noise_left).mean(axis=(1, 2), keepdims=True)
        usual = (band * band * relief_left).mean(axis=(1, 2), keepdims=True)
        signal = np.clip(power - np.float32(_CLEARLY) * expected, 0.0, rougher * usual)
        out += basis.to_cosines(part * (signal / (signal + expected)))
    return out


def _blurred(basis: Basis, values: Single, blur: Single) -> Single:
    """Return averages around each place; blur is the weighting's spectrum."""
    out: Single = np.maximum(basis.from_cosines(blur * basis.to_cosines(values)), 0.0)
    return out


def _spread(residual: Single, known: BoolArray) -> Single:
    """Return the standard deviation (W, 1, 1) of windows' residuals where known, by the median of their sizes."""
    size = np.where(known, np.abs(residual), np.float32(np.inf)).reshape(len(residual), -1)
    count = known.sum(axis=(1, 2))
    low, high = (count - 1) // 2, count // 2
    size.partition(np.unique(np.concatenate([low, high])), axis=1)
    median = 0.5 * (size[np.arange(len(size)), low] + size[np.arange(len(size)), high])
    out: Single = np.maximum(median / np.float32(_MEDIAN_SIZE), np.float32(_SPREAD_MIN))[:, None, None]
    return out


def _one_sided(residual: Single, scale: Single, known: BoolArray) -> BoolArray:
    """Return in which windows heights stand out above rather than below, (W,): there they are canopy and roofs."""
    count = known.sum(axis=(1, 2))
    # Unknown heights have the residual of the smooth surface itself and must not count.
    above = (known & (residual > _TAIL * scale)).sum(axis=(1, 2)) / count
    below = (known & (residual < -_TAIL * scale)).sum(axis=(1, 2)) / count
    out: BoolArray = above > _TAIL_SHARE + _TAIL_RATIO * below
    return out
