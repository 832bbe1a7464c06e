"""What is said about a conversion: to people as text, to programs as JSON.

Imports nothing heavy: the command line imports it at its start.
"""

from __future__ import annotations

import dataclasses
import json
import math
import time
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, TextIO

from osm2xodr.diagnostics import Diagnostics, Kind, counted

if TYPE_CHECKING:
    from osm2xodr.model import BorderEnd, ElevationReport
    from osm2xodr.reporting.statistics import Statistics
    from osm2xodr.surface import DemSummary

# Version of the layout of the JSON report; goes up when a field is removed or changes its meaning.
REPORT_FORMAT = 1

_KINDS = (Kind.GUESSED, Kind.DROPPED, Kind.REPAIRED, Kind.NOTE)


class Progress:
    """Shows which stage runs: in one line that is rewritten (`live`), in a line with the time of each (`verbose`)."""

    def __init__(self, stream: TextIO, *, live: bool, verbose: bool) -> None:
        self._stream = stream
        self._live = live
        self._verbose = verbose
        self._stage = ""
        self._began = 0.0

    def stage(self, name: str) -> None:
        """End the stage that runs, and begin another one."""
        self.done()
        self._stage, self._began = name, time.monotonic()
        if self._live:
            self._stream.write(f"\r\x1b[K{name} …")
            self._stream.flush()

    def done(self) -> None:
        """End the stage that runs, if any."""
        if self._stage and self._live:
            self._stream.write("\r\x1b[K")
        if self._stage and self._verbose:
            self._stream.write(f"{time.monotonic() - self._began:7.2f} s  {self._stage}\n")
        self._stream.flush()
        self._stage = ""


def summary(
    statistics: Statistics, diagnostics: Diagnostics, *, has_heights: bool, elevation: ElevationReport | None = None
) -> list[str]:
    """Return lines that sum up a conversion: the network, its heights, then what was guessed, dropped and repaired.

    `has_heights` says whether there is an elevation model, `elevation` how well the roads follow it.
    """
    roads, through = counted(statistics.roads, "road"), counted(statistics.connecting_roads, "connecting road")
    kilometres = f"{statistics.road_length / 1000.0:,.1f} km"
    lines = [f"  {roads} of {kilometres}, {through} in {counted(statistics.junctions, 'junction')}"]
    if has_heights:
        covered = statistics.dem_coverage
        coverage = "" if covered is None else f"; the elevation model covers {_percent(covered)} of the roads"
        lines.append(f"  heights from {statistics.lowest:,.1f} to {statistics.highest:,.1f} m{coverage}")
    else:
        lines.append("  flat at height 0: there is no elevation model")
    if elevation is not None:
        errors = f"mean {elevation.bias:+.2f} m, rms {elevation.rms:.2f} m, 95 % within {elevation.p95:.2f} m"
        lines.append(f"  roads on the ground less the elevation model: {errors}")
        kinds = [item.kind for item in elevation.structures]
        if kinds:
            built = " and ".join(counted(kinds.count(kind), kind) for kind in ("bridge", "tunnel") if kind in kinds)
            lines.append(f"  {built}; {counted(len(elevation.tight), 'crossing')} with less clearance than usual")
    first: dict[tuple[Kind, str], tuple[str, str]] = {}
    for item in diagnostics:
        first.setdefault((item.kind, item.code), (item.message, item.osm_id))
    counts = diagnostics.counts()
    order = sorted(counts.items(), key=lambda entry: (_KINDS.index(entry[0][0]), -entry[1], entry[0][1]))
    for (kind, code), count in order:
        lines.append(f"  {kind.value:<9}{count:>8,}  {code}: {_example(*first[kind, code], count)}")
    return lines


def details(diagnostics: Diagnostics) -> list[str]:
    """Return one line for each diagnostic."""
    return [f"  {item.kind.value}: {item.code}: {_example(item.message, item.osm_id, 1)}" for item in diagnostics]


def report(
    inputs: Mapping[str, Any],
    elevation_models: Sequence[DemSummary],
    statistics: Statistics,
    elevation: ElevationReport | None,
    diagnostics: Diagnostics,
    output: Mapping[str, Any],
    border_ends: Sequence[BorderEnd] | None = None,
) -> bytes:
    """Return the JSON report on a conversion, UTF-8; the same input gives the same bytes.

    `inputs` are files and options by name, `output` says what was written; `elevation` is None where the world is
    flat, and `border_ends`, where roads were cut off, for an area by itself.
    """
    counts = [{"kind": kind.value, "code": code, "count": n} for (kind, code), n in diagnostics.counts().items()]
    found = [
        {"kind": item.kind.value, "code": item.code, "osm_id": item.osm_id or None, "message": item.message}
        for item in diagnostics
    ]
    document = {
        "format": REPORT_FORMAT,
        "input": dict(inputs),
        "elevation_models": [dataclasses.asdict(item) for item in elevation_models],
        "output": dict(output),
        "statistics": dataclasses.asdict(statistics),
        "elevation": None if elevation is None else dataclasses.asdict(elevation),
        **({} if border_ends is None else {"border_ends": [dataclasses.asdict(item) for item in border_ends]}),
        "counts": counts,
        "diagnostics": found,
    }
    text = json.dumps(_plain(document), indent=1, ensure_ascii=False, allow_nan=False)
    # Names from damaged files may contain lone surrogates, which UTF-8 cannot encode.
    return text.encode("utf-8", "replace") + b"\n"


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: text for paths, null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, PurePath) else value


def _percent(share: float) -> str:
    """Return a share in per cent, never rounded up to 100 or down to 0."""
    if share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    return f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"


def _example(message: str, osm_id: str, count: int) -> str:
    """Return the first of several findings, and how many more there are."""
    text = message.rstrip(".")
    where = osm_id if osm_id not in text else ""
    others = f"and {count - 1:,} more" if count > 1 else ""
    both = ", ".join(filter(None, (where, others)))
    return f"{text} ({both})" if both else text
