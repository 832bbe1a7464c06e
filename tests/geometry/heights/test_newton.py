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
from osm2xodr.geometry.heights.sparse import System, join_blocks
from osm2xodr.model import FloatArray


def row(*values: float) -> sp.csr_matrix:
    return sp.csr_matrix(np.array([values]))


def observe(
    rows: sp.csr_matrix,
    z: list[float],
    weight: float = 1.0,
    above: float = 1e6,
    below: float = 1e6,
    kind: Kind = Kind.ROAD_HEIGHT,
) -> Observations:
    n = len(z)
    return Observations(
        rows,
        np.array(z),
        weight=np.full(n, weight),
        sigma=np.ones(n),
        kind=np.full(n, kind, np.int64),
        above=np.full(n, above),
        below=np.full(n, below),
        canopy=np.zeros(n, bool),
        floor=np.full(n, FLOOR),
    )


def bound(
    rows: sp.csr_matrix,
    low: float,
    high: float,
    stiffness: float,
    cap: float = np.inf,
    *,
    own: bool = True,
) -> Limits:
    n = rows.shape[0]
    bounds = np.full(n, low), np.full(n, high)
    return Limits(rows, *bounds, np.full(n, stiffness), np.full(n, cap), np.full(n, own, bool))


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


def test_tag_that_is_far_off_loses_its_weight_on_the_side_where_it_is_not_trusted() -> None:
    rows = sp.csr_matrix(np.ones((5, 1)))
    heights = [0.0, 0.1, -0.1, 0.0, 9.0]
    free = bound(row(1.0), -np.inf, np.inf, 1.0)
    x, factors = solve(observe(rows, heights, above=1.0, below=30.0, kind=Kind.TAGGED_HEIGHT), free)
    assert x[0] == pytest.approx(0.0, abs=0.1)
    assert factors[4] < 0.01 < 0.9 < factors[0]
    trusted, _ = solve(observe(rows, heights, above=30.0, below=30.0, kind=Kind.TAGGED_HEIGHT), free)
    assert trusted[0] == pytest.approx(1.8, abs=0.3)


def test_bare_ground_pulls_with_a_constant_force_however_far_off_it_is() -> None:
    # Huber's loss: the sum of x, x - 0.1, x + 0.1 and x, all within one standard error, is the force of the last one.
    rows = sp.csr_matrix(np.ones((5, 1)))
    free = bound(row(1.0), -np.inf, np.inf, 1.0)
    for far in (9.0, 50.0):
        x, factors = solve(observe(rows, [0.0, 0.1, -0.1, 0.0, far], above=1.0, below=1.0), free)
        assert x == pytest.approx([0.25], abs=0.02)
        assert factors == pytest.approx([1.0] * 4 + [1.0 / (far - 0.25)], rel=0.01)


def test_what_another_road_bends_a_road_away_from_is_no_outlier() -> None:
    # A limit lifts the road 4 m above two heights: they are outliers if it is the road's own.
    heights = observe(sp.csr_matrix(np.ones((2, 1))), [0.0, 0.0], above=1.0, below=1.0, kind=Kind.TAGGED_HEIGHT)
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


# ---------------------------------------------------------------- steps


def parabola(stiffness: float, right: float, limits: Limits) -> newton._Objective:
    """Return the objective stiffness x² / 2 - right x plus the energy of limits on x."""
    system = System([sp.csr_matrix([[stiffness]])], [limits.rows])
    return newton._Objective(system, np.array([stiffness]), np.array([right]), limits)


FREE = bound(row(1.0), -np.inf, np.inf, 1.0)


@pytest.mark.parametrize(
    ("direction", "share"),
    [
        # The minimum is at 2: a whole step toward it or to it, the part of one beyond it, next to none of one away.
        (1.0, 1.0),
        (2.0, 1.0),
        (4.0, 0.5),
        (16.0, 0.125),
        (-1.0, 1e-3),
    ],
)
def test_a_step_ends_where_the_objective_no_longer_falls(direction: float, share: float) -> None:
    zero = np.zeros(1)
    found, fall = newton._line_search(parabola(4.0, 8.0, FREE), zero, zero, np.array([direction]))
    assert found == pytest.approx(share, abs=2e-6)
    # Half of the slope at its start: that of a parabola whose minimum is a whole step away.
    assert fall == pytest.approx(4.0 * direction)


def test_a_step_ends_at_a_limit() -> None:
    """A wall at 1: beyond it a force of 1e6 per excess."""
    zero = np.zeros(1)
    wall = bound(row(1.0), -np.inf, 1.0, 1e6)
    found, _ = newton._line_search(parabola(4.0, 8.0, wall), zero, zero, np.array([2.0]))
    assert found == pytest.approx(0.5, abs=1e-5)
    # One that yields with a force of 3: 4 x - 8 + 3 is 0 at 1.25.
    soft = bound(row(1.0), -np.inf, 1.0, 1e6, 3.0)
    found, _ = newton._line_search(parabola(4.0, 8.0, soft), zero, zero, np.array([2.0]))
    assert found == pytest.approx(0.625, abs=2e-6)


def test_a_newton_step_takes_the_secant_of_limits_at_work() -> None:
    """From 3, two beyond a wall that yields with 3: its secant is 1.5, and 4 x - 8 + 3 + 1.5 (x - 3) is 0 there."""
    soft = bound(row(1.0), -np.inf, 1.0, 1e6, 3.0)
    aim = newton._newton_aim(parabola(4.0, 8.0, soft), np.array([3.0]))
    assert aim == pytest.approx([9.5 / 5.5], abs=1e-6)
    stiff = bound(row(1.0), -np.inf, 1.0, 4.0)
    assert newton._newton_aim(parabola(4.0, 8.0, stiff), np.array([3.0])) == pytest.approx([1.5], abs=1e-6)
    assert newton._newton_aim(parabola(4.0, 8.0, stiff), np.array([0.5])) == pytest.approx([2.0], abs=1e-6)
    step, fall = newton._newton_step(parabola(4.0, 8.0, stiff), np.array([3.0]))
    assert step == pytest.approx([-1.5], abs=1e-6)
    assert fall == pytest.approx(0.5 * 1.5 * 12.0, abs=1e-5)


def test_some_unknowns_settle_while_others_stay() -> None:
    """A chain of springs to neighbours and to the ground: the second and third settle between the others."""
    n = 6
    matrix = sp.csr_matrix(3.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    wall = bound(sp.csr_matrix(np.eye(n)[[1, 4]]), -np.inf, 0.5, 1e6)
    system = System([matrix], [wall.rows])
    right = np.arange(1.0, n + 1.0)
    ordered = wall.rows.copy()
    system.put_in_order(ordered)
    in_order = np.empty(n)
    in_order[system.place] = right
    objective = newton._Objective(system, system.placed(matrix), in_order, replace(wall, rows=ordered))
    x = np.empty(n)
    start = np.array([4.0, 0.0, 0.0, 0.0, 0.0, 2.0])
    x[system.place] = start
    some = np.sort(system.place[[1, 2]])
    found = x.copy()
    found[some] = newton._settle_part(objective, x, some)
    # The second is held at its limit, 0.5; 3 x - 0.5 - 0 = 3 for the third.
    assert found[system.place] == pytest.approx([4.0, 0.5, 3.5 / 3.0, 0.0, 0.0, 2.0], abs=1e-4)
