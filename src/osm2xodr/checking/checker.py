"""All checks of a file, one after another."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from osm2xodr.checking.checks import (
    LaneIndex,
    check_lanes,
    check_links,
    check_misfits,
    check_phases,
    check_plan_views,
    check_profiles,
    check_readers,
    check_references,
    check_surfaces,
    check_ways_on,
    file_bytes,
    lane_index,
    schema_violations,
    transitions,
)
from osm2xodr.checking.findings import Finding, Findings
from osm2xodr.checking.result import CheckOptions, CheckResult
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, frame_of, pose, read_xodr

_HEAD_END = b"<road"


def check_file(path: Path, options: CheckOptions | None = None) -> CheckResult:
    """Check a file of OpenDRIVE.

    Parameters
    ----------
    path
        The file.
    options
        What is looked at; by default the standard and the readers of `DEFAULT_READERS`.

    Raises
    ------
    InputError
        If the file, or a schema that was given, cannot be read.
    """
    return check_drive(read_xodr(path), options or CheckOptions())


def check_drive(drive: OpenDrive, options: CheckOptions) -> CheckResult:
    """Check a file that was read; see `check_file`."""
    rules = options.rules()
    findings = Findings(drive, rules)
    notes = _check_schema(drive, options, findings)
    # Damaged files make numbers that are none; what comes of them is no finding of its own.
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        _check_tables(drive, lane_index(drive), findings)
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
        notes,
    )


def _check_schema(drive: OpenDrive, options: CheckOptions, findings: Findings) -> tuple[str, ...]:
    """Hold the file against its schema, and return what hinders that."""
    if not findings.wants("schema"):
        return ()
    violations, note = schema_violations(drive.path, drive.header.revision, options.schema)
    findings.add(
        "schema", line=[line for line, _ in violations], other=[text for _, text in violations], count=len(violations)
    )
    return () if note is None else (note,)


def _check_tables(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look at all that was read."""
    check_misfits(drive, findings)
    check_references(drive, lanes, findings)
    # Some readers look at the text, of which standard input leaves none.
    text = b"" if str(drive.path) == "-" else file_bytes(drive.path)
    check_readers(drive, lanes, text.partition(_HEAD_END)[0].decode("utf-8", "replace"), findings)
    check_plan_views(drive, findings)
    check_profiles(drive, lanes, findings)
    check_lanes(drive, lanes, findings)
    steps = transitions(drive, lanes, findings)
    check_links(drive, lanes, steps, findings)
    check_ways_on(drive, lanes, steps, findings)
    check_surfaces(drive, lanes, findings)
    check_phases(drive, lanes, findings)


def _located(drive: OpenDrive, road: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x and y of stations; NaN where there is no road."""
    x, y = np.full(len(road), np.nan), np.full(len(road), np.nan)
    known = np.flatnonzero(road >= 0)
    if len(known):
        # Roads as a whole are found at their start.
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
