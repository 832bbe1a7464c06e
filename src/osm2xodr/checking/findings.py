"""The rules that a file is checked against, and findings: what breaks them, and where.

A rule says what a broken one means, for whom, and how to correct the file. Findings are collected as columns, however
many there are; only the worst ones become records. SI units unless a name says otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from configparser import ConfigParser, ExtendedInterpolation, SectionProxy
from enum import IntEnum
from importlib import resources
from types import MappingProxyType
from typing import Final, TypeAlias, TypedDict

import numpy as np

from osm2xodr.curves import repeated
from osm2xodr.defaults import CLEARANCE_LEAST, CONNECTING_RADIUS
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, OpenDrive
from osm2xodr.system import record

# Programs that read OpenDRIVE, as `--for` names them.
READERS: Final = ("carla", "esmini", "sumo", "libopendrive", "roadrunner")
DEFAULT_READERS: Final = ("carla", "esmini", "sumo")

# Distance between places that should be one, m: ASAM's checker allows lanes 0.01 where they touch. From the second on
# it is an error: a step that shakes a wheel, a choice.
GAP: Final = 0.01
GAP_ERROR: Final = 0.1
# Stations along s that differ by no more than this are one, m.
SAME_S: Final = 1e-6
# A lane that is narrower than this where it ends has tapered out, m: half of a shoe.
TAPERED_WIDTH: Final = 0.15

# Numbers that ``rules.ini`` refers to by name.
_NUMBERS: Final = {
    "GAP": GAP,
    "GAP_ERROR": GAP_ERROR,
    "SAME_S": SAME_S,
    "TAPERED_WIDTH": TAPERED_WIDTH,
    "CONNECTING_RADIUS": CONNECTING_RADIUS,
    "CLEARANCE_LEAST": CLEARANCE_LEAST,
}
_LIMIT: Final = re.compile(
    r"(?P<value>\S+) (?P<unit>[^ ,]+)(, error (?P<side>from|below) (?P<error>\S+))?( \((?P<source>.*)\))?"
)

# Surfaces whose heights differ by this or more are different levels, m.
LEVEL_HEIGHT: Final = 2.0

# Names the second thing that a finding is about, by the finding's row in the columns that were given.
Namer: TypeAlias = Callable[[int], str]
# Finds x and y of stations of roads.
Locator: TypeAlias = Callable[[IntArray, FloatArray], tuple[FloatArray, FloatArray]]
# What findings are sorted by: severity, excess, name of the rule, row.
_Rank: TypeAlias = tuple[float, float, str, int]

_NO_ROAD = -1


class Severity(IntEnum):
    """How bad a finding is."""

    INFO = 0
    WARNING = 1
    ERROR = 2

    @property
    def word(self) -> str:
        """Name as it is written."""
        return self.name.lower()


@record
class Limit:
    """A measured value above `value` is a finding."""

    value: float  # In `unit`
    unit: str
    source: str  # Of the value; empty without one
    error: float | None  # From here on a finding is an error, whatever the rule's severity; None: never
    least: bool = False  # Whether values below it are findings instead, and errors below `error`


@record
class Rule:
    """One rule; ``rules.ini`` says what the fields mean."""

    severity: Severity
    name: str
    meaning: str
    text: str
    remedy: str
    impact: str  # Empty where nothing was measured
    readers: tuple[str, ...]  # Of `READERS`
    limit: Limit | None  # None where nothing is measured
    standard: bool

    @property
    def unit(self) -> str:
        """Unit of the value and the limit."""
        return "" if self.limit is None else self.limit.unit

    def matters_to(self, readers: frozenset[str]) -> bool:
        """Whether the rule is required by the standard or by one of some readers."""
        return self.standard or bool(readers.intersection(self.readers))


def _read_rules() -> Iterator[tuple[str, Rule]]:
    """Yield name and content of the rules in ``rules.ini``."""
    parser = ConfigParser(
        {name: str(value) for name, value in _NUMBERS.items()}, delimiters="=", interpolation=ExtendedInterpolation()
    )
    parser.read_string(resources.files("osm2xodr.checking").joinpath("rules.ini").read_text(encoding="utf-8"))
    for name in parser.sections():
        item = parser[name]
        yield (
            name,
            Rule(
                Severity[item["severity"].upper()],
                name,
                item["meaning"],
                item["text"],
                item["remedy"],
                item.get("impact", ""),
                tuple(item.get("readers", "").split()),
                _limit(item),
                item.getboolean("standard", True),
            ),
        )


def _limit(item: SectionProxy) -> Limit | None:
    """Return the limit of a rule as it is read, if it has one."""
    if "limit" not in item:
        return None
    found = _LIMIT.fullmatch(item["limit"])
    assert found, item["limit"]
    error = found["error"]
    from_here = None if error is None else float(error)
    return Limit(float(found["value"]), found["unit"], found["source"] or "", from_here, found["side"] == "below")


RULES: Final[Mapping[str, Rule]] = MappingProxyType(dict(_read_rules()))


class Place(TypedDict, total=False):
    """Columns of `Findings.add` that say where findings are."""

    road: IntArray
    lane: IntArray
    s: FloatArray
    line: IntArray


@record
class Finding:
    """One thing that is wrong at one place."""

    rule: str  # Name of the rule
    severity: Severity  # How bad it is
    road: str  # Id of the road as written; empty where the finding is about no road
    lane: int | None  # Lane id; None where the finding is about no lane
    s: float | None  # Station on the road, m; None where there is none
    # Place on the reference line there, m; None without one
    x: float | None
    y: float | None
    # The same, degrees; None without a geoReference
    lat: float | None
    lon: float | None
    # Measured value and limit, in the rule's unit; None where nothing is measured
    value: float | None
    limit: float | None
    line: int  # Of the file; 0 where unknown
    readers: tuple[str, ...]  # Affected readers, of those that were asked for
    text: str  # A sentence


@record
class Count:
    """How often a rule was broken, all findings counted."""

    rule: str
    severity: Severity
    findings: int


@record
class _Batch:
    """Findings of one rule, as columns."""

    road: IntArray
    lane: IntArray
    s: FloatArray
    value: FloatArray
    line: IntArray
    other: Namer


class Findings:
    """Collects findings of one file that break some rules, given by their names; others are not collected."""

    def __init__(self, drive: OpenDrive, rules: frozenset[str]) -> None:
        self._drive = drive
        self._rules = rules
        self._batches: dict[str, list[_Batch]] = {}

    def wants(self, *rules: str) -> bool:
        """Whether any of some rules is checked."""
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
        """Collect findings of one rule, as columns, (n,).

        They are: index of the road, -1 for none; lane id, `ABSENT` for none; station (m) and value in the rule's
        unit, NaN for none; line of the file; what fills ``{other}`` in the rule's sentence, as texts or a function of
        the row. `count` is n if there is no column.
        """
        columns = [column for column in (road, lane, s, value, line) if column is not None]
        n = len(columns[0]) if columns else (1 if count is None else count)
        if rule not in self._rules or n == 0:
            return
        batch = _Batch(
            _integers(road, n, _NO_ROAD),
            _integers(lane, n, ABSENT),
            _reals(s, n),
            _reals(value, n),
            _integers(line, n, 0),
            other if callable(other) else (other.__getitem__ if other else lambda _: ""),
        )
        self._batches.setdefault(rule, []).append(batch)

    def counts(self) -> tuple[Count, ...]:
        """Return how often each rule was broken, by severity: the worse first."""
        out = []
        for name, batches in self._batches.items():
            rule = RULES[name]
            value = np.concatenate([batch.value for batch in batches])
            errors = int(np.count_nonzero(_severities(rule, value) == Severity.ERROR))
            if errors:
                out.append(Count(name, Severity.ERROR, errors))
            if len(value) > errors:
                out.append(Count(name, rule.severity, len(value) - errors))
        return tuple(sorted(out, key=lambda count: (-count.severity, -count.findings, count.rule)))

    def records(self, most: int, readers: frozenset[str], locate: Locator) -> tuple[Finding, ...]:
        """Return the worst findings, `most` of each rule and severity.

        Errors come first, then what exceeds its limit most. `readers` are those that were asked for.
        """
        ranked = [
            item
            for name, batches in self._batches.items()
            for item in self._of_rule(RULES[name], batches, most, readers, locate)
        ]
        return tuple(finding for _, finding in sorted(ranked, key=lambda item: item[0]))

    def _of_rule(
        self, rule: Rule, batches: list[_Batch], most: int, readers: frozenset[str], locate: Locator
    ) -> Iterable[tuple[_Rank, Finding]]:
        """Return the worst findings of one rule, each with its rank."""
        names = ("road", "lane", "s", "value", "line")
        road, lane, s, value, line = (np.concatenate([getattr(batch, name) for batch in batches]) for name in names)
        batch_of = repeated([len(batch.road) for batch in batches])
        row = np.concatenate([np.arange(len(batch.road)) for batch in batches])
        severity, excess = _severities(rule, value), _excess(rule, value)
        order = np.lexsort((line, -excess, -severity))
        kept = np.concatenate([order[severity[order] == level][:most] for level in (2, 1, 0)])
        x, y = locate(road[kept], s[kept])
        affected = tuple(reader for reader in rule.readers if reader in readers)
        limit = None if rule.limit is None else rule.limit.value
        for k, at_x, at_y in zip(kept.tolist(), x.tolist(), y.tolist(), strict=True):
            other = batches[batch_of[k]].other(int(row[k]))
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
                None if np.isnan(value[k]) else limit,
                int(line[k]),
                affected,
                rule.text.format(
                    value=quantity(float(value[k]), rule.unit), limit=quantity(limit, rule.unit), other=other
                ),
            )
            yield (-float(severity[k]), -float(excess[k]), rule.name, k), finding


def quantity(value: float | None, unit: str) -> str:
    """Return a number with its unit, to three digits."""
    if value is None or np.isnan(value):
        return "unknown"
    digits = f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"
    return f"{digits} {unit}".strip()


def _severities(rule: Rule, value: FloatArray) -> IntArray:
    """Return the severity of each finding of a rule, (n,)."""
    if rule.limit is None or rule.limit.error is None:
        return np.full(len(value), int(rule.severity))
    bad = value < rule.limit.error if rule.limit.least else value >= rule.limit.error
    return np.where(bad, int(Severity.ERROR), int(rule.severity))


def _excess(rule: Rule, value: FloatArray) -> FloatArray:
    """Return how many times the limit the values are, (n,); infinity where nothing is measured."""
    if rule.limit is None or rule.limit.value <= 0:
        return np.where(np.isnan(value), np.inf, np.maximum(value, 1.0))
    ratio = value / rule.limit.value
    # Some limits are least values: what is below them is a finding.
    return np.where(np.isnan(value), np.inf, np.where(ratio < 1, 1 / np.maximum(ratio, 1e-9), ratio))


def _known(value: float) -> float | None:
    """Return a number, or None for NaN."""
    return None if np.isnan(value) else float(value)


def _integers(column: IntArray | Sequence[int] | None, n: int, missing: int) -> IntArray:
    return np.full(n, missing, np.int64) if column is None else np.asarray(column, np.int64)


def _reals(column: FloatArray | Sequence[float] | None, n: int) -> FloatArray:
    return np.full(n, np.nan) if column is None else np.asarray(column, np.float64)
