"""Groups of different sizes that stand one after the other in flat arrays, and distinct integers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from osm2xodr.model import BoolArray, FloatArray, IntArray

# Rows that are worked on at a time: as many as a processor's cache holds with all columns that come of them.
ROWS_AT_ONCE: Final = 16384


def blocks(count: int, size: int = ROWS_AT_ONCE) -> Iterator[slice]:
    """Return the rows of a long table in blocks, one after the other; each is worked on in a processor's cache."""
    return (slice(first, first + size) for first in range(0, count, size))


def starts(count: IntArray | Sequence[int]) -> IntArray:
    """Return where each group begins, and behind them where the last ends, (groups + 1,), by the groups' sizes."""
    return np.concatenate([[0], np.cumsum(count)]).astype(np.int64)


def owners(start: IntArray) -> IntArray:
    """Return the group that each row belongs to, by where the groups begin and the last ends, (groups + 1,)."""
    return repeated(np.diff(start))


def repeated(count: IntArray | Sequence[int]) -> IntArray:
    """Return the group that each row belongs to, by the groups' sizes, (groups,)."""
    return np.repeat(np.arange(len(count)), np.asarray(count, np.int64))


def ranks(count: IntArray) -> IntArray:
    """Return 0, 1, 2 … within each group, for all groups in a row; `count` holds their sizes, (groups,)."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)


def sum_before(values: FloatArray, start: IntArray) -> FloatArray:
    """Return for each row the sum of the values before it in its group, (n,); `start` says where groups begin."""
    total = np.cumsum(values) - values
    return np.asarray(total - total[start[:-1]][owners(start)])


def runs(first: IntArray, count: IntArray) -> IntArray:
    """Return first, first + 1, first + 2 … of each group, for all groups in a row.

    `first` says where the rows of each group begin in another array and `count` how many they are, (groups,).
    """
    return np.repeat(first, count) + ranks(count)


# NumPy's own functions for this use hash tables in some versions, which are slower than sorting, and give inverses
# of other shapes in others.


class Distinct(NamedTuple):
    """Distinct integers, ascending, where they stand among the given ones, and how often."""

    values: IntArray
    first: IntArray  # Index of the first of each
    inverse: IntArray  # Index of the value of each given one, flat
    counts: IntArray


def sorted_unique(values: npt.ArrayLike) -> IntArray:
    """Return the distinct ones of integers of any shape, ascending."""
    ordered = np.sort(np.asarray(values), axis=None)
    return ordered[_is_new(ordered)]


def unique_inverse(values: npt.ArrayLike) -> tuple[IntArray, IntArray]:
    """Return the distinct ones of integers, ascending, and the index among them of each given one, flat."""
    flat = np.ravel(values)
    order = np.argsort(flat)
    ordered = flat[order]
    new = _is_new(ordered)
    return ordered[new], _numbers(order, new)


def connected_groups(count: int, one: IntArray, other: IntArray) -> IntArray:
    """Return the group of each of `count` things that pairs, (n,), join; numbered from 0 by their first members.

    Each takes the lowest number that it is joined to, and then what this has taken, until nothing changes.
    """
    group = np.arange(count)
    while True:
        lowest = group.copy()
        np.minimum.at(lowest, group[one], group[other])
        np.minimum.at(lowest, group[other], group[one])
        lowest = lowest[lowest[group]]
        if np.array_equal(lowest, group):
            return unique_inverse(group)[1]
        group = lowest


def unique_first(values: npt.ArrayLike) -> tuple[IntArray, IntArray]:
    """Return the distinct ones of integers, ascending, and the index of the first of each."""
    flat = np.ravel(values)
    order = np.argsort(flat, kind="stable")
    first = order[_is_new(flat[order])]
    return flat[first], first


def unique_counts(values: npt.ArrayLike) -> tuple[IntArray, IntArray]:
    """Return the distinct ones of integers, ascending, and how often each is there."""
    ordered = np.sort(np.asarray(values), axis=None)
    begin = np.flatnonzero(_is_new(ordered))
    return ordered[begin], np.diff(begin, append=len(ordered))


def unique_all(values: npt.ArrayLike) -> Distinct:
    """Return the distinct ones of integers of any shape with all that is known of them."""
    flat = np.ravel(values)
    return _distinct(flat, np.argsort(flat, kind="stable"))


def unique_rows(rows: IntArray) -> Distinct:
    """Return the distinct ones of rows of integers, (n, columns), by the first column, then the second and so on."""
    return _distinct(rows, np.lexsort(rows.T[::-1]))


def _distinct(values: IntArray, order: IntArray) -> Distinct:
    """Return distinct values, given the order in which they ascend, equal ones as they stand."""
    new = _is_new(values[order])
    begin = np.flatnonzero(new)
    return Distinct(values[order[begin]], order[begin], _numbers(order, new), np.diff(begin, append=len(order)))


def _is_new(ordered: IntArray) -> BoolArray:
    """Whether each of ascending integers, or rows of them, differs from the one before, (n,)."""
    new = np.ones(len(ordered), np.bool_)
    steps = ordered[1:] != ordered[:-1]
    new[1:] = steps if steps.ndim == 1 else steps.any(axis=1)
    return new


def _numbers(order: IntArray, new: BoolArray) -> IntArray:
    """Return the number of each integer's group, (n,); `new` says where groups begin in this order of integers."""
    out = np.empty(len(order), np.int64)
    out[order] = np.cumsum(new) - 1
    return out
