"""Groups of different sizes that stand one after the other in flat arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from osm2xodr.model import FloatArray, IntArray

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
    return np.repeat(np.arange(len(start) - 1), np.diff(start))


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
