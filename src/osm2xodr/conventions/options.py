"""How the options of a conversion are declared: once, beside the field of the stage that they are for.

The command line, configs, `osm2xodr.ConvertOptions`, manifests of batches, reports and the manual are made of these
declarations. Imports nothing heavy: the command line reads them before it knows what to do.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from enum import Enum
from typing import Any

from osm2xodr.system import record


class Group(str, Enum):
    """The parts of ``convert --help``; what tiles and experts need is shown on request alone."""

    WHAT = "What is converted"
    HEIGHTS = "Heights"
    LANES = "Roads and lanes"
    FURNITURE = "Furniture"
    OUTPUT = "Output"
    MACHINE = "Machine"
    MORE = "More"


class Reported(Enum):
    """Whether reports say an option among what was asked for."""

    ALWAYS = 0
    GIVEN = 1  # Only where it is given
    NEVER = 2


@record
class Declaration:
    """An option, as the user sees it, and what a stage gets of it."""

    name: str  # In Python; on the command line with dashes
    group: Group
    help: str  # One sentence for --help
    kind: type = str  # Of a value: str, float, int, bool or Path
    default: Any = None  # As the user gives it; None where the stage, or what is found, decides
    metavar: str | None = None  # Stands for the value in --help
    choices: tuple[str, ...] = ()  # All values that it can have; none where any will do
    least: int | None = None  # The smallest and the largest number
    most: int | None = None
    parse: Callable[[Any], Any] | None = None  # What makes the stage's value of the user's; raises ValueError
    negates: str = ""  # What the flag turns off: the stage gets the opposite, and the report says it by this name
    reported: Reported = Reported.ALWAYS
    per_area: bool = True  # Whether the areas of a batch can have it
    needs_dem: bool = False  # Whether it means nothing without an elevation model

    def for_stage(self, value: Any) -> Any:
        """Return what the stage gets of a value."""
        if self.negates:
            return not value
        return value if self.parse is None else self.parse(value)


def option(name: str, group: Group, help: str, kind: type = str, *, stage: Any = None, **more: Any) -> Any:
    """Declare an option as a field of a stage's dataclass; `stage` is the field's default where it is another one."""
    declaration = Declaration(name, group, help, kind, **more)
    default = declaration.default if stage is None else stage
    # Not as a default, which dataclasses want hashable.
    return dataclasses.field(default_factory=lambda: default, metadata={"option": name, "declaration": declaration})


def flag(name: str, group: Group, help: str, **more: Any) -> Any:
    """Declare an option without a value: a field that is True if it is given, or, if it negates something, False."""
    return option(name, group, help, bool, default=False, stage=bool(more.get("negates")), **more)


def same_option(name: str, default: Any) -> Any:
    """Return a field that gets its value from an option that another stage declares."""
    return dataclasses.field(default=default, metadata={"option": name})


def declarations(*stages: type) -> dict[str, Declaration]:
    """Return the options that are declared on dataclasses, by name."""
    fields = (item for stage in stages for item in dataclasses.fields(stage))
    return {
        item.metadata["option"]: item.metadata["declaration"] for item in fields if "declaration" in item.metadata
    }
