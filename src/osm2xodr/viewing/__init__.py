"""To see a road network: `write_report` makes a page to explore it, `write_picture` a picture of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.viewing.options import PICTURE_COLOURS as PICTURE_COLOURS
    from osm2xodr.viewing.picture import box_of_degrees as box_of_degrees
    from osm2xodr.viewing.surface_report import surface_page as surface_page

from pathlib import Path
from typing import TYPE_CHECKING

from osm2xodr.viewing.options import PictureOptions, ReportOptions

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.opendrive import OpenDrive

__all__ = ["PictureOptions", "ReportOptions", "write_picture", "write_report"]


def write_report(
    source: Path | OpenDrive,
    out: Path,
    options: ReportOptions,
    diagnostics: Diagnostics,
    result: CheckResult | None = None,
) -> int:
    """Write the report about a file of OpenDRIVE, and return its size in bytes.

    Parameters
    ----------
    source
        The file, or what was read of it.
    out
        Where to; the file is there as a whole or not at all. ``-`` is standard output.
    options
        What it is made of.
    diagnostics
        Receives what was found about the elevation models.
    result
        What the check found, if it was done before.

    Raises
    ------
    InputError
        The file or what it is compared with cannot be read.
    OutputError
        The page cannot be written.
    """
    from osm2xodr.system import stream_to
    from osm2xodr.viewing.page import make_report

    page = make_report(source, options, diagnostics, result)
    with stream_to(out) as stream:
        stream.write(page)
    return len(page)


def write_picture(source: Path | OpenDrive, out: Path, options: PictureOptions, kind: str) -> int:
    """Write a picture of a file of OpenDRIVE, and return its size in bytes.

    Parameters
    ----------
    source
        The file, or what was read of it.
    out
        Where to; the file is there as a whole or not at all. ``-`` is standard output.
    options
        What it shows.
    kind
        ``svg`` or ``png``.

    Raises
    ------
    InputError
        The file cannot be read, or nothing of it can be drawn.
    OutputError
        The picture cannot be written.
    """
    from osm2xodr.opendrive import read_xodr
    from osm2xodr.system import stream_to
    from osm2xodr.viewing.picture import make_picture

    picture = make_picture(read_xodr(source) if isinstance(source, Path) else source, options)
    if kind == "svg":
        from osm2xodr.viewing.picture import draw_svg

        data = draw_svg(picture)
    else:
        from osm2xodr.viewing.picture import draw_png

        data = draw_png(picture)
    with stream_to(out) as stream:
        stream.write(data)
    return len(data)


__getattr__ = lazy_exports(
    __name__, {"options": ("PICTURE_COLOURS",), "picture": ("box_of_degrees",), "surface_report": ("surface_page",)}
)
