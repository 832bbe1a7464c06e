"""Rows of numbers that belong to owners, collected kind by kind and turned into tables at the end.

They are kept as plain numbers from the start: as objects of Python they would take four times the memory.
"""

from __future__ import annotations

from array import array

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.tables import Misfit


class Records:
    """Rows of `width` numbers, the first of them s, from elements of one name, of one owner after another."""

    def __init__(self, element: str, width: int) -> None:
        self.element = element
        self._width = width
        self._flat = array("d")
        self._lines = array("q")
        self._start = array("q", [0])
        # Of each row out of order: owner, line, its s and that of the row before it.
        self._behind: list[tuple[int, int, float, float]] = []

    def add(self, rows: FloatArray, lines: IntArray, owner: IntArray, owners_: int) -> None:
        """Add the rows of further owners, with their lines; `owner` counts from 0 and ascends, (rows,)."""
        self._flat.frombytes(np.ascontiguousarray(rows).tobytes())
        self._lines.frombytes(lines.tobytes())
        extend_counts(self._start, np.bincount(owner, minlength=owners_))

    def extend(self, other: Records) -> None:
        """Add all owners of another collection."""
        extend_starts(self._start, other._start)
        self._flat.extend(other._flat)
        self._lines.extend(other._lines)

    @property
    def start(self) -> IntArray:
        """Index of each owner's first row, (owners + 1,)."""
        return np.array(self._start, np.int64)

    def table(self) -> tuple[FloatArray, IntArray, IntArray | None]:
        """Return all rows (rows, width) in ascending s per owner, and their lines.

        The third array has their places in the file, None where that is their order. Rows are handed over: only once,
        and `misfits` knows which of them were out of order.
        """
        rows = np.frombuffer(self._flat, np.float64).reshape(-1, self._width)
        lines = np.frombuffer(self._lines, np.int64)
        self._flat, self._lines = array("d"), array("q")
        owner = owners(self.start)
        behind = 1 + np.flatnonzero((np.diff(rows[:, 0]) < 0) & (owner[1:] == owner[:-1]))
        if not len(behind):
            return rows, lines, None
        columns_ = (owner[behind], lines[behind], rows[behind, 0], rows[behind - 1, 0])
        self._behind = list(zip(*(column.tolist() for column in columns_), strict=True))
        order = np.lexsort((rows[:, 0], owner))
        return rows[order], lines[order], order

    def misfits(self, roads: IntArray | None = None) -> list[Misfit]:
        """Report rows out of order; `roads` holds the road of each owner, (owners,), unless owners are roads."""
        return [
            Misfit(
                "unsorted-records",
                line,
                owner if roads is None else int(roads[owner]),
                f"<{self.element}> at {s:g} follows one at {before:g}; they are sorted",
            )
            for owner, line, s, before in self._behind
        ]

    def profile(self) -> tuple[CubicProfile, IntArray]:
        """Return rows of s, a, b, c, d as a table, and their lines."""
        rows, lines, _ = self.table()
        return CubicProfile(self.start, *columns(rows)), lines


def extend_starts(starts: array[int], others: array[int]) -> None:
    """Add the rows of other owners to the indices at which those of some owners start, (owners + 1,)."""
    last = starts[-1]
    starts.extend(last + start for start in others[1:])


def extend_counts(starts: array[int], counts: IntArray) -> None:
    """Add further owners with so many rows each."""
    starts.frombytes((starts[-1] + np.cumsum(counts, dtype=np.int64)).tobytes())


def columns(rows: FloatArray) -> list[FloatArray]:
    """Return the columns of a table, each on its own."""
    return [np.ascontiguousarray(column) for column in rows.T]
