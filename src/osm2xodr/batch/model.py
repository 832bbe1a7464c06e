"""What the parts of a batch hand to each other."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

from osm2xodr.model import LocalFrame, Outline
from osm2xodr.osmParsing import DRIVABLE, WaySelection


@dataclass(frozen=True, slots=True)
class Area:
    """One area to convert."""

    name: str  # Unique in the batch (also where case does not count); the stem of its files
    osm: Path  # Where its map is
    dems: tuple[Path, ...] = ()  # Its elevation models
    # Further options of ``convert``, as on its command line: neither files nor ``--jobs``
    options: tuple[str, ...] = ()
    # What is cut out of `osm`: rings of (longitude, latitude), degrees, WGS 84, as of `Outline`; empty for all of it
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class CutRequest:
    """A part of a map to cut out."""

    name: str  # Of the area, for messages
    target: Path  # File to write, ``.osm.pbf``
    frame: LocalFrame  # Local frame of the outline
    outline: Outline  # What is cut out
    # Whether the surroundings that decide about the shape of roads at the border belong to it as well
    context: bool = False
    ways: WaySelection = DRIVABLE  # Which ways the conversion makes streets of
    include_private: bool = False  # Whether it does so with ways that are closed to the public


class Status(str, Enum):
    """What became of an area."""

    DONE = "done"
    UNCHANGED = "unchanged"
    EMPTY = "empty"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Result:
    """What became of an area."""

    name: str  # The area
    status: Status  # ``EMPTY`` where there is nothing to drive on in what was cut out
    message: str = ""  # One sentence that says why it failed, or why there is nothing; empty otherwise
    seconds: float = 0.0  # How long the conversion took, s; 0 where there was none
    memory: int = 0  # Most memory that it took, bytes; 0 where there was none
    # What it covers, as of `Area`; the bounds of its roads where no outline was given; empty where unknown
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()


# Exit status of the copy where there is nothing to drive on; none of those of commands.
EMPTY: Final = 64
