"""All checks of a file, one after another, and what they come to."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator
from dataclasses import field
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from osm2xodr import defaults
from osm2xodr.checking.checks import Violation, check_tables, schema_violations
from osm2xodr.checking.findings import DEFAULT_READERS, READERS, RULES, Count, Finding, Findings, Severity
from osm2xodr.diagnostics import counted
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import OpenDrive, frame_of, pose, read_xodr
from osm2xodr.system import Task, available_jobs, record, stage, xml_stream

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


@record
class CheckOptions:
    """What is checked.

    Raises
    ------
    ValueError
        If a reader or rule is unknown, or `most` is negative.
    """

    readers: tuple[str, ...] = DEFAULT_READERS  # Readers of OpenDRIVE that must be able to use the file (`READERS`)
    schema: Path | None = None  # XML schema; by default that of ASAM's checker, if installed
    # Names of rules: only these (all if empty), but not these
    only: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    most: int = defaults.CHECK_FINDINGS  # Findings listed per rule and severity; all are counted

    def __post_init__(self) -> None:
        for name in self.readers:
            if name not in READERS:
                raise ValueError(f"{name} is no reader that check knows; it knows {', '.join(READERS)}")
        for name in (*self.only, *self.ignore):
            if name not in RULES:
                raise ValueError(f"{name} is no rule; osm2xodr check --list-rules lists them")
        if self.most < 0:
            raise ValueError(f"{self.most} findings per rule cannot be listed; give 0 or more")

    def rules(self) -> frozenset[str]:
        """Return the names of the rules that are checked."""
        readers = frozenset(self.readers)
        wanted = {name for name, rule in RULES.items() if rule.matters_to(readers)}
        # A rule that is asked for by name is checked whichever readers it affects.
        return frozenset((set(self.only) if self.only else wanted) - set(self.ignore))


@record
class CheckResult:
    """What was found in a file."""

    path: Path  # The file
    version: str  # The version that it states, such as ``1.7``; empty where it states none
    size: tuple[int, int, float]  # Roads, junctions and length of reference lines, km
    readers: tuple[str, ...]  # Those that were asked for
    rules: frozenset[str]  # Names of the rules that were checked
    counts: tuple[Count, ...]  # How often each rule was broken; complete
    findings: tuple[Finding, ...]  # The worst of them, ranked
    notes: tuple[str, ...] = field(default=())  # What could not be checked, and why

    def count(self, severity: Severity) -> int:
        """Return the number of findings of a severity."""
        return sum(item.findings for item in self.counts if item.severity == severity)

    def failed(self, severity: Severity = Severity.WARNING) -> bool:
        """Whether there are findings of a severity or worse."""
        return any(item.severity >= severity for item in self.counts)

    def by_rule(self) -> dict[str, int]:
        """Return the number of findings of each rule that was broken."""
        out: Counter[str] = Counter()
        for item in self.counts:
            out[item.rule] += item.findings
        return dict(out)

    def worst(self, most: int) -> CheckResult:
        """Return the result with at most `most` findings of each rule and severity, the first ones."""
        listed: Counter[tuple[str, Severity]] = Counter()
        kept = []
        for finding in self.findings:
            listed[finding.rule, finding.severity] += 1
            if listed[finding.rule, finding.severity] <= most:
                kept.append(finding)
        return dataclasses.replace(self, findings=tuple(kept))

    def headline(self) -> str:
        """Return the result in one line."""
        roads, junctions, length = self.size
        words = [
            counted(self.count(severity), word)
            for severity, word in ((Severity.ERROR, "error"), (Severity.WARNING, "warning"), (Severity.INFO, "note"))
        ]
        version = f"OpenDRIVE {self.version}" if self.version else "OpenDRIVE of no stated version"
        size = f"{counted(roads, 'road')}, {counted(junctions, 'junction')}, {length:,.1f} km"
        return f"{self.path}: {', '.join(words)} ({version}, {size})"

    def lines(self, least: Severity = Severity.INFO) -> Iterator[str]:
        """Yield the result as text: a headline, the findings, the worst first, and their number by rule.

        Findings below a severity are only counted in the headline.
        """
        yield self.headline()
        for finding in (item for item in self.findings if item.severity >= least):
            affected = f" ({', '.join(finding.readers)})" if finding.readers else ""
            yield f"{finding.severity.word:8}{place(finding)}: {finding.text} [{finding.rule}]{affected}"
        counts = [item for item in self.counts if item.severity >= least]
        if counts:
            yield ""
            yield "findings  rule"
        for count in counts:
            shown = sum(item.rule == count.rule and item.severity == count.severity for item in self.findings)
            more = f", {count.findings - shown:,} of them not listed" if shown < count.findings else ""
            yield f"{count.findings:8,}  {count.rule} ({count.severity.word}{more}): {RULES[count.rule].remedy}"
        for note in self.notes:
            yield f"note: {note}"


def place(finding: Finding) -> str:
    """Return where a finding is, in words."""
    words = []
    if finding.road:
        words.append(f"road {finding.road}")
    if finding.lane is not None:
        words.append(f"lane {finding.lane}")
    if finding.s is not None:
        words.append(f"s {finding.s:.2f}")
    if finding.x is not None and finding.y is not None:
        words.append(f"at {finding.x:.2f},{finding.y:.2f}")
    if finding.lat is not None and finding.lon is not None:
        words.append(f"({finding.lat:.6f} {finding.lon:.6f})")
    if finding.line:
        words.append(f"line {finding.line}")
    return " ".join(words) or "file"
