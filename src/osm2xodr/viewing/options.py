"""What the user may choose about reports and pictures. Imports nothing heavy: the command line reads it first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from osm2xodr import defaults

# What roads of a picture can be coloured by.
PICTURE_COLOURS: Final = ("type", "height", "grade", "speed")


@dataclass(frozen=True)
class ReportOptions:
    """What a report is made of, beside the file.

    Parameters
    ----------
    osm
        The area's file of OpenStreetMap; without it there is no table of coverage.
    dem
        Elevation models; without any there are no errors of heights.
    log
        The report that ``convert --report-json`` writes, as read from JSON.
    title
        Headline; empty: the name of the road network, or of the file.
    check
        Whether the file is checked.
    """

    osm: Path | None = None
    dem: tuple[Path, ...] = ()
    log: Mapping[str, Any] | None = None
    title: str = ""
    check: bool = True


@dataclass(frozen=True)
class PictureOptions:
    """What a picture shows.

    Parameters
    ----------
    box
        West, south, east, north in the file's x and y, m; None: everything.
    width
        Pixels.
    colour
        One of `PICTURE_COLOURS`.
    """

    box: tuple[float, float, float, float] | None = None
    width: int = defaults.RENDER_WIDTH
    colour: str = "type"
