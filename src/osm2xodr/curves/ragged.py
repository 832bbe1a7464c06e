"""Groups of different sizes that stand one after the other in flat arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from osm2xodr.model import IntArray


def starts(count: IntArray | Sequence[int]) -> IntArray:
    """Return where each group begins, and behind them where the last ends, (groups + 1,), by the groups' sizes."""
    return np.concatenate([[0], np.cumsum(count)]).astype(np.int64)


def owners(start: IntArray) -> IntArray:
    """Return the group that each row belongs to, by where the groups begin and the last ends, (groups + 1,)."""
    return np.repeat(np.arange(len(start) - 1), np.diff(start))


def ranks(count: IntArray) -> IntArray:
    """Return 0, 1, 2 … within each group, for all groups in a row; `count` holds their sizes, (groups,)."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)


def runs(first: IntArray, count: IntArray) -> IntArray:
    """Return first, first + 1, first + 2 … of each group, for all groups in a row.

    `first` says where the rows of each group begin in another array and `count` how many they are, (groups,).
    """
    return np.repeat(first, count) + ranks(count)
