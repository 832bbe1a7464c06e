"""Pictures: of a road network as SVG or PNG, and of any pixels as PNG."""

from __future__ import annotations

from pathlib import Path

from osm2xodr.opendrive import OpenDrive, read_xodr
from osm2xodr.system import stream_to
from osm2xodr.viewing.options import PictureOptions
from osm2xodr.viewing.picture.contents import box_of_degrees as box_of_degrees, make_picture
from osm2xodr.viewing.picture.drawing import as_png as as_png, draw_png, draw_svg, draw_thumbnail as draw_thumbnail


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
    picture = make_picture(read_xodr(source) if isinstance(source, Path) else source, options)
    data = draw_svg(picture) if kind == "svg" else draw_png(picture)
    with stream_to(out) as stream:
        stream.write(data)
    return len(data)
