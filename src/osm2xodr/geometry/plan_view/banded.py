"""Banded systems of linear equations, whose solutions have the same last digit on every machine."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import FloatArray


def solve_banded(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution of a symmetric, positive definite system, (n,).

    `matrix`, (bands, n), holds the diagonal and the bands below it: [k, i] is the entry of row i + k and column i.
    """
    work, out = matrix.copy(), right.astype(np.float64)
    eliminate(work, out)
    return out


def eliminate(matrix: FloatArray, out: FloatArray) -> None:
    """Turn the right side into the solution, by Gaussian elimination in place; the matrix is used up."""
    bands, n = matrix.shape[0], matrix.shape[1]
    for i in range(n):
        reach = min(bands, n - i)
        for k in range(1, reach):
            share = float(matrix[k, i]) / float(matrix[0, i])
            for m in range(k, reach):
                matrix[m - k, i + k] -= share * float(matrix[m, i])
            out[i + k] -= share * float(out[i])
    for i in range(n - 1, -1, -1):
        rest = float(out[i])
        for k in range(1, min(bands, n - i)):
            rest -= float(matrix[k, i]) * float(out[i + k])
        out[i] = rest / float(matrix[0, i])
