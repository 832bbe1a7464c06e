"""The ground beneath coarse elevation models, told apart from their noise, over the area around the roads.

A global elevation model of 30 m cells has errors of metres that are correlated over a few cells, and takes canopy
and roofs for ground. Sampled along a road they are grades of many per cent that are not there. What lies beside a
road tells more about it than the few cells beneath it, so the ground is estimated in two dimensions first.

The model: ground with a power spectrum A / k⁴ (a thin-plate spline; relief at road scale is close to it), plus noise
of level N that is flat at wavelengths the model resolves well. A and N are estimated window by window from the
elevation model itself by Whittle's likelihood, so that a plain is smoothed over a kilometre and the Alps over a
cell or two. The estimate is the penalised weighted least-squares surface with penalty N / A, with weights that fall
for heights that stand out (iteratively; one-sided where the errors are), solved by conjugate gradients in the
basis of cosines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.fft import dctn, idctn
from scipy.ndimage import map_coordinates, uniform_filter

from osm2xodr import defaults
from osm2xodr.model import BoolArray, FloatArray, IntArray, Surface

# Windows overlap by twice the margin, both in cells; a multiple of small primes is quick to transform. Their size is
# how far the terrain is taken to be of one kind: on coarsened models of a valley town and a city on a river, and on
# ten known terrains, windows of 36 to 60 cells do alike, ones of 96 cells are worse by a tenth in grade.
CORE = 24
MARGIN = 12
SIZE = CORE + 2 * MARGIN
# Shortest wavelength at which the noise counts as flat, in cells.
SHORTEST_WAVE = 5.0
# Spread of the prior of the noise about what the surface states, in natural logarithm.
NOISE_SPREAD = 1.0
# By how many standard deviations heights stand out, above and below, where they count half.
ONE_SIDED = (1.8, 4.5)
TWO_SIDED = (4.0, 4.0)
# Fewest heights that make an estimate, and the share of them that makes one of second order.
FEWEST = 30
SECOND_ORDER = 0.3
# A place is within what is known if this share of the cells around it is.
SUPPORT = 0.15
SUPPORT_CELLS = 7
PASSES = 3
CG_STEPS = 6


@dataclass(frozen=True, slots=True, eq=False)
class GroundReading:
    """The ground at places.

    Parameters
    ----------
    z : (n,)
        Height, m; NaN where no window reaches or none has data.
    sigma : (n,)
        Standard error, m.
    correlation : (n,)
        Length over which the error is correlated, m.
    """

    z: FloatArray
    sigma: FloatArray
    correlation: FloatArray


class _Basis:
    """What all windows share: the cosines' wave numbers, and spectra to choose from."""

    def __init__(self, cell: float) -> None:
        k = np.pi * np.arange(SIZE) / (SIZE * cell)
        k2 = k[:, None] ** 2 + k[None, :] ** 2
        self.cell = cell
        self.k4 = k2 * k2
        flat = np.sqrt(k2).ravel()
        used = (flat > 0) & (flat < 2 * np.pi / (SHORTEST_WAVE * cell))
        edges = np.linspace(np.log(flat[used].min()), np.log(flat[used].max()), 28)
        self.bin = np.where(used, np.digitize(np.log(np.maximum(flat, 1e-30)), edges), 0)
        self.count = np.bincount(self.bin, minlength=30)[1:].astype(np.float64)
        wave = np.bincount(self.bin, np.where(used, np.log(np.maximum(flat, 1e-30)), 0.0), minlength=30)[1:]
        wave = np.exp(wave / np.maximum(self.count, 1))
        self.log_a = np.arange(-14.0, 14.0, 0.35)
        self.log_n = np.arange(-4.0, 16.0, 0.25)
        spectrum = np.exp(self.log_a)[:, None, None] / wave[None, None, :] ** 4 + np.exp(self.log_n)[None, :, None]
        self.weighted_log = (self.count * np.log(spectrum)).sum(-1)
        self.inverse = self.count / spectrum

    def fit(self, residual: FloatArray, prior_log_n: float) -> tuple[float, float]:
        """Return ln A and ln N of a window's heights, by Whittle's likelihood with a prior on N."""
        power = (dctn(residual, norm="ortho") ** 2 * self.cell**2).ravel()
        mean = np.bincount(self.bin, power, minlength=30)[1:] / np.maximum(self.count, 1)
        # Cosines are real: each adds half of what a complex amplitude would.
        cost = 0.5 * (self.weighted_log + self.inverse @ mean)
        cost = cost + 0.5 * ((self.log_n - prior_log_n) / NOISE_SPREAD) ** 2
        i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        return float(self.log_a[i]), float(self.log_n[j])


def _smooth(weight: FloatArray, target: FloatArray, penalty: FloatArray, start: FloatArray) -> FloatArray:
    """Return the coefficients that minimise weight (target - f)² + penalty c², from a start, by some CG steps."""
    diagonal = 1.0 / (weight.mean() + penalty)

    def apply(c: FloatArray) -> FloatArray:
        out: FloatArray = dctn(weight * idctn(c, norm="ortho"), norm="ortho") + penalty * c
        return out

    c = start
    r = dctn(weight * target, norm="ortho") - apply(c)
    z = diagonal * r
    p = z
    rz = float((r * z).sum())
    first = rz
    for _ in range(CG_STEPS):
        if rz <= 1e-10 * max(first, 1e-30):
            break
        q = apply(p)
        alpha = rz / float((p * q).sum())
        c = c + alpha * p
        r = r - alpha * q
        z = diagonal * r
        new = float((r * z).sum())
        p = z + (new / rz) * p
        rz = new
    return c


def _polynomial(size: int) -> FloatArray:
    """Return the six monomials of order 2 over a window, (size², 6)."""
    t = np.linspace(-1.0, 1.0, size)
    y, x = (axis.ravel() for axis in np.meshgrid(t, t, indexing="ij"))
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])


_MONOMIALS = _polynomial(SIZE)


@dataclass(frozen=True, slots=True, eq=False)
class _Window:
    """The ground within a window: height and share of known cells around per cell, standard error, its length."""

    z: FloatArray
    support: FloatArray
    sigma: float
    correlation: float


def _estimate(z: FloatArray, basis: _Basis, prior_log_n: float, smoothing: float) -> _Window | None:
    """Estimate the ground from the heights of a window, NaN where unknown; None where too little is known."""
    known = np.isfinite(z)
    share = float(known.mean())
    if known.sum() < FEWEST:
        return None
    monomials = _MONOMIALS[:, : 6 if share > SECOND_ORDER else 3]
    trend = (monomials @ np.linalg.lstsq(monomials[known.ravel()], z[known], rcond=None)[0]).reshape(z.shape)
    target = np.where(known, z - trend, 0.0)
    weight = known.astype(np.float64)
    log_a, log_n = basis.fit(target, prior_log_n)
    c = np.zeros_like(target)
    for step in range(PASSES + 1):
        penalty = smoothing * defaults.ROAD_SMOOTHNESS * np.exp(log_n - log_a) * basis.k4
        for _ in range(1 if step else 2):
            c = _smooth(weight, target, penalty, c)
        f = idctn(c, norm="ortho")
        residual = (target - f)[known]
        scale = max(float(np.median(np.abs(residual))) / 0.6745, 1e-3)
        above, below = _sides(residual, scale)
        k = np.where(residual > 0, above, below) * scale
        factor = 1.0 / (1.0 + (residual / k) ** 2)
        weight[known] = factor if step == 0 else factor * factor
        if step == 1:
            clipped = np.array(f, np.float64)
            clipped[known] += np.clip(residual, -3 * scale, 2 * scale)
            log_a, log_n = basis.fit(clipped, prior_log_n)
    noise = np.exp(log_n) / max(share, 0.05)
    ratio = smoothing * defaults.ROAD_SMOOTHNESS * np.exp(log_n - log_a)
    sigma = np.sqrt(noise / (8.0 * np.sqrt(ratio)))
    support = uniform_filter(known.astype(np.float64), SUPPORT_CELLS, mode="nearest")
    return _Window(trend + f, support, float(sigma), float(2.0 * ratio**0.25))


def _sides(residual: FloatArray, scale: float) -> tuple[float, float]:
    """Return how far above and below outliers begin: closer above where canopy and roofs stand out."""
    above = float(np.mean(residual > 2.5 * scale))
    below = float(np.mean(residual < -2.5 * scale))
    return ONE_SIDED if above > 0.01 + 2.0 * below else TWO_SIDED


def read_ground(
    surface: Surface, x: FloatArray, y: FloatArray, cell: float, sigma: float, smoothing: float = 1.0
) -> GroundReading:
    """Estimate the ground at places from the elevation model around them.

    Parameters
    ----------
    surface
        The elevation model.
    x, y : (n,)
        Local positions, m.
    cell
        Cell size of the elevation model there, m.
    sigma
        Its standard error, m: the prior of the noise.
    smoothing
        Factor on the penalty.
    """
    basis = _Basis(cell)
    noise_length = 2 * defaults.NOISE_LENGTH_CELLS * cell
    prior_log_n = 2.0 * float(np.log(max(sigma, defaults.HEIGHT_SIGMA_MIN) * noise_length))
    x0, y0 = float(x.min(initial=np.inf)), float(y.min(initial=np.inf))
    u, v = (x - x0) / cell, (y - y0) / cell
    rows, cols = (axis.ravel() for axis in np.meshgrid(np.arange(SIZE), np.arange(SIZE), indexing="ij"))
    sums = np.zeros((4, len(x)))
    for i, j, inside in _windows(u, v):
        left, low = i * CORE - MARGIN, j * CORE - MARGIN
        z, measured = surface.heights((cols + left) * cell + x0, (rows + low) * cell + y0)
        z = np.where(measured, z, np.nan).reshape(SIZE, SIZE)
        window = _estimate(z, basis, prior_log_n, smoothing)
        if window is None:
            continue
        place = [v[inside] - low, u[inside] - left]
        share = _ramp(place[0]) * _ramp(place[1])
        share *= map_coordinates(window.support, place, order=1, mode="nearest") > SUPPORT
        height = map_coordinates(window.z, place, order=3, mode="mirror")
        sums[:, inside] += share * np.stack(
            [np.ones_like(share), height, np.full_like(share, window.sigma), np.full_like(share, window.correlation)]
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        return GroundReading(*(sums[1:] / sums[0]))


def _ramp(position: FloatArray) -> FloatArray:
    """Return a window's share: 1 in its core, 0 from three quarters of the margin off, and smooth between."""
    edge = np.minimum(position, SIZE - 1 - position) - 0.25 * MARGIN
    t = np.clip(edge / (1.5 * MARGIN), 0.0, 1.0)
    out: FloatArray = t * t * (3 - 2 * t)
    return out


def _windows(u: FloatArray, v: FloatArray) -> Iterator[tuple[int, int, IntArray]]:
    """Yield column and row of each window whose core has places in it, and the places in its reach."""
    if not len(u):
        return
    i, j = np.floor(u / CORE).astype(np.int64) + 1, np.floor(v / CORE).astype(np.int64) + 1
    stride = int(i.max()) + 2
    block = i + stride * j
    order = np.argsort(block, kind="stable")
    ordered = block[order]
    reach = 0.75 * MARGIN
    for b in np.unique(ordered):
        around = np.concatenate([np.arange(-1, 2) + b + stride * dj for dj in (-1, 0, 1)])
        start, end = np.searchsorted(ordered, around), np.searchsorted(ordered, around, "right")
        near = np.sort(np.concatenate([order[p:q] for p, q in zip(start, end, strict=True)]))
        ci, cj = int(b % stride) - 1, int(b // stride) - 1
        du, dv = u[near] - ci * CORE, v[near] - cj * CORE
        keep: BoolArray = (du > -reach) & (du < CORE + reach) & (dv > -reach) & (dv < CORE + reach)
        yield ci, cj, near[keep]
