"""Small pictures of road networks, drawn as soon as these are made, and kept from one start to the next."""

from __future__ import annotations

import contextlib

from osm2xodr.batching.out_dir import OutDir
from osm2xodr.errors import InputError, OutputError
from osm2xodr.system import stream_to
from osm2xodr.viewing import draw_thumbnail


def thumbnail(out: OutDir, name: str) -> bytes:
    """Return the picture of an area, as PNG; empty if there is no road network to draw."""
    xodr, kept = out.outputs(name)[0], out.thumbnail(name)
    with contextlib.suppress(OSError):
        if kept.stat().st_mtime_ns >= xodr.stat().st_mtime_ns:
            return kept.read_bytes()
    try:
        picture = draw_thumbnail(xodr)
    except InputError:
        return b""
    # The page does without the kept one.
    with contextlib.suppress(OutputError), stream_to(kept) as stream:
        stream.write(picture)
    return picture
