"""The ground of windows: a smooth surface that sees through what stands out, and from it the filtered ground."""

from __future__ import annotations

import itertools
from dataclasses import fields
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from osm2xodr.curves import exp, log, solve_dense
from osm2xodr.geometry.heights import defaults
from osm2xodr.geometry.heights.ground_windows.spectra import SIZE, Basis, Single, Spectrum, all_spectra
from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.system import record

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

# The outermost cells of a window steady it and are not used.
RIM: Final = 4
INNER: Final = SIZE - 2 * RIM
# Windows in a stack: they fit the cache.
_STACK: Final = 16
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
# Keeps the trend of heights in one row determinate, as a share of their weight.
_RIDGE: Final = 1e-9


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


@record(eq=False)
class WindowEstimates:
    """The ground within W windows, without their rims."""

    # (W, INNER, INNER) Coefficients of the cubic B-spline that is the height, m, in rows from the south and columns
    # from the west; NaN where too little is known.
    spline: Single
    supported: BoolArray  # (W, INNER, INNER) Where heights are known around
    log_relief: Single  # (W, INNER, INNER) ln A of the relief around, whose spectrum is A / k⁴
    # (W,) ln N of the noise at long waves, N in m⁴, more where less is known; NaN where too little is
    log_noise: Single


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
    factors: FloatArray = solve_dense(gram, right[:, :, None])[:, :, 0]
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
    spline = np.full((count, INNER, INNER), np.nan, np.float32)
    return WindowEstimates(
        spline, np.zeros(spline.shape, np.bool_), spline.copy(), np.full(count, np.nan, np.float32)
    )


class Estimator:
    """Estimates the ground in windows of cells of one size, m, whose heights have the standard error `sigma`, m.

    `smoothing` is a factor on the penalty on roughness.
    """

    def __init__(self, cell: float, sigma: float, smoothing: float) -> None:
        self._basis = Basis(cell)
        self._filter = PlaceFilter(self._basis)
        self._sigma, self._smoothing = max(sigma, defaults.HEIGHT_SIGMA_MIN), smoothing

    def estimate(self, z: FloatArray) -> WindowEstimates:
        """Estimate the ground in windows of heights (W, SIZE, SIZE), m, NaN where unknown."""
        out = unknown_windows(len(z))
        enough = np.flatnonzero(np.isfinite(z).sum(axis=(1, 2)) >= _FEWEST)
        for first in range(0, len(enough), _STACK):
            part = enough[first : first + _STACK]
            found = self._estimate(z[part])
            for item in fields(out):
                getattr(out, item.name)[part] = getattr(found, item.name)
        return out

    def _estimate(self, z: FloatArray) -> WindowEstimates:
        """Estimate the ground in a stack of windows that have enough heights."""
        basis, known = self._basis, np.isfinite(z)
        share = np.maximum(known.mean(axis=(1, 2)), _KNOWN_MIN)
        z = np.where(known, z, 0.0).reshape(len(z), -1)
        factors = _trends(z, known.reshape(z.shape))
        above_trend = (z - np.einsum("wk,nk->wn", factors, _MONOMIALS)).reshape(known.shape)
        target = np.where(known, above_trend, 0.0).astype(np.float32)
        smooth = self._smooth_surface(target, known)
        residual = np.where(known, target - smooth, np.float32(0.0))
        scale = _spread(residual, known)
        one_sided = _one_sided(residual, scale, known)
        clipped = smooth + np.clip(residual, _CLIP[0] * scale, _CLIP[1] * scale)
        spectrum = all_spectra().fit(basis.to_cosines(clipped), basis.cell, self._sigma)
        # Beneath canopy and roofs heights leave the smooth surface by no more than it leaves the ground.
        held = np.minimum(spectrum.ground_error.astype(np.float32)[:, None, None], scale)
        heights = smooth + np.where(one_sided[:, None, None], np.clip(residual, -held, held), residual)
        cosines, log_relief = self._filter.apply(heights, spectrum, one_sided, self._smoothing)
        inner = slice(RIM, SIZE - RIM)
        spline = np.einsum("wk,nk->wn", factors, _MONOMIAL_SPLINES).reshape(known.shape)
        spline += basis.from_cosines(cosines * basis.to_spline)
        return WindowEstimates(
            spline[:, inner, inner].astype(np.float32),
            _supported(known)[:, inner, inner],
            log_relief[:, inner, inner],
            log(spectrum.noise / (self._smoothing * share**2)).astype(np.float32),
        )

    def _smooth_surface(self, target: Single, known: BoolArray) -> Single:
        """Return the smooth surface through heights less the trend, (W, SIZE, SIZE), m, below what stands out."""
        stack = _Stack(self._basis, target, known)
        # As if errors were white over the length that they are correlated over.
        noise_length = 2.0 * defaults.NOISE_LENGTH_CELLS * self._basis.cell
        prior_log_n = 2.0 * float(log(self._sigma * noise_length))
        log_a, log_n = self._basis.fit(target, prior_log_n)
        for step in range(_PASSES + 1):
            ratio = self._smoothing * defaults.ROAD_SMOOTHNESS * exp(log_n - log_a)
            stack.solve(ratio, _CG_STEPS if step else _FIRST_STEPS)
            if step == _PASSES:
                break
            residual = target - stack.smooth
            scale = _spread(residual, known)
            one_sided = _one_sided(residual, scale, known)
            sides = np.where(one_sided[:, None], _ONE_SIDED, _TWO_SIDED).astype(np.float32)
            above, below = sides[:, 0, None, None], sides[:, 1, None, None]
            base = 1.0 / (1.0 + (residual / np.where(residual > 0, above * scale, below * scale)) ** 2)
            stack.weight = np.where(known, base * base if step else base, np.float32(0.0))
            if step == 1:
                clipped = np.where(known, np.clip(residual, _CLIP[0] * scale, _CLIP[1] * scale), np.float32(0.0))
                log_a, log_n = self._basis.fit(stack.smooth + clipped, prior_log_n)
        return stack.smooth


def _supported(known: BoolArray) -> BoolArray:
    """Return where heights are known around, (W, SIZE, SIZE)."""
    out = np.ones(known.shape, np.bool_)
    partly = np.flatnonzero(~known.all(axis=(1, 2)))
    if len(partly):
        # How many are known in the square around each; beyond its edges a window goes on as it is there.
        around = np.pad(known[partly], ((0, 0), *[(_SUPPORT_CELLS // 2,) * 2] * 2), mode="edge")
        for axis in (1, 2):
            around = sliding_window_view(around, _SUPPORT_CELLS, axis=axis).sum(axis=-1)
        out[partly] = around > _SUPPORT * _SUPPORT_CELLS**2
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
