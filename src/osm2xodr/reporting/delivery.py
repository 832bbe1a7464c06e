"""Results on their way out: to files that are there as a whole or not at all, or to standard output.

Imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.reporting.report import report
from osm2xodr.system import settle, stream_to
from osm2xodr.xodrWriter import WriteOptions, write_xodr

if TYPE_CHECKING:
    from osm2xodr.reporting.conversion import Conversion


class _Counting:
    """A binary stream that counts what goes through."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.size = 0

    def write(self, data: bytes) -> int:
        """Write all of `data`."""
        self._stream.write(data)
        self.size += len(data)
        return len(data)


def deliver(
    conversion: Conversion,
    diagnostics: Diagnostics,
    target: Path,
    options: WriteOptions,
    report_target: Path | None,
    inputs: Mapping[str, Any],
    jobs: int = 1,
) -> int:
    """Write the road network, and the report if there is to be one; both or none.

    Parameters
    ----------
    conversion, diagnostics
        What was made.
    target, options
        Where the road network goes, and how it is written.
    report_target, inputs
        Where the report goes, if anywhere, and what it says about the input.
    jobs
        How many processes make the text of the road network.

    Returns
    -------
    int
        Size of the road network, bytes.

    Raises
    ------
    OutputError
        If either cannot be written.
    BrokenPipeError
        If nobody reads standard output to its end.
    """
    with stream_to(target) as stream:
        counting = _Counting(stream)
        write_xodr(conversion.road_map, counting, options, diagnostics, jobs)
        if report_target is not None:
            # Only when the document is safe, but before its file gets its name: both are there in the end, or none.
            settle(stream)
            with stream_to(report_target) as reports:
                reports.write(report_text(conversion, diagnostics, target, options, inputs, counting.size))
    return counting.size


def report_text(
    conversion: Conversion,
    diagnostics: Diagnostics,
    target: Path,
    options: WriteOptions,
    inputs: Mapping[str, Any],
    size: int,
) -> bytes:
    """Return the report on a conversion, JSON, for parameters as those of `deliver` and the size that it returns."""
    output = {"file": str(target), "bytes": size, "xodr_version": options.version}
    road_map, models = conversion.road_map, conversion.elevation_models
    elevation, ends = road_map.elevation_report, road_map.border_ends
    return report(inputs, models, conversion.statistics, elevation, diagnostics, output, ends)
