"""Rows of numbers that belong to owners, collected one by one and turned into tables at the end."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from osm2xodr.curves import owners
from osm2xodr.model import CubicProfile, FloatArray, IntArray
from osm2xodr.opendrive.tables import Misfit


class Records:
    """Rows of `width` numbers, the first of them s, from elements of one name, of one owner after another."""

    def __init__(self, element: str, width: int) -> None:
        self.element = element
        self._width = width
        self._flat: list[float] = []
        self._lines: list[int] = []
        self._start = [0]

    def add(self, values: Iterable[float], line: int) -> None:
        """Add a row to the current owner."""
        self._flat.extend(values)
        self._lines.append(line)

    def close(self) -> None:
        """Go on to the next owner."""
        self._start.append(len(self._lines))

    @property
    def is_empty(self) -> bool:
        """Whether the current owner has no rows."""
        return len(self._lines) == self._start[-1]

    @property
    def start(self) -> IntArray:
        """Index of each owner's first row, (owners + 1,)."""
        return np.array(self._start, np.int64)

    @property
    def owner(self) -> IntArray:
        """Index of each row's owner, (rows,)."""
        return owners(self.start)

    def table(self) -> tuple[FloatArray, IntArray, IntArray]:
        """Return all rows (rows, width) in ascending s per owner, their lines, and their places in the file."""
        rows, lines = self._rows, np.array(self._lines, np.int64)
        order = np.lexsort((rows[:, 0], self.owner)) if len(self._unsorted(rows[:, 0])) else np.arange(len(rows))
        return rows[order], lines[order], order

    @property
    def _rows(self) -> FloatArray:
        return np.array(self._flat, np.float64).reshape(-1, self._width)

    def _unsorted(self, s: FloatArray) -> IntArray:
        """Return the rows whose s is less than that of the row before them, of the same owner."""
        owner = self.owner
        return 1 + np.flatnonzero((np.diff(s) < 0) & (owner[1:] == owner[:-1]))

    def misfits(self, roads: IntArray | None = None) -> list[Misfit]:
        """Report rows out of order; `roads` holds the road of each owner, (owners,), unless owners are roads."""
        rows = self._rows
        owner = self.owner if roads is None else roads[self.owner]
        return [
            Misfit(
                "unsorted-records",
                self._lines[row],
                int(owner[row]),
                f"<{self.element}> at {rows[row, 0]:g} follows one at {rows[row - 1, 0]:g}; they are sorted",
            )
            for row in self._unsorted(rows[:, 0]).tolist()
        ]

    def profile(self) -> tuple[CubicProfile, IntArray]:
        """Return rows of s, a, b, c, d as a table, and their lines."""
        rows, lines, _ = self.table()
        return CubicProfile(self.start, *columns(rows)), lines


def columns(rows: FloatArray) -> list[FloatArray]:
    """Return the columns of a table, each on its own."""
    return [np.ascontiguousarray(column) for column in rows.T]
