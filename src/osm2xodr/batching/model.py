"""What the modules of a batch hand to each other."""

from __future__ import annotations

import re
from collections.abc import Mapping, Set as AbstractSet
from dataclasses import field
from enum import Enum
from pathlib import Path
from typing import Final

from osm2xodr.model import LocalFrame, Outline
from osm2xodr.osmParsing import DRIVABLE, WaySelection
from osm2xodr.system import record

_OPTION: Final = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")


@record
class Area:
    """One area to convert."""

    name: str  # Unique in the batch (also where case does not count); the stem of its files
    osm: Path  # Its map
    dems: tuple[Path, ...] = ()  # Its elevation models
    # Options of ``convert`` as on its command line, without files and ``--jobs``
    options: tuple[str, ...] = ()
    # What is cut out of `osm`: rings of (longitude, latitude), degrees, WGS 84, as in `Outline`; empty for all of it
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()
    where: str = field(default="", compare=False)  # Where it is asked for, for messages


@record
class CutRequest:
    """A part of a map to cut out."""

    name: str  # Of the area, for messages
    target: Path  # File to write, ``.osm.pbf``
    frame: LocalFrame  # Local frame of the outline
    outline: Outline  # What is cut out
    # Whether the surroundings that shape roads at the border are cut out as well
    context: bool = False
    ways: WaySelection = DRIVABLE  # Which ways become streets
    include_private: bool = False  # Whether those closed to the public do
    kept: frozenset[int] = frozenset()  # OSM ids of ways that do in any case
    where: str = ""  # Where the outline stands, for messages; by default its name
    # Areas that it consists of, by name, whose ways are to be counted; none where it is one area
    parts: Mapping[str, Outline] = field(default_factory=dict)
    surroundings: bool = False  # Whether buildings and water, which only scenes have, are cut out as well
    allow_partial: bool = False  # Whether the map may be one of which its server says that it is not whole


class Status(str, Enum):
    """What became of an area."""

    DONE = "done"
    UNCHANGED = "unchanged"
    EMPTY = "empty"
    FAILED = "failed"


@record
class Result:
    """What became of an area."""

    name: str  # The area
    status: Status  # ``EMPTY`` where there is nothing to drive on in what was cut out
    message: str = ""  # One sentence that says why it failed or is empty; else empty
    seconds: float = 0.0  # Duration of the conversion, s; 0 without one
    memory: int = 0  # Peak memory of the conversion, bytes; 0 without one
    # What it covers, as in `Area`; the bounds of its roads if it has no outline; empty if unknown
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()


def for_batches(message: str, own: AbstractSet[str]) -> str:
    """Say where a batch takes the options of conversions that a message names.

    `own` are the names of its own options, such as ``--workers``; where there are none there is no command.
    """
    named = [name for name in dict.fromkeys(_OPTION.findall(message)) if name not in own]
    if not named or not own:
        return message
    keys = ", ".join(name.removeprefix("--") for name in named)
    return f"{message} (in a batch: {', '.join(named)} within --options, or {keys} as a key of the manifest)"


# Exit status of a conversion that found nothing to drive on; no command ends with it.
EMPTY: Final = 64
