"""Tables: frozen dataclasses whose fields are columns with one entry for each row."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Any, TypeVar, cast

import numpy as np

from osm2xodr.curves.plan_views import chosen_curves, stack_plan_views
from osm2xodr.curves.ragged import runs, starts
from osm2xodr.model import BoolArray, IntArray, PlanView

_Table = TypeVar("_Table", bound="Table")
_Ragged = TypeVar("_Ragged", bound="RaggedTable")


class Table:
    """Base of dataclasses whose fields are columns: arrays, tuples, tables, plan views with a curve for each row."""

    __slots__ = ()

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the names of the columns."""
        return tuple(cls.__dataclass_fields__)  # type: ignore[attr-defined]

    def chosen(self: _Table, rows: IntArray | BoolArray | slice) -> _Table:
        """Return the table of some rows, by their indices in any order, or those that are kept."""
        return self._of(_entries(getattr(self, name), rows) for name in self.columns())

    def joined(self: _Table, *others: _Table) -> _Table:
        """Return the table with the rows of others behind its own."""
        every = (self, *others)
        return self._of(_behind([getattr(one, name) for one in every]) for name in self.columns())

    @classmethod
    def _of(cls: type[_Table], columns: Iterable[Any]) -> _Table:
        make: Any = cls
        return cast("_Table", make(*columns))


class RaggedTable(Table):
    """Base of tables of groups of rows: their first field, `start`, (groups + 1,), says where each group begins."""

    __slots__ = ()

    def chosen(self: _Ragged, rows: IntArray | BoolArray | slice) -> _Ragged:
        """Return the table of some groups, by their indices in any order, or those that are kept."""
        first, *others = (getattr(self, name) for name in self.columns())
        at = self.rows(rows)
        return self._of([starts(np.diff(first)[rows]), *(_entries(column, at) for column in others)])

    def rows(self, groups: IntArray | BoolArray | slice) -> IntArray:
        """Return the indices of the rows of some groups."""
        start: IntArray = getattr(self, self.columns()[0])
        return runs(start[:-1][groups], np.diff(start)[groups])

    def joined(self: _Ragged, *others: _Ragged) -> _Ragged:
        """Return the table with the groups of others behind its own."""
        first, *columns = ([getattr(one, name) for one in (self, *others)] for name in self.columns())
        return self._of([starts(np.concatenate([np.diff(start) for start in first])), *map(_behind, columns)])


def join_tables(parts: Iterable[_Table]) -> _Table:
    """Return tables, at least one, as one table, one behind the other."""
    first, *others = parts
    return first.joined(*others)


def _entries(column: Any, rows: IntArray | BoolArray | slice) -> Any:
    """Return some entries of a column."""
    if isinstance(column, np.ndarray):
        return column[rows]
    if isinstance(column, Table):
        return column.chosen(rows)
    if isinstance(column, PlanView):
        return chosen_curves(column, np.arange(len(column.start) - 1)[rows])
    return tuple(map(column.__getitem__, np.arange(len(column))[rows].tolist()))


def _behind(columns: Sequence[Any]) -> Any:
    """Return columns of one kind, one behind the other."""
    first = columns[0]
    if isinstance(first, np.ndarray):
        return np.concatenate(columns)
    if isinstance(first, Table):
        return join_tables(columns)
    return stack_plan_views(*columns) if isinstance(first, PlanView) else tuple(chain.from_iterable(columns))
