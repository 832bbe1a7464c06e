"""Writes the summary of a batch: a table for programs, and a page for people."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

from osm2xodr.batching.index.area_rows import AreaRow, Figures, read_rows
from osm2xodr.batching.index.html import make_index
from osm2xodr.batching.model import Result
from osm2xodr.diagnostics import Kind
from osm2xodr.system import stream_to

TABLE_NAME: Final = "summary.csv"
PAGE_NAME: Final = "index.html"

# Spreadsheets take cells that begin with these for formulas; the last four are the full-width forms.
_FORMULA = tuple("=+-@\uff1d\uff0b\uff0d\uff20")


def _of_result(decimals: int, get: Callable[[Result], float]) -> Callable[[AreaRow], str]:
    """Return a function for cells with a figure that is 0 without a conversion."""
    return lambda row: f"{get(row.result):.{decimals}f}" if get(row.result) > 0.0 else ""


def _figure(decimals: int, get: Callable[[Figures], float | None], unit: float = 1.0) -> Callable[[AreaRow], str]:
    """Return a function for cells with a figure of the report, in some unit."""

    def cell(row: AreaRow) -> str:
        value = None if row.figures is None else get(row.figures)
        return "" if value is None else f"{value / unit:.{decimals}f}"

    return cell


def _text(get: Callable[[AreaRow], str]) -> Callable[[AreaRow], str]:
    """Return a function for cells with a text, after an apostrophe where spreadsheets would see a formula."""

    def cell(row: AreaRow) -> str:
        value = get(row)
        return f"'{value}" if value.lstrip().startswith(_FORMULA) else value

    return cell


_COLUMNS: Final = MappingProxyType(
    {
        "name": _text(lambda row: row.name),
        "status": _text(lambda row: row.result.status.value),
        "message": _text(lambda row: row.message),
        "seconds": _of_result(2, lambda result: result.seconds),
        "memory_mb": _of_result(1, lambda result: result.memory / 1e6),
        "xodr": _text(lambda row: row.files.get(".xodr", "")),
        "report": _text(lambda row: row.files.get(".json", "")),
        "page": _text(lambda row: row.files.get(".html", "")),
        "xodr_bytes": _figure(0, lambda figures: figures.size),
        "roads": _figure(0, lambda figures: figures.roads),
        "connecting_roads": _figure(0, lambda figures: figures.connecting_roads),
        "junctions": _figure(0, lambda figures: figures.junctions),
        "road_km": _figure(3, lambda figures: figures.road_length, 1000.0),
        "connecting_road_km": _figure(3, lambda figures: figures.connecting_length, 1000.0),
        "dem_coverage": _figure(4, lambda figures: figures.dem_coverage),
        "lowest_m": _figure(2, lambda figures: figures.lowest),
        "highest_m": _figure(2, lambda figures: figures.highest),
        "steepest_grade": _figure(4, lambda figures: figures.grade),
        "guessed": _figure(0, lambda figures: figures.counts[Kind.GUESSED]),
        "dropped": _figure(0, lambda figures: figures.counts[Kind.DROPPED]),
        "repaired": _figure(0, lambda figures: figures.counts[Kind.REPAIRED]),
        "notes": _figure(0, lambda figures: figures.counts[Kind.NOTE]),
        "xodr_version": _text(lambda row: "" if row.figures is None else row.figures.xodr_version),
        "osm2xodr": _text(lambda row: "" if row.figures is None else row.figures.version),
    }
)
COLUMNS: Final = tuple(_COLUMNS)


def write_summary(out_dir: Path, results: Sequence[Result]) -> None:
    """Write ``summary.csv`` and ``index.html`` into the folder of a batch, each as a whole or not at all.

    The same results and reports give the same bytes, whatever the order of the results. Figures come from the reports
    ``NAME.json`` in the folder; where one is missing or damaged the message says so. Raises `OutputError` if a file
    cannot be written.
    """
    rows = read_rows(out_dir, results)
    for name, text in ((TABLE_NAME, make_table(rows)), (PAGE_NAME, make_index(rows))):
        with stream_to(out_dir / name) as stream:
            stream.write(text)


def make_table(rows: Sequence[AreaRow]) -> bytes:
    """Return a table by RFC 4180, UTF-8, with a header, and empty cells for what is unknown."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows([make(row) for make in _COLUMNS.values()] for row in rows)
    return text.getvalue().encode("utf-8", "replace")
