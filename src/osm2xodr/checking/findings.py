"""Findings: collected as columns, however many there are; made into records for the worst ones only."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from osm2xodr.checking.rules import RULES, Rule, Severity
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive

# Names the second thing that a finding is about, by the finding's row in what was handed in.
Namer = Callable[[int], str]
# Finds x and y of stations of roads.
Locator = Callable[[IntArray, FloatArray], tuple[FloatArray, FloatArray]]

_NO_ROAD = -1


class Place(TypedDict, total=False):
    """Columns of `Findings.add` that say where findings are."""

    road: IntArray
    lane: IntArray
    s: FloatArray
    line: IntArray


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong in one place."""

    rule: str  # Name of the rule
    severity: Severity  # How bad it is
    road: str  # Id of the road as written; empty where none is concerned
    lane: int | None  # Lane id; None where none is concerned
    s: float | None  # Station on the road, m; None where the finding has none
    # Place on the reference line there, m; None without one
    x: float | None
    y: float | None
    # The same, degrees; None without a geoReference
    lat: float | None
    lon: float | None
    # What was measured and allowed, in the rule's unit; None where there is no number
    value: float | None
    limit: float | None
    line: int  # Of the file; 0 where unknown
    readers: tuple[str, ...]  # Readers that suffer, of those that were asked for
    text: str  # A sentence


@dataclass(frozen=True)
class _Batch:
    """Findings of one rule, as columns."""

    road: IntArray
    lane: IntArray
    s: FloatArray
    value: FloatArray
    line: IntArray
    other: Namer


@dataclass(frozen=True, slots=True)
class Count:
    """How often a rule was broken, all findings counted."""

    rule: str
    severity: Severity
    findings: int


class Findings:
    """Collects findings of one file.

    Parameters
    ----------
    drive
        The file.
    rules
        Names of the rules that are looked at; others are not collected.
    """

    def __init__(self, drive: OpenDrive, rules: frozenset[str]) -> None:
        self._drive = drive
        self._rules = rules
        self._batches: dict[str, list[_Batch]] = {}

    def wants(self, *rules: str) -> bool:
        """Whether any of some rules is looked at."""
        return not self._rules.isdisjoint(rules)

    def add(
        self,
        rule: str,
        *,
        road: IntArray | Sequence[int] | None = None,
        lane: IntArray | Sequence[int] | None = None,
        s: FloatArray | Sequence[float] | None = None,
        value: FloatArray | Sequence[float] | None = None,
        line: IntArray | Sequence[int] | None = None,
        other: Namer | Sequence[str] = "",
        count: int | None = None,
    ) -> None:
        """Take in findings of one rule.

        Parameters
        ----------
        rule
            Name of the rule.
        road : (n,)
            Index of the road, -1 for none.
        lane : (n,)
            Lane id, `ABSENT` for none.
        s : (n,)
            NaN for none.
        value : (n,)
            In the rule's unit, NaN for none.
        line : (n,)
            Of the file.
        other
            What fills ``{other}`` in the rule's sentence: one text for each, or a function of the row.
        count
            Number of findings where no column tells it.
        """
        columns = [column for column in (road, lane, s, value, line) if column is not None]
        n = len(columns[0]) if columns else (1 if count is None else count)
        if rule not in self._rules or n == 0:
            return
        namer: Namer = other if callable(other) else (other.__getitem__ if other else (lambda _: ""))
        self._batches.setdefault(rule, []).append(
            _Batch(
                _whole(road, n, _NO_ROAD),
                _whole(lane, n, ABSENT),
                _real(s, n),
                _real(value, n),
                _whole(line, n, 0),
                namer,
            )
        )

    def counts(self) -> tuple[Count, ...]:
        """Return how often each rule was broken, by severity: the worse first."""
        out = []
        for name, batches in self._batches.items():
            rule = RULES[name]
            value = np.concatenate([batch.value for batch in batches])
            grave = int(np.count_nonzero(_severities(rule, value) == Severity.ERROR))
            if grave:
                out.append(Count(name, Severity.ERROR, grave))
            if len(value) > grave:
                out.append(Count(name, rule.severity, len(value) - grave))
        return tuple(sorted(out, key=lambda count: (-count.severity, -count.findings, count.rule)))

    def records(self, most: int, readers: frozenset[str], locate: Locator) -> tuple[Finding, ...]:
        """Return the worst findings of each rule and severity, ranked: errors first, then by how far off they are.

        Parameters
        ----------
        most
            Findings per rule and severity.
        readers
            Those that were asked for.
        locate
            Finds x and y.
        """
        ranked: list[tuple[tuple[float, float, str, int], Finding]] = []
        for name, batches in self._batches.items():
            ranked += self._of_rule(RULES[name], batches, most, readers, locate)
        return tuple(finding for _, finding in sorted(ranked, key=lambda item: item[0]))

    def _of_rule(
        self, rule: Rule, batches: list[_Batch], most: int, readers: frozenset[str], locate: Locator
    ) -> Iterable[tuple[tuple[float, float, str, int], Finding]]:
        """Return the worst findings of one rule with what they are sorted by."""
        names = ("road", "lane", "s", "value", "line")
        road, lane, s, value, line = (np.concatenate([getattr(batch, name) for batch in batches]) for name in names)
        batch_of = np.repeat(np.arange(len(batches)), [len(batch.road) for batch in batches])
        row = np.concatenate([np.arange(len(batch.road)) for batch in batches])
        severity = _severities(rule, value)
        excess = _excess(rule, value)
        order = np.lexsort((line, -excess, -severity))
        kept = np.concatenate([order[severity[order] == level][:most] for level in (2, 1, 0)])
        x, y = locate(road[kept], s[kept])
        suffering = tuple(reader for reader in rule.readers if reader in readers)
        for k, at_x, at_y in zip(kept.tolist(), x.tolist(), y.tolist(), strict=True):
            named = batches[batch_of[k]].other(int(row[k]))
            text = rule.text.format(
                value=quantity(float(value[k]), rule.unit), limit=quantity(rule.limit, rule.unit), other=named
            )
            finding = Finding(
                rule.name,
                Severity(int(severity[k])),
                self._drive.roads.id[road[k]] if road[k] >= 0 else "",
                None if lane[k] == ABSENT else int(lane[k]),
                _known(s[k]),
                _known(at_x),
                _known(at_y),
                None,
                None,
                _known(value[k]),
                None if np.isnan(value[k]) else rule.limit,
                int(line[k]),
                suffering,
                text,
            )
            yield (-float(severity[k]), -float(excess[k]), rule.name, k), finding


def quantity(value: float | None, unit: str) -> str:
    """Return a number with its unit, to three digits."""
    if value is None or np.isnan(value):
        return "unknown"
    digits = f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"
    return f"{digits} {unit}".strip()


def _severities(rule: Rule, value: FloatArray) -> IntArray:
    """Return the severity of each finding of a rule."""
    if rule.grave is None:
        return np.full(len(value), int(rule.severity))
    return np.where(value >= rule.grave, int(Severity.ERROR), int(rule.severity))


def _excess(rule: Rule, value: FloatArray) -> FloatArray:
    """Return how many times the limit findings reach; infinity for what is no matter of measure."""
    if rule.limit is None or rule.limit <= 0:
        return np.where(np.isnan(value), np.inf, np.maximum(value, 1.0))
    ratio = value / rule.limit
    # Some limits are least values: what is below them is a finding.
    return np.where(np.isnan(value), np.inf, np.where(ratio < 1, 1 / np.maximum(ratio, 1e-9), ratio))


def _known(value: float) -> float | None:
    """Return a number, or None for NaN."""
    return None if np.isnan(value) else float(value)


def _whole(column: IntArray | Sequence[int] | None, n: int, missing: int) -> IntArray:
    """Return a column of whole numbers."""
    return np.full(n, missing, np.int64) if column is None else np.asarray(column, np.int64)


def _real(column: FloatArray | Sequence[float] | None, n: int) -> FloatArray:
    """Return a column of numbers."""
    return np.full(n, np.nan) if column is None else np.asarray(column, np.float64)
