"""Groups of different sizes in flat arrays."""

from __future__ import annotations

import numpy as np

from osm2xodr.curves.ragged import (
    connected_groups,
    owners,
    ranks,
    repeated,
    runs,
    sorted_unique,
    starts,
    unique_all,
    unique_counts,
    unique_first,
    unique_inverse,
    unique_rows,
)

COUNT = np.array([2, 0, 3])


def test_ranks_count_from_0_within_each_group() -> None:
    assert ranks(COUNT).tolist() == [0, 1, 0, 1, 2]
    assert ranks(np.zeros(0, np.int64)).tolist() == []


def test_runs_count_from_the_first_row_of_each_group() -> None:
    assert runs(np.array([7, 9, 4]), COUNT).tolist() == [7, 8, 4, 5, 6]


def test_starts_and_owners_of_rows() -> None:
    start = starts(COUNT)
    assert start.tolist() == [0, 2, 2, 5]
    assert owners(start).tolist() == repeated(COUNT).tolist() == [0, 0, 2, 2, 2]
    assert starts([]).tolist() == [0]
    assert owners(starts([])).tolist() == []


def test_distinct_integers_are_ascending() -> None:
    values = np.array([[5, 2], [5, -1], [2, 5]])
    assert sorted_unique(values).tolist() == [-1, 2, 5]
    assert [column.tolist() for column in unique_all(values)] == [
        [-1, 2, 5],
        [3, 1, 0],
        [2, 1, 2, 0, 1, 2],
        [1, 2, 3],
    ]
    assert [column.tolist() for column in unique_inverse(values)] == [[-1, 2, 5], [2, 1, 2, 0, 1, 2]]
    assert [column.tolist() for column in unique_first(values)] == [[-1, 2, 5], [3, 1, 0]]
    assert [column.tolist() for column in unique_counts(values)] == [[-1, 2, 5], [1, 2, 3]]
    none = np.zeros(0, np.int64)
    assert [column.tolist() for column in (sorted_unique(none), *unique_all(none))] == [[]] * 5


def test_distinct_rows_ascend_by_column() -> None:
    found = unique_rows(np.array([[2, 1], [1, 9], [2, 0], [1, 9]]))
    assert found.values.tolist() == [[1, 9], [2, 0], [2, 1]]
    assert (found.first.tolist(), found.inverse.tolist()) == ([1, 2, 0], [2, 0, 1, 0])
    assert found.counts.tolist() == [2, 1, 1]
    assert unique_rows(np.zeros((0, 2), np.int64)).values.shape == (0, 2)


def test_pairs_join_groups() -> None:
    one, other = np.array([[5, 4], [4, 1], [6, 6], [2, 0], [0, 2]]).T
    np.testing.assert_array_equal(connected_groups(7, one, other), [0, 1, 0, 2, 1, 1, 3])
    chain = np.random.default_rng(1).permutation(1000)
    assert not connected_groups(1000, chain[1:], chain[:-1]).any()
    assert not len(connected_groups(0, one[:0], other[:0]))
