"""What a conversion comes to, and writing it.

Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
import shlex
import tempfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from osm2xodr.conventions import PROGRAMMES_HEAD, programmes_file
from osm2xodr.diagnostics import Diagnostics, Kind, counted
from osm2xodr.errors import OptionError
from osm2xodr.reporting.report import report
from osm2xodr.system import STANDARD_OUTPUT, record, remove_made, settle, stream_to
from osm2xodr.xodrWriter import WriteOptions, check_date, signal_programmes, write_xodr

if TYPE_CHECKING:
    from osm2xodr.model import RoadMap
    from osm2xodr.reporting.statistics import Statistics
    from osm2xodr.surface import DemSummary


@record
class Written:
    """A file that was written."""

    path: Path  # The file; ``-`` is standard output
    size: int  # Bytes
    diagnostics: Diagnostics  # What was guessed, dropped and repaired on the way to it
    sha256: str = ""  # Of a road network; empty for other files


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Conversion:
    """A road network made of an OpenStreetMap file, as `osm2xodr.convert` returns it."""

    road_map: RoadMap  # The road network
    statistics: Statistics  # Its figures: numbers and lengths of roads, heights
    diagnostics: Diagnostics  # What was guessed, dropped and repaired, each with the element of OpenStreetMap
    # What the elevation models are and what was used of them, in the order given
    elevation_models: tuple[DemSummary, ...] = ()
    inputs: Mapping[str, Any] = field(default_factory=dict)  # Files and options, by name, as reports say them
    # How it is written unless `write` is told otherwise, and by how many processes
    options: WriteOptions = field(default_factory=WriteOptions)
    jobs: int = 1
    source: Path | None = None  # The map, for the places of its elements; None where it cannot be read again
    # Reads a file and writes the part of it that is wanted; returns what was cut off, in sentences. None: all of it.
    clip: Callable[[Path, Any], Iterable[str]] | None = None

    def write(
        self,
        path: str | os.PathLike[str],
        options: WriteOptions | None = None,
        *,
        report_json: str | os.PathLike[str] | None = None,
        osm_issues: str | os.PathLike[str] | None = None,
        **changes: Any,
    ) -> Written:
        """Write the road network as OpenDRIVE, and what there is to be beside it; all or nothing.

        For SUMO the programmes of traffic lights are written beside a file, as ``area.tll.xml`` beside ``area.xodr``.
        If there are none, the programmes of a file that is replaced are removed.

        Parameters
        ----------
        path
            File to write; ``-`` is standard output. One that exists is replaced.
        options
            How to write; by default as was said when the area was converted.
        report_json
            File for the report: all that is to be known about the conversion, as JSON. None writes none.
        osm_issues
            File for the mistakes of OpenStreetMap that were found, as GeoJSON. None writes none.
        **changes
            Fields of `WriteOptions` that differ from those in `options`: ``name``, ``date``, and ``version`` of
            OpenDRIVE, which may be called ``xodr_version`` as well.

        Returns
        -------
        Written
            The file, its size, and the diagnostics of the conversion with what this version of OpenDRIVE cannot say.

        Raises
        ------
        TypeError
            An option is unknown.
        OptionError
            The version cannot be written; there is no map to read the places of `osm_issues` from.
        InputError
            The map cannot be read.
        OutputError
            A file cannot be written.
        BrokenPipeError
            Nobody reads standard output to its end.
        """
        how = _changed(options or self.options, changes)
        diagnostics = self.diagnostics.copy()
        with stream_to(Path(path)) as stream:
            counting = _Counting(stream)
            self._write(counting, how, diagnostics)
            written = Written(Path(path), counting.size, diagnostics, counting.sha256())
            others: list[tuple[Path, bytes]] = []
            beside = None if Path(path) == STANDARD_OUTPUT else programmes_file(Path(path))
            programmes = signal_programmes(self.road_map, how) if how.target.programmes_option else b""
            if beside is not None and programmes:
                others.append((beside, programmes))
            if report_json is not None:
                others.append((Path(report_json), self.report(written, how)))
            if osm_issues is not None:
                others.append((Path(osm_issues), self._issues()))
            if others:
                # Only when the document is safe, but before its file gets its name: all are there in the end, or
                # none.
                settle(stream)
            with ExitStack() as stack:
                for target, data in others:
                    stack.enter_context(stream_to(target)).write(data)
        if beside is not None and beside not in (target for target, _ in others):
            # What belonged to a file that is replaced would now contradict it.
            remove_made(beside, PROGRAMMES_HEAD.encode())
        return written

    def _write(self, stream: _Counting, how: WriteOptions, diagnostics: Diagnostics) -> None:
        """Write the document, or the part of it that is wanted."""
        if self.clip is None:
            write_xodr(self.road_map, stream, how, diagnostics, self.jobs)
            return
        with tempfile.TemporaryDirectory(prefix="osm2xodr-") as folder:
            whole = Path(folder) / "whole.xodr"
            with whole.open("wb") as file:
                write_xodr(self.road_map, file, how, diagnostics, self.jobs)
            for line in self.clip(whole, stream):
                diagnostics.note("clipped", "", line)

    def _issues(self) -> bytes:
        """Return the mistakes of OpenStreetMap, GeoJSON in UTF-8."""
        if self.source is None:
            raise OptionError("osm_issues needs the map as a file, to read places from", "osm_issues")
        from osm2xodr.reporting.report import osm_issues

        return osm_issues(self.diagnostics, self.source, self.road_map.frame)

    def report(self, written: Written, options: WriteOptions | None = None) -> bytes:
        """Return the report about the conversion and a file that was written, JSON in UTF-8.

        `options` say how it was written; by default as was said when the area was converted.
        """
        version = (options or self.options).version
        output = {"file": str(written.path), "bytes": written.size, "xodr_version": version, "sha256": written.sha256}
        elevation, ends = self.road_map.elevation_report, self.road_map.border_ends
        return report(
            self.inputs,
            self.elevation_models,
            self.statistics,
            elevation,
            written.diagnostics,
            output,
            ends,
            self.road_map.junctions,
        )

    def load_command(self, path: str | os.PathLike[str]) -> str:
        """Return the command that loads a file that was written into the reader that it is for.

        Empty for readers that need no command line, or none that would differ from any other file's.
        """
        from osm2xodr.model import Rule

        name = shlex.quote(os.fspath(path))
        left_hand, lights = self.road_map.rule is Rule.LEFT_HAND, bool(self.road_map.furniture.programmes)
        return self.options.target.load_command(name, left_hand=left_hand, programmes=lights)

    def __repr__(self) -> str:
        figures = self.statistics
        parts = [
            f"{counted(figures.roads, 'road')} of {figures.road_length / 1000.0:,.1f} km",
            f"{counted(figures.connecting_roads, 'connecting road')} in {counted(figures.junctions, 'junction')}",
            *(f"{count:,} {word}" for word, count in self._remarks().items()),
        ]
        return f"<Conversion {self.options.name!r}: {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        """Return a table, which notebooks show."""
        figures = self.statistics
        cells = {
            "roads": f"{figures.roads:,}",
            "length": f"{figures.road_length / 1000.0:,.1f} km",
            "connecting roads": f"{figures.connecting_roads:,}",
            "junctions": f"{figures.junctions:,}",
            "heights": f"{figures.lowest:,.1f} to {figures.highest:,.1f} m",
            **{word: f"{count:,}" for word, count in self._remarks().items()},
        }
        rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in cells.items())
        return f"<table><caption>{escape(self.options.name)}</caption>{rows}</table>"

    def _remarks(self) -> dict[str, int]:
        """Return how much was guessed, dropped and repaired."""
        counts = self.diagnostics.counts().items()
        kinds = [kind for kind in Kind if kind is not Kind.NOTE]
        return {kind.value: sum(count for (found, _), count in counts if found is kind) for kind in kinds}


def _changed(options: WriteOptions, changes: Mapping[str, Any]) -> WriteOptions:
    """Return options with some of them changed."""
    try:
        check_date(changes.get("date", ""))
    except ValueError as error:
        raise OptionError(f"date: {error}", "date") from error
    named = {"version" if name == "xodr_version" else name: value for name, value in changes.items()}
    try:
        return dataclasses.replace(options, **named)
    except ValueError as error:
        raise OptionError(f"xodr_version: {error}", "xodr_version") from error


class _Counting:
    """A binary stream that counts what goes through, and sums it up."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.size = 0
        self._sum = hashlib.sha256()

    def write(self, data: bytes) -> int:
        """Write all of `data`."""
        self._stream.write(data)
        self.size += len(data)
        self._sum.update(data)
        return len(data)

    def sha256(self) -> str:
        """Return the SHA-256 of all that was written."""
        return self._sum.hexdigest()
