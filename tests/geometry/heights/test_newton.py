"""The solve, on problems that can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from osm2xodr.geometry.heights import newton
from osm2xodr.geometry.heights.limits import Limits
from osm2xodr.geometry.heights.newton import Solved, solve_network
from osm2xodr.geometry.heights.observations import FLOOR, Kind, Observations
from osm2xodr.geometry.heights.sparse import join_blocks
from osm2xodr.model import FloatArray


def row(*values: float) -> sp.csr_matrix:
    return sp.csr_matrix(np.array([values]))


def observe(
    rows: sp.csr_matrix, z: list[float], weight: float = 1.0, above: float = 1e6, below: float = 1e6
) -> Observations:
    n = len(z)
    return Observations(
        rows,
        np.array(z),
        weight=np.full(n, weight),
        sigma=np.ones(n),
        kind=np.full(n, Kind.ROAD_HEIGHT, np.int64),
        above=np.full(n, above),
        below=np.full(n, below),
        canopy=np.zeros(n, bool),
        floor=np.full(n, FLOOR),
    )


def bound(
    rows: sp.csr_matrix, low: float, high: float, stiffness: float, cap: float = np.inf, *, own: bool = True
) -> Limits:
    n = rows.shape[0]
    return Limits(
        rows, np.full(n, low), np.full(n, high), np.full(n, stiffness), np.full(n, cap), np.full(n, own, bool)
    )


def minimise(stiffness: sp.csr_matrix, observations: Observations, limits: Limits) -> Solved:
    """Solve with copies of the rows, which are used up."""
    return solve_network(
        stiffness,
        replace(observations, rows=observations.rows.copy()),
        replace(limits, rows=limits.rows.copy()),
        np.ones(len(observations.value)),
    )


def solve(observations: Observations, limits: Limits) -> tuple[FloatArray, FloatArray]:
    n = observations.rows.shape[1]
    solved = minimise(sp.csr_matrix((n, n)), observations, limits)
    assert solved.value == pytest.approx(observations.rows @ solved.x, abs=1e-9)
    return solved.x, solved.factors


def test_limit_stops_what_is_observed() -> None:
    # Minimum of (x - 3)² / 2 + 1000 (x - 1)² / 2.
    x, factors = solve(observe(row(1.0), [3.0]), bound(row(1.0), -np.inf, 1.0, 1000.0))
    assert x == pytest.approx([1003.0 / 1001.0], abs=1e-6)
    assert factors == pytest.approx([1.0], abs=1e-9)


def test_limit_gives_way_beyond_its_cap() -> None:
    # A force of 0.5 against a spring of 1.
    x, _ = solve(observe(row(1.0), [3.0]), bound(row(1.0), -1.0, 1.0, 1000.0, 0.5))
    assert x == pytest.approx([2.5], abs=0.1)


def test_lower_bound() -> None:
    x, _ = solve(observe(row(1.0), [-3.0]), bound(row(1.0), -1.0, np.inf, 1000.0))
    assert x == pytest.approx([-1003.0 / 1001.0], abs=1e-6)


def test_limits_that_do_not_bind_change_nothing() -> None:
    rows = sp.csr_matrix([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    x, _ = solve(observe(rows, [1.0, 2.0, 3.3]), bound(row(1.0, -1.0), -5.0, 5.0, 1e5))
    assert x == pytest.approx([1.1, 2.1], abs=1e-6)


def test_limits_against_each_other_settle() -> None:
    # Two bounds that cannot both be met: the stiffer one wins, in proportion.
    limits = join_blocks([bound(row(1.0), 2.0, np.inf, 3e4), bound(row(1.0), -np.inf, 1.0, 1e4)], 1)
    x, _ = solve(observe(row(1.0), [0.0], 1e-3), limits)
    assert x == pytest.approx([1.75], abs=1e-3)


def test_outlier_loses_its_weight_on_the_side_where_it_is_not_trusted() -> None:
    rows = sp.csr_matrix(np.ones((5, 1)))
    heights = [0.0, 0.1, -0.1, 0.0, 9.0]
    free = bound(row(1.0), -np.inf, np.inf, 1.0)
    x, factors = solve(observe(rows, heights, above=1.0, below=30.0), free)
    assert x[0] == pytest.approx(0.0, abs=0.1)
    assert factors[4] < 0.01 < 0.9 < factors[0]
    trusted, _ = solve(observe(rows, heights, above=30.0, below=30.0), free)
    assert trusted[0] == pytest.approx(1.8, abs=0.3)


def test_what_another_road_bends_a_road_away_from_is_no_outlier() -> None:
    # A limit lifts the road 4 m above two heights: they are outliers if it is the road's own.
    heights = observe(sp.csr_matrix(np.ones((2, 1))), [0.0, 0.0], above=1.0, below=1.0)
    for own, factor in ((True, 0.01), (False, 1.0)):
        x, factors = solve(heights, bound(row(1.0), 4.0, np.inf, 1e4, own=own))
        assert x == pytest.approx([4.0], abs=0.01)
        assert factors == pytest.approx([factor, factor], abs=0.01)


def test_joined_blocks_see_only_their_own_unknowns() -> None:
    joined = join_blocks([observe(row(1.0), [5.0]), observe(row(0.0, 2.0), [8.0])], 3)
    assert joined.rows.toarray().tolist() == [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
    assert joined.value.tolist() == [5.0, 8.0]


def test_few_places_are_brought_to_rest_by_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    # A stiff chain on springs, pushed down at places whose limits come into play one after the other.
    n = 9000
    rng = np.random.default_rng(5)
    second = sp.csr_matrix(sp.eye(n - 2, n) - 2.0 * sp.eye(n - 2, n, k=1) + sp.eye(n - 2, n, k=2))
    stiffness = sp.csr_matrix(50.0 * (second.T @ second))
    seen = observe(sp.csr_matrix(sp.eye(n)), np.cumsum(rng.normal(size=n)).tolist())
    some = np.unique(rng.integers(0, n, 300))
    high = seen.value[some] - rng.uniform(0.0, 3.0, len(some))
    k = len(some)
    # A few that give way take many steps.
    cap = np.where(np.arange(k) < 6, rng.uniform(1.0, 30.0, k), np.inf)
    limits = Limits(
        sp.csr_matrix(sp.eye(n))[some],
        np.full(k, -np.inf),
        high,
        np.full(k, 1e3),
        cap,
        np.ones(k, bool),
    )
    parts = []
    settle_part = newton._settle_part

    def counted(*args: Any) -> FloatArray:
        parts.append(len(args[-1]))
        return settle_part(*args)

    monkeypatch.setattr(newton, "_settle_part", counted)
    monkeypatch.setattr(newton, "_SMALLEST_FALL", 1e-9)

    def solved(parts_from: int) -> tuple[FloatArray, float]:
        """Return the unknowns and the objective."""
        monkeypatch.setattr(newton, "_PARTS_FROM", parts_from)
        x = minimise(stiffness, seen, limits).x
        over = np.maximum(x[some] - high, 0.0)
        yields = np.minimum(over, cap / 1e3)
        quadratic = 0.5 * float(x @ (stiffness @ x) + ((x - seen.value) ** 2).sum())
        return x, quadratic + float((1e3 * yields * (over - 0.5 * yields)).sum())

    x, cost = solved(newton._PARTS_FROM)
    assert parts
    assert max(parts) < n
    plain_x, plain_cost = solved(n)
    assert x == pytest.approx(plain_x, abs=0.02)
    assert cost < plain_cost + 1e-3
