"""The rules that a file is checked against: what a broken one means, for whom, and how to correct the file.

And numbers that several checks share. SI units unless the name says otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from configparser import ConfigParser, ExtendedInterpolation, SectionProxy
from dataclasses import dataclass
from enum import IntEnum
from importlib import resources
from types import MappingProxyType
from typing import Final

from osm2xodr.defaults import CLEARANCE_LEAST, CONNECTING_RADIUS

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
    source: str  # Of the value; empty without one
    error: float | None  # From here on a finding is an error, whatever the rule's severity; None: never
    least: bool = False  # Whether values below it are findings instead, and errors below `error`


@dataclass(frozen=True, slots=True)
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
