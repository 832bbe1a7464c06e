"""A rule: what it means when a file breaks it, which readers are affected, and how to correct the file."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import Final

# Programs that read OpenDRIVE, as `--for` names them.
READERS: Final = ("carla", "esmini", "sumo", "libopendrive", "roadrunner")
DEFAULT_READERS: Final = ("carla", "esmini", "sumo")


class Severity(IntEnum):
    """How bad a finding is."""

    INFO = 0
    WARNING = 1
    ERROR = 2

    @property
    def word(self) -> str:
        """Name as it is written."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Limit:
    """A measured value above `value` is a finding."""

    value: float  # In `unit`
    unit: str
    source: str = ""  # Of the value
    error: float | None = None  # From here on a finding is an error, whatever the rule's severity; None: never


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule."""

    severity: Severity  # Of a finding, unless its value reaches `limit.error`
    name: str  # Short name in kebab-case; stable
    meaning: str  # What is wrong if there is a finding: one sentence
    text: str  # Sentence for one finding; ``{value}``, ``{limit}`` and ``{other}`` are filled in
    remedy: str  # How to correct the file
    impact: str = ""  # What the affected readers do with such a file; empty where nothing was measured
    readers: tuple[str, ...] = ()  # Those of `READERS` that are affected
    limit: Limit | None = None  # None where nothing is measured
    standard: bool = True  # Whether the standard itself asks for it. If not, it matters only to `readers`.

    @property
    def unit(self) -> str:
        """Unit of the value and the limit."""
        return "" if self.limit is None else self.limit.unit

    def matters_to(self, readers: frozenset[str]) -> bool:
        """Whether the rule is required by the standard or by one of some readers."""
        return self.standard or bool(readers.intersection(self.readers))


error = partial(Rule, Severity.ERROR)
warning = partial(Rule, Severity.WARNING)
note = partial(Rule, Severity.INFO)
