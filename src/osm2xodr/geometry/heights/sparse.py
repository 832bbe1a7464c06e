"""Sparse symmetric systems of one pattern: what follows from the pattern is worked out once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, Final, TypeVar

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from osm2xodr.curves import Factors, elimination_order
from osm2xodr.model import BoolArray, FloatArray, IntArray

# Added to the diagonal: unknowns that nothing determines stay at the mean height instead of failing the solve.
TINY: Final = 1e-9
# A matrix's places in the pattern are kept for the next one if it fills more than this share of it.
_KEPT_FROM: Final = 0.5

Block = TypeVar("Block")


class System:
    """Systems of one pattern, in an order of the unknowns in which elimination fills little.

    A matrix is the array of its values at the places of the pattern, so that matrices are added as arrays are.
    Chains eliminate without fill: the cost is linear in road length. The pattern has the entries of symmetric
    matrices, (N, N), and of the products of rows, (n, N), with themselves.
    """

    def __init__(self, matrices: Sequence[sp.csr_matrix], rows: Sequence[sp.csr_matrix]) -> None:
        size = matrices[0].shape[0]
        pattern = sp.csr_matrix(sp.identity(size))
        for matrix in matrices:
            pattern = pattern + _ones(matrix)
        for some in rows:
            ones = _ones(some)
            pattern = pattern + sp.csr_matrix(ones.T) @ ones
        order = elimination_order(pattern)
        # The place of each unknown in the system's order, (N,).
        self.place: IntArray = np.empty(size, np.int64)
        self.place[order] = np.arange(size)
        self._size = size
        pattern = self._reordered(pattern)
        self._keys = _keys(pattern)
        self._indices, self._start = pattern.indices, pattern.indptr
        self._factors = Factors(pattern.indptr, pattern.indices)
        self._diagonal = np.searchsorted(self._keys, (size + 1) * np.arange(size, dtype=np.int64))
        self._last: tuple[npt.NDArray[np.int32], npt.NDArray[np.int32], npt.NDArray[np.int32]] | None = None

    def put_in_order(self, rows: sp.csr_matrix) -> None:
        """Put the columns of rows (n, N) into the system's order, in place, as they are too large to copy."""
        rows.indices[:] = self.place[rows.indices]
        rows.has_sorted_indices = False
        rows.sort_indices()

    def placed(self, matrix: sp.csr_matrix) -> FloatArray:
        """Return a symmetric matrix, its unknowns in their own order, with `TINY` added to its diagonal."""
        values: FloatArray = np.zeros(len(self._keys))
        matrix = self._reordered(matrix)
        values[np.searchsorted(self._keys, _keys(matrix))] = matrix.data
        values[self._diagonal] += TINY
        return values

    def normal(self, rows: sp.csr_matrix, transposed: sp.csr_matrix, weight: FloatArray) -> FloatArray:
        """Return transposed · diag(weight) · rows of ordered rows (n, N)."""
        weighted = rows.data * np.repeat(weight, np.diff(rows.indptr))
        product = transposed @ sp.csr_matrix((weighted, rows.indices, rows.indptr), rows.shape)
        last = self._last
        if last is None or not (np.array_equal(last[0], product.indptr) and np.array_equal(last[1], product.indices)):
            at = np.searchsorted(self._keys, _keys(product)).astype(np.int32)
            last = product.indptr, product.indices, at
            # The observations' rows are the same in every step, those of limits at work are few and others.
            if product.nnz > _KEPT_FROM * len(self._keys):
                self._last = last
        values: FloatArray = np.zeros(len(self._keys))
        values[last[2]] = product.data
        return values

    def product(self, matrix: FloatArray, x: FloatArray) -> FloatArray:
        """Return a matrix times the unknowns, (N,), in the system's order."""
        rows = sp.csr_matrix((matrix, self._indices, self._start), (self._size, self._size))
        return np.asarray(rows @ x, np.float64)

    def around(self, some: BoolArray, steps: int) -> IntArray:
        """Return the unknowns within this many steps of some of them, (N,), a step joining two in one entry."""
        near = some.astype(np.float64)
        ones = np.ones(len(self._keys))
        for _ in range(steps):
            near = np.minimum(self.product(ones, near), 1.0)
        return np.flatnonzero(near)

    def part(self, matrix: FloatArray, some: IntArray) -> sp.csr_matrix:
        """Return the part of a matrix that relates some of the unknowns, in the system's order, to each other."""
        rows = sp.csr_matrix((matrix, self._indices, self._start), (self._size, self._size))
        return sp.csr_matrix(chosen_rows(rows, some)[:, some])

    def solve(self, matrix: FloatArray, right: FloatArray) -> FloatArray:
        """Return the unknowns, in the system's order, that solve a positive definite system."""
        return self._factors.solve(matrix, right)

    def _reordered(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """Return a square matrix with its unknowns in the system's order, rows sorted."""
        place = self.place.astype(np.int32)
        row = np.repeat(place, np.diff(matrix.indptr))
        out = sp.csr_matrix(sp.coo_matrix((matrix.data, (row, place[matrix.indices])), matrix.shape))
        out.sort_indices()
        return out


def join_blocks(blocks: Sequence[Block], columns: int) -> Block:
    """Join dataclasses of arrays, the first field a matrix whose rows are the others' items, into one.

    `columns` widens the rows by unknowns that they do not see.
    """
    table: Any = blocks[0]
    first, *others = (field.name for field in fields(table))
    matrices: list[sp.csr_matrix] = [getattr(block, first) for block in blocks]
    wide = [sp.csr_matrix((rows.data, rows.indices, rows.indptr), (rows.shape[0], columns)) for rows in matrices]
    arrays = (np.concatenate([getattr(block, name) for block in blocks]) for name in others)
    kind: Any = type(blocks[0])
    joined: Block = kind(sp.csr_matrix(sp.vstack(wide)), *arrays)
    return joined


def chosen_rows(rows: sp.csr_matrix, some: IntArray) -> sp.csr_matrix:
    """Return some rows of a matrix."""
    # The types of some versions of SciPy do not allow arrays as indices.
    matrix: Any = rows
    return sp.csr_matrix(matrix[some])


def _keys(matrix: sp.csr_matrix) -> IntArray:
    """Return numbers of a square matrix's entries that ascend from row to row and within sorted rows."""
    size = matrix.shape[0]
    out: IntArray = np.repeat(size * np.arange(size, dtype=np.int64), np.diff(matrix.indptr))
    out += matrix.indices
    return out


def _ones(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Return the matrix with ones for all entries."""
    return sp.csr_matrix((np.ones(matrix.nnz, np.int32), matrix.indices, matrix.indptr), matrix.shape)
