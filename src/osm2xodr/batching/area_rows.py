"""One row per area for the summary of a batch: its result, the figures of its report, and a small picture."""

from __future__ import annotations

import contextlib
import math
import unicodedata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from osm2xodr.batching.model import Result, Status
from osm2xodr.batching.out_dir import OutDir
from osm2xodr.diagnostics import Kind
from osm2xodr.errors import InputError, OutputError
from osm2xodr.reporting import REPORT_FORMAT
from osm2xodr.system import parse_json, record, stream_to
from osm2xodr.viewing import draw_thumbnail

# Endings of the files of an area: road network, report, page to explore.
_SUFFIXES = (".xodr", ".json", ".html")
# Replacements of characters by category: controls, ends of lines and of paragraphs, lone surrogates.
_BLANKS = {"Cc": " ", "Zl": " ", "Zp": " ", "Cs": "\ufffd"}
# Characters that change the direction of text.
_TURNING = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
# Statuses of areas whose files are of this input.
_KEPT = (Status.DONE, Status.UNCHANGED)


@record
class Figures:
    """Figures of a report; None where it lacks one."""

    # Numbers of roads outside of junctions, of roads through them, of junctions
    roads: float | None
    connecting_roads: float | None
    junctions: float | None
    # Lengths of reference lines, m
    road_length: float | None
    connecting_length: float | None
    dem_coverage: float | None  # Share of the roads whose height is measured
    # Heights of reference lines, m
    lowest: float | None
    highest: float | None
    grade: float | None  # The steepest one, rise per metre
    counts: Mapping[Kind, int]  # Diagnostics of each kind
    size: float | None  # Of the road network's file, bytes
    xodr_version: str  # Of OpenDRIVE
    version: str  # Of the converter


@record
class AreaRow:
    """A row of the table and of the page."""

    result: Result
    message: str  # The sentence of the result, in one line; or that its report is missing
    files: Mapping[str, str]  # Names of its files that exist, by suffix; none for areas that failed
    figures: Figures | None  # Of its report; None without one
    thumbnail: bytes = b""  # Small picture of its road network, PNG; empty without one

    @property
    def name(self) -> str:
        """Name of the area, in one line."""
        return one_line(self.result.name)


def read_rows(out_dir: Path, results: Sequence[Result]) -> tuple[AreaRow, ...]:
    """Return a row for each result, in order of names; `out_dir` has the files of the areas."""
    return tuple(_row(out_dir, result) for result in sorted(results, key=lambda item: item.name))


def one_line(text: str) -> str:
    """Return text of unknown origin with blanks for line breaks, and without changes of direction."""
    return "".join(_BLANKS.get(unicodedata.category(char), char) for char in text if char not in _TURNING)


def _row(out_dir: Path, result: Result) -> AreaRow:
    message = " ".join(one_line(result.message).split())
    if result.status not in _KEPT:
        return AreaRow(result, message, {}, None)
    names = {suffix: f"{result.name}{suffix}" for suffix in _SUFFIXES}
    files = {suffix: name for suffix, name in names.items() if (out_dir / name).is_file()}
    figures = _read(out_dir / names[".json"])
    if figures is None and not message:
        message = f"There are no figures: its report {one_line(names['.json'])} is missing or cannot be read."
    return AreaRow(result, message, files, figures, thumbnail(OutDir(out_dir), result.name))


def _read(path: Path) -> Figures | None:
    """Return the figures of a report; None if there is none of this layout."""
    try:
        report = parse_json(path.read_bytes())
    except (OSError, ValueError):
        return None
    if not isinstance(report, dict) or report.get("format") != REPORT_FORMAT:
        return None
    statistics, output = _object(report, "statistics"), _object(report, "output")
    further = _object(statistics, "further")
    return Figures(
        roads=_number(statistics, "roads"),
        connecting_roads=_number(statistics, "connecting_roads"),
        junctions=_number(statistics, "junctions"),
        road_length=_number(statistics, "road_length"),
        connecting_length=_number(statistics, "connecting_length"),
        dem_coverage=_number(statistics, "dem_coverage"),
        lowest=_number(statistics, "lowest"),
        highest=_number(statistics, "highest"),
        grade=_number(further, "grade_max"),
        counts=_counts(report.get("counts")),
        size=_number(output, "bytes"),
        xodr_version=_text(output, "xodr_version"),
        version=_text(_object(report, "input"), "osm2xodr"),
    )


def _counts(entries: Any) -> dict[Kind, int]:
    """Return the number of diagnostics of each kind."""
    out = dict.fromkeys(Kind, 0)
    for entry in entries if isinstance(entries, list) else []:
        if isinstance(entry, dict) and entry.get("kind") in {kind.value for kind in Kind}:
            out[Kind(entry["kind"])] += int(_number(entry, "count") or 0)
    return out


def _object(parent: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = parent.get(key)
    return value if isinstance(value, dict) else {}


def _number(parent: Mapping[str, Any], key: str) -> float | None:
    value = parent.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return value


def _text(parent: Mapping[str, Any], key: str) -> str:
    value = parent.get(key)
    return one_line(value) if isinstance(value, str) else ""


def thumbnail(out: OutDir, name: str) -> bytes:
    """Return the picture of an area, as PNG; empty if there is no road network to draw."""
    xodr, kept = out.outputs(name)[0], out.thumbnail(name)
    with contextlib.suppress(OSError):
        if kept.stat().st_mtime_ns >= xodr.stat().st_mtime_ns:
            return kept.read_bytes()
    try:
        picture = draw_thumbnail(xodr)
    except InputError:
        return b""
    # The page does without the kept one.
    with contextlib.suppress(OutputError), stream_to(kept) as stream:
        stream.write(picture)
    return picture
