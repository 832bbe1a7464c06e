from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.surface.grids.grid import Cells
from osm2xodr.surface.grids.voids import fill_from_rim, fill_voids, rim_of


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
