"""Groups of different sizes that stand one after the other in flat arrays."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import IntArray


def ranks(count: IntArray) -> IntArray:
    """Return 0, 1, 2 … within each group, for all groups in a row; `count` holds their sizes, (groups,)."""
    out: IntArray = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    return out


def runs(first: IntArray, count: IntArray) -> IntArray:
    """Return first, first + 1, first + 2 … of each group, for all groups in a row.

    `first` says where the rows of each group begin in another array and `count` how many they are, (groups,).
    """
    out: IntArray = np.repeat(first, count) + ranks(count)
    return out
