"""What the user may choose about furniture. Imports nothing heavy: the command line reads it first."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from osm2xodr.conventions import DEFAULT_TARGET, TARGETS, Target

# Kinds of objects that are numerous and rarely needed: only on request.
EXTRA_OBJECTS: Final = ("lamps", "trees")


@dataclass(frozen=True, slots=True)
class FurnitureOptions:
    """What the user may choose about furniture."""

    target: Target = field(default_factory=lambda: TARGETS[DEFAULT_TARGET])  # The reader to write for
    extra_objects: frozenset[str] = frozenset()  # Which of `EXTRA_OBJECTS` to place
    enabled: bool = True  # Whether to place any furniture


def parse_objects_option(text: str) -> frozenset[str]:
    """Read ``--objects``: names of `EXTRA_OBJECTS`, separated by commas, or ``all``.

    Raises
    ------
    ValueError
        A name is unknown, or there is none.
    """
    names = {name.strip() for name in text.split(",") if name.strip()}
    if names == {"all"}:
        return frozenset(EXTRA_OBJECTS)
    unknown = sorted(names - set(EXTRA_OBJECTS))
    if unknown or not names:
        problem = f"{unknown[0]!r} is not a kind of object" if unknown else "no kind of object is named"
        raise ValueError(f"{problem}; choose from {', '.join(EXTRA_OBJECTS)}, or all")
    return frozenset(names)
