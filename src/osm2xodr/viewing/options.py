"""What the user may choose about reports and pictures. Imports nothing heavy: the command line reads it first."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from osm2xodr import defaults
from osm2xodr.system import record

# What roads of a picture can be coloured by.
PICTURE_COLOURS: Final = ("type", "height", "grade", "speed")


@record
class ReportOptions:
    """What a report is made of, beside the file."""

    osm: Path | None = None  # The area's file of OpenStreetMap; without it there is no table of coverage
    dem: tuple[Path, ...] = ()  # Elevation models; without any there are no errors of heights
    log: Mapping[str, Any] | None = None  # The report that ``convert --report-json`` writes, as read from JSON
    title: str = ""  # Headline; empty: the name of the road network, or of the file
    check: bool = True  # Whether the file is checked
    # CRS, unit and encoding of heights of elevation models that do not say theirs, as in `surface.SurfaceOptions`
    dem_crs: str | None = None
    dem_unit: str | None = None
    dem_encoding: str | None = None
    # Whether the view in 3D shows the scene that `export_scene` makes; None: where it can be made and is not too long
    scene: bool | None = None


@record
class PictureOptions:
    """What a picture shows."""

    # West, south, east, north in the file's x and y, m; None: everything
    box: tuple[float, float, float, float] | None = None
    width: int = defaults.RENDER_WIDTH  # Pixels
    colour: str = "type"  # One of `PICTURE_COLOURS`
