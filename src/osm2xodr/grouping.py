"""Rows of groups that stand one after the other in flat arrays."""

from __future__ import annotations

import numpy as np

from osm2xodr.model import IntArray


def ranks(count: IntArray) -> IntArray:
    """Return 0, 1, 2 … within each group, for all groups in a row.

    Parameters
    ----------
    count : (groups,)
        Rows of each group.
    """
    out: IntArray = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    return out
