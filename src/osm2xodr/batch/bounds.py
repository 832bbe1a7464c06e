"""The bounds of a map, kept beside the areas that were cut out of it: large maps take minutes to look through."""

from __future__ import annotations

import json
from pathlib import Path

from osm2xodr import __version__
from osm2xodr.system import stream_to

_Bounds = tuple[float, float, float, float]


def recall_bounds(out_dir: Path, source: Path) -> _Bounds | None:
    """Return the bounds of a map, west, south, east, north, degrees; None if they are not known or it has changed."""
    try:
        known = json.loads(_file(out_dir).read_bytes())
        if known["mark"] != _mark(source):
            return None
        west, south, east, north = (float(value) for value in known["bounds"])
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return west, south, east, north


def keep_bounds(out_dir: Path, source: Path, bounds: _Bounds) -> None:
    """Keep the bounds of a map for the next time.

    Raises
    ------
    OutputError
        They cannot be written.
    """
    if recall_bounds(out_dir, source) == bounds:
        return
    with stream_to(_file(out_dir)) as stream:
        stream.write(json.dumps({"mark": _mark(source), "bounds": bounds}).encode("ascii") + b"\n")


def _file(out_dir: Path) -> Path:
    # Without an ending, as the states of areas have.
    return out_dir / ".state" / "bounds"


def _mark(source: Path) -> list[str | int]:
    found = source.stat()
    return [__version__, str(source), found.st_size, found.st_mtime_ns]
