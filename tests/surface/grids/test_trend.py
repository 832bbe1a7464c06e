from __future__ import annotations

import numpy as np
import pytest

from osm2xodr.model import FloatArray
from osm2xodr.surface.grids.trend import PolynomialTrend, fit_polynomial


def largest_residual(trend: PolynomialTrend, x: FloatArray, y: FloatArray, z: FloatArray) -> float:
    return float(np.abs(trend.heights(x.ravel(), y.ravel()) - z.ravel()).max())


def quartic(u: FloatArray, v: FloatArray) -> FloatArray:
    z: FloatArray = 300 + 40 * u - 25 * v + 9 * u * v - 7 * u**2 + 3 * v**3 + 2 * u**2 * v**2 - 5 * u**4 + u * v**3
    return z


@pytest.mark.parametrize(("east", "north"), [(0.0, 0.0), (676093.0, 5537046.0)])
def test_quartic_is_found_in_any_frame(east: float, north: float) -> None:
    rng = np.random.default_rng(1)
    u, v = rng.uniform(-1, 1, (2, 5000))
    points = east + 7000 * u, north + 3000 * v, quartic(u, v)
    trend = fit_polynomial(*points, 4)
    assert trend.rms < 1e-9
    assert largest_residual(trend, *points) < 1e-8
    u, v = rng.uniform(-1, 1, (2, 100))
    assert np.abs(trend.heights(east + 7000 * u, north + 3000 * v) - quartic(u, v)).max() < 1e-8


def test_order_is_the_total_degree() -> None:
    u, v = np.random.default_rng(1).uniform(-1, 1, (2, 2000))
    for order in range(2, 6):
        below = fit_polynomial(u, v, u**order + (u * v) ** (order // 2), order)
        above = fit_polynomial(u, v, u**order * v, order)
        assert below.rms < 1e-12
        assert above.rms > 0.01
        assert np.count_nonzero(np.abs(below.coefficients) > 1e-12) <= (order + 1) * (order + 2) // 2


def test_rms_and_largest_residual() -> None:
    x, y = np.meshgrid(np.linspace(0, 100, 21), np.linspace(0, 50, 21))
    z = np.full(x.shape, 5.0)
    z[10, 10] += 441.0
    trend = fit_polynomial(x, y, z, 0)
    assert trend.heights(np.array([3.0]), np.array([4.0])) == pytest.approx(6.0)
    assert largest_residual(trend, x, y, z) == pytest.approx(440.0)
    assert trend.rms == pytest.approx(np.sqrt((440.0**2 + 440 * 1.0) / 441))


def test_it_is_the_least_squares_solution() -> None:
    rng = np.random.default_rng(2)
    x, y, z = rng.normal(0, 1, (3, 300))
    weights = rng.uniform(0, 2, 300)
    trend = fit_polynomial(x, y, z, 2, weights)
    powers = np.column_stack([x**i * y**j for i in range(3) for j in range(3 - i)])
    root = np.sqrt(weights)
    best = np.linalg.lstsq(powers * root[:, None], z * root, rcond=None)[0]
    assert np.abs(trend.heights(x, y) - powers @ best).max() < 1e-10
    assert trend.rms == pytest.approx(np.sqrt(np.sum(weights * (powers @ best - z) ** 2) / weights.sum()))


def test_many_points_in_chunks() -> None:
    u, v = np.random.default_rng(3).uniform(-1, 1, (2, 200_000))
    points = 5e5 + 1e4 * u, 5e6 + 1e4 * v, quartic(u, v)
    assert largest_residual(fit_polynomial(*points, 4), *points) < 1e-8


def test_points_on_a_line() -> None:
    t = np.linspace(0, 1000, 200)
    points = t, 0 * t + 7.0, 100 + (t / 100) ** 2
    trend = fit_polynomial(*points, 4)
    assert largest_residual(trend, *points) < 1e-9
    assert np.isfinite(trend.coefficients).all()


@pytest.mark.parametrize(
    ("points", "order", "words"),
    [(14, 4, "needs 15 points, not 14"), (5, -1, "needs 1 points"), (30, 2, "must be finite")],
)
def test_what_cannot_be_fitted(points: int, order: int, words: str) -> None:
    x = np.arange(points, dtype=np.float64)
    z = np.where(x == 29, np.nan, x)
    with pytest.raises(ValueError, match=words):
        fit_polynomial(x, x**2, z, order)


def test_coefficients_are_read_only() -> None:
    x, y = np.random.default_rng(3).uniform(-1, 1, (2, 50))
    with pytest.raises(ValueError, match="read-only"):
        fit_polynomial(x, y, x, 2).coefficients[0, 0] = 1.0
