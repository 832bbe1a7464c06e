"""Systems of one pattern, against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from osm2xodr.geometry.heights.sparse import TINY, System
from osm2xodr.model import FloatArray

SIZE = 40


def chain() -> sp.csr_matrix:
    """Return the stiffness of springs from each unknown to the next."""
    return sp.csr_matrix(2.5 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1))


def rows(seed: int, count: int) -> sp.csr_matrix:
    """Return rows of three entries each, anywhere."""
    rng = np.random.default_rng(seed)
    column = np.array([rng.choice(SIZE, 3, replace=False) for _ in range(count)])
    return sp.csr_matrix(
        (rng.normal(size=3 * count), (np.repeat(np.arange(count), 3), column.ravel())), (count, SIZE)
    )


def values(system: System, some: sp.csr_matrix, weight: FloatArray) -> FloatArray:
    ordered = some.copy()
    system.put_in_order(ordered)
    return system.normal(ordered, sp.csr_matrix(ordered.T), weight)


def test_solves_what_dense_algebra_solves() -> None:
    some, other = rows(1, 30), rows(2, 20)
    system = System([chain()], [some, other])
    right = np.arange(SIZE, dtype=np.float64)
    first, second = np.linspace(0.1, 2.0, 30), np.linspace(3.0, 0.2, 20)
    dense = chain().toarray() + TINY * np.eye(SIZE)
    dense += (
        some.toarray().T @ np.diag(first) @ some.toarray() + other.toarray().T @ np.diag(second) @ other.toarray()
    )
    matrix = system.placed(chain()) + values(system, some, first) + values(system, other, second)
    ordered = np.empty(SIZE)
    ordered[system.place] = right
    assert system.solve(matrix, ordered)[system.place] == pytest.approx(np.linalg.solve(dense, right), rel=1e-9)
    assert system.product(matrix, ordered)[system.place] == pytest.approx(dense @ right, rel=1e-12)


def test_the_same_rows_with_other_weights() -> None:
    some = rows(3, 50)
    system = System([chain()], [some])
    right = np.ones(SIZE)
    for factor in (1.0, 4.0):
        weight = factor * np.linspace(1.0, 2.0, 50)
        dense = some.toarray().T @ np.diag(weight) @ some.toarray()
        product = system.product(values(system, some, weight), right)
        assert product[system.place] == pytest.approx(dense @ right, abs=1e-12)


def test_some_of_the_rows() -> None:
    some = rows(4, 50)
    system = System([chain()], [some])
    few = some[np.array([7, 11])]
    dense = few.toarray().T @ few.toarray()
    product = system.product(values(system, few, np.ones(2)), np.ones(SIZE))
    assert product[system.place] == pytest.approx(dense @ np.ones(SIZE), abs=1e-12)


def test_what_nothing_determines_stays_at_zero() -> None:
    none = sp.csr_matrix((SIZE, SIZE))
    system = System([none], [])
    assert system.solve(system.placed(none), np.zeros(SIZE)).tolist() == [0.0] * SIZE


def test_rows_in_order_are_the_same_rows_and_sorted() -> None:
    some = rows(5, 30)
    system = System([chain()], [some])
    ordered = some.copy()
    system.put_in_order(ordered)
    assert ordered.toarray()[:, system.place] == pytest.approx(some.toarray())
    for k in range(30):
        columns = ordered.indices[ordered.indptr[k] : ordered.indptr[k + 1]]
        assert columns.tolist() == sorted(columns.tolist())


def test_what_is_near_by_entries_and_the_part_of_it() -> None:
    """Along a chain each unknown has two neighbours; rows of their own join 3 and 30."""
    joined = sp.csr_matrix((np.ones(2), ([0, 0], [3, 30])), (1, SIZE))
    system = System([chain()], [joined])
    matrix = system.placed(chain())
    there = np.zeros(SIZE, bool)
    there[system.place[[4, 12]]] = True

    def near(steps: int) -> set[int]:
        return set(np.flatnonzero(np.isin(system.place, system.around(there, steps))).tolist())

    assert near(0) == {4, 12}
    assert near(1) == {3, 4, 5, 11, 12, 13}
    assert near(2) == {2, 3, 4, 5, 6, 30, 10, 11, 12, 13, 14}
    some = np.sort(system.place[[7, 8, 20]])
    part = system.part(matrix, some).toarray()
    own = np.argsort(system.place)[some]
    assert part == pytest.approx(chain().toarray()[np.ix_(own, own)], abs=2 * TINY)
