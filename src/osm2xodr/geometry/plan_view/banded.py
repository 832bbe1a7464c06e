"""Banded systems of linear equations, whose solutions have the same last digit on every machine, and means."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray, IntArray

_INFINITE: Final = math.inf


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


def add_squares(terms: FloatArray, value: FloatArray, matrix: FloatArray, right: FloatArray) -> None:
    """Add the squares of equations, of terms, (k, n), by k unknowns in a row plus a value, (n,), to a system."""
    k, n = terms.shape[0], terms.shape[1]
    for i in range(n + k - 1):
        for a in range(max(i - n + 1, 0), min(k, i + 1)):
            right[i] -= float(terms[a, i - a]) * float(value[i - a])
            for b in range(k - a):
                matrix[b, i] += float(terms[a, i - a]) * float(terms[a + b, i - a])


def average(start: IntArray, spacing: FloatArray, total: FloatArray, width: FloatArray, out: FloatArray) -> None:
    """Write the mean value about each point of curves over a width, or as much of it as there is on both sides.

    `start`, (curves + 1,), says where the points of each curve begin, which are `spacing` apart; `total`,
    (n + 1,), holds the sums of all values before each point.
    """
    for curve in range(len(start) - 1):
        first, last = start[curve], start[curve + 1] - 1
        for i in range(first, last + 1):
            half = int(0.5 * float(width[i]) / float(spacing[i]))
            half = min(half, i - first, last - i)
            out[i] = (float(total[i + half + 1]) - float(total[i - half])) / (2 * half + 1)


def grade(at: FloatArray, value: FloatArray, out: FloatArray) -> None:
    """Write the largest values, (n,), nowhere above these, that change from place to place no faster than `at`."""
    least = _INFINITE
    for i in range(len(at)):
        least = min(least, float(value[i]) - float(at[i]))
        out[i] = least + float(at[i])
    least = _INFINITE
    for i in range(len(at) - 1, -1, -1):
        least = min(least, float(value[i]) + float(at[i]))
        out[i] = min(float(out[i]), least - float(at[i]))
