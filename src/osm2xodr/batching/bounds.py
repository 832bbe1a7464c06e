"""Bounds of the map that areas are cut out of, kept because reading it takes minutes, and of road networks."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from osm2xodr import __version__
from osm2xodr.batching.areas import RingDeg
from osm2xodr.model import LocalFrame
from osm2xodr.projection import to_geographic
from osm2xodr.system import parse_json, stream_to

_Bounds = tuple[float, float, float, float]


def recall_bounds(out_dir: Path, source: Path) -> _Bounds | None:
    """Return the bounds of a map, west, south, east, north, degrees; None if unknown or if the map has changed."""
    try:
        known = parse_json(_file(out_dir).read_bytes())
        if known["mark"] != _mark(source):
            return None
        west, south, east, north = (float(value) for value in known["bounds"])
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return west, south, east, north


def keep_bounds(out_dir: Path, source: Path, bounds: _Bounds) -> None:
    """Keep the bounds of a map for the next run."""
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


def road_bounds(xodr: Path) -> tuple[RingDeg, ...]:
    """Return the bounds in the header of a file that osm2xodr wrote, as corners in degrees; nothing if unknown."""
    try:
        # Opened here, because Python before 3.13 does not close it when reading stops early.
        with xodr.open("rb") as stream:
            for _, element in ElementTree.iterparse(stream, ("end",)):
                if element.tag == "header":
                    return (_ring(element),)
    except (OSError, ElementTree.ParseError, ValueError):
        pass
    return ()


def _ring(header: ElementTree.Element) -> RingDeg:
    proj = re.sub(r"\s*\+(?:geoidgrids|vunits)=\S+", "", header.findtext("geoReference", "")).strip()
    west, south, east, north = (float(header.get(side, "")) for side in ("west", "south", "east", "north"))
    x, y = np.array([west, east, east, west]), np.array([south, south, north, north])
    lon, lat = to_geographic(LocalFrame(proj, 0.0, 0.0), x, y)
    return tuple(zip(np.round(lon, 7).tolist(), np.round(lat, 7).tolist(), strict=True))
