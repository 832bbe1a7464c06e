"""Tables of equally long columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.curves import RaggedTable, Table, curves_of, join_tables, lengths
from osm2xodr.model import FloatArray, IntArray, PlanView


@dataclass(frozen=True, slots=True, eq=False)
class Pieces(RaggedTable):
    start: IntArray
    size: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Places(Table):
    row: IntArray
    xy: FloatArray
    name: tuple[str, ...]
    curve: PlanView
    pieces: Pieces


def places() -> Places:
    zero = np.zeros(3)
    curve = curves_of(zero, zero, zero, np.array([[1.0], [2.0], [4.0]]), np.zeros((3, 1)))
    pieces = Pieces(np.array([0, 2, 2, 3]), np.array([0.1, 0.2, 0.3]))
    return Places(np.array([7, 8, 9]), np.arange(6.0).reshape(3, 2), ("a", "b", "c"), curve, pieces)


def test_rows_are_chosen_by_index_mask_or_slice() -> None:
    one = places().chosen(np.array([2, 0, 2]))
    assert one.row.tolist() == [9, 7, 9]
    assert one.xy.tolist() == [[4.0, 5.0], [0.0, 1.0], [4.0, 5.0]]
    assert one.name == ("c", "a", "c")
    assert lengths(one.curve).tolist() == [4.0, 1.0, 4.0]
    assert one.pieces.start.tolist() == [0, 1, 3, 4]
    assert one.pieces.size.tolist() == [0.3, 0.1, 0.2, 0.3]
    for rows in (np.array([False, True, True]), slice(1, None)):
        two = places().chosen(rows)
        assert (two.row.tolist(), two.name, lengths(two.curve).tolist()) == ([8, 9], ("b", "c"), [2.0, 4.0])
        assert two.pieces.start.tolist() == [0, 0, 1]


def test_tables_are_joined_one_behind_the_other() -> None:
    none = places().chosen(np.zeros(0, np.int64))
    both = join_tables([none, places().chosen(slice(2)), places().chosen(slice(1))])
    assert both.row.tolist() == [7, 8, 7]
    assert both.name == ("a", "b", "a")
    assert lengths(both.curve).tolist() == [1.0, 2.0, 1.0]
    assert both.pieces.start.tolist() == [0, 2, 2, 4]
    assert places().pieces.rows(np.array([2, 0])).tolist() == [2, 0, 1]
