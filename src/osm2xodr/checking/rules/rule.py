"""Rules that a file is held against: what each means, for whom it matters and how to mend what breaks it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Severity(IntEnum):
    """How bad a finding is."""

    INFO = 0
    WARNING = 1
    ERROR = 2

    @property
    def word(self) -> str:
        """Name as it is written."""
        return self.name.lower()


# Programs that read OpenDRIVE, as `--for` names them.
READERS = ("carla", "esmini", "sumo", "libopendrive", "roadrunner")
DEFAULT_READERS = ("carla", "esmini", "sumo")


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule."""

    name: str  # Short name in kebab-case; stable
    severity: Severity  # Of a finding, unless its value reaches `grave`: then it is an error
    meaning: str  # What is wrong if there is a finding: one sentence
    text: str  # Sentence for one finding; ``{value}``, ``{limit}`` and ``{other}`` are filled in
    remedy: str  # How to mend it
    suffers: str = ""  # What which readers make of it; empty where nothing was measured
    readers: tuple[str, ...] = ()  # Those of `READERS` that suffer
    standard: bool = True  # Whether the standard itself asks for it. If not, it matters only to `readers`.
    # Values above `limit` are findings, above `grave` errors; None where there is no number
    limit: float | None = None
    grave: float | None = None
    unit: str = ""  # Of value and limit
    source: str = ""  # Of the limit

    def matters_to(self, readers: frozenset[str]) -> bool:
        """Whether the rule is asked for by the standard or by one of some readers."""
        return self.standard or bool(readers.intersection(self.readers))
