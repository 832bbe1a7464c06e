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
    """One area to convert.

    Parameters
    ----------
    name
        Unique in the batch (also where case does not count); the stem of its files.
    osm
        Where its map is.
    dems
        Its elevation models.
    options
        Further options of ``convert``, as on its command line: neither files nor ``--jobs``.
    outline_deg
        What is cut out of `osm`: rings of (longitude, latitude), degrees, WGS 84, as of `Outline`; empty for all of
        it.
    """

    name: str
    osm: Path
    dems: tuple[Path, ...] = ()
    options: tuple[str, ...] = ()
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class CutRequest:
    """A part of a map to cut out.

    Parameters
    ----------
    name
        Of the area, for messages.
    target
        File to write, ``.osm.pbf``.
    frame
        Local frame of the outline.
    outline
        What is cut out.
    context
        Whether the surroundings that decide about the shape of roads at the border belong to it as well.
    ways
        Which ways the conversion makes streets of.
    include_private
        Whether it does so with ways that are closed to the public.
    """

    name: str
    target: Path
    frame: LocalFrame
    outline: Outline
    context: bool = False
    ways: WaySelection = DRIVABLE
    include_private: bool = False


class Status(str, Enum):
    """What became of an area."""

    DONE = "done"
    UNCHANGED = "unchanged"
    EMPTY = "empty"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Result:
    """What became of an area.

    Parameters
    ----------
    name
        The area.
    status
        ``EMPTY`` where there is nothing to drive on in what was cut out.
    message
        One sentence that says why it failed, or why there is nothing; empty otherwise.
    seconds
        How long the conversion took, s; 0 where there was none.
    memory
        Most memory that it took, bytes; 0 where there was none.
    outline_deg
        What it covers, as of `Area`; the bounds of its roads where no outline was given; empty where unknown.
    """

    name: str
    status: Status
    message: str = ""
    seconds: float = 0.0
    memory: int = 0
    outline_deg: tuple[tuple[tuple[float, float], ...], ...] = ()


# Exit status of the copy where there is nothing to drive on; none of those of commands.
EMPTY: Final = 64
