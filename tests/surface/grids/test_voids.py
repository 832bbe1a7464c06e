""" """

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.surface.grids.grid import Cells
from osm2xodr.surface.grids.voids import PolynomialTrend, fill_from_rim, fill_voids, fit_polynomial, rim_of


def exact(values: FloatArray, free: BoolArray, steps: tuple[float, float], fade: float) -> FloatArray:
    """Solve the membrane's equations directly; the border of the grid is level."""
    index = np.cumsum(free.reshape(-1)).reshape(free.shape) - 1
    entries: list[tuple[int, int, float]] = []
    right = np.zeros(int(free.sum()))
    for row, col in np.argwhere(free):
        here = int(index[row, col])
        entries.append((here, here, 1.0 / fade**2))
        for dr, dc, weight in (
            (0, 1, steps[0] ** -2),
            (0, -1, steps[0] ** -2),
            (1, 0, steps[1] ** -2),
            (-1, 0, steps[1] ** -2),
        ):
            r, c = row + dr, col + dc
            if 0 <= r < free.shape[0] and 0 <= c < free.shape[1]:
                entries.append((here, here, weight))
                if free[r, c]:
                    entries.append((here, int(index[r, c]), -weight))
                else:
                    right[here] += weight * values[r, c]
    i, j, v = zip(*entries, strict=True)
    out = values.copy()
    out[free] = spsolve(coo_matrix((np.array(v), (np.array(i), np.array(j)))).tocsr(), right)
    return out


def blob(shape: tuple[int, int], seed: int) -> BoolArray:
    rng = np.random.default_rng(seed)
    row, col = np.mgrid[: shape[0], : shape[1]]
    out = np.zeros(shape, bool)
    for _ in range(4):
        at = rng.uniform(0, shape[0]), rng.uniform(0, shape[1])
        out |= np.hypot(row - at[0], col - at[1]) < rng.uniform(2, 0.25 * min(shape))
    return out


def test_rim() -> None:
    gap = np.zeros((5, 6), bool)
    gap[2, 2:4] = True
    rim = rim_of(gap)
    assert rim.astype(int).tolist() == [
        [0, 0, 0, 0, 0, 0],
        [0, 1, 1, 1, 1, 0],
        [0, 1, 0, 0, 1, 0],
        [0, 1, 1, 1, 1, 0],
        [0, 0, 0, 0, 0, 0],
    ]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("steps", "fade"), [((1.0, 1.0), np.inf), ((20.0, 31.0), np.inf), ((30.0, 30.0), 100.0)])
def test_the_membrane_is_nearly_that_of_a_direct_solution(seed: int, steps: tuple[float, float], fade: float) -> None:
    shape = (61, 84)
    row, col = np.mgrid[: shape[0], : shape[1]]
    values = 10 * np.sin(row / 9.0) + 8 * np.cos(col / 7.0)
    gap = blob(shape, seed)
    rim = rim_of(gap)
    out = np.where(rim, values, 0.0)
    fill_from_rim(out, rim, gap, steps, fade)
    best = exact(values, gap, steps, fade)
    assert np.array_equal(out[rim], values[rim])
    assert np.abs(out - best)[gap].max() < 0.025 * np.ptp(values[rim])
    low, high = min(values[rim].min(), 0.0), max(values[rim].max(), 0.0)
    assert low - 1e-9 <= out[gap].min()
    assert out[gap].max() <= high + 1e-9


def test_constants_stay() -> None:
    gap = blob((100, 70), 3)
    rim = rim_of(gap)
    out = np.where(rim, 4.25, 0.0)
    fill_from_rim(out, rim, gap, (1.0, 2.0))
    assert np.abs(out[gap] - 4.25).max() < 1e-12


def test_beyond_the_fading_length_nothing_is_left() -> None:
    known = np.zeros((3, 400), bool)
    known[:, 0] = True
    out = np.where(known, 10.0, 0.0)
    fill_from_rim(out, known, ~known, (10.0, 10.0), 100.0)
    # In one dimension the membrane is exp(-distance / fade).
    distance = 10.0 * np.arange(400)
    assert np.abs(out[1] - 10.0 * np.exp(-distance / 100.0)).max() < 0.5
    assert np.abs(out[1, 100:]).max() < 0.01


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_large_void_takes_little_time(dtype: type) -> None:
    row, col = np.mgrid[:1500, :1500]
    gap = np.hypot(row - 750, col - 750) < 560
    z: Cells = np.where(gap, np.nan, 0.01 * col).astype(dtype)
    asked = []

    def below(col: FloatArray, row: FloatArray) -> FloatArray:
        asked.append(len(col))
        return 300.0 + 0.002 * col - 0.03 * row

    begin = time.perf_counter()
    out = fill_voids(z, below, (1.0, 1.0), np.inf)
    assert time.perf_counter() - begin < 5.0
    # The residual is a plane, which is a membrane itself; a million cells in all, up to 11 m apart in height.
    assert np.abs(out - 0.01 * col)[gap].max() < 0.3
    assert np.array_equal(out[~gap], z[~gap])
    assert sum(asked) < 300_000
    assert out.dtype == dtype


def test_what_is_below_shows_in_the_middle_of_a_void() -> None:
    row, col = np.mgrid[:200, :300]
    gap = (np.abs(row - 100) < 60) & (np.abs(col - 150) < 100)
    ground = 50 + 5 * np.sin(row / 8.0) * np.cos(col / 8.0)
    z = np.where(gap, np.nan, ground + 3.0)
    out = fill_voids(z, lambda col, row: 50 + 5 * np.sin(row / 8.0) * np.cos(col / 8.0), (10.0, 10.0), 100.0)
    step = out - ground
    assert np.abs(step[~gap] - 3.0).max() < 1e-9
    # Next to the rim the step of 3 m is still there, 600 m from it nothing but exp(-6) of it.
    assert 2.4 < step[42, 150] < 2.8
    assert np.abs(step[100, 100:200]).max() < 0.06


def test_voids_apart_are_filled_as_if_alone() -> None:
    row, col = np.mgrid[:500, :600]
    ground = 100 + 10 * np.sin(row / 30.0) + 8 * np.cos(col / 25.0)
    # An angle around a spot, spots at the border and in corners, and one of a single cell.
    gaps = [
        ((row > 50) & (row < 450) & (col > 40) & (col < 60)) | ((row > 430) & (row < 450) & (col > 40) & (col < 550)),
        np.hypot(row - 200, col - 300) < 20,
        np.hypot(row - 0, col - 599) < 30,
        np.hypot(row - 499, col - 599) < 1,
        (row == 130) & (col == 450),
    ]

    def below(col: FloatArray, row: FloatArray) -> FloatArray:
        return 90 + 0.01 * col

    together = fill_voids(np.where(np.any(gaps, axis=0), np.nan, ground), below, (10.0, 10.0), np.inf)
    assert np.isfinite(together).all()
    for gap in gaps:
        alone = fill_voids(np.where(gap, np.nan, ground), below, (10.0, 10.0), np.inf)
        assert np.array_equal(alone[gap], together[gap])
        assert np.abs(alone - ground)[gap].max() < 9.0


def test_no_voids_and_nothing_but_voids_at_the_border() -> None:
    z = np.random.default_rng(1).normal(0, 1, (20, 30))
    assert np.array_equal(fill_voids(z, lambda col, row: 0 * col, (1.0, 1.0), 5.0), z)
    z[:, :29] = np.nan
    z[:, 29] = 4.0
    filled = fill_voids(z, lambda col, row: 0 * col + 1.0, (1.0, 1.0), np.inf)
    assert np.abs(filled - 4.0).max() < 1e-9


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
