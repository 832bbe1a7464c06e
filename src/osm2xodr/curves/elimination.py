"""Systems of linear equations, whose solutions have the same last digit on every machine.

Linear algebra libraries sum in other orders on other processors; here every sum has one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from osm2xodr.model import FloatArray, IntArray

if TYPE_CHECKING:
    import scipy.sparse as sp


def solve_dense(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solutions, (..., n, m), of systems (..., n, n) with right sides (..., n, m).

    Gaussian elimination with pivots by columns (Golub and Van Loan, Matrix Computations, 3.4), all systems at once.
    """
    n, m = matrix.shape[matrix.ndim - 1], right.shape[right.ndim - 1]
    work = np.concatenate([matrix, right], axis=right.ndim - 1)
    if not work.size:
        return right.copy()
    work = work.reshape(work.size // (n * (n + m)), n, n + m)
    each = np.arange(len(work))
    for k in range(n):
        pivot = k + np.argmax(np.abs(work[:, k:, k]), axis=1)
        row = work[each, pivot]
        work[each, pivot] = work[:, k]
        work[:, k] = row
        share = work[:, k + 1 :, k] / work[:, k, k, None]
        work[:, k + 1 :, k + 1 :] -= share[:, :, None] * work[:, k, None, k + 1 :]
    out = work[:, :, n:]
    for k in range(n - 1, -1, -1):
        out[:, k] /= work[:, k, k, None]
        out[:, :k] -= work[:, :k, k, None] * out[:, k, None]
    return np.asarray(out.reshape(right.shape))


def dot(one: FloatArray, other: FloatArray) -> float:
    """Return the inner product of two vectors, (n,)."""
    return float((one * other).sum())


def elimination_order(pattern: sp.csr_matrix) -> IntArray:
    """Return the order of the unknowns in which eliminating them fills little (minimum degree)."""
    import scipy.sparse as sp
    from scipy.sparse.linalg import splu

    # Any values will do whose diagonal outweighs the rest.
    ones = sp.csc_matrix((np.ones(pattern.nnz), pattern.indices, pattern.indptr), pattern.shape)
    dominant = ones + sp.diags(np.diff(pattern.indptr).astype(np.float64))
    # Rows have a handful of entries: panels of columns, made for denser systems, would only cost time.
    options = {"SymmetricMode": True, "Equil": False}
    found = splu(
        sp.csc_matrix(dominant), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, relax=4, panel_size=1, options=options
    )
    order: IntArray = np.argsort(found.perm_c)
    return order


def solve_sparse(matrix: sp.csr_matrix, right: FloatArray) -> FloatArray:
    """Return the solution, (n,), of a sparse, symmetric, positive definite system."""
    order = elimination_order(matrix)
    # The types of some versions of SciPy do not allow arrays as indices.
    any_matrix: Any = matrix.tocsr()
    ordered = any_matrix[order][:, order].tocsr()
    ordered.sort_indices()
    out = np.empty(len(right))
    out[order] = Factors(ordered.indptr, ordered.indices).solve(ordered.data, right[order])
    return out


class Factors:
    """Sparse, symmetric, positive definite systems of one pattern, (n, n), whose order fills little.

    The pattern is in compressed rows, sorted, with both triangles; what follows from it is worked out once. A matrix
    is L D L' with ones on the diagonal of L, made row by row from those of its rows that the elimination tree names
    (Davis 2005, Algorithm 849: a concise sparse Cholesky factorization package).
    """

    def __init__(self, start: npt.NDArray[np.integer[Any]], column: npt.NDArray[np.integer[Any]]) -> None:
        self._start, self._column = start.astype(np.int64), column.astype(np.int64)
        size = len(start) - 1
        self._parent = np.empty(size, np.int64)
        count = np.zeros(size, np.int64)
        elimination_tree(self._start, self._column, self._parent, count, np.empty(size, np.int64))
        self._first = np.concatenate([[0], np.cumsum(count)])
        self._row = np.empty(int(count.sum()), np.int64)
        self._lower = np.empty(len(self._row))

    def solve(self, matrix: FloatArray, right: FloatArray) -> FloatArray:
        """Return the unknowns, (n,), where `matrix` has values at the places of the pattern."""
        out = right.astype(np.float64)
        diagonal = np.empty(len(out))
        factorise(
            *(self._start, self._column, matrix, self._parent, self._first),
            *(np.zeros(len(out), np.int64), np.empty(len(out), np.int64), np.empty(len(out), np.int64)),
            np.zeros(len(out)),
            *(self._row, self._lower, diagonal),
        )
        substitute(self._first, self._row, self._lower, diagonal, out)
        return out


def elimination_tree(start: IntArray, column: IntArray, parent: IntArray, count: IntArray, seen: IntArray) -> None:
    """Write the parent of each row in the elimination tree, -1 for none, and add up entries of each column of L.

    `seen` notes the row that came to a column last.
    """
    for row in range(len(parent)):
        parent[row] = -1
        seen[row] = row
        for at in range(start[row], start[row + 1]):
            node = column[at]
            if node >= row:
                break
            while seen[node] != row:
                if parent[node] < 0:
                    parent[node] = row
                count[node] += 1
                seen[node] = row
                node = parent[node]


def factorise(
    start: IntArray,
    column: IntArray,
    matrix: FloatArray,
    parent: IntArray,
    first: IntArray,
    filled: IntArray,
    seen: IntArray,
    stack: IntArray,
    line: FloatArray,
    rows: IntArray,
    lower: FloatArray,
    diagonal: FloatArray,
) -> None:
    """Write L, column by column from `first` on, as rows and values, and the diagonal D.

    `filled` counts the entries of columns of L so far, and `line` is the row at work: both are 0 to begin with.
    `seen` notes the row that came to a column last; `stack` has at its end the columns in which the row is not 0, in
    the order of elimination.
    """
    size = len(parent)
    for row in range(size):
        top = size
        seen[row] = row
        for at in range(start[row], start[row + 1]):
            node = column[at]
            if node > row:
                break
            line[node] = matrix[at]
            depth = 0
            while seen[node] != row:
                stack[depth] = node
                depth += 1
                seen[node] = row
                node = parent[node]
            while depth > 0:
                depth -= 1
                top -= 1
                stack[top] = stack[depth]
        pivot = line[row]
        line[row] = 0.0
        for place in range(top, size):
            node = stack[place]
            value = line[node]
            line[node] = 0.0
            end = first[node] + filled[node]
            for at in range(first[node], end):
                line[rows[at]] -= lower[at] * value
            share = value / diagonal[node]
            pivot -= share * value
            rows[end] = row
            lower[end] = share
            filled[node] += 1
        diagonal[row] = pivot


def substitute(first: IntArray, rows: IntArray, lower: FloatArray, diagonal: FloatArray, out: FloatArray) -> None:
    """Turn the right side into the solution."""
    size = len(out)
    for node in range(size):
        value = out[node]
        for at in range(first[node], first[node + 1]):
            out[rows[at]] -= lower[at] * value
    for node in range(size):
        out[node] /= diagonal[node]
    for node in range(size - 1, -1, -1):
        value = out[node]
        for at in range(first[node], first[node + 1]):
            value -= lower[at] * out[rows[at]]
        out[node] = value
