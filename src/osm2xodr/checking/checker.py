"""All checks of a file, one after another."""

from __future__ import annotations

import dataclasses
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr.checking.checks import Violation, check_tables, schema_violations
from osm2xodr.checking.findings import Finding, Findings
from osm2xodr.checking.result import CheckOptions, CheckResult
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, frame_of, pose, read_xodr
from osm2xodr.system import Task, available_jobs, stage, xml_stream

# Bytes that are read at once; headers are shorter.
_CHUNK: Final = 1 << 16
# Files of more bytes are checked on two cores: a copy of the process costs about as much as a file of this size.
_LARGE: Final = 2_000_000


def check_file(path: Path, options: CheckOptions | None = None) -> CheckResult:
    """Check a file of OpenDRIVE; by default against the rules of the standard and of `DEFAULT_READERS`.

    Raises
    ------
    InputError
        The file, or the schema that was given, cannot be read.
    """
    return check_drive(read_xodr(path), options or CheckOptions())


def check_drive(drive: OpenDrive, options: CheckOptions) -> CheckResult:
    """Check a file that was read before; see `check_file`."""
    rules = options.rules()
    findings = Findings(drive, rules)
    # Damaged files lead to NaN and infinity; warnings about them would say nothing new.
    with _schema(drive, options, findings) as schema, np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        stage("checking roads")
        check_tables(drive, _head(drive.path), findings)
        stage("checking the schema")
        violations, note = schema.result()
    findings.add(
        "schema", line=[line for line, _ in violations], other=[text for _, text in violations], count=len(violations)
    )
    readers = frozenset(options.readers)
    found = findings.records(options.most, readers, lambda road, s: _located(drive, road, s))
    major, minor = drive.header.revision
    return CheckResult(
        drive.path,
        f"{major}.{minor}" if min(major, minor) >= 0 else "",
        (len(drive.roads.id), len(drive.junctions.id), float(np.nansum(drive.roads.length)) / 1000),
        options.readers,
        rules,
        findings.counts(),
        _on_earth(drive, found),
        () if note is None else (note,),
    )


def _schema(
    drive: OpenDrive, options: CheckOptions, findings: Findings
) -> Task[tuple[tuple[Violation, ...], str | None]]:
    """Find how the file violates its schema, and why that is not known, if so; beside all else if it is large."""
    if not findings.wants("schema"):
        return Task(lambda: ((), None), apart=False)
    large = drive.path.is_file() and drive.path.stat().st_size > _LARGE
    find = partial(schema_violations, drive.path, drive.header.revision, options.schema)
    return Task(find, apart=large and available_jobs() > 1)


def _head(path: Path) -> str:
    """Return the text of a file up to its first road, on which some readers depend; none for standard input."""
    if str(path) == "-":
        return ""
    data = b""
    with path.open("rb") as file:
        stream = xml_stream(file)
        while b"<road" not in data and (chunk := stream.read(_CHUNK)):
            data += chunk
    return data.partition(b"<road")[0].decode("utf-8", "replace")


def _located(drive: OpenDrive, road: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x and y of stations, (n,), m; NaN where there is no road."""
    x, y = np.full(len(road), np.nan), np.full(len(road), np.nan)
    known = np.flatnonzero(road >= 0)
    if len(known):
        # A finding about a road as a whole is placed at its start.
        x[known], y[known], _ = pose(drive, road[known], np.nan_to_num(s[known]))
    return x, y


def _on_earth(drive: OpenDrive, found: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Return findings with latitude and longitude, if the file says where it is."""
    placed = [k for k, item in enumerate(found) if item.x is not None and item.y is not None]
    frame, _ = frame_of(drive.header)
    if not placed or frame is None:
        return found
    x = np.array([found[k].x for k in placed], np.float64)
    y = np.array([found[k].y for k in placed], np.float64)
    lon, lat = frame.to_geographic(x, y)
    out = list(found)
    for k, at_lon, at_lat in zip(placed, lon.tolist(), lat.tolist(), strict=True):
        if np.isfinite(at_lon) and np.isfinite(at_lat):
            out[k] = dataclasses.replace(out[k], lat=at_lat, lon=at_lon)
    return tuple(out)
