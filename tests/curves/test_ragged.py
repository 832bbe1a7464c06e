"""Groups of different sizes in flat arrays."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves.ragged import owners, ranks, runs, starts

COUNT = np.array([2, 0, 3])


def test_ranks_count_from_0_within_each_group() -> None:
    assert ranks(COUNT).tolist() == [0, 1, 0, 1, 2]
    assert ranks(np.zeros(0, np.int64)).tolist() == []


def test_runs_count_from_the_first_row_of_each_group() -> None:
    assert runs(np.array([7, 9, 4]), COUNT).tolist() == [7, 8, 4, 5, 6]


def test_starts_and_owners_of_rows() -> None:
    start = starts(COUNT)
    assert start.tolist() == [0, 2, 2, 5]
    assert owners(start).tolist() == [0, 0, 2, 2, 2]
    assert starts([]).tolist() == [0]
    assert owners(starts([])).tolist() == []
