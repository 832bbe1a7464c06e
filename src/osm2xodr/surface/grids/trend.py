"""The polynomial trend of heights: a linear least-squares problem in scaled coordinates.

z(x, y) = sum of c_ij T_i(u) T_j(v) over i + j <= order, with Chebyshev polynomials T and u, v the coordinates scaled
to [-1, 1]. In powers of unscaled coordinates the same problem has a condition number above 1e20, in this basis of
about ten.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from osm2xodr.curves import solve_dense
from osm2xodr.model import FloatArray, IntArray

# Points that are processed at a time, to bound memory.
_CHUNK: Final = 2**16
# Terms whose share of the largest is below this are not determined by the points.
_DETERMINED: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialTrend:
    """A polynomial of total degree `order` in x and y."""

    order: int
    coefficients: FloatArray  # (order + 1, order + 1) c_ij of T_i(u) T_j(v), m; 0 where i + j > order
    # u = (x - centre[0]) / half_range[0], v likewise, m
    centre: tuple[float, float]
    half_range: tuple[float, float]
    rms: float  # Weighted root mean square of the residuals at the fitted points, m

    def heights(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z (n,), m, at x, y (n,), m. Away from the fitted points it grows without bound."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        i, j = _terms(self.order)
        out = np.empty(len(x))
        for first in range(0, len(x), _CHUNK):
            part = slice(first, first + _CHUNK)
            basis = _basis(*_scaled(x[part], y[part], self.centre, self.half_range), i, j)
            out[part] = (basis * self.coefficients[i, j]).sum(axis=1)
        return out

    def on_grid(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return z (len(y), len(x)), m, at all pairs of x and y, m."""
        u, v = _scaled(np.asarray(x, np.float64), np.asarray(y, np.float64), self.centre, self.half_range)
        across, along = _chebyshev(u, self.order), _chebyshev(v, self.order)
        return np.asarray(np.einsum("ni,im->nm", np.einsum("nj,ij->ni", along, self.coefficients), across.T.copy()))


def term_count(order: int) -> int:
    """Return the number of terms of a bivariate polynomial of a total degree."""
    return (order + 1) * (order + 2) // 2


def fit_polynomial(
    x: FloatArray, y: FloatArray, z: FloatArray, order: int = 4, weights: FloatArray | None = None
) -> PolynomialTrend:
    """Fit a polynomial of a total degree to heights z at x, y, all (n,), m, by linear least squares.

    All numbers are finite, n is at least the number of terms (else `ValueError`); `weights` (n,), 0 or more, are
    those of the squared residuals, equal by default.

    A QR factorisation is updated with a chunk of points at a time (sequential TSQR, Demmel et al. 2012), so that
    memory is bounded and the normal matrix never formed. Where the points do not determine all terms (as on one
    line), the solution has minimum norm.
    """
    x, y, z = (np.asarray(value, np.float64).reshape(-1) for value in (x, y, z))
    root = np.ones(len(z)) if weights is None else np.sqrt(np.asarray(weights, np.float64).reshape(-1))
    if order < 0 or len(z) < term_count(order):
        raise ValueError(f"a polynomial of degree {order} needs {term_count(max(order, 0))} points, not {len(z)}")
    if not all(np.isfinite(value).all() for value in (x, y, z, root)):
        raise ValueError("positions, heights and weights must be finite to fit a polynomial to them")
    (west, east), (south, north) = (float(x.min()), float(x.max())), (float(y.min()), float(y.max()))
    centre = 0.5 * (west + east), 0.5 * (south + north)
    # Points on one line have no extent across it.
    half_range = 0.5 * (east - west) or 1.0, 0.5 * (north - south) or 1.0
    i, j = _terms(order)
    mean = float(z.mean())
    factor = np.zeros((0, len(i) + 1))
    for first in range(0, len(z), _CHUNK):
        part = slice(first, first + _CHUNK)
        basis = _basis(*_scaled(x[part], y[part], centre, half_range), i, j)
        rows = np.column_stack([basis, z[part] - mean]) * root[part, None]
        factor = _triangle(np.vstack([factor, rows]))
    coefficients = np.zeros((order + 1, order + 1))
    coefficients[i, j] = _solved(factor[:, :-1], factor[:, -1])
    coefficients[0, 0] += mean
    coefficients.flags.writeable = False
    trend = PolynomialTrend(order, coefficients, centre, half_range, 0.0)
    residual = trend.heights(x, y) - z
    rms = np.sqrt(np.sum((root * residual) ** 2) / max(float(np.sum(root**2)), np.finfo(float).tiny))
    return replace(trend, rms=float(rms))


def _triangle(rows: FloatArray) -> FloatArray:
    """Return the triangular factor of the QR factorisation of a matrix, by Householder's reflections.

    Those of libraries have other last digits on other machines.
    """
    work = np.asfortranarray(rows)
    for k in range(min(work.shape)):
        across = work[k:, k].copy()
        size = np.sqrt((across * across).sum())
        if size > 0.0:
            across[0] += size if across[0] >= 0.0 else -size
            share = (across[:, None] * work[k:, k:]).sum(axis=0) * (2.0 / (across * across).sum())
            work[k:, k:] -= across[:, None] * share
    return np.triu(work[: work.shape[1]])


def _solved(factor: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution, (terms,), of a triangular system, of minimum norm where it leaves some of it open."""
    terms = factor.shape[1]
    size = np.abs(np.diagonal(factor))
    if len(size) == terms and size.min() > _DETERMINED * size.max():
        return solve_dense(factor[:terms], right[:terms, None])[:, 0]
    return np.asarray(np.linalg.lstsq(factor, right, rcond=_DETERMINED)[0])


def _scaled(
    x: FloatArray, y: FloatArray, centre: tuple[float, float], half_range: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return u, v of x, y."""
    return (x - centre[0]) / half_range[0], (y - centre[1]) / half_range[1]


def _terms(order: int) -> tuple[IntArray, IntArray]:
    """Return i and j of all terms."""
    i, j = np.indices((order + 1, order + 1)).reshape(2, -1)
    keep = i + j <= order
    return i[keep], j[keep]


def _basis(u: FloatArray, v: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Return all terms at u, v, (n, terms)."""
    return _chebyshev(u, int(i.max()))[:, i] * _chebyshev(v, int(j.max()))[:, j]


def _chebyshev(u: FloatArray, order: int) -> FloatArray:
    """Return T_0 to T_order at u (n, order + 1) by the recurrence T_k = 2 u T_k-1 - T_k-2."""
    out = np.ones((len(u), order + 1))
    if order > 0:
        out[:, 1] = u
    for k in range(2, order + 1):
        out[:, k] = 2.0 * u * out[:, k - 1] - out[:, k - 2]
    return out
