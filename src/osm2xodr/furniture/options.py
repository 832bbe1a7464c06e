"""What the user may choose about furniture. Imports nothing heavy: the command line reads it first."""

from __future__ import annotations

from typing import Final

from osm2xodr.conventions import DEFAULT_TARGET, TARGETS, Group, Target, flag, option
from osm2xodr.system import record

# Kinds of objects that are numerous and rarely needed: only on request.
EXTRA_OBJECTS: Final = ("lamps", "trees")


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


@record
class FurnitureOptions:
    """What the user may choose about furniture."""

    target: Target = option(
        "target",
        Group.OUTPUT,
        "Reader to write for where readers contradict each other; generic suits CARLA, esmini and SUMO.",
        default=DEFAULT_TARGET,
        choices=tuple(TARGETS),
        parse=TARGETS.__getitem__,
        stage=TARGETS[DEFAULT_TARGET],
    )
    extra_objects: frozenset[str] = option(
        "objects",
        Group.FURNITURE,
        f"Further objects: {', '.join(EXTRA_OBJECTS)}, or all.  [default: none]",
        metavar="LIST",
        parse=parse_objects_option,
        stage=frozenset[str](),
    )
    enabled: bool = flag(
        "no_furniture",
        Group.FURNITURE,
        "Write the carriageway alone: no signals, objects and lanes beside it.",
        negates="furniture",
    )
