"""Systems of linear equations, solved by loops of our own."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from osm2xodr.curves import Factors, dot, solve_dense, solve_sparse
from osm2xodr.model import FloatArray

RNG = np.random.default_rng(3)


def test_dense_systems_need_pivots() -> None:
    matrix = np.array([[0.0, 2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    assert solve_dense(matrix, np.array([[2.0], [8.0], [4.0]])).tolist() == [[2.0], [1.0], [3.0]]


@pytest.mark.parametrize("shape", [(7, 7), (5, 6, 6), (0, 4, 4), (3, 0, 0)])
def test_dense_systems_of_any_shape(shape: tuple[int, ...]) -> None:
    matrix, right = RNG.normal(0.0, 1.0, shape), RNG.normal(0.0, 1.0, (*shape[:-1], 2))
    found = solve_dense(matrix, right)
    assert found.shape == right.shape
    assert np.abs(matrix @ found - right).max(initial=0.0) < 1e-11


def _network(size: int) -> sp.csr_matrix:
    """Return the matrix of a chain with some links between far places, positive definite."""
    along = np.arange(size - 1)
    one, other = RNG.integers(0, size, (2, size // 5))
    value = np.concatenate([np.full(size - 1, -1.0), np.full(len(one), -0.3)])
    places = np.concatenate([along, one]), np.concatenate([along + 1, other])
    half = sp.csr_matrix((value, places), (size, size))
    matrix = half + half.T
    return sp.csr_matrix(matrix + sp.diags(0.5 + np.asarray(abs(matrix).sum(axis=1)).ravel()))


@pytest.mark.parametrize("size", [2, 50, 700])
def test_sparse_systems(size: int) -> None:
    matrix, expected = _network(size), RNG.normal(0.0, 1.0, size)
    assert np.abs(solve_sparse(matrix, matrix @ expected) - expected).max() < 1e-11


def test_one_pattern_serves_several_matrices() -> None:
    matrix = _network(60)
    matrix.sort_indices()
    factors = Factors(matrix.indptr, matrix.indices)
    right: FloatArray = RNG.normal(0.0, 1.0, 60)
    for times in (1.0, 4.0, 1.0):
        assert np.abs(times * (matrix @ factors.solve(times * matrix.data, right)) - right).max() < 1e-11


def test_inner_products() -> None:
    assert dot(np.array([1.0, 2.0, 3.0]), np.array([4.0, -5.0, 6.0])) == 12.0
